"""Constraints that are vectors: the same as their components, written one by one."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.model.orientation import turning
from lagrange_cli.spec.entering import enter_names
from lagrange_cli.spec.families import expand
from lagrange_cli.spec.nodes import compose
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.read import read_draft, read_spec
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.zeros import CONSTANT, VARYING, ZERO, Zeros
from tests.support.files import problems, underlined

LINKS = """\
parameters: {{m: 1, g: 9.81, a: 0.5}}
coordinates: {{x: , y: , f: {{initial: {f}}}, u: , v: , p: {{initial: {p}}}}}
bodies:
  A: {{mass: m, inertia: [0.1, 0.1, 0.1], position: [x, y, 0], orientation: {{euler: [f, 0, 0]}}}}
  B: {{mass: m, inertia: [0.1, 0.1, 0.1], position: [u, v, 0], orientation: {{euler: [p, 0, 0]}}}}
potential: m*g*(A.y + B.y)
constraints:
{constraints}
solve: {{stop: 1, samples: 11, outputs: [q, multipliers, constraints]}}
"""
VECTORS = """\
  pin: A.at(0, a, 0)
  joint: A.at(0, -a, 0) - B.at(0, a, 0)
"""
ONE_BY_ONE = """\
  pin_x: A.at(0, a, 0).x
  pin_y: A.at(0, a, 0).y
  joint_x: A.at(0, -a, 0).x - B.at(0, a, 0).x
  joint_y: A.at(0, -a, 0).y - B.at(0, a, 0).y
"""


def links(constraints, f=0.3, p=-0.2):
    return LINKS.format(constraints=constraints, f=f, p=p)


@pytest.mark.exhaustive(keep=0.4)
def test_a_vector_is_its_components_to_the_last_bit():
    one, two = (lagrange.solve(links(each)) for each in (VECTORS, ONE_BY_ONE))
    assert [*one.multipliers] == ["pin.x", "pin.y", "joint.x", "joint.y"]
    for name in one.multipliers:
        assert np.array_equal(one.multipliers[name], two.multipliers[name.replace(".", "_")])
    assert all(np.array_equal(one.q[name], two.q[name]) for name in one.q)


@pytest.mark.exhaustive(keep=0.75)
def test_the_multipliers_of_a_joint_are_the_force_in_it():
    resting = lagrange.solve(links(VECTORS, 0, 0))
    g = 9.81
    expected = {"pin.x": 0, "pin.y": 2 * g, "joint.x": 0, "joint.y": -g}
    for name, force in expected.items():
        assert resting.multipliers[name] == pytest.approx(np.full(11, force), abs=1e-12)


FORMS = [
    "A - B",
    "[A.x - B.x, A.y - B.y]",
    "2*(A - B)/3",
    "-(B - A)",
    "A - (B.x, B.y)",
    "sum((i + 1)*(A - B) for i in range(3))",
    "A - d",
]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("form", FORMS)
def test_each_way_to_write_a_vector_joins_two_particles(form):
    text = f"""\
coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}, u: , v: }}
definitions: {{d: (u, v)}}
masses: {{A: 1, B: 2}}
positions: {{A: [x, y], B: [u, v]}}
potential: A.y
constraints: {{c: "{form}"}}
"""
    motion = lagrange.solve(text.replace('"[', "[").replace(']"', "]"), stop=1, outputs=["q", "multipliers"])
    assert [*motion.multipliers] == ["c.x", "c.y"]
    assert motion.q["y"] == pytest.approx(-(motion.t**2) / 6, abs=1e-14)
    assert motion.q["v"] == pytest.approx(motion.q["y"], abs=1e-14)


def test_a_cross_product_has_three_components():
    text = """\
coordinates: {x: {initial: 1}, y: {initial: 2}, z: {initial: 3, velocity: 3}}
masses: {A: 1}
positions: {A: [x, y, z]}
potential: A.z
constraints: {line: "cross(A, (1, 2, 3))"}
"""
    spec = read_spec(text, "line.yaml")
    assert [*spec.constraints] == ["line.x", "line.y", "line.z"]
    with pytest.warns(lagrange.LagrangeWarning, match="depends on the others"):
        motion = lagrange.solve(text, stop=1)
    assert motion.q["y"] == pytest.approx(2 * motion.q["x"], abs=1e-13)
    assert motion.q["z"] == pytest.approx(3 * motion.q["x"], abs=1e-13)


CHAIN = """\
sizes: {N: 4}
coordinates:
  x[i in range(N)]: {initial: i + 1}
  y[i in range(N)]: {initial: 0}
