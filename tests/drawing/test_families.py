"""Families drawn at once are drawn as their members are one by one."""

from textwrap import dedent

import numpy as np
import pytest

from lagrange_cli.drawing import evaluate
from lagrange_cli.drawing.draw import at_once, draw
from lagrange_cli.drawing.drawing import Drawing
from lagrange_cli.drawing.evaluate import extent, points, sizes
from lagrange_cli.drawing.families.crowd import crowd_of
from lagrange_cli.drawing.families.draw import Sketch
from lagrange_cli.expression.node import reachable
from lagrange_cli.page.engine import derived, placed
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.drawing.test_draw import ends
from tests.support.command import SYSTEMS

HEAD = "parameters: {l: 0.7, k: 2, g: 9.8, a: 3}\nmasses:\n  b[i in range(N)]: 1 + i\n"
PLANE = f"""{HEAD}
coordinates: {{"x[i in range(N)]": {{initial: a*i}}, "y[i in range(N)]": {{initial: -l*(i % 2)}}}}
positions: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
"""
ANGLES = f'{HEAD}\ncoordinates: {{X: {{initial: 1}}, "q[i in range(N)]": {{initial: 0.3*i + 0.1}}}}\n'
LINE = f"""{HEAD}
coordinates: {{"x[i in range(N)]": {{initial: i + 0.1*i**2}}}}
positions: {{"b[i in range(N)]": "x[i]"}}
"""
STRETCHED = "sum(k/2*(x[i] - x[i - 1] {})**2 for i in range(1, N))"
CASES = {
    "shipped pendulums": (SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8"),
    "shipped chain": (SYSTEMS / "chain.yaml").read_text(encoding="utf-8"),
    "shipped beads": (SYSTEMS / "fpu_chain.yaml").read_text(encoding="utf-8"),
    "ring": f"{PLANE}potential: sum((1 + i)*k*(norm(b[i] - b[(i + 1) % N]) - l)**2/2 for i in range(N))",
    "ring of named distances": f"""{PLANE}
definitions: {{"d[i in range(N)]": norm(b[i] - b[(i + 1) % N]) - l}}
potential: sum((1 + i)*k*d[i]**2/2 for i in range(N))
""",
    "every third pair": f"{PLANE}potential: >-\n  sum(k*dot(b[i] - b[j], b[i] - b[j]) for i in range(N)"
    " for j in range(i) if (i + j) % 3 == 0)",
    "components": f"{PLANE}potential: >-\n  sum(k/2*((x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2)"
    " for i in range(1, N))",
    "one component": f"{PLANE}potential: sum(k/2*(x[i] - x[i - 1])**2 for i in range(1, N))",
    "anchors": f"{PLANE}potential: >-\n  sum(k/2*(norm(b[i] - (a*i, 1)) - l)**2 + k*dot(b[i], b[i])"
    " for i in range(N))",
    "repulsion": f"{PLANE}potential: -sum(k/2*(norm(b[i]) - l)**2 for i in range(N))",
    "rods from points": f"{PLANE}constraints: {{'c[i in range(N)]': '(x[i] - a*i)**2 + y[i]**2 - l**2'}}",
    "rods by pairs": f"{PLANE}constraints: {{'c[i in range(N//2)]': 'norm(b[2*i] - b[2*i + 1]) - a'}}",
    "on a cart": f"""{ANGLES}
positions:
  b[i in range(N)]: ["X + sum(l*sin(q[j]) for j in range(i + 1))", "-sum(l*cos(q[j]) for j in range(i + 1))"]
""",
    "a tree": f"""{ANGLES}
definitions:
  c[0]: [l*sin(q[0]), -l*cos(q[0])]
  c[i in range(1, N)]: ["c[(i - 1)//2].x + l*sin(q[i])", "c[(i - 1)//2].y - l*cos(q[i])"]
positions: {{"b[i in range(N)]": "c[i]"}}
""",
    "beside each other in space": f"""{ANGLES}
positions: {{"b[i in range(N)]": ["i + l*sin(q[i])", 0, "-l*cos(q[i])"]}}
potential: sum(k*(norm(b[i] - b[i - 1]) - 1)**2/2 for i in range(1, N))
""",
    "beads on a hoop": f"""{ANGLES.replace("b[", "bead[")}
positions: {{"bead[i in range(N)]": ["l*sin(q[i])", "-l*cos(q[i])"]}}
""",
    "turning rods": f'{ANGLES}\npositions: {{"b[i in range(N)]": [l*sin(g*t) + i, "q[i]"]}}\n',
    "along a line": f"{LINE}potential: k*(x[0] - l)**2/2 + {STRETCHED.format('- l')}",
    "over each other": f"{LINE.replace('i + 0.1*i**2', '0.1')}potential: {STRETCHED.format('')}",
}


def both(text: str, size: int) -> tuple[Drawing, Drawing, dict[str, float], int]:
    """A drawing through the members, and at once; the parameters, and how many coordinates there are."""
    text = text if "sizes" in text else f"sizes: {{N: 7}}\n{text}"
    spec = read_spec(dedent(text).encode(), "system.yaml", {"N": str(size)})
    values = resolve_values(spec)
    one, other = draw(spec, values), Sketch(crowd_of(spec, values, 0.0)).drawing()
    assert one.located is None and other.located is not None
    return one, other, dict(values.parameters), len(values.q)


def spots(drawing: Drawing, places: np.ndarray) -> list[tuple[float, ...]]:
    return sorted(tuple(places[one.point].ravel().round(9)) for one in drawing.pivots)


@pytest.mark.exhaustive(keep=12)
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("size", [2, 7])
def test_both_ways_draw_the_same(name, size):
    one, other, parameters, degrees = both(CASES[name], size)
    assert ends(one, one.rods) == ends(other, other.rods)
    assert ends(one, one.springs) == ends(other, other.springs)
    assert (len(one.rods), len(one.springs)) == (len(other.rods), len(other.springs))
    assert (one.dimension, one.up, one.camera) == (other.dimension, other.up, other.camera)
    t, q = np.array([0.3, 1.2]), np.random.default_rng(size).normal(size=(2, degrees))
    there, here = points(one, t, q, parameters), points(other, t, q, parameters)
    assert [dot.name for dot in one.dots] == [dot.name for dot in other.dots]
    assert np.allclose(
        [there[dot.point] for dot in one.dots], [here[dot.point] for dot in other.dots], atol=1e-12
    )
    assert spots(one, there) == spots(other, here)
    masses = [sizes(drawing, parameters)[[dot.mass for dot in drawing.dots]] for drawing in (one, other)]
    assert np.array_equal(*masses)


def test_the_bounds_of_a_long_motion_are_found_in_parts(monkeypatch):
    _, drawing, parameters, degrees = both(CASES["shipped pendulums"], 7)
    t, q = np.linspace(0, 1, 50), np.random.default_rng(0).normal(size=(50, degrees))
    whole = extent(drawing, t, q, parameters)
    monkeypatch.setattr(evaluate, "AT_ONCE", 7 * drawing.count * drawing.dimension)
    parts = extent(drawing, t, q, parameters)
    for one, other in zip(vars(whole).values(), vars(parts).values(), strict=True):
        assert np.array_equal(one, other)


def test_nothing_is_written_out_for_more_members():
    """The expressions of a drawing are as many for a thousand as for a hundred; so are instructions."""
    found = set()
    for size in ("100", "1000"):
        spec = read_spec((SYSTEMS / "n_pendulum.yaml").read_bytes(), "system.yaml", {"N": size})
        drawing = at_once(spec, resolve_values(spec))
        assert drawing is not None and len(drawing.rods) == int(size)
        terms = [one.node for axis in drawing.located.axes for one in axis.terms]
        instructions = "".join((placed(spec, drawing)[0], derived(spec)[0])).count(" = ")
        found.add((len(reachable(terms)), len(drawing.sizes), instructions))
    assert len(found) == 1
