"""What hides from a step's series is found in families, too: narrow walls, and forces that grow fast."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.support.motion import run

WALLS = """
sizes: {{N: {count}}}
parameters: {{w: {width}}}
coordinates:
  x[i in range(N)]: {{initial: "-1 - 0.1*i", velocity: "1 + i/N"}}
definitions:
  high[i in range(N)]: where(i % 3 == 0, 0.3, 3)
  run[0]: x[0]
  run[i in range(1, N)]: run[i - 1] + (x[i] - x[i - 1])
masses: {{"ball[i in range(N)]": 1.0}}
embedding: {{"ball[i in range(N)]": "x[i]"}}
potential: {potential}
"""
PULSE = "sum(high[i]*exp(-({place}/w)**2) for i in range(N))"
POTENTIALS = {
    "pulses": PULSE.format(place="x[i]"),
    "quotients": "sum(high[i]/(1 + (x[i]/w)**2)**4 for i in range(N))",
    "of sums": PULSE.format(place="run[i]"),
}


CASES = [(count, kind, width, DOUBLE) for count in (1, 3, 9) for kind in POTENTIALS for width in (1e-3, 1e-6)]
CASES += [(count, "pulses", 1e-3, DOUBLE_DOUBLE) for count in (1, 9)]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("count", "kind", "width", "precision"), CASES)
def test_narrow_walls_reflect_what_is_too_slow(
    count: int, kind: str, width: float, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Free motion before and after the wall: with the same velocity, or the opposite one."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    spec = read_spec(WALLS.format(count=count, width=width, potential=POTENTIALS[kind]), "system.yaml")
    exact, outputs = precision == DOUBLE_DOUBLE, frozenset(["q", "v"])
    settings = Compilation("taylor", 2.0 ** (-104 if exact else -52), outputs, precision=precision)
    assert family_run(spec, settings) is not None
    ready = prepare_system(spec, partial(derive_system, exact=exact), None, settings)
    values = (resolve_long_values if exact else resolve_values)(spec, {})
    found = run(ready, values, 0.0, 4.0, 2).data
    members = np.arange(count)
    before, high = 1 + members / count, np.where(members % 3 == 0, 0.3, 3.0)
    after = found["v/x"][-1]
    assert after == pytest.approx(np.where(before**2 / 2 > high, before, -before), rel=1e-3 * width**0.5)


def test_exponentials_that_overflow_go_through_members(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are bounded there: 1/cosh(x/w)^2 far from its peak."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    potential = "sum(high[i]/cosh(x[i]/w)**2 for i in range(N))"
    spec = read_spec(WALLS.format(count=3, width=1e-3, potential=potential), "system.yaml")
    assert systems.family_system(spec) is None
