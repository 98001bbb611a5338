"""Constraints that cannot be are refused, each at its place and with a way out."""

from __future__ import annotations

import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.run.check import classify
from lagrange_cli.run.motion import read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values

SYSTEM = """\
parameters: {m: 1, l: 1}
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {bob: m}
positions: {bob: [x, y]}
solve: {stop: 1}
"""
# the constraints, then the piece that is underlined, part of the message, part of the hint
BAD = [
    ("constraints: {c: x_dot}", "x_dot", "the velocity 'x_dot' cannot be used", "'nonholonomic'"),
    ("constraints: {c: bob.vx + x}", "bob.vx", "the velocity of 'bob' cannot be used", "'nonholonomic'"),
    ("constraints: {c: l - 1}", "l - 1", "'c' contains no coordinate", "that stays 0"),
    ("constraints: {c: t}", "t", "'c' contains no coordinate", "that stays 0"),
    ("constraints: {c: x - x}", "x - x", "no coordinate has an effect on it", "that stays 0"),
    ("nonholonomic: {c: x}", "x", "'c' contains no velocity", "'constraints'"),
    ("nonholonomic: {c: x_dot*0}", "x_dot*0", "no velocity has an effect on it", "in velocities"),
    ("nonholonomic: {c: x_dot*y_dot}", "x_dot*y_dot", "'c' is not linear in the velocities", "linear"),
    ("nonholonomic: {c: x_dot**3}", "x_dot**3", "'c' is not linear in the velocities", "linear"),
    ("nonholonomic: {c: abs(x_dot)}", "abs(x_dot)", "'c' is not linear in the velocities", "linear"),
    ("nonholonomic: {c: sqrt(x_dot)}", "sqrt(x_dot)", "'c' is not linear in the velocities", "linear"),
    ("constraints: {c: y - acos(cos(t))}", "acos(cos(t))", "asin and acos have no slope at 1", "another way"),
    ("constraints: {c: y}\nnonholonomic: {c: y_dot}", "c", "'c' is the name of another constraint", "rename"),
    ("constraints: {c: z}", "z", "unknown name 'z' in constraint 'c'", "parameters"),
    ("constraints: {c: bob}", "bob", "'c.x' is not satisfied", "--project-initial"),
    ("constraints: {c: norm(bob - (1, 0))}", "norm(bob - (1, 0))", "no derivative", "the vector itself"),
    ("constraints: [x]", "[", "must be a mapping with a name for each constraint", "rod"),
    ("constraints: {c: 1/y}", "1/y", "division by zero", "divisor"),
    ("constraints: {c: sqrt(y)}", "sqrt(y)", "'c' has no derivative where it is satisfied", "under the root"),
    ("constraints: {c: sqrt(y) - y}", "sqrt(y) - y", "'c' has no finite derivative", "another state"),
    (
        "constraints: {c: (x - 1)**2}",
        "(x - 1)**2",
        "although the constraint restricts the motion",
        "f in place of f**2",
    ),
    (
        "bodies: {b: {mass: 1, inertia: [1, 1, 1], position: [x, y, 0],\n"
        "  orientation: {quaternion: [l, y, 0, 0]}}}",
        "[",
        "although the constraint restricts the motion",
        "let its four components be coordinates",
    ),
    ("constraints: {c: x - 2}", "x - 2", "'c' is not satisfied by the initial values: it is -1", "(x = 2)"),
    ("constraints: {c: x - 1, d: x - 2}", "x - 2", "'d' is not satisfied", "contradict each other"),
    ("nonholonomic: {c: x_dot - 1, d: x_dot - 2}", "x_dot - 2", "'d' is not satisfied", "contradict each"),
    ("constraints: {c: x - 1, d: x - 1 - t}", "x - 1 - t", "'d' is not satisfied", "no velocities near"),
    ("constraints: {c: x - 1, d: x - 1 - t**2}", "x - 1 - t**2", "contradicts them later", "at all times"),
]


@pytest.mark.exhaustive(keep=17)
@pytest.mark.parametrize(("constraints", "underlined", "message", "hint"), BAD, ids=lambda value: str(value))
def test_a_bad_constraint_is_refused_by_solve_and_check_at_its_place(constraints, underlined, message, hint):
    text = SYSTEM + constraints
    with pytest.raises(SpecError) as of_solve:
        motion = read_motion(text.encode(), "system.yaml", Request())
        classify(motion.spec)
    with pytest.raises(SpecError) as of_check:
        spec = read_spec(text, "system.yaml")
        classify(spec, values=resolve_values(spec))
    assert str(of_solve.value) == str(of_check.value)
    (problem,) = of_solve.value.problems
    assert message in problem.message and hint in problem.hint
    line = text.splitlines()[problem.line - 1]
    assert line[problem.column - 1 :].startswith(underlined)
    assert problem.length == len(underlined)


def test_all_constraints_that_are_not_satisfied_are_listed():
    with pytest.raises(SpecError) as caught:
        read_motion((SYSTEM + "constraints: {c: x - 2, d: y - 3}").encode(), "system.yaml", Request())
    assert [one.message[:14] for one in caught.value.problems] == ["constraint 'c'", "constraint 'd'"]


def test_numbers_whose_squares_are_too_large_are_refused_in_words():
    text = SYSTEM.replace("l: 1}", "l: 1e160}").replace("x: {initial: 1}", "x: {initial: l}")
    with pytest.raises(SpecError, match="a number is too large, or its square"):
        read_motion((text + "constraints: {c: x**2 + y**2 - l**2}").encode(), "system.yaml", Request())


def test_a_method_that_cannot_keep_quaternions_says_so():
    """Nobody wrote a constraint."""
    text = """
        coordinates: {w: {initial: 1}, x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
        bodies:
          b: {mass: 1, solid: {sphere: 1}, position: [0, 0, 0], orientation: {quaternion: [w, x, y, z]}}
        solve: {stop: 1, method: BDF}
        """
    with pytest.raises(SpecError, match="quaternions, whose norms are constraints, needs method taylor"):
        read_motion(text.encode(), "system.yaml", Request())


@pytest.mark.parametrize(
    ("more", "underlined", "message"),
    [
        ("constraints: {c: y}\nsolve: {stop: 1, method: LSODA}", "LSODA", "constraints needs method taylor"),
        ("events: {e: y}\nsolve: {stop: 1, method: BDF}", "BDF", "DOP853 or Radau, not BDF"),
        ("events: {e: {when: y, action: {set: {m: 2}}}}\nsolve: {stop: -1}", "-1", "cannot be undone"),
    ],
)
def test_defaults_that_do_not_fit_the_system_are_mistakes_of_the_file(more, underlined, message):
    text = SYSTEM.replace("solve: {stop: 1}", more)
    with pytest.raises(SpecError) as caught:
        read_motion(text.encode(), "system.yaml", Request())
    (problem,) = caught.value.problems
    assert message in problem.message and problem.hint
    line = text.splitlines()[problem.line - 1]
    assert line[problem.column - 1 :][: problem.length] == underlined
