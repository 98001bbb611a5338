"""Motions that end name the expression that ends them, its line, and the time: known in closed form."""

import math
import re

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import End
from lagrange_cli.run.causes import before
from tests.support.command import lagrange


def fall(speed_squared, first: float, last: float) -> float:
    """The time from one place to another, where the square of the speed is known."""
    return abs(float(mpmath.quad(lambda x: 1 / mpmath.sqrt(speed_squared(x)), [first, last])))


def line(velocity: float, lagrangian: str, initial: float = 0.0) -> str:
    return f"coordinates: {{x: {{initial: {initial}, velocity: {velocity}}}}}\nlagrangian: {lagrangian}\n"


PLANE = """
coordinates: {x: {initial: 1}, y: {initial: 0}}
definitions:
  r: norm((x, y))
masses: {p: 1}
embedding: {p: [x, y]}
potential: -1/r
"""
BODIES = """
sizes: {N: 3}
parameters: {m: {value: 1}}
coordinates:
  u[i in range(N)]: {initial: 10*i*(i + 1)}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) + sum(m/(u[i] - u[j]) for i in range(2) for j in range(i))
"""
HALF_PI = mpmath.pi / 2
LOG = fall(lambda x: 1 + mpmath.log(3 / (3 + mpmath.mpf("1.7") * x)) / 2, mpmath.mpf(-30) / 17, 0)
ROOT = fall(lambda x: 1 + (mpmath.sqrt(2 - x) - mpmath.sqrt(2)) / 2, 0, 2)
TAN = fall(lambda x: 1 + mpmath.tan(x) / 2, 0, HALF_PI)
FREE_FALL = math.pi / math.sqrt(8)
CHAIN = fall(lambda x: (x * (2 - x) - 0.0975) / (1 - x), 0.05, 1)
ENDS = {
    "log": (line(-1, "x_dot**2/2 - log(3 + 1.7*x)/4"), "3 + 1.7*x reaches 0 in log(3 + 1.7*x) (line 2)", LOG),
    "root": (line(1, "x_dot**2/2 + sqrt(2-x)/4"), "2-x reaches 0 in sqrt(2-x) (line 2)", ROOT),
    "power": (line(-2, "x_dot**2/2 - x**1.5", 1), "x reaches 0 in x**1.5 (line 2)", None),
    "asin": (line(1, "x_dot**2/2 - asin(x)/4"), "x reaches 1 in asin(x) (line 2)", None),
    "tan": (line(1, "x_dot**2/2 + tan(x)/4"), "x reaches 1.5708 in tan(x) (line 2)", TAN),
    "time": (line(1, "x_dot**2/2 + x/(t-2)"), "the denominator t-2 reaches 0 in x/(t-2) (line 2)", 2.0),
    "definition": (PLANE, "the denominator r reaches 0 in -1/r (line 7)", FREE_FALL),
    "family": (
        BODIES,
        "the denominator u[i] - u[j] reaches 0 in m/(u[i] - u[j]), for i = 1, j = 0 (line 6)",
        20**1.5 * FREE_FALL / math.sqrt(2),
    ),
    "escape": (line(2, "x_dot**2/2 + 2*x**3", 1), "x grows without bound", 1.0),
    "rounded": (
        line(-1, "x_dot**2/2 - acos(1 - x**4)", 0.5),
        "1 - x**4 reaches 1 in acos(1 - x**4) (line 2)",
        None,
    ),
    "constraint": (
        "coordinates: {x: {initial: 0.5}, y: }\nlagrangian: x_dot**2/2 + y_dot**2/2 - 9*y\n"
        "constraints: {wire: x - acos(1 - y) - sin(acos(1 - y))}\n",
        "1 - y reaches 1 in acos(1 - y) (line 3)",
        None,
    ),
    "folded chain": (line(0, "(1 - x)*x_dot**2 + x*(2 - x)", 0.05), "x_dot grows without bound", CHAIN),
    "no mass": (line(-1, "x**4*x_dot**2/2", 1), "x_dot grows without bound", 1 / 3),
    "beside what stays 0": (
        line(1, "x_dot**2/2 + 1e-12/(1 - x) - 10*max(0, x - 3)**1.5"),
        "the denominator 1 - x reaches 0 in 1e-12/(1 - x) (line 2)",
        1.0,
    ),
}


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize("case", ENDS)
def test_the_expression_that_ends_a_motion_is_named(case, precision, tmp_path):
    text, expected, end = ENDS[case]
    (tmp_path / "a.yaml").write_text(text)
    done = lagrange("solve", "a.yaml", "--stop", 80, "--step", 1, "--precision", precision, cwd=tmp_path)
    assert done.returncode == 4
    found = re.search(r"a: (.*) at t = (\S+), where", done.stderr)
    assert found is not None and found[1] == expected
    if end is not None:
        assert float(found[2]) == pytest.approx(end, rel=1e-8)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("case", ENDS)
