"""What families conserve, beside what is proven of the same systems member by member."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.errors import SpecError
from lagrange_cli.families import system as systems
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.native.families import jets
from lagrange_cli.run.check import classify
from lagrange_cli.run.classification import as_text
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_systems import drawn
from tests.support.motion import SYSTEMS, run

BODIES = """
name: bodies
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: cos(i)}}
  y[i in range(N)]: {{initial: sin(2*i)}}
  z[i in range(N)]: {{initial: i}}
masses: {{"body[i in range(N)]": 1 + i/2}}
embedding: {{"body[i in range(N)]": ["x[i]", "{scale}*y[i]", "z[i]"]}}
potential: {potential}
{forces}
solve: {{stop: 1}}
"""
PAIRS = "sum({} for i in range(N) for j in range(i))"
GRAVITY = PAIRS.format("-1/norm(body[i] - body[j])")
CASES = {
    "gravity": {"potential": GRAVITY},
    "another scale": {"potential": GRAVITY, "scale": 3},
    "in a field": {"potential": f"{GRAVITY} + sum(9.81*(1 + i/2)*body[i].z for i in range(N))"},
    "in one that changes": {"potential": f"{GRAVITY} + sum(sin(t)*body[i].z for i in range(N))"},
    "about an axis": {"potential": f"{GRAVITY} + sum(body[i].x**2 + body[i].y**2 for i in range(N))"},
    "no forces": {"potential": "0"},
    "one is held": {"potential": f"{GRAVITY} + x[0]**2"},
    "damped": {"potential": GRAVITY, "forces": 'generalized_forces: {"x[i in range(N)]": "-x_dot[i]"}'},
    "pulled": {"potential": GRAVITY, "forces": 'forces: {"body[i in range(N)]": ["0", "0", "1 + i/2"]}'},
    "pushed apart": {
        "potential": GRAVITY, "forces": 'generalized_forces: {"x[0]": "sin(t)", "x[1]": "-sin(t)"}',
    },
    "charged, in a magnetic field": {
        "potential": f"{GRAVITY} - sum(i*(body[i].x*body[i].vy - body[i].y*body[i].vx) for i in range(N))",
    },
    "with the same charge, in a gauge": {
        "potential": f"{GRAVITY} - sum((1 + i/2)*x[i]*y_dot[i] for i in range(N))", "scale": 2,
    },
    "in a field of others": {
        "potential": PAIRS.format("(x[i] - x[j])*(y_dot[i] - y_dot[j]) - (y[i] - y[j])*x_dot[j]"),
    },
    "turned by a field": {
        "potential": GRAVITY,
        "forces": 'generalized_forces: {"x[i in range(N)]": "y_dot[i]", "y[i in range(N)]": "-x_dot[i]"}',
    },
}  # fmt: skip


def of_members(text: str) -> tuple[tuple[str, ...], dict[str, Conserved]]:
    """The cyclic coordinates, and what is conserved, by derivation member by member."""
    residual = derive_system(read_spec(text, "system.yaml"))
    found = [*residual.conserved, *(one.conserved for one in symmetries(residual.model, residual.conserved))]
    return residual.cyclic, {one.quantity: one for one in found}


def of_families(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[tuple[str, ...], dict[str, Conserved]]:
    """The same of families."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None
    found = constants_of(system)
    return found.cyclic, {one.quantity: one for one in found.conserved}


def displaced(expected: dict[str, Conserved]) -> set[str]:
    """What follows from displacements that L does not change by, as families find it: not from those with a
    constant acceleration."""
    kinds = ("P_", "L_", "K_", "p_", "h_")
    steady = {name for name, one in expected.items() if "constant acceleration" not in one.because}
    return {name for name in steady if name[:2] in kinds or name == "h"}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("case", CASES)
