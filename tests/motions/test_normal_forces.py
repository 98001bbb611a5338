"""Forces and events that depend on forces of constraint: friction by a normal force, leaving a surface."""

from __future__ import annotations

from contextlib import nullcontext
from textwrap import dedent

import numpy as np
import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.equations import derive
from lagrange_cli.run.start import consistent_values
from lagrange_cli.run.verification import verify_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.support.motion import follow, prepared, run, spec_of

G = 9.81
OUTPUTS = ("q", "v", "constraints", "ledger")
BLOCK = """
    parameters: {m: 2.0, g: 9.81, mu: 0.8, alpha: 0.5, v0: 3.0, k: 0.0}
    coordinates:
      x: {initial: 0, velocity: v0}
      y: {initial: 0}
    masses: {block: m}
    positions: {block: [x, y]}
    potential: m*g*(sin(alpha)*x + cos(alpha)*y)
    constraints: {plane: y}
    definitions: {N: plane.multiplier}
    generalized_forces: {x: k*t - mu*N*sign(x_dot), y: 0.7*k*t}
    """
TENSION = """
    parameters: {m: 2.0, g: 9.81, mu: 0.05, l: 1.5}
    coordinates:
      x: {initial: 1.5, velocity: 0}
      y: {initial: 0, velocity: -1.0}
    masses: {bob: m}
    positions: {bob: [x, y]}
    potential: m*g*y
    constraints: {rod: (x**2 + y**2 - l**2)/(2*l)}
    definitions:
      N: -rod.multiplier
      F: (mu*N**1.5 + tanh(x_dot/N))/sqrt(bob.vx**2 + bob.vy**2)
    forces: {bob: [-F*bob.vx, -F*bob.vy]}
    observables: {tension: N}
    """.replace("bob.vx**2 + bob.vy**2", "x_dot**2 + y_dot**2")
WIRE = """
    parameters: {m: 2.0, g: 9.81, mu: 0.2, a: 1.0}
    coordinates:
      x: {initial: 1.5}
      y: {initial: 2.25}
    masses: {bead: m}
    positions: {bead: [x, y]}
    potential: m*g*y
    constraints: {wire: y - a*x**2}
    definitions:
      friction: mu*abs(wire.multiplier)*sign(x_dot)
    forces: {bead: [-friction, -2*friction*a*x]}
    """
RING = """
    parameters: {m: 1, R: 0.5, w: 6, mu: 0.2, g: 9.81}
    coordinates: {s: {initial: 0.1}, z: {initial: -sqrt(R**2 - 0.01)}}
    masses: {bead: m}
    positions: {bead: [s*cos(w*t), s*sin(w*t), z]}
    potential: m*g*z
    constraints: {ring: sqrt(s**2 + z**2) - R}
    definitions:
      N: sqrt(ring.multiplier**2 + (2*m*w*s_dot)**2)
      friction: mu*N*sign((s_dot*z - z_dot*s)/R)/R
    generalized_forces: {s: -friction*z, z: friction*s}
    """


@pytest.mark.exhaustive(keep=0.4)
def test_friction_by_the_normal_force_slows_a_block_down_and_holds_it() -> None:
    """Up an incline with g (sin + mu cos), then it rests; the coordinates are Cartesian."""
    motion = follow(BLOCK, 2.0, 21, outputs=OUTPUTS)
    slowing = G * (np.sin(0.5) + 0.8 * np.cos(0.5))
    stop = 3.0 / slowing
    moving = motion.t < stop
    expected = np.where(moving, 3.0 * motion.t - slowing / 2 * motion.t**2, 9.0 / (2 * slowing))
    assert moving.any() and not moving.all()
    np.testing.assert_allclose(motion["q/x"], expected, rtol=1e-15, atol=0)
    np.testing.assert_array_equal(motion["v/x"][~moving], 0.0)
    for path in ("h", "p/x", "p/y"):
        assert np.abs(motion[f"diagnostics/ledger/{path}"]).max() <= 1e-14


def test_a_block_that_is_not_held_slides_back() -> None:
    motion = follow(BLOCK, 2.0, 21, outputs=OUTPUTS, sets={"mu": 0.5})
    stop = 3.0 / (up := G * (np.sin(0.5) + 0.5 * np.cos(0.5)))
    down = G * (np.sin(0.5) - 0.5 * np.cos(0.5))
    assert motion["q/x"][-1] == pytest.approx(9.0 / (2 * up) - down / 2 * (2.0 - stop) ** 2, rel=1e-14)


def test_a_block_is_released_where_the_force_exceeds_what_the_normal_force_can_hold() -> None:
    """k t = mu (m g - 0.7 k t): both sides change."""
    motion = follow(BLOCK, 5.0, 51, outputs=OUTPUTS, sets={"alpha": 0, "v0": 0, "k": 3, "mu": 0.5})
    released = 0.5 * 2 * G / (3 * 1.35)
    assert (motion["v/x"][motion.t < released] == 0).all()
    speed = (3 * 1.35 * (25 - released**2) / 2 - 0.5 * 2 * G * (5 - released)) / 2
    assert motion["v/x"][-1] == pytest.approx(speed, rel=1e-14)


