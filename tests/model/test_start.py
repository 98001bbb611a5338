"""A consistent start: what is found, what is moved, and what is refused, at its place in the file."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Sequence
from itertools import product
from textwrap import dedent

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.exact import context
from lagrange_cli.model.start import equations
from lagrange_cli.model.start.beginnings import STARTS
from lagrange_cli.model.start.blocks import Block, blocks
from lagrange_cli.model.start.closures import closures
from lagrange_cli.model.start.consistent import consistent
from lagrange_cli.model.start.equations import Equations, Masses
from lagrange_cli.model.start.nearest import ROUND, Curvature, Surface
from lagrange_cli.model.start.search import Given
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import left_open, resolve_values
from tests.support.draws import examples

PENDULUM = """
parameters: {m: 2.0, l: 1.3}
coordinates:
  x: {initial: 0.5}
  y: {initial: -1.2}
masses: {bob: m}
positions: {bob: [x, y]}
constraints:
  rod: x**2 + y**2 - l**2
"""
SLIDER_CRANK = """
parameters: {r: 0.3, l: 1.0}
coordinates:
  phi: {initial: 0.4, velocity: 2}
  psi: {initial: 0.1170928911202160}
  x: {}
masses: {crank: 1.0, rod: 0.7, slider: 0.5}
positions:
  crank: [r/2*cos(phi), r/2*sin(phi)]
  rod: [r*cos(phi) + l/2*cos(psi), r*sin(phi) - l/2*sin(psi)]
  slider: [x, 0]
constraints:
  along: r*cos(phi) + l*cos(psi) - x
  across: r*sin(phi) - l*sin(psi)
"""
PARALLELOGRAM = """
coordinates: {x1: {initial: C}, y1: {initial: S}, x2: {initial: 2 + C}, y2: {initial: S}}
parameters: {C: 0.6, S: 0.8}
masses: {p: 1, q: 1.5}
positions: {p: [x1, y1], q: [x2, y2]}
constraints:
  left: x1**2 + y1**2 - 1
  right: (x2 - 2)**2 + y2**2 - 1
  bar: (x2 - x1)**2 + (y2 - y1)**2 - 4