masses:
  A[i in range(N)]: 1
positions:
  A[i in range(N)]: [x[i], y[i]]
potential: sum(A[i].y for i in range(N))
constraints:
  c[0]: A[1] - A[0] - (1, 0)
  c[i in range(1, N - 1)]: A[i + 1] - A[i] - (1, 0)
"""


def test_a_family_of_vectors_is_a_family_for_each_component():
    motion = lagrange.solve(CHAIN, stop=1, outputs=["q", "multipliers"])
    assert {name: each.shape for name, each in motion.multipliers.items()} == {
        "c.x": (1001, 3),
        "c.y": (1001, 3),
    }
    assert motion.q["y"] == pytest.approx(np.repeat(-(motion.t[:, None] ** 2) / 2, 4, axis=1), abs=1e-14)


@pytest.mark.exhaustive(keep=0.6)
def test_velocities_of_a_vector_under_nonholonomic():
    text = """\
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0, velocity: 2}, u: {initial: 3}, v: {initial: 4}}
masses: {A: 1, B: 1}
positions: {A: [x, y], B: [u, v]}
potential: 0
nonholonomic: {together: [A.vx - B.vx, A.vy - B.vy]}
"""
    motion = lagrange.solve(text, stop=1, outputs=["q", "v"])
    assert motion.v["u"] == pytest.approx(1, abs=1e-14)
    assert motion.q["v"][-1] == pytest.approx(6, abs=1e-13)
    assert lagrange.check(text).as_data()["degrees_of_freedom"] == 2


WRONG = [
    ("c: A - B\nforces: {A: [c.multiplier, 0]}", "c.multiplier", "'c' is a vector", "c_x, c_y"),
    ("c: A - (B.x, B.y, 0)", "A - (B.x, B.y, 0)", "vectors of 2 and 3 components", "same number"),
    ("c: [x, y, u, v]", "[", "one to three components, not 4", "[x, y, z]"),
    ("c: A = B", "A = B", "not an equation", "A - B"),
    ("c: {x: A.x - B.x, y: A.y - B.y}", "{", "not a mapping", "as a list"),
    ("c: 2 + A", "2 + A", "vector", "component"),
]


@pytest.mark.parametrize("constraints, place, message, hint", WRONG)
def test_what_is_no_constraint_is_refused_with_a_way_out(constraints, place, message, hint):
    (problem,) = problems(f"""\
coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}, u: {{initial: 1}}, v: {{initial: 0}}}}
masses: {{A: 1, B: 2}}
positions: {{A: [x, y], B: [u, v]}}
potential: A.y
constraints:
  {constraints}