@pytest.mark.exhaustive(keep=0.15)
def test_a_normal_force_of_either_sign() -> None:
    """With |N| a bead slides on a wire and comes to rest: the ledgers balance, and N does not change sign
    without being seen."""
    motion = follow(WIRE, 10.0, 101, outputs=OUTPUTS)
    assert abs(motion["v/x"][-1]) < 1e-15 and abs(motion["q/x"][-1]) <= 0.1
    assert np.abs(motion["diagnostics/ledger/h"]).max() <= 1e-12
    plain = follow(WIRE.replace("abs(wire.multiplier)", "wire.multiplier"), 10.0, 101, outputs=OUTPUTS)
    np.testing.assert_allclose(motion["q/x"], plain["q/x"], rtol=0, atol=1e-12)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize(("place", "rests"), [(0.1, True), (0.2, False)])
def test_friction_that_is_not_linear_in_the_normal_force_holds_a_bead_in_all_coordinates(place, rests):
    """On a ring that turns, m sin (w^2 R cos - g) is along it, and m (w^2 R sin^2 + g cos) across it."""
    sine = place / 0.5
    along = sine * (18 * np.sqrt(1 - sine**2) - G)
    assert (along < 0.2 * (18 * sine**2 + G * np.sqrt(1 - sine**2))) == rests
    motion = follow(RING.replace("0.1", f"{place}").replace("0.01", f"{place**2}"), 3.0, 4, outputs=OUTPUTS)
    assert (abs(motion["q/s"][-1] - place) < 1e-15) == rests
    for path in ("h", "p/s", "p/z"):
        assert np.abs(motion[f"diagnostics/ledger/{path}"]).max() <= 1e-12


@pytest.mark.exhaustive(keep=0.65)
def test_a_bead_leaves_a_sphere_where_the_force_of_constraint_is_none() -> None:
    """y = 2 R/3 + v0^2/(3 g), as from the law of energy (Goldstein, 3rd ed., exercise 2.13)."""
    text = """
        parameters: {m: 2.0, g: 9.81, R: 1.5, v0: 0.3}
        coordinates:
          x: {initial: 0, velocity: v0}
          y: {initial: R}
        masses: {bead: m}
        positions: {bead: [x, y]}
        potential: m*g*y
        constraints: {sphere: x**2 + y**2 - R**2}
        events:
          leaves: {when: sphere.multiplier, direction: falling, action: stop}
        """
    motion = follow(text, 5.0, 51)
    assert motion.data["events/leaves/q/y"][-1] == pytest.approx(1.0 + 0.09 / (3 * G), rel=1e-14)


@pytest.mark.exhaustive(keep=0.15)
def test_forces_that_are_not_linear_in_the_force_of_constraint() -> None:
    """The ledgers balance in doubles and in double-double, and both agree."""
    outputs = (*OUTPUTS, "multipliers", "observables")
    motion = follow(TENSION, 0.3, 4, outputs=outputs)
    ready = prepared(TENSION, outputs=outputs, tolerance=2.0**-104, precision=DOUBLE_DOUBLE)
    fine = run(ready, resolve_long_values(spec_of(TENSION)), 0.0, 0.3, 4)
    for one, bound in ((motion, 1e-14), (fine, 1e-29)):
        assert np.abs(one["diagnostics/ledger/h"]).max() <= bound
    np.testing.assert_allclose(motion["multipliers/rod"], fine["multipliers/rod"], rtol=1e-14)
    np.testing.assert_array_equal(motion["observables/tension"], -motion["multipliers/rod"])