"""


SIGNS = [*product((-1, 1), repeat=3)]
TOP = """
coordinates: {w: {initial: 1}, x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
bodies: {top: {mass: 1, position: [0, 0, 0], inertia: [1, 2, 2.5], orientation: {quaternion: [w, x, y, z]}}}
"""


def start(text, *, forced=False, t=0.0, exact=None, **sets):
    """The consistent start of a system file, with values in place of the file's."""
    spec = read_spec(dedent(text), "system.yaml")
    overrides = {name: repr(x) for name, x in sets.items()}
    values = resolve_values(spec, overrides)
    names = left_open(spec, overrides)
    coordinates = [one.name for one in spec.coordinates]
    free = [
        frozenset(k for k, name in enumerate(coordinates) if name + suffix in names)
        for suffix in ("", "_dot")
    ]
    number = float if exact is None else exact.mpf
    parameters = {name: number(x) for name, x in values.parameters.items()}
    q, v = (tuple(map(number, row)) for row in (values.q, values.v))
    return consistent(spec, parameters, Given(number(t), q, v, *free, forced), exact)


def refused(text, **sets):
    """The problems of a start that is refused."""
    with pytest.raises(SpecError) as caught:
        start(text, **sets)
    return caught.value.problems


def test_a_consistent_start_stays_as_it_is():
    assert start(PENDULUM).q == (0.5, -1.2)
    assert start(PENDULUM).changed == ()


def test_velocities_that_are_left_out_are_found_and_given_ones_are_kept():
    found = start(PENDULUM, x_dot=1.0)
    assert found.v == pytest.approx((1.0, 0.5 / 1.2), rel=1e-15)
    assert [(one.name, one.given) for one in found.changed] == [("y_dot", None)]


def test_coordinates_that_are_left_out_are_found():
    found = start(SLIDER_CRANK)
    phi, psi, x = found.q
    assert (phi, psi) == (0.4, 0.1170928911202160)
    assert x == pytest.approx(0.3 * math.cos(0.4) + math.cos(math.asin(0.3 * math.sin(0.4))), rel=1e-15)
    turning = 0.3 * math.cos(0.4) * 2 / math.cos(psi)
    assert found.v == pytest.approx((2, turning, -0.6 * math.sin(0.4) - math.sin(psi) * turning), rel=1e-14)


def test_slightly_wrong_values_are_moved_by_the_shortest_way():
    found = start(PENDULUM, x=0.5 * (1 + 3e-7), y=-1.2 * (1 + 3e-7))
    assert found.q == pytest.approx((0.5, -1.2), rel=1e-14)
    assert {one.name: one.by for one in found.changed} == pytest.approx({"x": -1.5e-7, "y": 3.6e-7}, rel=1e-6)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("count", [1, 300])
@pytest.mark.parametrize(("off", "accepted"), [(3e-7, True), (3e-6, False)])
@pytest.mark.parametrize(
    "constraint", ["rod[i in range(N)]: x[i]**2 + y[i]**2 - 1", "wall[i in range(N)]: y[i] - 1"]
)
def test_many_parts_are_judged_as_one_is(count, off, accepted, constraint):
    """Rods next to each other, and beads at walls; before, the bound had the factor sqrt(N)."""
    text = f"""
    sizes: {{N: {count}}}
    coordinates: {{x[i in range(N)]: {{initial: 0}}, y[i in range(N)]: {{initial: {1 + off!r}}}}}
    masses: {{bob[i in range(N)]: 2}}
    positions: {{bob[i in range(N)]: ['x[i]', 'y[i]']}}
    constraints: {{'{constraint.partition(": ")[0]}': '{constraint.partition(": ")[2]}'}}
    """
    if accepted:
        assert start(text).q[count:] == pytest.approx([1.0] * count, rel=1e-14)
    else:
        assert all(
            re.search("(is|are) not satisfied by the initial values", one.message) for one in refused(text)
        )


def test_members_that_are_off_are_told_in_one_message_with_the_worst_of_them():
    text = """
    sizes: {N: 200}
    coordinates: {"x[i in range(N)]": {initial: i, velocity: "0.01*(7*i % N)"}}
    masses: {"b[i in range(N)]": 1}
    positions: {"b[i in range(N)]": "x[i]"}
    constraints: {"pin[i in range(N)]": x[i] - i}
    """
    (problem,) = refused(text)
    assert problem.message == (
        "constraints 'pin[57]', 'pin[114]', 'pin[171]', 'pin[28]' and 195 more are not satisfied by the "
        "initial velocities: their rates of change are 1.99, 1.98, 1.97, 1.96, ..., not 0"
    )


def test_velocities_that_are_left_out_are_found_however_large():
    """A rod that is all but level turns fast where its end moves along it: y_dot = -x x_dot/y."""
    found = start(PENDULUM, x=1.3, y=1e-5, x_dot=1.0)
    assert found.v[1] == pytest.approx(-found.q[0] / found.q[1], rel=1e-12)


def test_values_that_are_too_far_off_are_refused_with_the_residual_at_its_line():
    (problem,) = refused(PENDULUM, y=-1.21)
    assert problem.line == 9
    assert "'rod' is not satisfied by the initial values: it is 0.0241" in problem.message
    assert "--project-initial takes the nearest consistent state (x = 0.496473, y = -1.20146)" in problem.hint
    moved = start(PENDULUM, y=-1.21, forced=True)
    assert math.hypot(*moved.q) == pytest.approx(1.3, rel=1e-15)
    (problem,) = refused(PENDULUM, x_dot=1.0, y_dot=0.0)
    assert "its rate of change is 1, not 0" in problem.message


def test_several_closures_are_listed_and_each_may_be_copied():
    """With so many digits that nothing has to be moved."""
    text = SLIDER_CRANK.replace("psi: {initial: 0.1170928911202160}", "psi: {}")
    (problem,) = refused(text)
    assert "the constraints allow 2 possible initial states" in problem.message
    listed = numbers(r"psi = ([^,]+), x = (\S+)", problem.message)
    known = [(0.117092891120216, 1.26947075473542), (3.02449976246958, -0.71683415833369)]
    np.testing.assert_allclose(listed, known, rtol=1e-14)
    assert f"--set psi={listed[0][0]!r}" in problem.hint
    for psi, x in listed:
        found = start(text, psi=psi, x=x)
        assert [one for one in found.changed if one.given is not None] == []


LINKAGE = """
parameters: {a: 1, b: 0.7, m: 1, alpha: 1, beta: asin(b*sin(alpha)/a)}
coordinates: {t1: {initial: 1, velocity: 1}, t2: {}, t3: {}}
bodies:
  one: {mass: m, solid: {box: [a, a, a]}, position: [0, 0, 0], orientation: {euler: [t1, beta, t2]}}
  two:
    mass: m
    solid: {box: [b, b, b]}
    position: [a, 0, 0]
    orientation: {euler: [alpha, t3, 0], sequence: xzx}
constraints:
  joint: one.at(a, 0, 0) + b*(cos(t1), sin(t1), 0) - two.at(b, 0, 0)
"""


def test_closures_of_bodies_do_not_build_them_at_each_place(monkeypatch) -> None:
    """A linkage of Bennett's: opposite angles are equal."""
    built = []
    scope = equations.Scope

    def counted(*given):
        built.append(given)
        return scope(*given)

    monkeypatch.setattr(equations, "Scope", counted)
    found = start(LINKAGE)
    assert found.q[1] == pytest.approx(found.q[2], abs=1e-14)
    assert found.redundant
    assert len(built) <= 40


def numbers(pattern: str, message: str) -> list[tuple[float, ...]]:
    """The numbers in a message."""
    return [tuple(map(float, one)) for one in re.findall(pattern, message)]


@pytest.mark.exhaustive(keep=0.45)
def test_all_closures_of_loops_in_a_row_are_listed():
    """Two loops close in two ways each, whatever the way of the other one. At 0, where a coordinate without a
    value begins, the distance of two of the joints has no derivative."""
    (problem,) = refused("""
        parameters: {C: 0.6, S: 0.8}
        coordinates: {xa: {initial: C}, ya: {initial: S}, xb: {}, yb: {}, xc: {}, yc: {}}
        masses: {a: 1, b: 1, c: 1}
        positions: {a: [xa, ya], b: [xb, yb], c: [xc, yc]}
        constraints:
          left: norm(a) - 1
          middle: norm(b - (2, 0)) - 1
          right: norm(c - (4, 0)) - 1
          ab: norm(a - b) - 2
          bc: norm(b - c) - 2
        """)
    assert "4 possible initial states" in problem.message
    assert "xb = 2.6, yb = 0.8, xc = 4.6, yc = 0.8" in problem.message
    listed = numbers(r"xb = ([^,]+), yb = ([^,]+), xc = ([^,]+), yc = (\S+)", problem.message)
    near, far = (21 / 13, -12 / 13), (2.6, 0.8)
    known = [
        (*near, 526 / 170, 72 / 170),
        (*near, 47 / 13, -12 / 13),
        (*far, 47 / 13, -12 / 13),
        (*far, 4.6, 0.8),
    ]
    np.testing.assert_allclose(listed, known, rtol=1e-12)


def test_a_closure_that_is_found_again_is_not_looked_at_again() -> None:
    """Wires that give a coordinate each: to tidy a closure takes a look for each of them."""
    count, looks = 40, [0]

    def at(x: Sequence[float]) -> tuple[list[float], list[dict[int, float]]]:
        looks[0] += 1
        return [one - 7.0 - k / 10 for k, one in enumerate(x)], [{k: 1.0} for k in range(count)]

    surface = Surface(at, range(count), range(count), Masses({}), [1.0] * count, ROUND)
    found = closures(surface, [0.0] * count, [])
    assert np.allclose(found.states, [[7.0 + k / 10 for k in range(count)]])
    assert looks[0] < STARTS * count  # Newton's method takes 25 from each place


@pytest.mark.parametrize("seed", range(3))
def test_the_directions_of_a_quadratic_function_lead_to_its_minimum(seed):
    """In as many steps as there are coordinates, each to the lowest place in its direction; then what is
    known of the slope's changes is exact. In a metric M: slope -M^-1 (H x - b)."""
    count, chance = 7, np.random.default_rng(seed)
    metric, bent = (a @ a.T + np.eye(count) for a in chance.normal(size=(2, count, count)))
    right, x = chance.normal(size=(2, count))
    curvature = Curvature(lambda step: metric @ step)
    slope = np.linalg.solve(metric, right - bent @ x)
    for _ in range(count):
        step = curvature.direction(slope)
        step = step * (step @ metric @ slope) / (step @ bent @ step)
        x = x + step
        before, slope = slope, np.linalg.solve(metric, right - bent @ x)
        curvature.learn(step, before - slope)
    np.testing.assert_allclose(x, np.linalg.solve(bent, right), atol=1e-8)
    there = chance.normal(size=count)
    ahead = curvature.direction(np.linalg.solve(metric, right - bent @ there))
    np.testing.assert_allclose(there + ahead, x, atol=1e-6)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("constraint", "x", "y", "nearest"),
    [
        ("x*y", 1.0, 1.0, {(0, 1), (1, 0)}),
        ("x*y", 1.0, 0.9, {(1, 0)}),
        ("x**2/4 + y**2 - 1", 0.5, 0.0, {(2 / 3, math.sqrt(8) / 3), (2 / 3, -math.sqrt(8) / 3)}),
        ("x**2/4 + y**2 - 1", 1.8, 0.0, {(2, 0)}),  # within the centre of curvature at (3/2, 0)
    ],
)
def test_the_search_for_the_nearest_state_leaves_those_that_are_only_stationary(constraint, x, y, nearest):
    """From the axis of an ellipse the point ahead is the nearest only beyond its centre of curvature."""
    text = f"""
    coordinates: {{x: {{initial: {x}}}, y: {{initial: {y}}}}}
    masses: {{p: 1}}
    positions: {{p: [x, y]}}
    constraints: {{c: {constraint}}}
    """
    if len(nearest) == 1:
        assert start(text, forced=True).q == pytest.approx(*nearest, abs=1e-12)
        return
    with pytest.raises(SpecError) as caught:
        start(text, forced=True)
    (problem,) = caught.value.problems
    assert "several states that satisfy the constraints are equally near" in problem.message
    shown = re.findall(r"x = (\S+), y = (\S+)", problem.message)
    assert sorted(tuple(map(float, one)) for one in shown) == [
        pytest.approx(one, abs=1e-12) for one in sorted(nearest)
    ]
    (problem,) = refused(text)
    assert "several consistent states are equally near" in problem.hint


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("case", range(4))
def test_from_anywhere_the_nearest_point_of_a_circle_is_the_one_ahead(case):
    """However small it is beside the way to it."""
    numbers = np.random.default_rng(case)
    x, y = (float(a * b) for a, b in zip(numbers.choice([-1, 1], 2), numbers.uniform(0.5, 3, 2)))
    radius, distance = (0.1, 0.5, 0.5, 2.0)[case], math.hypot(x, y)
    text = f"""
    coordinates: {{x: {{initial: {x}}}, y: {{initial: {y}}}}}
    masses: {{p: 1}}
    positions: {{p: [x, y]}}
    constraints: {{c: x**2 + y**2 - {radius}**2}}
    """
    expected = [x * radius / distance, y * radius / distance]
    assert start(text, forced=True).q == pytest.approx(expected, abs=1e-10), (x, y, radius)