def test_the_expression_that_ends_a_member_of_a_sweep_is_named(case, tmp_path):
    text, expected, _ = ENDS[case]
    (tmp_path / "a.yaml").write_text(text)
    initial = re.search(r"x: {initial: ([0-9.]+)", text)
    same = "m=1" if initial is None else f"x={initial[1]}"
    done = lagrange("sweep", "a.yaml", "--stop", 80, "--over", same, cwd=tmp_path)
    assert done.returncode == 4
    assert f"): {expected} at t = " in done.stderr


DOME = """
coordinates: {x: {initial: 0, velocity: 0.6}, y: {initial: 0, velocity: 0.8}}
masses: {p: 1}
positions:
  p: [x, y, sqrt(1 - x**2 - y**2)]
"""
BEND = """
coordinates: {{x: {{initial: 0, velocity: 1}}}}
masses: {{p: 0.25}}
positions: {{p: ["x", "{}"]}}
"""
ARC = fall(lambda x: 2 * (1 - x) / (2 - x), 0, 1)
SLOPE = """
coordinates: {x: {initial: 1, velocity: 6}, y: {initial: 0.5, velocity: 0.3}}
masses: {p: 1}
positions: {p: "(x, y, 3*asin((x + y/3)/20))"}
"""
EDGES = {
    "dome": (DOME, "1 - x**2 - y**2 reaches 0 in sqrt(1 - x**2 - y**2) (line 5)", HALF_PI),
    "bend": (BEND.format("2*sqrt(1 - x)"), "1 - x reaches 0 in sqrt(1 - x) (line 4)", ARC),
    "fades": (BEND.format("log(1 - x)"), "1 - x reaches 0 in log(1 - x) (line 4)", None),
    "slope": (SLOPE, "(x + y/3)/20 reaches 1 in asin((x + y/3)/20) (line 4)", None),
}
"""Positions near the edge of a domain, where the last digits of the argument are lost."""


@pytest.mark.parametrize("case", EDGES)
def test_the_edge_of_a_position_is_named_after_few_steps(case, tmp_path):
    text, expected, end = EDGES[case]
    (tmp_path / "a.yaml").write_text(text)
    done = lagrange("solve", "a.yaml", "--stop", 80, "--step", 1, cwd=tmp_path)
    assert done.returncode == 4
    found = re.search(r"a: (.*) at t = (\S+), where", done.stderr)
    assert found is not None and found[1] == expected
    if end is not None:
        assert float(found[2]) == pytest.approx(float(end), rel=1e-6)
    steps = re.search(r" in (\d+) steps", done.stdout)
    assert steps is not None and int(steps[1]) <= 8192


def test_what_outgrows_all_numbers_is_no_collision(tmp_path):
    (tmp_path / "a.yaml").write_text(line(0, "x_dot**2/2 - x**2/2", 1) + "dissipation: x_dot**2/2\n")
    done = lagrange("solve", "a.yaml", "--stop=-2000", "--step", 100, cwd=tmp_path)
    assert done.returncode == 4
    assert "a coordinate or a velocity exceeds the largest double, 1.8e308, at t = -141" in done.stderr


def test_what_passes_0_does_not_grow_without_bound():
    """At the origin, where atan2 ends this motion, 1/x is infinite, and x is not."""
    from lagrange_cli.run.causes import escapes
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.symbolic.direct import Dual

    spec = read_spec("name: a\ncoordinates: {x: {initial: 1}}\nlagrangian: x_dot**2", "a.yaml")
    for x, a, told in ((-1e-19, 1e-19, False), (1e20, 2e60, True), (1e20, 0.0, False)):
        rate = -0.5 if x < 1 else 1e40
        values = {"x": Dual((x, rate, a / 2)), "x_dot": Dual((rate, a, 0.0))}
        assert any(text.startswith("x ") for _, text in escapes(spec, values)) == told


def test_integrals_behind_the_state_stay_as_they_are():
    """A motion as if it had ended before has those of its end, as where an explanation asks for it twice."""
    end = End(Ending.STEP_UNDERFLOW, 2.0, np.array([1.0, 3.0, 7.0]), 9, 9, accelerations=np.array([4.0]))
    earlier = before(end, 0.5)
    assert (earlier.t, earlier.state.tolist()) == (1.5, [-0.5, 1.0, 7.0])
