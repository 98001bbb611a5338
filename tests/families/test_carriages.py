"""Particles on what one coordinate, or a few, move: families whose mass matrix has a border."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.joints import carriages
from tests.support.families import alike, followed

WRITTEN = frozenset(["q", "v", "h", "p", "T", "U", "positions"])
START = """
sizes: {{N: {count}}}
parameters: {{M: {mass}, l: 0.8, g: 9.81, k: 3, "m[i in range(N)]": 0.1 + i/30}}
coordinates:
  X: {{initial: 0.2, velocity: -0.3}}
  Y: {{initial: -0.1}}
  a[i in range(N)]: {{initial: 0.5 + 0.3*i, velocity: 0.4*cos(i)}}
"""
PLANE = """
masses: {{cart: M, "bob[i in range(N)]": "m[i]"}}
embedding:
  cart: [X, Y]
  bob[i in range(N)]: {bob}
potential: k*X**2/2 + k*Y**2 + sum(m[i]*g*bob[i].y for i in range(N)) + {more}
"""
CASES = {
    "pendulums on a cart": PLANE.replace("{bob}", '["X + l*sin(a[i])", "Y - l*cos(a[i])"]').replace(
        "{more}", "0"
    ),
    "joined by springs": PLANE.replace("{bob}", '["X + i + l*sin(a[i])", "Y - l*cos(a[i])"]').replace(
        "{more}", "sum(k*norm(bob[i] - bob[i - 1])**2 for i in range(1, N))"
    ),
    "driven and damped": PLANE.replace(
        "{bob}", '["X/2 + l*sin(a[i]) + sin(t)/9", "Y - l*cos(a[i])"]'
    ).replace("{more}", "0")
    + 'generalized_forces: {{X: "sin(2*t) - X_dot/5", "a[i in range(N)]": "-0.1*a_dot[i]"}}\n'
    + 'forces: {{cart: [0, 1], "bob[i in range(N)]": ["-bob[i].vx/9", "0.2"]}}\n',
    "beads on wires": PLANE.replace("{bob}", '["X + a[i]", "Y + a[i]**2/3"]').replace("{more}", "0"),
    "coordinates that multiply": PLANE.replace("{bob}", '["X*cos(a[i])", "Y - sin(a[i])"]').replace(
        "{more}", "0"
    ),
}


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", CASES)
def test_motions_are_those_of_the_members(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In loops, also if what carries the others does not stand apart in a sum."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    monkeypatch.setattr(carriages, "FEWEST", 3)
    for count in (1, 2, 9):
        mass = float(np.random.default_rng(count).uniform(0.5, 3.0))
        text = (START + CASES[case]).format(count=count, mass=mass)
        monkeypatch.setattr(systems, "FEWEST", 0)
        ready, found = followed(text, WRITTEN)
        assert ready.machine.program.loops
        with monkeypatch.context() as members:
            members.setattr(systems, "made", lambda *_: None)
            ready, expected = followed(text, WRITTEN)
        assert not ready.machine.program.loops
        alike(found.data, expected.data, 1e-11, count, mass)


@pytest.mark.exhaustive(keep=0.55)
def test_a_thousand_pendulums_push_one_cart() -> None:
    """All swing as one of their mass does, and the momentum of all stays 0: a closed form of small swings is
    x = -(m/(M + m)) l a, with a frequency of sqrt(g (M + m)/(M l))."""
    text = """
sizes: {N: 1000}
parameters: {g: 9.81, l: 2.0}
coordinates: {X: {initial: -1e-6}, "a[i in range(N)]": {initial: 1e-6}}
masses: {cart: 1, "bob[i in range(N)]": 1/N}
embedding: {cart: [X, 0], "bob[i in range(N)]": ["X + l*sin(a[i])", "-l*cos(a[i])"]}
potential: sum(g/N*bob[i].y for i in range(N))
"""
    ready, motion = followed(text, frozenset(["q"]), stop=1.3)
    assert ready.machine.program.loops
    angle = 1e-6 * np.cos(np.sqrt(9.81 * 2 / 2.0) * motion["t"])
    assert np.abs(motion["q/a"] - angle[:, None]).max() <= 1e-16
    assert np.abs(motion["q/X"] + angle).max() <= 1e-16


@pytest.mark.exhaustive(keep=0.35)
def test_balances_of_what_is_joined_to_its_cart() -> None:
    """The momentum of all is conserved, though its rate is a sum of large forces that cancel."""
    text = """
sizes: {N: 20}
parameters: {g: 2.1, l: 0.7}
coordinates: {X: {initial: 0.1, velocity: 0.3}, "a[i in range(N)]": {initial: 0.3*cos(2*i)}}
masses: {cart: 1.5, "p[i in range(N)]": 1}
embedding:
  cart: [X, 0]
  p[i in range(N)]: ["X + sum(l*sin(a[j]) for j in range(i + 1))", "-sum(l*cos(a[j]) for j in range(i + 1))"]
potential: sum(g*p[i].y + 0.5*((p[i].x - cart.x)**2 + p[i].y**2) for i in range(N))
"""
    ready, motion = followed(text, frozenset(["q", "p", "h", "ledger"]), stop=0.5)
    assert ready.machine.program.loops and {"p_X", "h"} <= {*ready.recording.conserved}
    assert motion.outcome.steps <= 60
    largest = np.abs(motion["diagnostics/p/a"]).max()
    assert np.abs(motion["diagnostics/ledger/p/a"]).max() <= 1e-13 * largest