def test_from_the_centre_of_a_circle_all_of_it_is_equally_near():
    with pytest.raises(SpecError, match="equally near, such as"):
        start(PENDULUM, x=0.0, y=0.0, forced=True)


@pytest.mark.exhaustive(keep=0.2)
def test_an_angle_that_is_found_beside_given_ones_has_no_full_turns():
    text = """
    coordinates: {a: {initial: 0}, b: , c: {initial: 1.5}}
    masses: {p: 1, q: 1}
    positions: {p: [cos(a), sin(a)], q: [cos(a) + 2.5*cos(b), sin(a) + 2.5*sin(b)]}
    constraints: {crank: a - t, x: q.x - 2 - 2*cos(c), y: q.y - 2*sin(c)}
    """
    _, b, c = start(text, forced=True).q
    assert 2.5 * cmath.exp(1j * b) == pytest.approx(1 + 2 * cmath.exp(1j * c), abs=1e-12)
    assert abs(b) <= math.pi and abs(c) <= math.pi


ZIGZAG = """
sizes: {N: 6}
parameters: {l: 1.0}
coordinates:
  x[i in range(N)]: {initial: 0.6*(i + 1)}
  y[i in range(N - M)]: {initial: 0.8*(i + 1 - 2*(i//2))}
  y[i in range(N - M, N)]:
masses: {bob[i in range(N)]: 1}
positions: {bob[i in range(N)]: ['x[i]', 'y[i]']}
constraints:
  rod[0]: x[0]**2 + y[0]**2 - l**2
  rod[i in range(1, N)]: (x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - l**2
"""


