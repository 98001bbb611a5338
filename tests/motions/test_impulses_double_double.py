"""Impulses of constraints in double-double: what an action does not set is found to 31 digits, too."""

from __future__ import annotations

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.integrate.impacts import impulses

SPHERE = """
parameters: {{e: 0.8, g: 9.81}}
coordinates:
  x: {{initial: 0.5}}
  y: {{initial: 0.3, velocity: 1}}
  z: {{initial: -sqrt(0.66), velocity: 0.3/sqrt(0.66)}}
masses: {{b: 1.3}}
positions: {{b: [x, y, z]}}
potential: 1.3*g*b.z
constraints: {constraints}
events: {{wall: {{when: x - 0.2, direction: falling, action: {{set: {{{set}}}}}}}}}
observables: {{X: x, Y: y, vy: y_dot, vz: z_dot}}
"""
ONE, TWICE = "{s: x**2 + y**2 + z**2 - 1}", "{s: x**2 + y**2 + z**2 - 1, same: 3 - 3*(x**2 + y**2 + z**2)}"
BACK = "x_dot: -e*x_dot"
ALL = BACK + "".join(f", {q}_dot: {q}_dot + {q}*(1 + e)*x*x_dot/(y**2 + z**2)" for q in "yz")
SHORTER = """
sizes: {{N: 2}}
parameters: {{l: 1, g: 9.81}}
coordinates:
  {coordinates}
masses: {{"b[i in range(N)]": 1.3}}
positions: {{"b[i in range(N)]": [{x}, {y}]}}
potential: sum(1.3*g*b[i].y for i in range(N))
{constraints}
events: {{cut: {{when: t - 0.3, action: {{set: {{l: 0.9*l{more}}}}}}}}}
observables: {{X: b[0].x, Y: b[N - 1].y, V: b[0].vx}}
"""
CARTESIAN = {
    "coordinates": "x[i in range(N)]: {initial: sin(0.7 + i/99)}\n"
    "  y[i in range(N)]: {initial: -cos(0.7 + i/99)}",
    "x": "x[i]", "y": "y[i]", "constraints": "constraints: {'rod[i in range(N)]': x[i]**2 + y[i]**2 - l**2}",
    "more": "",
}  # fmt: skip
ANGLES = {
    "coordinates": "a[i in range(N)]: {initial: 0.7 + i/99}", "x": "l*sin(a[i])", "y": "-l*cos(a[i])",
    "constraints": "", "more": ", 'a_dot[i in range(N)]': a_dot[i]/0.9",
}  # fmt: skip


def followed(text: str, stop: float) -> lagrange.Motion:
    return lagrange.solve(text, stop=stop, samples=7, outputs="observables", precision="double-double")


def apart(one: lagrange.Motion, other: lagrange.Motion) -> float:
    """The largest difference of the observables, with their low parts."""
    names = [name for name in one.datasets if name.startswith("observables/")]
    assert names and one.attributes["events"] == other.attributes["events"]
    rest = [
        (one.datasets[name] - other.datasets[name])
        + (one.datasets[f"low/{name}"] - other.datasets[f"low/{name}"])
        for name in names
    ]
    return float(np.max(np.abs(rest)))


@pytest.mark.filterwarnings("ignore:.*depends on the others")
@pytest.mark.parametrize("constraints", [ONE, TWICE])
def test_velocities_that_an_impact_leaves_free(constraints):
    found = followed(SPHERE.format(constraints=constraints, set=BACK), 1.2)
    known = followed(SPHERE.format(constraints=ONE, set=ALL), 1.2)
    assert apart(found, known) < 1e-29


@pytest.mark.parametrize("few", [impulses.FEW, 0], ids=["dense", "sparse"])
def test_coordinates_that_a_shorter_rod_moves(few, monkeypatch):
    monkeypatch.setattr(impulses, "FEW", few)
    found, known = (followed(SHORTER.format(**way), 0.6) for way in (CARTESIAN, ANGLES))
    assert apart(found, known) < 1e-29


@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize("third", ["0.3333333333333333", "0.33333333333333331", "0.33333333333333337"])
def test_what_rounded_numbers_leave_of_an_impact_is_none(third: str, precision: str) -> None:
    """An impact that takes all of the speed, in coordinates whose numbers are rounded to doubles."""
    text = f"""
coordinates: {{y: {{initial: 1}}}}
masses: {{ball: 1}}
positions: {{ball: [0, y]}}
potential: 2*ball.y
events: {{floor: {{when: 3*y, direction: falling, action: {{set: {{y_dot: "y_dot - {third}*(3*y_dot)"}}}}}}}}
"""
    motion = lagrange.solve(text, stop=3, samples=4, precision=precision)
    assert np.abs(motion.datasets["q/y"][-2:]).max() < 1e-14
