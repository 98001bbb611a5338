"""Families in double-double, and with a certificate: beside members written out, closed forms and exact
numbers."""

from __future__ import annotations

import random
from collections.abc import Mapping
from fractions import Fraction
from functools import partial
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.family_program import write_families
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from lagrange_cli.native.families import jets
from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values
from tests.families import test_chains, test_constraints, test_systems
from tests.support.motion import run

MP = mpmath.mp.clone()
MP.dps = 50
BOUND = 2.0**-92
OUTPUTS = frozenset(["q", "v", "p", "h", "observables"])
OF_CONSTRAINTS = frozenset(["q", "v", "h", "positions", "constraints", "multipliers", "reactions"])
RING = """
sizes: {{N: {count}}}
parameters: {{m: 0.1, k: 0.7, "g[i in range(N)]": "0.3 + 0.1*i"}}
coordinates:
  u[i in range(N)]: {{initial: "sin(pi*(i + 1)/(N + 1))", velocity: 0.1}}
lagrangian: >
  sum(m*u_dot[i]**2/2 - k*u[i]**2/2 for i in range(N)) - {nonlinear}*sum(g[i]*u[i]**4 for i in range(N))
  - k*sum((u[i] - u[i - 1])**2 for i in range(1, N))/2 - 0.3*sum((1 - cos(u[i])) for i in range(N))
solve: {{stop: {stop}, step: 0.5}}
"""
CHAIN = """
sizes: {{N: {count}}}
coordinates: {{"u[i in range(N)]": {{initial: "sin(pi*(i + 1)/(N + 1))"}}}}
lagrangian: >
  sum(u_dot[i]**2/2 for i in range(N)) - u[0]**2/2 - u[N - 1]**2/2
  - sum((u[i] - u[i - 1])**2/2 for i in range(1, N))
"""


@pytest.fixture(autouse=True)
def whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small families stay families, too."""
    fewest(monkeypatch, 0)


def fewest(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    for name in ("FEWEST", "FEWEST_SWITCHED", "FEWEST_JOINTED", "FEWEST_BOUND"):
        monkeypatch.setattr(systems, name, count)
    monkeypatch.setattr(systems, "_LATEST", [])


def followed(text: str) -> tuple[Prepared, Mapping[str, NDArray[np.float64]]]:
    """A short motion in double-double, and what it was followed by."""
    spec = read_spec(text, "system.yaml")
    values, outputs = resolve_long_values(spec, {}), OUTPUTS
    if spec.constraints:
        spec, values, _ = consistent_values(spec, values, 0.0, (), exact=True)
        outputs = OF_CONSTRAINTS
    compilation = Compilation("taylor", FULL_DOUBLE_DOUBLE, outputs, precision=DOUBLE_DOUBLE)
    ready = prepare_system(spec, partial(derive_system, exact=True), None, compilation)
    return ready, run(ready, values, 0.0, 0.5, 6).data


def exactly(data: Mapping[str, NDArray[np.float64]], path: str) -> NDArray[np.object_]:
    """The numbers of a dataset with all their digits."""
    exact = np.vectorize(MP.mpf, otypes=[object])
    return exact(data[path]) + exact(data.get(f"low/{path}", 0.0))


@pytest.mark.exhaustive(keep=0.15, most=12)
@pytest.mark.parametrize("case", range(40))
@pytest.mark.parametrize(
    "kind", [test_systems, test_chains, test_constraints], ids=["lattices", "chains", "constraints"]
)
def test_families_move_as_their_members_do_in_double_double(
    kind: object, case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {case}")
    few = (chance.choice([1, 2, 3, 8]),) if kind is test_chains else ()  # others take long to write out
    text = kind.drawn(chance, *few)  # type: ignore[attr-defined]
    together, found = followed(text)
    fewest(monkeypatch, 10**9)
    apart, expected = followed(text)
    assert together.recording.datasets == apart.recording.datasets
    for path in expected:
        if not path.startswith("low/"):
            one, other = exactly(found, path), exactly(expected, path)
            size = max(1.0, float(np.max(np.abs(expected[path]), initial=0.0)))
            assert np.max(np.abs(one - other), initial=0.0) <= BOUND * size, (path, text)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9, 40])
def test_the_lowest_mode_of_a_chain_is_a_cosine(count: int) -> None:
    ready, found = followed(CHAIN.format(count=count))
    assert "@polynomial" in ready.machine.program.text  # type: ignore[attr-defined]
    step = MP.pi / (count + 1)
    frequency = 2 * MP.sin(step / 2)
    expected = [
        [MP.sin(step * (i + 1)) * MP.cos(frequency * MP.mpf(float(t))) for i in range(count)]
        for t in found["t"]
    ]
    assert np.max(np.abs(exactly(found, "q/u") - np.array(expected))) < 1e-30


def test_the_code_in_double_double_does_not_grow_with_a_family() -> None:
    def counted(count: int) -> int:
        spec = read_spec(RING.format(count=count, nonlinear=0.25, stop=1), "system.yaml")
        compilation = Compilation("taylor", FULL_DOUBLE_DOUBLE, OUTPUTS, precision=DOUBLE_DOUBLE)
        system = systems.family_system(spec, ExactGraphAlgebra)
        assert system is not None
        return len(write_families(system, compilation)[0].text.splitlines())

    assert counted(40) == counted(64)


@pytest.mark.exhaustive(keep=0.65)
def test_constants_of_a_companion_have_larger_rounding_errors() -> None:
    """1/M of a family, which is computed once: that of the run less so many times its error."""
    spec = read_spec(RING.format(count=9, nonlinear=0.25, stop=1), "system.yaml")
    found = {}
    for factor in (None, 8):
        compilation = Compilation("taylor", 2.0**-52, frozenset("qv"), precision=DOUBLE, factor=factor)
        system = systems.family_system(spec, ExactGraphAlgebra)
        assert system is not None
        machine = compile_program(write_families(system, compilation)[0], QUICK)
        values = resolve_long_values(spec, {})
        given = np.array([values.parameters[name] for name in machine.program.parameters])
        constants = np.zeros(machine.program.constants + 8)
        constants = constants[(-constants.ctypes.data % 64) // 8 :]
        both = np.concatenate([given, np.zeros_like(given)])
        machine.prepare(both.ctypes.data, constants.ctypes.data)
        found[factor] = constants
    run_has = float(1 / np.float64(0.1))
    exact = 1 / Fraction(0.1)
    companion = float(Fraction(run_has) + CONSTANTS * (exact - Fraction(run_has)))
    assert run_has != companion
    assert np.sum(found[None] == run_has) >= 9 and np.sum(found[None] == companion) == 0
    assert np.sum(found[8] == companion) >= 9


@pytest.mark.parametrize("options", [{"precision": DOUBLE_DOUBLE}, {"factor": 8}])
def test_another_method_is_not_named_where_there_is_none(
    options: Mapping[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = read_spec(CHAIN.format(count=9), "system.yaml")
    system = systems.family_system(spec, ExactGraphAlgebra)
    assert system is not None
    monkeypatch.setattr(jets, "MOST_NUMBERS", 100)
    for change in ({}, options):
        with pytest.raises(TooManyNumbers) as found:
            write_families(system, Compilation("taylor", 2.0**-52, frozenset("qv"), **change))
        assert ("--method ias15" in found.value.hint) == (not change)