def test_all_closures_of_a_chain_are_found_link_by_link():
    """The last three links lead up or down by 0.8, each by itself."""
    text = ZIGZAG.replace("range(N - M", "range(N - 3").replace("(i + 1 - 2*(i//2))", "((i + 1) % 2)")
    (problem,) = refused(text)
    ways = {
        tuple(round(float(one.partition(" = ")[2]), 9) for one in line.split(", "))
        for line in problem.message.splitlines()[1:]
    }
    turns = ((0.8 + 0.8 * a, 0.8 + 0.8 * (a + b), 0.8 + 0.8 * (a + b + c)) for a, b, c in SIGNS)
    assert ways == {tuple(round(y, 9) for y in one) for one in turns}


@pytest.mark.exhaustive(keep=0.3)
def test_many_coordinates_without_values_are_found_with_little_work():
    """The links of a chain are found one after the other, each from its own constraints: the work grows with
    their number, and steps of all of them together are sparse."""
    text = """
    sizes: {N: %d}
    coordinates: {x[i in range(N)]: {}, y[i in range(N)]: {}}
    masses: {bob[i in range(N)]: 1}
    positions: {bob[i in range(N)]: ['x[i]', 'y[i]']}
    constraints:
      first: x[0] - 1
      step[i in range(N - 1)]: x[i + 1] - x[i] - 1
      bent[i in range(N - 2)]: 3*y[i + 1] + y[i + 1]**3/10 - y[i] - y[i + 2] - 1
      low: 3*y[0] - y[1] - 1
      high: 3*y[N - 1] - y[N - 2] - 1
    """
    found = start(text % 110)
    assert found.q[:110] == tuple(range(1, 111))
    y = found.q[110:]
    assert max(abs(3 * b + b**3 / 10 - a - c - 1) for a, b, c in zip(y, y[1:], y[2:])) < 1e-14


