"""What people write who have read the documents only: one message each, with a way out that works."""

from __future__ import annotations

import pytest

from tests.support.files import PENDULUM, problems

START, POSITION, POTENTIAL = "{initial: 0.1}", "bob: [l*sin(theta), -l*cos(theta)]", "m*g*bob.y"

SAID = [
    # what to replace, by what; what is said
    ("g: 9.81", "g: true", "'true' is not a number; write a number, such as 1 or 0, or an expression"),
    ("g: 9.81", "g: 1d-3", "unknown notation of a number: '1d-3'; write 1e-3"),
    ("g: 9.81", "g: -2.5D+4", "unknown notation of a number: '-2.5D+4'; write -2.5e+4"),
    (START, "{initial: yes}", "'yes' is not a number; write a number, such as 1 or 0, or an expression"),
    (START, "on", "coordinate 'theta' must be a mapping; write theta: {initial: 0.1}"),
    (START, "[1, 2]", "coordinate 'theta' must be a mapping; write theta: {initial: 1, velocity: 2}"),
    (START, "{initial: deg(30)}", "unknown function 'deg'; write x*pi/180 for x degrees"),
    (START, "{initial: 30*deg}", "unknown name 'deg'; write pi/180: angles are in radians"),
    (
        START,
        "{initial: rad(1)}",
        "unknown function 'rad'; write x: angles are in radians, and x*pi/180 is x degrees",
    ),
    (
        START,
        "{initial: 1}\n  theta_dot: {initial: 0}",
        "the coordinate 'theta_dot' has the name of the velocity of 'theta'; "
        "write 'theta: {velocity: ...}', or rename it",
    ),
    (
        POSITION,
        "x: l*sin(theta)\n  y: -l*cos(theta)",
        "the particle 'bob' has a mass but no position; add embedding: {bob: [x, y]}",
    ),
    (
        POSITION,
        f"{POSITION}\n  pivot: [0, 0]",
        "the particle 'pivot' has a position but no mass; "
        "add masses: {pivot: 1.0}, or write it under 'definitions' if it has no mass",
    ),
    (
        "potential:",
        "definitions: {up: bob - l}\npotential:",
        "a vector and a scalar cannot be combined by '-'; write bob.x for a component, or norm(bob)",
    ),
    (
        POTENTIAL,
        "m*g*[l - theta]**2",
        "a vector cannot stand in a power; write parentheses: [ and ] make a vector",
    ),
    (
        POTENTIAL,
        "l + [l - theta]",
        "a vector and a scalar cannot be combined by '+'; write parentheses: [ and ] make a vector",
    ),
    (POTENTIAL, "V", "unknown name 'V'; write out the potential energy, here or as 'V' under 'definitions'"),
    (
        "bob: m\n",
        "bob: m*exp(-t)\n",
        "the time 't' cannot be used; "
        "masses and moments of inertia may use numbers and parameters; with a mass that changes, "
        "write 'lagrangian'",
    ),
    (
        "potential:",
        "time: 10\npotential:",
        "time is the unit of t, not a number; write 'solve: {stop: 10}' for the end of the motion",
    ),
    (
        "potential:",
        "solve: {t: [0, 10]}\npotential:",
        "unknown key 't' in solve; write 'start: 0' and 'stop: 10'",
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), SAID, ids=[new for _, new, _ in SAID])
def test_one_message_leads_to_what_was_meant(old, new, said):
    assert PENDULUM.count(old) == 1
    (found,) = problems(PENDULUM.replace(old, new))
    message, _, hint = said.partition("; ")
    assert found.message.startswith(message)
    assert found.hint == hint


POINTS = """
parameters: {r: 1}
coordinates: {x: {initial: 0}, a: {initial: 1}, b: {initial: 1}}
bodies:
  disc: {mass: 1, solid: {disc: r}, position: [x, 0, r], orientation: {euler: [a, b, 0]}}
potential: 0
definitions:
  point: disc.at(r*sin(a), r, 0)
  same: point
  rim: disc.at(r, 0, 0)
  pair[i in range(2)]: disc.at(0, a, i)
observables: {speed: %s}
"""


@pytest.mark.parametrize(
    ("velocity", "point"),
    [
        ("point.vx", "disc.at(r*sin(a), r, 0).vx"),
        ("same.vy", "disc.at(r*sin(a), r, 0).vy"),
        ("pair[1].vz", "disc.at(0, a, i).vz"),
    ],
)
def test_a_definition_of_a_point_of_contact_has_two_velocities(velocity, point):
    """``disc.at(..).vx`` is the velocity of the body there, and not the rate of ``disc.at(..).x``."""
    (found,) = problems(POINTS % velocity)
    assert "two velocities" in found.message
    assert found.hint == f"write {point} for that of the body there"


@pytest.mark.parametrize("velocity", ["rim.vx", "point.x", "disc.at(r*sin(a), r, 0).vx"])
def test_other_points_have_one_velocity(velocity):
    assert problems(POINTS % velocity) == []


@pytest.mark.parametrize("item", ["[1]", '"1"', "{b: 1}"])
def test_a_brace_that_is_left_open_to_the_end_is_named(item):
    (found,) = problems(f"parameters: {{\n  a: {item}\n")
    assert found.hint == "the '{' of line 1 is still open: close it, or write a comma"
