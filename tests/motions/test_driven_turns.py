"""Friction against the velocity of what is driven, where that turns round: nothing holds it there."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import lagrange_cli as lagrange

DRIVEN = """
parameters: {{w: 1.3}}
coordinates:
  x: {{initial: {start}}}
  y: {{initial: {beside}}}
masses: {{b: 1.7}}
embedding: {{b: [x, y]}}
constraints: {{rail: "x - ({place})"}}
forces: {{b: -0.3*{normal}*(b.vx, b.vy)/norm((b.vx, b.vy))}}
potential: {potential}
"""
NORMALS = {"constant": "1", "of the force of constraint": "abs(rail.multiplier + 1)"}
METHODS = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-7, "Radau": 1e-6}

RELEASED = """
coordinates:
  x: {initial: 0.623 + 0.868*sin(0.947), velocity: -0.45*cos(0.947)}
  y: {initial: -0.289 - 0.868*cos(0.947), velocity: -0.45*sin(0.947)}
  u: {initial: -0.434 - 0.564*sin(1.399)}
  v: {initial: -0.466 - 0.564*cos(1.399)}
masses: {a: 0.903, b: 1.891}
embedding: {a: [x, y], b: [u, v]}
potential: 45*max(0, sqrt(dot(b - a, b - a) + 0.01) - 0.33)**2/2
forces: {b: -0.085*abs(rod.multiplier)*(b.vx, b.vy)/norm((b.vx, b.vy))}
constraints: {other: "(x - 0.623)**2 + (y + 0.289)**2 - 0.868**2", rod: "norm(b - (-0.434, -0.466)) - 0.564"}
"""


def solved(text: str, method: str, stop: float) -> lagrange.Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        tolerance = {"DOP853": 1e-10, "Radau": 1e-9}.get(method)
        given = {} if tolerance is None else {"tolerance": tolerance}
        outputs = "q,v,constraints,ledger"
        return lagrange.solve(text, stop=stop, samples=81, method=method, outputs=outputs, **given)


def errors(motion: lagrange.Motion) -> float:
    """How far constraints and balances are from 0."""
    checked = [one for name, one in motion.datasets.items() if "constraints" in name or "ledger" in name]
    assert len(checked) == 4
    return max(float(np.max(np.abs(one))) for one in checked)


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("beside", [0.0, 0.2])
@pytest.mark.parametrize("potential", ["x", "2*y**2"])
def test_what_is_driven_turns_round(method: str, normal: str, beside: float, potential: str) -> None:
    """It stood still, 0.3 and more from its rail, and nothing was said."""
    given = {"place": "0.3*sin(w*t)", "start": 0, "beside": beside, "potential": potential}
    motion = solved(DRIVEN.format(**given, normal=NORMALS[normal]), method, 4)
    assert errors(motion) < METHODS[method]
    assert np.max(np.abs(motion.q["x"] - 0.3 * np.sin(1.3 * motion.t))) < METHODS[method]
    if potential == "x" or not beside:
        assert np.all(motion.q["y"] == beside)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", METHODS)
def test_what_is_driven_rests_for_a_time(method: str) -> None:
    """While its rail does, friction holds it beside the rail's place; and again it lets go."""
    place = "0.3*(1 - cos(pi*min(t, 1))) + where(t > 2, (t - 2)**2, 0)"
    given = {"place": place, "start": 0, "beside": 0.1, "potential": "0.2*y**2"}
    motion = solved(DRIVEN.format(**given, normal=NORMALS["of the force of constraint"]), method, 3)
    assert errors(motion) < METHODS[method]
    rests = (motion.t > 1.7) & (motion.t < 2)
    assert np.ptp(motion.q["y"][rests]) == 0.0 and np.all(motion.v["y"][rests] == 0.0)
    assert motion.q["x"][-1] == pytest.approx(1.6, abs=METHODS[method])


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", METHODS)
def test_a_bob_that_rubs_by_the_force_of_its_rod_is_released(method: str) -> None:
    """From rest, where friction cannot hold it: with ``Radau``, no motion began."""
    motion, exact = solved(RELEASED, method, 0.5), solved(RELEASED, "taylor", 0.5)
    for name in ("u", "v"):
        assert np.max(np.abs(motion.q[name] - exact.q[name])) < METHODS[method]
