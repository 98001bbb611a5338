"""Tails of waves: members that hardly move beside others of their family."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import Motion, run

CHAIN = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: i + 1}}
  y[i in range(N)]: {{initial: 0, velocity: exp(-i**2/2)}}
masses: {{"bob[i in range(N)]": 1.0}}
positions: {{"bob[i in range(N)]": ["x[i]", "y[i]"]}}
constraints:
  rod[0]: x[0]**2 + y[0]**2 - 1
  rod[i in range(1, N)]: (x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - 1
"""
ROW = """
sizes: {N: 12}
coordinates: {"u[i in range(N)]": {initial: 0, velocity: "exp(-2*i**2)"}}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) - 9*sum((u[i] - u[i - 1])**2/2 for i in range(1, N))
"""


def moved(text: str, stop: float) -> Motion:
    spec = read_spec(text, "system.yaml")
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, frozenset("qvh")))
    return run(ready, resolve_values(spec, {}), 0.0, stop, 3)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("count", [8, 20])
def test_a_straight_chain_with_a_tail_takes_the_steps_of_its_head(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = CHAIN.format(count=count)
    apart = moved(text, 1.0)
    assert apart.outcome.steps < 25
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    monkeypatch.setattr(systems, "_LATEST", [])
    together = moved(text, 1.0)
    for path in "q/x", "q/y", "v/x", "v/y":
        assert np.max(np.abs(apart.data[path] - together.data[path])) < 1e-13


def test_a_tail_is_right_beside_its_head() -> None:
    """Free ends: the modes are cosines, of the frequencies 6 sin(pi k/24)."""
    found = moved(ROW, 0.5)
    assert found.outcome.steps < 50
    sites, modes = np.arange(12), np.arange(12)
    shapes = np.cos(np.pi * np.outer(modes, sites + 0.5) / 12)
    shapes /= np.linalg.norm(shapes, axis=1)[:, None]
    rates = 6 * np.sin(np.pi * modes / 24)
    at_start = shapes @ np.exp(-2.0 * sites**2)
    expected = shapes.T @ (at_start * 0.5 * np.sinc(rates * 0.5 / np.pi))
    assert np.max(np.abs(found.data["q/u"][-1] - expected)) < 1e-15
