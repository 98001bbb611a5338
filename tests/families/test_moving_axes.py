"""Particles along axes that move: M is diagonal and constant, and forces depend on t only where they do."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.support.families import alike, followed

WRITTEN = frozenset(["q", "v", "h", "p", "T", "U", "positions"])
TURNING = "x[i]*cos({angle}) - y[i]*sin({angle})", "x[i]*sin({angle}) + y[i]*cos({angle})"
AXES = {
    "turning": ("w*t", *TURNING),
    "turning faster and faster": ("w*t**2", *TURNING),
    "of a point that moves": ("w*t", "x[i] + sin(w*t)", "y[i] - w*t**2"),
    "askew": ("w*t", "(x[i] + y[i])/sqrt(2)", "(x[i] - y[i])/sqrt(2)"),
    "turning about a point that moves": ("w*t", f"{TURNING[0]} + sin(t)", f"{TURNING[1]} - cos(2*t)"),
}
POTENTIALS = {
    "a centre": "-sum(k/sqrt(0.3 + dot(b[i], b[i])) for i in range(N))",
    "pairs": "-sum(k*m[i]/sqrt(0.4 + dot(b[i] - b[j], b[i] - b[j])) for i in range(N) for j in range(i))",
    "a field": "sum(9.8*b[i].y + k*b[i].x**2/2 for i in range(N))",
}
TEXT = """
sizes: {{N: {count}}}
parameters: {{w: {speed}, k: 0.7, "m[i in range(N)]": 1 + i/5}}
coordinates:
  x[i in range(N)]: {{initial: 1.5*cos(7*i), velocity: 0.3*sin(i)}}
  y[i in range(N)]: {{initial: 1 + 0.4*i, velocity: 0.2}}
masses: {{"b[i in range(N)]": "m[i]"}}
embedding: {{"b[i in range(N)]": ["{x}", "{y}"]}}
potential: "{potential}"
generalized_forces: {{"x[i in range(N)]": -0.1*x_dot[i]}}
"""


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("potential", POTENTIALS.values(), ids=POTENTIALS)
@pytest.mark.parametrize("axes", AXES.values(), ids=AXES)
def test_motions_are_those_of_the_members(
    axes: tuple[str, str, str], potential: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also the energies, in any number of members."""
    angle, x, y = axes
    for count in (1, 3):
        speed = float(np.random.default_rng(count).uniform(0.3, 2.0))
        places = {"x": x.format(angle=angle), "y": y.format(angle=angle)}
        text = TEXT.format(count=count, speed=speed, potential=potential, **places)
        monkeypatch.setattr(systems, "FEWEST", 10**9)
        ready, expected = followed(text, WRITTEN)
        assert not ready.machine.program.loops
        monkeypatch.setattr(systems, "FEWEST", 0)
        ready, found = followed(text, WRITTEN)
        assert ready.machine.program.loops
        alike(found.data, expected.data, 1e-12, count, speed)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("fewest", [0, 10**9])
def test_turning_axes_leave_no_trace_of_time(fewest: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A circle as seen from axes that turn with it: a particle rests, in one step, with members written out
    and not."""
    monkeypatch.setattr(systems, "FEWEST", fewest)
    coordinates = "{'x[i in range(N)]': {initial: 1}, 'y[i in range(N)]': {initial: 0}}"
    x, y = (one.format(angle="w*t") for one in TURNING)
    text = f"""
sizes: {{N: 3}}
parameters: {{w: 1}}
coordinates: {coordinates}
masses: {{"b[i in range(N)]": 1}}
embedding: {{"b[i in range(N)]": ["{x}", "{y}"]}}
potential: -sum(1/norm(b[i]) for i in range(N))
"""
    _, motion = followed(text, frozenset(["q"]), stop=20.0)
    assert motion.outcome.steps <= 2
    assert np.abs(motion["q/x"] - 1).max() <= 1e-15 and np.abs(motion["q/y"]).max() <= 1e-15
