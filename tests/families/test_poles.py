"""Steep and weak poles of forces in large systems: no step of ias15 passes over them."""

from __future__ import annotations

from math import gamma, pi, sqrt

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.families import narrow
from lagrange_cli.spec.read import read_spec
from tests.support.families import followed

WALLS = """
sizes: {{N: 40}}
parameters: {{k: {k}}}
coordinates: {{"x[i in range(N)]": {{initial: "100 + i", velocity: "-2 - i/10"}}}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(k/{distance}**{n} for i in range(N))
"""
FALL = """
sizes: {N: 40}
coordinates: {"x[i in range(N)]": {initial: "1 + i/8"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: sum(x[i] + 1e-40/(x[i]**2)**12 for i in range(N))
"""
GAS = """
sizes: {{N: 36}}
coordinates:
  x[i in range(N)]: {{initial: "{gap}*(i % 6) + 0.1*sin({seed} + 5*i)", velocity: "3*sin({seed} + i*i)"}}
  y[i in range(N)]: {{initial: "{gap}*(i//6) + 0.1*cos({seed} + 3*i)", velocity: "3*cos({seed} + 7*i*i)"}}
masses: {{"atom[i in range(N)]": 1 + i % 3}}
embedding: {{"atom[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "sum({pair} for i in range(N) for j in range(i))"
"""
R2 = "dot(atom[i] - atom[j], atom[i] - atom[j])"
PAIRS = {
    "Lennard-Jones": f"(1/{R2})**6 - (1/{R2})**3",
    "soft spheres, softened": f"1e-3/({R2} + 0.01)**5",
    "feeble": f"1e-25/{R2}**6",
    "of squares of charges": "1e-9*(1 + i % 2)*(1 + j % 2)/norm(atom[i] - atom[j])",
}


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("k", "n", "wall"), [(1, 12, 0.0), (1e-19, 12, 0.0), (1e-30, 4, 0.0), (1e-5, 24, 0.5), (1e-12, 3, -1.0)]
)
def test_beads_return_from_a_wall(k: float, n: int, wall: float) -> None:
    """Far away they have the speed with which they came, and the time that they need is an integral: with
    u = x/x0 of the turning point x0, that of du/sqrt(1 - u^-n) to U is U + B(-1/n, 1/2)/n."""
    text = WALLS.format(k=k, n=n, distance=f"norm((x[i] - ({wall})*t, 0))")
    motion = followed(text, frozenset({"q", "v"}), 200.0, 2, "ias15")[1]
    i = np.arange(40)
    speed = 2 + i / 10 + wall
    turn = (2 * k / speed**2) ** (1 / n)
    late = gamma(-1 / n) * sqrt(pi) / gamma(0.5 - 1 / n) / n
    place = 200 * speed - 100 - i - 2 * turn * late
    assert motion["q/x"][-1] == pytest.approx(place + 200 * wall, rel=1e-9, abs=1e-9)
    assert motion["v/x"][-1] == pytest.approx(speed + wall, rel=1e-9, abs=1e-9)


@pytest.mark.exhaustive(keep=0.5)
def test_beads_that_fall_from_rest_bounce() -> None:
    """They return to where they were let go: at first nothing tells that they come near the wall."""
    _, motion = followed(FALL, frozenset({"q", "v"}), 20.0, 2001, "ias15")
    height = 1 + np.arange(40) / 8
    assert np.all(motion["q/x"] > 0)
    period = 2 * np.sqrt(2 * height)
    t = motion.t[:, None] % period - period / 2
    assert np.max(np.abs(motion["q/x"] - (height - (np.abs(t) - period / 2) ** 2 / 2))) < 0.5


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("name", PAIRS)
def test_gases_move_as_with_series(name: str, seed: int) -> None:
    text = GAS.format(seed=seed, gap=1.3, pair=PAIRS[name])
    assert not narrow(family_system(read_spec(text, "gas.yaml")), "ias15")
    (_, found), (_, expected) = (
        followed(text, frozenset({"q", "v", "h"}), 0.4, 3, method) for method in ("ias15", "taylor")
    )
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert found[path] == pytest.approx(expected[path], rel=1e-9, abs=1e-9), (name, seed)
    drifts = [np.ptp(one["diagnostics/h"]) for one in (found, expected)]
    assert drifts[0] <= 4 * drifts[1] + 1e-12 * abs(expected["diagnostics/h"][0])