""")
    assert message in problem.message
    assert hint in problem.hint
    assert underlined(problem) == place


def test_members_of_a_family_have_the_same_number_of_components():
    (problem,) = problems(CHAIN.replace("A[1] - A[0] - (1, 0)", "x[1] - x[0] - 1"))
    assert "differ in their number of components" in problem.message


RIGHT = {"0": 0.0, "0.0": 0.0, "pi/2": np.pi / 2, "-pi": -np.pi, "3*pi/2": 3 * np.pi / 2}


def orientations():
    angles = ["a", "0", "pi/2", "-pi", "3*pi/2", "0.0", "l"]
    for sequence in ("zxz", "xyz", "zyx", "yxy"):
        for given in itertools.product(angles, repeat=3):
            yield f"{{euler: [{', '.join(given)}], sequence: {sequence}}}", "euler", sequence, given
    for given in itertools.product(["a", "0"], repeat=4):
        if "a" in given:
            yield f"{{quaternion: [{', '.join(given)}]}}", "quaternion", "", given


def zeros_of(text):
    """What is known of the names of a file, and its orientation."""
    noted = Problems(Source("pattern.yaml", text))
    draft = expand(read_draft(compose(noted.source, noted), noted), {}, noted)
    known = enter_names(draft, {}, noted)
    assert not noted.found
    return Zeros(draft, known, lambda tree: getattr(tree, "items", tree)), draft.bodies[0].orientation


@pytest.mark.exhaustive(keep=0.4)
def test_what_is_known_of_the_entries_of_an_orientation(pytestconfig):
    """Those that are 0, and those that do not change: at three states, a parameter l being any number."""
    rng = random.Random(pytestconfig.option.seed)
    by_angles = [one for one in orientations() if one[1] == "euler"]
    by_quaternions = [one for one in orientations() if one[1] == "quaternion"]
    for text, form, sequence, given in [*by_quaternions, *rng.sample(by_angles, 300)]:
        body = f"bodies: {{A: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], orientation: {text}}}}}\n"
        zeros, written = zeros_of(f"parameters: {{l: 1}}\ncoordinates: {{a: {{initial: 1}}}}\n{body}")
        pattern = np.array(zeros.pattern(written))
        fixed = [rng.uniform(0.1, 1.4) if one == "l" else RIGHT.get(one) for one in given]
        found = []
        for _ in range(3):
            values = np.array([rng.uniform(0.1, 1.4) if one is None else one for one in fixed])
            values /= np.linalg.norm(values) if form == "quaternion" else 1.0
            found.append(turning(NumberAlgebra(), form, sequence, [*values], lambda x: x).axes)
        assert np.array_equal(pattern > ZERO, np.max(np.abs(found), axis=0).T > 1e-12), text
        assert np.array_equal(pattern == VARYING, np.ptp(found, axis=0).T > 1e-12), text


KNOWN = [
    ("0*x + 0", ZERO), ("l*2", CONSTANT), ("l*sin(x)", VARYING), ("t", VARYING), ("-(0/x)", ZERO),
    ("x**2*0", ZERO),
    ("cos(l) + pi", CONSTANT), ("A.z", CONSTANT), ("A.vz", ZERO), ("A.vx*0.5", VARYING), ("A.R33", CONSTANT),
    ("A.R13", ZERO), ("A.vR33 + A.vR12*0", ZERO), ("A.vR12", VARYING), ("A.wx", ZERO), ("A.w2", ZERO),
    ("A.wz", VARYING), ("d", ZERO), ("e + d", VARYING), ("sum(0*i for i in range(3))", ZERO),
    ("where(x > 0, l, 1)", VARYING),
]  # fmt: skip


@pytest.mark.parametrize(("text", "level"), KNOWN)
def test_what_is_known_of_an_expression(text, level):
    zeros, _ = zeros_of("""\
parameters: {l: 1}
coordinates: {x: {initial: 1}, y: {initial: 0}}
definitions: {d: 0*x, e: x*y}
bodies: {A: {mass: 1, inertia: [1, 1, 1], position: [x, y, l], orientation: {euler: [0, 0, y]}}}
""")
    assert zeros.level(parse(text)) == level


ROLLING = """\
parameters: {m: 1, r: 0.1, Omega: 2, I: 2*m*r**2/5}
coordinates:
  {x: {initial: 1}, y: {initial: 0}, a: {initial: 1}, b: {initial: 0}, c: {initial: 0}, d: {initial: 0}}
bodies:
  ball: {mass: m, inertia: [I, I, I], position: [x, y, r], orientation: {quaternion: [a, b, c, d]}}
potential: 0
definitions: {turning: (x, y, 0)}
nonholonomic:
  roll: >-
    (ball.vx, ball.vy, ball.vz) + cross((ball.wx, ball.wy, ball.wz), (0, 0, -r))
    - Omega*cross((0, 0, 1), turning)
solve: {stop: 10, outputs: [q, v, multipliers]}
"""


@pytest.mark.exhaustive(keep=0.75)
def test_a_ball_rolls_on_a_turntable_by_a_vector():
    """It moves in a circle at 2/7 of the rate at which the table turns, whatever the circle is (Earnshaw)."""
    motion = lagrange.solve(ROLLING, set={"y_dot": 1})
    rate = 2 * 2 / 7
    assert {*motion.multipliers} == {"ball.norm", "roll.x", "roll.y"}
    along, t = motion.v["x"] + 1j * motion.v["y"], motion.t
    assert along == pytest.approx(1j * np.exp(1j * rate * t), abs=1e-12)
