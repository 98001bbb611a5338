"""Which coordinates accelerations depend on: by the tables of families, and by expressions written singly."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.native.stepping.coupling import of_residual
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import Motion, residual_of, run, spec_of

RING = """
sizes: {N: 40}
coordinates:
  x[i in range(N)]: {initial: cos(2*pi*i/N)*(1 + 0.05*cos(3*i))}
  y[i in range(N)]: {initial: sin(2*pi*i/N)*(1 + 0.05*cos(5*i))}
masses: {bead[i in range(N)]: 1}
embedding: {bead[i in range(N)]: [x[i], y[i]]}
potential: sum(5e4*(norm(bead[(i + 1) % N] - bead[i]) - 0.3)**2 for i in range(N))
dissipation: sum(50*(x_dot[i]**2 + y_dot[i]**2) for i in range(N))
"""
DRIVEN = """
sizes: {N: 30}
coordinates: {u[i in range(N)]: {initial: sin(i)}}
masses: {bead[i in range(N)]: 1 + i}
embedding: {bead[i in range(N)]: u[i]}
potential: sum((u[i + 2] - u[i])**2 for i in range(N - 2)) + u[0]**2 + u[1]**2*cos(t)
dissipation: sum((u_dot[i + 1] - u_dot[i])**2 for i in range(N - 1))
"""
ALL = (
    RING.replace("N: 40", "N: 12")
    .replace("(i + 1) % N] - bead[i]", "i] - bead[j]")
    .replace("range(N))\ndiss", "range(N) for j in range(i))\ndiss")
)


BARS = """
sizes: {N: 30}
coordinates:
  x[i in range(N)]: {initial: 2*i + cos(i)}
  y[i in range(N)]: {initial: sin(i)}
  u[i in range(N)]: {initial: 2*i, velocity: 0.1*sin(i)}
masses: {bob[i in range(N)]: 1, cart[i in range(N)]: 1 + i/9}
embedding: {bob[i in range(N)]: [x[i], y[i]], cart[i in range(N)]: [u[i], 0]}
potential: sum(9.81*y[i] for i in range(N)) + sum(20*(u[i + 1] - u[i] - 2)**2 for i in range(N - 1))
constraints: {bar[i in range(N)]: (x[i] - u[i])**2 + y[i]**2 - 1}
"""
"""Pendulums on carts with springs between them: a cart's acceleration depends on those beside it."""
SKATES = """
sizes: {N: 24}
coordinates:
  x[i in range(N)]: {initial: i, velocity: cos(i)}
  y[i in range(N)]: {initial: sin(i), velocity: sin(i)}
  a[i in range(N)]: {initial: i, velocity: 1}
lagrangian: sum(x_dot[i]**2/2 + y_dot[i]**2/2 + a_dot[i]**2/4 - 9.81*y[i] for i in range(N))
nonholonomic: {edge[i in range(N)]: cos(a[i])*y_dot[i] - sin(a[i])*x_dot[i]}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("text", "reach"),
    [(RING, 6), (DRIVEN, 2), (ALL, 23), (BARS, 5), (SKATES, 2)],
    ids=["ring", "driven", "all", "bars", "skates"],
)
def test_tables_and_expressions_say_the_same(text: str, reach: int) -> None:
    one, other = of_families(systems.made(spec_of(text))), of_residual(residual_of(text))
    assert one.band == other.band
    assert one.band.reach == reach
    assert sorted(one.places or range(one.band.size)) == list(range(one.band.size))


def moved(text: str, method: str, tolerance: float) -> Motion:
    """A motion; derivatives that belong elsewhere would be taken again and again."""
    systems._LATEST.clear()
    spec = spec_of(text)
    asked = Compilation(method, tolerance, frozenset({"q", "v"}))
    ready = prepare_system(spec, derive_system, None, asked)
    motion = run(ready, resolve_values(spec, {}), 0.0, 0.5, 3)
    if method == "Radau":
        assert motion.outcome.evaluations < 9 * motion.outcome.steps + 150
    return motion


def test_derivatives_belong_to_coordinates_in_another_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    moved(RING, "Radau", 1e-8)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("text", [RING, DRIVEN, BARS, SKATES], ids=["ring", "driven", "bars", "skates"])
def test_families_move_as_their_members_do(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where coordinates are in another order than the rows of the matrices, too."""
    ends = []
    for fewest, method, tolerance in ((0, "Radau", 1e-8), (10**6, "Radau", 1e-8), (0, "taylor", 2.0**-52)):
        monkeypatch.setattr(systems, "FEWEST", fewest)
        data = moved(text, method, tolerance).data
        ends.append(np.concatenate([data[path][-1] for path in sorted(data) if path != "t"]))
    assert np.max(np.abs(ends[0] - ends[1])) < 1e-9
    assert np.max(np.abs(ends[0] - ends[2])) < 1e-5
    assert np.any(ends[0] != ends[2])