def test_blocks_are_found_in_an_order_in_which_each_can_be_solved():
    pattern = {0: [0], 1: [0, 1], 2: [2, 3, 1], 3: [2, 3], 4: [4, 5], 5: [6], 6: [6]}
    found, free = blocks(pattern, range(7))
    assert free == [4, 5]
    assert found == [Block([5, 6], [6]), Block([0], [0]), Block([1], [1]), Block([2, 3], [2, 3])]


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(1, 9))
def test_blocks_have_the_structural_rank(seed, rows, unknown):
    """Random numbers in the places of a pattern have its rank; a coordinate is free if a vector of the kernel
    has it."""
    chance = np.random.default_rng(seed)
    matrix = chance.normal(size=(rows, unknown)) * (chance.random((rows, unknown)) < 0.3)
    pattern = {i: np.flatnonzero(row).tolist() for i, row in enumerate(matrix) if row.any()}
    found, free = blocks(pattern, range(unknown))
    kernel = np.linalg.svd(matrix)[2][np.linalg.matrix_rank(matrix) :]
    assert free == np.flatnonzero(np.abs(kernel).max(axis=0, initial=0.0) > 1e-9).tolist()
    known: set[int] = set()
    for one in found:
        assert len(one.rows) >= len(one.unknown) == np.linalg.matrix_rank(matrix[one.rows][:, one.unknown])
        known.update(one.unknown)
        assert all(known.issuperset(pattern[i]) for i in one.rows)
    assert known == {*range(unknown)}.difference(free)


@pytest.mark.exhaustive(keep=0.2)
def test_closures_that_leave_nothing_open_are_listed_alone():
    """Peaucellier's rhombus: where its two arms lie on each other, the last joint turns freely."""
    text = """
coordinates: {px: {}, py: {}, ax: {}, ay: {}, cx: {}, cy: {}}
masses: {a: 1, c: 1, p: 1}
positions: {a: [ax, ay], c: [cx, cy], p: [px, py]}
constraints:
  oa: norm(a) - 2
  oc: norm(c) - 2
  ab: norm(a - (1.7, 0.4)) - 1
  cb: norm(c - (1.7, 0.4)) - 1
  ap: norm(a - p) - 1
  cp: norm(c - p) - 1
"""
    (problem,) = refused(text)
    assert "the constraints allow 4 possible initial states" in problem.message
    places = [float(one) for one in re.findall(r"px = (-?[\d.]+)", problem.message)]
    inverse = 1.7 * 3 / (1.7**2 + 0.4**2)  # |OB| |OP| = 2^2 - 1^2
    assert sorted(places) == pytest.approx([inverse, inverse, 1.7, 1.7], abs=1e-12)
    shown = re.findall(r"px = (\S+), ax = (\S+),", problem.message)  # these two tell the four apart
    assert len({(px, ax[:8]) for px, ax in shown}) == 4
    assert re.search(r"--set px=\S+ --set ax=\S+$", problem.hint)


def test_a_coordinate_that_nothing_determines_needs_a_value():
    (problem,) = refused(PENDULUM.replace("{initial: 0.5}", "{}").replace("{initial: -1.2}", "{}"))
    assert problem.line == 4
    assert "'x' has no initial value, and the constraints leave it free" in problem.message


