"""Integrals beside the motions of families that stay families, beside the same systems written out."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.families.test_events import PENDULUM, keep_families
from tests.support.families import alike
from tests.support.motion import run

OUTPUTS = frozenset(["q", "v", "p", "h", "ledger", "action"])
CHAIN = """
sizes: {{N: {count}}}
parameters: {{k: 1.5}}
coordinates: {{"x[i in range(N)]": {{initial: "0.5*sin(i + 1)", velocity: "2*cos(i*i + 1)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(k*(x[i] - x[i - 1])**2/2 + (x[i] - x[i - 1])**4/4 for i in range(1, N)) + x[0]**2/2
{more}
"""
CASES = {
    "alone": (CHAIN, ""),
    "damped": (CHAIN, 'generalized_forces: {{"x[i in range(N)]": "-0.1*x_dot[i] + sin(t + i)/5"}}'),
    "walls": (
        CHAIN,
        'events: {{"wall[i in range(N)]": {{when: "x[i] - 0.9", direction: rising,'
        ' action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}}}',
    ),
    "a kick": (
        CHAIN,
        'events: {{kick: {{when: "t - 0.4", action: {{set: {{"x_dot[0]": "x_dot[0] + 1"}}}}}}}}',
    ),
    "rods": (PENDULUM.replace("events: {events}", "{more}"), ""),
    "damped rods": (
        PENDULUM.replace("events: {events}", "{more}"),
        'generalized_forces: {{"th[i in range(N)]": "-0.1*th_dot[i] + sin(t)/5"}}',
    ),
}
DRIVEN = CHAIN.replace("+ x[0]**2/2", "+ x[0]**2/2 + sum(x[i]*cos(t + i)*(1 + x[0]**2) for i in range(N))")
CASES["driven"] = DRIVEN, ""
CASES["an integral that needs shorter steps"] = (
    CHAIN.replace("+ x[0]**2/2", "+ x[0]**2/2 + 1/(1.1 + cos(9*t))"),
    "",
)


METHODS = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}
"""Their tolerances."""
CLOSE = {"taylor": 2.0**-41, "ias15": 2.0**-41, "DOP853": 2.0**-30, "Radau": 2.0**-30}
"""How near two motions are, and ledgers are to 0."""
BY_METHODS = pytest.mark.parametrize("method", METHODS)


def ready(text: str, *, backward: bool = False, method: str = "taylor") -> Prepared:
    """A system that has been compiled."""
    asked = Compilation(method, METHODS[method], OUTPUTS, backward=backward)
    derive = partial(derive_system, resting=True)
    return prepare_system(read_spec(text, "system.yaml"), derive, None, asked)


def followed(prepared: Prepared, text: str, stop: float = 1.0) -> Mapping[str, NDArray[np.float64]]:
    """The samples of a motion."""
    return run(prepared, resolve_values(read_spec(text, "system.yaml"), {}), 0.0, stop, 7).data


@pytest.mark.exhaustive(keep=0.6)
@BY_METHODS
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_ledgers_and_the_action_are_those_of_the_members(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    form, more = CASES[case]
    text = form.format(count=count, more=more.format())
    keep_families(monkeypatch, whole=True)
    asked = Compilation(method, METHODS[method], OUTPUTS)
    assert family_run(read_spec(text, "system.yaml"), asked) is not None
    together = ready(text, method=method)
    found = followed(together, text)
    keep_families(monkeypatch, whole=False)
    apart = ready(text, method=method)
    expected = followed(apart, text)
    assert found.keys() == expected.keys()
    for path, values in expected.items():
        assert found[path].shape == values.shape, path
        assert np.max(np.abs(found[path] - values), initial=0.0) <= CLOSE[method], path
        if "ledger" in path:
            assert np.max(np.abs(found[path]), initial=0.0) <= CLOSE[method], path
    one, other = together.recording, apart.recording
    assert one.datasets == other.datasets


BACKWARD = {
    "damped": CASES["damped"],
    "driven": CASES["driven"],
    "damped rods": CASES["damped rods"],
    "events": (CHAIN, 'events: {{"hit[i in range(N)]": {{when: "x[i] + x_dot[i]*t/9", direction: rising}}}}'),
}


@pytest.mark.exhaustive(keep=0.15)
@BY_METHODS
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", BACKWARD)
def test_families_move_backward_as_their_members_do(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    form, more = BACKWARD[case]
    text = form.format(count=count, more=more.format())
    keep_families(monkeypatch, whole=True)
    asked = Compilation(method, METHODS[method], OUTPUTS, backward=True)
    assert family_run(read_spec(text, "system.yaml"), asked) is not None
    found = followed(ready(text, backward=True, method=method), text, -1.0)
    keep_families(monkeypatch, whole=False)
    expected = followed(ready(text, backward=True, method=method), text, -1.0)
    assert found.keys() == expected.keys()
    alike(found, expected, CLOSE[method])


@pytest.mark.exhaustive(keep=0.15)
def test_a_dataset_of_integrals_takes_no_more_text(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)

    def counted(count: int) -> tuple[int, int]:
        text = DRIVEN.format(count=count, more=CASES["damped"][1].format())
        system = systems.family_system(read_spec(text, "system.yaml"))
        assert system is not None
        program = ready(text).machine.program
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert counted(30) == counted(50)


AT_REST = """
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum((x[i + 1] - x[i])**2/2 + (x[i + 1] - x[i])**4/4 for i in range(N - 1)) - x[0]*cos(2*t)/10
"""


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("precision", [DOUBLE, DOUBLE_DOUBLE])
def test_balances_of_a_chain_at_rest_that_is_pushed_at_its_end(
    precision: str, whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Far from the end, forces grow as high powers of t, from 1e-300 on: beside that at the end they are
    nothing, and need no steps of their own."""
    text = AT_REST.format(count=30)
    tolerance, close = (2.0**-52, 1e-14) if precision is DOUBLE else (FULL_DOUBLE_DOUBLE, 1e-29)
    asked = Compilation("taylor", tolerance, OUTPUTS, precision=precision)
    keep_families(monkeypatch, whole=whole)
    spec = read_spec(text, "system.yaml")
    assert (family_run(spec, asked) is not None) is whole
    derive = partial(derive_system, resting=True, exact=precision is DOUBLE_DOUBLE)
    values = resolve_long_values(spec, {}) if precision is DOUBLE_DOUBLE else resolve_values(spec, {})
    found = run(prepare_system(spec, derive, None, asked), values, 0.0, 2.0, 7).data
    for path, balance in found.items():
        if "ledger" in path:
            assert np.max(np.abs(balance), initial=0.0) <= close, path
    # every force but the first one is between members: the momenta add up to the impulse
    assert np.sum(found["v/x"][-1]) == pytest.approx(np.sin(4.0) / 20, abs=1e-13)