def test_particles_conserve_what_their_members_do(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = BODIES.format(**{"count": 3, "scale": 1, "forces": ""} | CASES[case])
    cyclic, found = of_families(text, monkeypatch)
    expected_cyclic, expected = of_members(text)
    assert cyclic == expected_cyclic
    assert found.keys() == displaced(expected)
    for name, one in found.items():
        assert one == expected[name]


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", ["gravity", "another scale", "about an axis", "pulled"])
def test_what_is_conserved_is_written(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = BODIES.format(**{"count": 3, "scale": 1, "forces": ""} | CASES[case])

    def followed(fewest: int) -> tuple[Prepared, Mapping[str, NDArray[np.float64]]]:
        monkeypatch.setattr(systems, "FEWEST", fewest)
        spec = read_spec(text, "system.yaml")
        outputs = frozenset(["conserved"])
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
        return ready, run(ready, resolve_values(spec, {}), 0.0, 0.3, 4).data

    (together, found), (apart, expected) = followed(0), followed(10**9)
    names = [one.path for one in together.recording.datasets]
    assert set(names) <= {one.path for one in apart.recording.datasets} and len(names) > 1
    for name in names:
        size = 1 + np.max(np.abs(expected[name]))
        assert np.max(np.abs(found[name] - expected[name])) <= 2.0**-40 * size
        assert np.ptp(found[name]) <= 2.0**-40 * size
    assert {f"diagnostics/conserved/{one}" for one in ("P_x", "L_z", "K_x")} & {*names}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", range(40))
def test_random_families_conserve_what_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} conserved {case}"))
    cyclic, found = of_families(text, monkeypatch)
    expected_cyclic, expected = of_members(text)
    assert cyclic == expected_cyclic, text
    plain = {name for name in expected if name[:2] == "p_" or name == "h"}
    assert {name for name in found if name[:2] == "p_" or name == "h"} == plain, text


def test_a_ring_keeps_its_momentum(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (SYSTEMS / "lattice.yaml").read_text().replace("w**2*(1 - cos(u[i, j]))", "0*w")
    _, found = of_families(text, monkeypatch)
    assert found["P_u"].expression == "sum of p_u[i,j]"
    assert found["P_u"].because == "changing all u[i,j] alike leaves L unchanged"


@pytest.mark.exhaustive(keep=0.65)
def test_check_of_many_bodies_says_what_it_says_of_few(monkeypatch: pytest.MonkeyPatch) -> None:
    def said(count: int) -> str:
        text = BODIES.format(count=count, scale=1, potential=GRAVITY, forces="")
        found = classify(read_spec(text, "bodies.yaml"))
        shown = as_text(found, verbose=False)
        return shown.replace(f"..{count - 1}]", "..]").replace(f"{3 * count} degrees", "degrees")

    assert said(120) == said(4)


def test_check_refuses_series_that_are_too_large_as_solve_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jets, "MOST_NUMBERS", 10_000)
    spec = read_spec((SYSTEMS / "lattice.yaml").read_text(), "lattice.yaml", {"N": "20", "M": "20"})
    with pytest.raises(SpecError, match="Taylor series of this system are"):
        classify(spec)


CART = """
sizes: {{N: 3}}
parameters: {{m: 1.5, l: 1.0, M: 2.0, k: 0.7}}
coordinates:
  X: {{initial: 0.1}}
  Y: {{initial: 0.2}}
  theta[i in range(N)]: {{initial: 2.0 + 0.1*i}}
masses: {{cart: M, "bob[i in range(N)]": "m*(i + 1)"}}
embedding:
  cart: [{cart}]
  bob[i in range(N)]:
    - {x} + sum(l*sin(theta[j]) for j in range(i + 1))
    - {y} - sum(l*cos(theta[j]) for j in range(i + 1))
potential: {potential}
generalized_forces: {{Y: "{force}"}}
solve: {{stop: 1}}
"""
CARTS = {
    "free": {"potential": "0"},
    "on a scale": {"potential": "0", "cart": "2*X, Y/2", "x": "2*X", "y": "Y/2"},
    "mirrored": {"potential": "0", "cart": "-Y, X", "x": "-Y", "y": "X"},
    "falling": {"potential": "M*Y + sum(m*(i + 1)*bob[i].y for i in range(N))"},
    "round the origin": {
        "potential": "sum(k*bob[i].x**2 + k*bob[i].y**2 for i in range(N)) + k*M*(X**2 + Y**2)"
    },
    "held": {"potential": "sum(k*norm(bob[i] - cart) for i in range(N))", "force": "-Y"},
    "inside": {"potential": "sum(k*norm(bob[i] - cart)**2 for i in range(N))"},
    # where families show more: what the members conserve is found only where combinations of few are tried
    "bent": {"potential": "0", "cart": "X, Y + X**2", "y": "(Y + X**2)"},
    "hung": {"potential": "0", "x": "0", "y": "0"},
}  # fmt: skip


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("case", "count"),
    [
        *((case, count) for case in CARTS for count in (1, 2, 3) if (case, count) != ("hung", 1)),  # no chain
        *((case, 8) for case in ("free", "inside")),
    ],
)
def test_chains_conserve_what_their_members_do(
    case: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    given = {"cart": "X, Y", "x": "X", "y": "Y", "force": "0"} | CARTS[case]
    text = CART.format(**given).replace("{N: 3}", f"{{N: {count}}}")
    cyclic, found = of_families(text, monkeypatch)
    expected_cyclic, expected = of_members(text)
    assert cyclic == expected_cyclic
    known = displaced(expected)
    more = {"bent": {"P_x", "K_x", "L_z"}, "hung": {"P_theta"}}.get(case, set())
    assert known <= found.keys() <= known | more
    for name in known:
        assert found[name] == expected[name]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", ["free", "mirrored", "on a scale", "inside", "bent"])
def test_what_chains_conserve_is_written(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"cart": "X, Y", "x": "X", "y": "Y", "force": "0"} | CARTS[case]

    def followed(fewest: int) -> Mapping[str, NDArray[np.float64]]:
        monkeypatch.setattr(systems, "FEWEST_JOINTED", fewest)
        spec = read_spec(CART.format(**given), "system.yaml")
        outputs = frozenset(["conserved"])
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
        return run(ready, resolve_values(spec, {}), 0.0, 0.3, 4).data

    found, expected = followed(0), followed(10**9)
    names = {name for name in found if "conserved" in name}
    assert len(names) > 3
    for name in names & expected.keys():
        size = 1 + np.max(np.abs(expected[name]))
        assert np.max(np.abs(found[name] - expected[name])) <= 2.0**-40 * size
    for name in names:
        assert np.ptp(found[name]) <= 2.0**-40 * (1 + np.max(np.abs(found[name])))