@pytest.mark.exhaustive(keep=0.8)
def test_a_closure_where_two_meet_is_found_to_all_digits():
    assert start(PENDULUM.replace("{initial: -1.2}", "{}"), x=1.3).q == (1.3, 0.0)
    bent = """
    parameters: {C: 0.5, S: -1.2}
    coordinates:
      {xa: {initial: C}, ya: {initial: S}, xb: {initial: C + 0.7}, yb: {}, xc: {initial: C + 2}, yc: {}}
    masses: {a: 1, b: 1, c: 1}
    positions: {a: [xa, ya], b: [xb, yb], c: [xc, yc]}
    constraints: {rod: norm(a) - 1.3, ab: norm(a - b) - 0.7, bc: norm(b - c) - 1.3}
    """
    assert start(bent).q[3::2] == pytest.approx((-1.2, -1.2), rel=4e-16)


@pytest.mark.exhaustive(keep=0.5)
def test_rods_in_a_line_may_be_too_short_by_rounding():
    found = start(PENDULUM.replace("{initial: -1.2}", "{}"), x=1.3 + 1e-7)
    assert found.q == pytest.approx((1.3, 0.0), rel=1e-15)
    assert [one.name for one in found.changed if one.given is not None] == ["x"]
    problem, rod = refused(PENDULUM.replace("{initial: -1.2}", "{}"), x=1.31)
    assert "no value of y was found" in problem.message
    assert "--project-initial takes the nearest consistent state (x = 1.3, y = 0)" in problem.hint
    assert (rod.line, "it is 0.026" in rod.message) == (9, True)


def test_a_time_that_counts():
    text = """
    parameters: {w: 2.0}
    coordinates: {x: {}, s: {initial: 0.5}}
    masses: {a: 1, b: 1}
    positions: {a: [x, 0], b: [s, 0]}
    constraints: {drive: x - sin(w*t)}
    """
    found = start(text, t=0.3)
    assert found.q == pytest.approx((math.sin(0.6), 0.5), rel=1e-15)
    assert found.v == pytest.approx((2 * math.cos(0.6), 0.0), rel=1e-15)


def test_velocities_of_nonholonomic_constraints():
    text = """
    coordinates: {x: {initial: 0}, y: {initial: 0}, a: {initial: 0.5, velocity: 1}}
    masses: {tip: 1, tail: 1}
    positions: {tip: [x, y], tail: [x + cos(a), y + sin(a)]}
    nonholonomic: {edge: tip.vy*cos(a) - tip.vx*sin(a)}
    """
    found = start(text, x_dot=2.0)
    assert found.v == pytest.approx((2.0, 2 * math.tan(0.5), 1.0), rel=1e-15)
    assert start(text).v == (0, 0, 1.0)


def test_redundant_constraints_are_told_apart_from_a_singular_configuration():
    bar = PARALLELOGRAM + "  middle: (x1 + x2 - 2)**2 + (y1 + y2)**2 - 4\n"
    found = start(bar)
    assert (found.redundant, found.singular) == (("middle",), ())
    flat = start(PARALLELOGRAM, C=1.0, S=0.0)
    assert (flat.redundant, flat.singular) == ((), ("bar",))


def test_a_start_at_a_singular_configuration_may_be_the_only_state_at_its_time():
    """A point of a circle that is driven along x begins where the circle is vertical."""
    found = start("""
        coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 1}}
        masses: {b: 1}
        positions: {b: [x, y]}
        constraints: {circle: x**2 + y**2 - 1, driven: x - cos(t)}
        """)
    assert (found.singular, found.redundant) == (("driven",), ())


def test_a_constraint_that_follows_from_another_one_may_be_flat():
    both = PENDULUM + "  again: (x**2 + y**2 - l**2)**2\n"
    assert start(both).redundant == ("again",)
    (problem,) = refused(PENDULUM.replace("x**2 + y**2 - l**2", "(x**2 + y**2 - l**2)**2"))
    assert "although the constraint restricts the motion" in problem.message and "f**2" in problem.hint


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("x**2 + y**2 - 1", "'other' is not satisfied by the initial values: it is 0.69"),
        ("2*(x**2 + y**2 - l**2) + t", "'other' is not satisfied by the initial velocities"),
        ("2*(x**2 + y**2 - l**2) + t**2", "'other' agrees with the others at the start, and contradicts"),
        ("x - x", "no coordinate has an effect on it"),
    ],
)
def test_contradictions_are_refused(more, said):
    problem = refused(PENDULUM + f"  other: {more}\n")[-1]
    assert (problem.line, said in problem.message) == (10, True), problem.message


def test_many_digits():
    found = start(PENDULUM, x=0.3, y=-1.264911064067352, exact=context())
    assert abs(found.q[0] ** 2 + found.q[1] ** 2 - context().mpf(1.3) ** 2) < 1e-33
    assert abs(found.q[0] - 0.3) < 1e-15


