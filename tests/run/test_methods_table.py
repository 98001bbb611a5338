"""What docs/methods.md says of each method, against what it does: every cell is tried."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Observer, Start
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.integrate.times import Times
from lagrange_cli.run.motion import read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.spec.defaults import SolveDefaults
from tests.support.command import ROOT
from tests.support.motion import follow, prepared, values_of

FALL = """
coordinates: {{x: {{initial: 1}}, y: {{initial: 0, velocity: 1}}}}
masses: {{p: 1}}
positions: {{p: [x, y]}}
potential: {potential}
{more}
solve: {{stop: 1}}
"""


def accepted(method: str, text: str, precision: str | None = None) -> bool:
    """Whether a method is accepted for a system; if not, methods that are, are named."""
    more = {} if precision is None else {"precision": precision}
    try:
        read_motion(text.encode(), "a.yaml", Request(options=SolveDefaults(method=method), **more))
    except LagrangeError as error:
        assert "needs method taylor" in str(error) and "add --method taylor" in str(error)
        return False
    return True


def events(method: str) -> bool:
    text = FALL.format(potential="p.x", more="events: {floor: {when: x - 0.5, action: stop}}")
    if not accepted(method, text):
        return False
    motion = follow(text, 2.0, method=method, tolerance=1e-10)
    assert motion.outcome.ending is Ending.STOPPED
    assert motion.outcome.final.t == pytest.approx(1, abs=1e-9)
    kink = follow(FALL.format(potential="abs(p.x - 0.5)", more=""), 2.5, method=method, tolerance=1e-10)
    assert not kink.outcome.undetected
    assert kink["q/x"][-1] == pytest.approx(0.125, abs=1e-9)
    return True


def constraints(method: str) -> bool:
    text = FALL.format(potential="0", more="constraints: {ring: x**2 + y**2 - 1}")
    if not accepted(method, text):
        return False
    motion = follow(text, 2.0, method=method, tolerance=1e-10)
    assert motion["q/x"] == pytest.approx(np.cos(motion.t), abs=1e-8)
    return True


def narrow(method: str) -> bool:
    potential = "exp(-10**4*p.x**2) + exp(-10**4*(p.x**2 - 4)**2)"
    motion = follow(FALL.format(potential=potential, more=""), 1.0, method=method, tolerance=1e-9)
    return "narrow" not in motion.outcome.undetected


def double_double(method: str) -> bool:
    return accepted(method, FALL.format(potential="p.x", more=""), DOUBLE_DOUBLE)


def goes_on(method: str) -> bool:
    text = FALL.format(potential="p.x**4", more="")
    ready, values = prepared(text, method, 1e-10), values_of(text)
    parameters, state = np.array([*values.parameters.values()]), np.array([1.0, 0, 0, 1])
    times = Times(0.0, 1e3, 11, 1e2)
    end = ready.follower.follow(Start(parameters, state, times), Observer(interrupt=lambda _: True))
    assert end.ending is Ending.INTERRUPTED
    return end.snapshot is not None


TRIED = {
    "events, impacts, switches": events,
    "constraints": constraints,
    "detects narrow forces": narrow,
    "double-double": double_double,
    "can be resumed": goes_on,
}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", METHODS)
def test_the_table_of_methods_is_what_they_do(method: str) -> None:
    head, _, *rows = [
        [cell.strip(" `") for cell in line.strip("|").split("|")]
        for line in (ROOT / "docs" / "methods.md").read_text(encoding="utf-8").splitlines()
        if line.startswith(("| method |", "|---", "| `"))
    ][: len(METHODS) + 2]
    assert head[1:] == [*TRIED]
    (row,) = (row for row in rows if row[0] == method)
    assert row[1:] == ["yes" if tried(method) else "no" for tried in TRIED.values()]
