"""Which constraints are solved for coordinates, and what is left."""

from __future__ import annotations

import json

import pytest

from lagrange_cli.native.elimination import reduced, work
from tests.support.command import lagrange
from tests.support.elimination import BELTS, CART, DISC, GEARS, MIXED, PULLEYS, SHAKEN, TRAIN
from tests.support.motion import residual_of

BY_HAND = {
    "gears": (
        GEARS,
        """
parameters: {I1: 2.0, I2: 0.7, R1: 0.3, R2: 0.8, k: 5}
coordinates: {a: {initial: 1.3}}
lagrangian: I1*a_dot**2/2 + I2*(R1/R2*a_dot)**2/2 + k*cos(a)
""",
    ),
    "shaken": (
        SHAKEN,
        """
parameters: {m: 2.0, M: 0.7, w: 3, A: 0.3, l: 1.1, g: 9.81}
coordinates: {th: {initial: 1}}
masses: {p: m}
positions: {p: [A*cos(w*t) + l*sin(th), -l*cos(th)]}
potential: m*g*p.y
""",
    ),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_equations_are_those_of_independent_coordinates(name):
    """As many products an order as without the constraint: nothing of it is left."""
    given, alone = BY_HAND[name]
    found = reduced(residual_of(given))
    assert found is not None
    after, hand = found.after, residual_of(alone)
    assert not after.multipliers and len(after.residual) == len(hand.residual) == 1
    assert after.series().convolutions == hand.series().convolutions
    assert len(after.series().unknown) == 1 and len(after.series().coordinates) == 2


@pytest.mark.parametrize(
    ("text", "gone", "multipliers"),
    [
        (GEARS, {"b"}, 0),
        (PULLEYS, {"c", "y"}, 0),
        (BELTS, {"b", "c", "d"}, 0),
        (DISC, {"phi"}, 0),  # the place of x counts, and the angle does not
        (CART, {"x"}, 0),
        (MIXED, {"x2"}, 1),
        (TRAIN, {f"th[{i}]" for i in range(4)}, 0),
    ],
)
def test_what_is_eliminated(text, gone, multipliers):
    residual = residual_of(text)
    found = reduced(residual)
    assert found is not None
    assert {one.name for one in found.after.dependent} == gone
    assert len(found.after.multipliers) == multipliers
    assert found.after.state_q == residual.model.q and found.after.state_v == residual.model.v
    assert work(found.after, found.after.series()) < work(residual, residual.series())


ATOMS = """
sizes: {N: 30}
coordinates: {"x[i in range(N)]": {initial: i}}
masses: {"atom[i in range(N)]": 1}
positions: {"atom[i in range(N)]": "x[i]"}
potential: sum(cos(x[i]) for i in range(N))
constraints: {centre: "sum(x[i] for i in range(N)) - 435"}
"""
FRICTION = """
parameters: {m: 1, g: 9.81, mu: 0.2}
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0}}
masses: {block: m}
positions: {block: [x, y]}
potential: m*g*y
constraints: {plane: y}
generalized_forces: {x: -mu*plane.multiplier*sign(x_dot)}
"""
GEAR_BOX = GEARS + "events: {shift: {when: a_dot + 9, action: {set: {R2: R2/2}}}}\n"
BOTH_PLACES = DISC.replace("+ k*x**4", "+ k*x**4 + k*cos(phi)")
ROLLING_FASTER = CART.replace("+ 0.1", "+ 0.1*t")
PENDULUM = """
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {bob: 1}
positions: {bob: [x, y]}
potential: y
constraints: {rod: x**2 + y**2 - 1}
"""


@pytest.mark.parametrize(
    "text",
    [
        ATOMS,  # all masses would be coupled
        FRICTION,  # its multiplier acts
        GEAR_BOX,  # what is divided by may change
        BOTH_PLACES,  # either place is known but for a constant
        ROLLING_FASTER,  # an integral over t would have to be found
        PENDULUM,
    ],
)
def test_what_is_not(text):
    assert reduced(residual_of(text)) is None


@pytest.mark.exhaustive(keep=0.8)
def test_short_constraints_are_eliminated_where_a_long_one_is_not():
    text = ATOMS.replace("{centre:", "{pair: x[0] + x[1] - 1, centre:")
    found = reduced(residual_of(text))
    assert found is not None
    assert [one.name for one in found.after.dependent] == ["x[1]"] and len(found.after.multipliers) == 1


DIFFERENCES = """
parameters: {R: 3, S: 2}
coordinates: {a: {initial: 1}, b: {}, c: {}}
lagrangian: (a_dot**2 + b_dot**2 + 2*c_dot**2)/2 - a**4 - c**2
constraints: {one: a + b + c, two: a + R*b + S*c}
"""


def test_differences_of_coefficients_are_not_divided_by():
    """With S = 1 nothing is left of c in the second constraint, once the first one has been put into it."""
    found = reduced(residual_of(DIFFERENCES))
    assert found is not None
    assert len(found.after.dependent) == 1 and len(found.after.multipliers) == 1


@pytest.mark.exhaustive(keep=0.35)
def test_check_says_it(tmp_path):
    (tmp_path / "gears.yaml").write_text(GEARS)
    (tmp_path / "train.yaml").write_text(TRAIN)

    def check(*arguments):
        return lagrange("check", *arguments, cwd=tmp_path).stdout

    assert "b follows from the constraint mesh (line 5), which is linear: b = -R1*a/R2" in check("gears.yaml")
    said = check("train.yaml")
    assert "th[0..3] follow from linear constraints: the equations are solved without them" in said
    assert "th[2] follows" not in said
    said = check("train.yaml", "--verbose")
    assert "th[2] follows from the constraint mesh[1] (line 10), which is linear: th[2] = 5*a/6" in said
    (one,) = json.loads(check("gears.yaml", "--json"))["eliminated"]
    assert one == {"coordinate": "b", "constraint": "mesh", "quantity": "b", "expression": "-R1*a/R2"}
    said = check("gears.yaml", "--set", "R2=0", "--set", "a=0", "--set", "b=0")
    assert "constraints: mesh" in said and "follows" not in said


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("text", [GEARS, CART, MIXED])
def test_printed_equations_are_those_that_are_followed(tmp_path, text):
    (tmp_path / "system.yaml").write_text(text)
    run = lagrange("equations", "system.yaml", "--verify", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