def chain(lengths, text="  %s\n"):
    """A closed chain of bars between fixed ends, and its angles as the file has them."""
    n = len(lengths)
    names = [f"p{i}" for i in range(n - 1)]
    places = [("0", "0"), *((f"{name}.x", f"{name}.y") for name in names), ("D", "0")]
    return "\n".join(
        [
            "parameters: {D: 1.5}",
            f"coordinates: [{', '.join(f'x{i}, y{i}' for i in range(n - 1))}]",
            f"masses: {{{', '.join(f'{name}: {1 + 0.7 * i}' for i, name in enumerate(names))}}}",
            "positions:",
            *(f"  {name}: [x{i}, y{i}]" for i, name in enumerate(names)),
            "constraints:",
            *(
                f"  bar{i}: ({a} - ({c}))**2 + ({b} - ({d}))**2 - {length}**2"
                for i, (((a, b), (c, d)), length) in enumerate(
                    zip(zip(places[1:], places), lengths, strict=True)
                )
            ),
        ]
    )


@pytest.mark.exhaustive(keep=0.15)
@examples(4)
@given(st.lists(st.floats(0.8, 1.6), min_size=3, max_size=5), st.integers(0, 10**6))
def test_the_projection_of_closed_chains_is_the_nearest_point_and_stays_there(lengths, seed):
    spec = read_spec(chain(lengths), "chain.yaml")
    n = len(spec.coordinates)
    around = np.stack([np.linspace(0, 1.5, n // 2 + 2)[1:-1], np.full(n // 2, 0.8)], axis=1).ravel()
    parameters, resting = {"D": 1.5}, ((0.0,) * n, (), frozenset(range(n)), True)
    near = consistent(spec, parameters, Given(0.0, tuple(around.tolist()), *resting)).q
    q = np.array(near) + 0.02 * np.random.default_rng(seed).standard_normal(n)
    found = consistent(spec, parameters, Given(0.0, tuple(q.tolist()), *resting))
    masses = np.repeat([1 + 0.7 * i for i in range(n // 2)], 2)

    equations = Equations(spec, parameters)
    rates = equations.at(0.0, found.q, (0.0,) * n)
    assert np.abs(rates.values).max() < 1e-14
    slopes = np.array([[row.get(k, 0.0) for k in range(n)] for row in rates.rows])
    way = np.array(found.q) - q
    across = np.linalg.lstsq(slopes.T, masses * way, rcond=None)[0]
    assert np.abs(slopes.T @ across - masses * way).max() < 1e-7

    again = consistent(spec, parameters, Given(0.0, found.q, (0.0,) * n, (), frozenset(range(n))))
    assert again.q == found.q

    def gap(x):
        return equations.at(0.0, x.tolist(), (0.0,) * n).values

    other = minimize(
        lambda x: masses @ (x - q) ** 2, found.q, constraints={"type": "eq", "fun": gap}, method="SLSQP",
        options={"ftol": 1e-14},
    )  # fmt: skip
    assert masses @ way**2 <= other.fun * (1 + 1e-6) + 1e-12


@pytest.mark.exhaustive(keep=0.75)
@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(-100, 100), min_size=8, max_size=8), st.sampled_from([1e-99, 0.3, 2.0, 1e99]))
@example([18, 1, 0, 0, 18, 1, 0, 0], 1e-99)  # it grows, and does not turn
def test_a_quaternion_is_normalized_and_keeps_its_angular_velocity(numbers, length):
    values, rates = np.array(numbers[:4]) / 100, np.array(numbers[4:]) / 100
    values = np.array([1.0, 0.2, 0, 0]) if np.linalg.norm(values) < 0.1 else values
    values = length * values / np.linalg.norm(values)
    names = [*"wxyz", "w_dot", "x_dot", "y_dot", "z_dot"]
    found = start(TOP, **dict(zip(names, map(float, [*values, *rates]))))

    def spin(q, v):
        return 2 * (q[0] * v[1:] - v[0] * q[1:] - np.cross(q[1:], v[1:])) / (q @ q)

    unit, turning = np.array(found.q), np.array(found.v)
    assert unit == pytest.approx(values / length, abs=1e-15)
    assert abs(unit @ turning) <= 3e-15 * np.linalg.norm(rates) / length
    written = spin(values / length, rates / length)
    assert spin(unit, turning) == pytest.approx(
        written, rel=1e-13, abs=1e-14 * np.linalg.norm(rates) / length
    )
    assert [*found.normalized.values()] == [pytest.approx(length)]


@pytest.mark.exhaustive(keep=0.55)
def test_what_changes_by_rounding_is_not_told():
    """Moving y restores the other constraint, too; x and the velocities change in the last digit at most."""
    exact = context()
    text = PENDULUM.replace("x: {initial: 0.5}", "x: {initial: 0.5, velocity: 0.1}")
    text = text.replace("rod:", "height: z - 3\n  rod:").replace("[x, y]", "[x, y, z]")
    text = text.replace("  y: {", "  z: {initial: 1}\n  y: {")
    found = start(text, forced=True, exact=exact, y_dot=0.1 * 0.5 / 1.2)
    assert [one.name for one in found.changed] == ["z"]
    assert found.v[2] != 0.1 * 0.5 / 1.2  # to 31 digits


def test_the_length_of_a_quaternion_that_is_no_coordinate_is_refused_in_its_own_words():
    text = TOP.replace("[w, x, y, z]", "[cos(w/2), 0, sin(w/2), 0]")
    (problem,) = refused(text)
    assert "the length of the quaternion of body 'top' does not depend on any coordinate" in problem.message


@pytest.mark.parametrize("scalar", ["w", "-w", "2*w"])
def test_a_quaternion_that_is_0_is_refused_at_its_place(scalar):
    """Before, eight states were listed that are equally near, if it is made of expressions."""
    (problem,) = refused(TOP.replace("[w, x", f"[{scalar}, x"), w=0.0)
    assert (problem.line, "it has no direction" in problem.message) == (3, True)


def test_of_many_states_that_are_equally_near_two_are_shown_by_what_tells_them_apart():
    """Before, all were listed, each by its first coordinates, which may be the same."""
    text = """
    coordinates: {a: {initial: 0.6}, b: {initial: 0.6}, c: {initial: 0.6}, x: {}, y: {}}
    masses: {p: 1}
    positions: {p: [a + x, b + y, c]}
    constraints: {a: a - 0.5, b: b - 0.5, c: c - 0.5, x: x**2 + a**2 - 1, y: y**2 + a**2 - 1}
    """
    hint = refused(text)[0].hint
    shown = re.search(
        r"change to x = (\S+), y = (\S+), a = .* or x = (\S+), y = (\S+), a = .* or one of", hint
    )
    assert [abs(float(one)) for one in shown.groups()] == pytest.approx([0.866025] * 4)
    assert shown.groups()[:2] != shown.groups()[2:]
    assert hint.endswith("or one of 2 others")


def test_a_quaternion_is_normalized_to_many_digits():
    mpf = context().mpf
    found = start(TOP, exact=context(), w=2.0, z=0.1, y_dot=3.0)
    assert abs(found.q[0] - 2 / (4 + mpf(0.1) ** 2) ** mpf("0.5")) < 1e-30
    assert abs(sum(x * x for x in found.q) - 1) < 1e-30


def test_a_constraint_that_restricts_nothing_at_the_start_is_told_from_a_constant():
    text = "coordinates: {x: {}, y: {}}\nmasses: {p: 1}\npositions: {p: [x, y]}\n"
    text = text.replace("{}", "{initial: 0}")
    (problem,) = refused(text + "nonholonomic: {e: t*x_dot - 1}")
    assert problem.message == "constraint 'e' restricts nothing at t = 0: all its slopes are 0 then"
    (problem,) = refused(text + "constraints: {e: t*x}")
    assert "restricts nothing at t = 0" in problem.message
    (problem,) = refused(text + "nonholonomic: {e: x_dot - x_dot + t}")
    assert "no velocity has an effect on it" in problem.message


def test_constraints_that_disagree_by_rounding_only_depend_on_each_other():
    """With the difference of 1e-9 no wheel could turn, although the file says that they do."""
    gears = """
    parameters: {e: 1e-9}
    coordinates: {a: {initial: 0, velocity: 1}, b: {}, c: {}}
    masses: {p: 1, q: 1, r: 1}
    positions: {p: a, q: b, r: c}
    constraints: {ab: a + 2*b, bc: 2*b + 3*c, ac: a - 3*c*(1 + e)}
    """
    found = start(gears)
    assert (found.redundant, found.singular) == (("ac",), ())
    assert 1e-12 < found.generic.rest < 1e-9
    assert found.v == pytest.approx((1, -0.5, 1 / 3), rel=1e-8)
    assert start(gears, e=0.0).generic.rest == 0.0
    refused(gears, e=1e-3)