ROD = """
    parameters: {m: 1, l: 1, mu: 2.5, g: 9.81}
    coordinates: {x: {initial: 0, velocity: -5}, y: {initial: l*sin(0.3)}, th: {initial: 0.3, velocity: 1}}
    bodies:
      rod:
        mass: m
        solid: {rod: 2*l}
        position: [x, y, 0]
        orientation: {euler: [th, pi/2, 0], sequence: zyx}
    definitions: {friction: -mu*floor.multiplier*sign(x_dot + l*sin(th)*th_dot)}
    potential: m*g*y
    constraints: {floor: y - l*sin(th)}
    generalized_forces: {x: friction, th: friction*l*sin(th)}
    solve: {stop: 2}
"""
"""A rod whose end slides on a floor and sticks: its speed there is a sum that is 0 up to rounding."""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "text", [RING, BLOCK, WIRE, TENSION, ROD], ids=["ring", "line", "abs", "smooth", "rod"]
)
def test_printed_compiled_and_direct_equations_agree(text: str) -> None:
    derived = derive(read_spec(dedent(text), "system.yaml"), lambda _: nullcontext(), {})
    verification = verify_system(derived, {})
    assert verification.agrees and verification.directly


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("N: plane.multiplier", "N: plain.multiplier", "(?s)no constraint 'plain'.*did you mean 'plane'"),
        (
            "N: plane.multiplier",
            "N: plane",
            "(?s)'plane' is a constraint, which is always 0.*plane.multiplier",
        ),
        (
            "potential: m*g",
            "potential: N + m*g",
            "(?s)which depends on a multiplier.*forces, observables and",
        ),
        ("constraints: {plane: y}", "constraints: {plane: y*N}", "cannot be used"),
    ],
)
def test_what_a_multiplier_cannot_stand_in(old: str, new: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        read_spec(dedent(BLOCK.replace(old, new)), "system.yaml")


def test_a_multiplier_that_is_not_determined_has_no_part_in_forces() -> None:
    """Two constraints that say the same share their force in any way."""
    spec = read_spec(dedent(BLOCK.replace("{plane: y}", "{plane: y, again: 2*y}")), "system.yaml")
    spec, *_ = consistent_values(spec, resolve_values(spec), 0.0, {})
    with pytest.raises(SpecError, match="multiplier of constraint 'plane' is not determined"):
        derive_system(spec)


@pytest.mark.exhaustive(keep=0.65)
def test_a_ladder_leaves_the_wall_at_two_thirds_of_its_height():
    """sin(th) = 2/3 sin(th0): by the energy th_dot^2 = 3 g (sin(th0) - sin(th))/(2 l) for a rod of the length
    2 l, whose centre has no acceleration along the floor there."""
    text = """
parameters: {m: 3, l: 1, g: 9.81, th0: 1.2}
coordinates: {X: {initial: -l*cos(th0)}, Y: {initial: l*sin(th0)}, th: {initial: th0}}
bodies:
  ladder:
    mass: m
    solid: {rod: 2*l}
    position: [X, Y, 0]
    orientation: {euler: [th, pi/2, 0], sequence: zyx}
potential: m*g*ladder.y
constraints: {wall: "ladder.at(0, 0, l).x", floor: "ladder.at(0, 0, -l).y"}
events: {leaves: {when: wall.multiplier, direction: rising, action: stop}}
"""
    motion = follow(text, 5.0, 11, outputs=("q",))
    final = motion.outcome.final
    assert np.sin(final.q["th"]) == pytest.approx(2 / 3 * np.sin(1.2), abs=1e-14)
    assert final.v["th"] == pytest.approx(-np.sqrt(G * np.sin(1.2) / 2), abs=1e-13)


@pytest.mark.exhaustive(keep=0.6)
def test_what_friction_has_stopped_on_a_wire_does_not_move_at_all():
    """Nor does what the wire moves with it, so that the motion can begin anew from where it rests."""
    text = """
parameters: {m: 1, g: 9.81, mu: 0.5}
coordinates: {x: {initial: 0.2, velocity: 0.5}, y: {}}
masses: {b: m}
positions: {b: [x, y]}
potential: m*g*y
constraints: {wire: y - sqrt(1 + x**2)}
generalized_forces: {x: -mu*abs(wire.multiplier)*sign(x_dot)}
"""
    motion = follow(text, 2.0, 11, outputs=("q", "v"))
    assert motion["v/x"][0] == 0.5
    assert not np.any([motion["v/x"][1:], motion["v/y"][1:]])


@pytest.mark.exhaustive(keep=0.25)
def test_a_bead_stays_on_a_rough_hoop_that_turns_past_the_axes():
    """The friction's components vanish in turn: the force that holds the bead is none of them."""
    by_angle = """
coordinates: {a: {initial: 0.5}}
masses: {bead: 1}
positions: {bead: [sin(a)*cos(6*t), sin(a)*sin(6*t), -cos(a)]}
potential: 9.81*bead.z
definitions: {n: "sqrt((a_dot**2 + 36*sin(a)**2 + 9.81*cos(a))**2 + (12*cos(a)*a_dot)**2)"}
generalized_forces: {a: -0.1*n*sign(a_dot)}
"""
    in_space = """
coordinates: {x: {initial: sin(0.5)}, y: {initial: 0, velocity: 6*sin(0.5)}, z: {initial: -cos(0.5)}}
masses: {bead: 1}
positions: {bead: [x, y, z]}
potential: 9.81*z
constraints: {sphere: (x**2 + y**2 + z**2 - 1)/2, plane: x*sin(6*t) - y*cos(6*t)}
definitions:
  r: x*cos(6*t) + y*sin(6*t)
  n: 0.1*sqrt(sphere.multiplier**2 + plane.multiplier**2)
  s: sign(z_dot*r - z*(x_dot*cos(6*t) + y_dot*sin(6*t)))
forces: {bead: [n*s*z*cos(6*t), n*s*z*sin(6*t), -n*s*r]}
"""
    angle, space = (follow(text, 4, 41, outputs=("q",)) for text in (by_angle, in_space))
    assert space["q/z"] == pytest.approx(-np.cos(angle["q/a"]), abs=1e-12)
    assert np.ptp(space["q/z"][20:]) < 1e-14  # it holds from t = 1.8 on, past cos(6 t) = 0
    assert space.outcome.steps < 100
