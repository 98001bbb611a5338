"""Forces of constraint on particles, against closed forms and against multipliers."""

from __future__ import annotations

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.errors import NotDefined
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.mechanics.constrained.reactions import Reactions
from lagrange_cli.outputs.plan import make_plan
from tests.support.motion import follow, model_of, residual_of

ANGLE = """
parameters: {m: 0.7, l: 1.3, g: 9.81}
coordinates: {theta: {initial: 1.0, velocity: 0.5}}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
observables: {tension: m*l*theta_dot**2 + m*g*cos(theta), x: bob.x/l, y: bob.y/l}
"""
CARTESIAN = """
parameters: {m: 0.7, l: 1.3, g: 9.81}
coordinates: {x: {initial: l*sin(1)}, y: {initial: -l*cos(1)}}
masses: {bob: m}
positions: {bob: [x, y]}
potential: m*g*y
constraints: {rod: x**2 + y**2 - l**2}
"""
POLAR = """
parameters: {m: 0.7, l: 1.3, g: 9.81}
coordinates: {r: {initial: l}, phi: {initial: 0.4}}
masses: {bob: m}
positions: {bob: [r*cos(phi), r*sin(phi)]}
potential: m*g*r*sin(phi)
generalized_forces: {phi: -0.2*r**2*phi_dot}
constraints: {ring: r - l}
"""
INCLINE = """
parameters: {m: 2.0, alpha: 0.5, g: 9.81}
coordinates: {s: {initial: 0.0}}
masses: {block: m}
positions: {block: [s*cos(alpha), -s*sin(alpha)]}
potential: m*g*block.y
"""
ATWOOD = """
parameters: {m1: 2.0, m2: 0.7, l: 3.0, g: 9.81}
coordinates: {x: {initial: 1.0}}
masses: {left: m1, right: m2}
positions: {left: [-x], right: [x - l]}
potential: m1*g*left.x + m2*g*right.x
"""
SPHERE = """
parameters: {m: 1.5, a: 0.8, g: 9.81}
coordinates: {phi: {initial: 0.001}}
masses: {bead: m}
positions: {bead: [a*sin(phi), a*cos(phi)]}
potential: m*g*bead.y
observables: {normal: m*g*(3*cos(phi) - 2*cos(0.001)), x: bead.x/a, y: bead.y/a}
events: {leaves: {when: cos(phi) - 2*cos(0.001)/3, action: stop}}
"""
PARABOLA = """
parameters: {m: 1.5, k: 0.8, g: 9.81}
coordinates: {x: {initial: 0.9}}
masses: {bead: m}
positions: {bead: [x, k*x**2]}
potential: m*g*bead.y
observables: {up: m*(2*k*x_dot**2 + g)/(1 + 4*k**2*x**2), along: -2*k*x}
"""


def test_the_tension_of_a_pendulum_from_its_angle():
    motion = follow(ANGLE, 10.0, 101, outputs=("reactions", "observables"))
    direction = np.stack([motion["observables/x"], motion["observables/y"]], axis=1)
    tension = motion["observables/tension"]
    assert np.abs(motion["reactions/bob"] + tension[:, None] * direction).max() < 1e-14
    assert tension.min() > 3


@pytest.mark.exhaustive(keep=0.35)
def test_the_same_from_a_constraint():
    motion = follow(CARTESIAN, 10.0, 101, outputs=("q", "reactions", "multipliers"))
    place = np.stack([motion["q/x"], motion["q/y"]], axis=1)
    force = 2 * motion["multipliers/rod"][:, None] * place
    assert np.abs(motion["reactions/bob"] - force).max() < 1e-13
    assert np.abs(force).max() > 3


def test_forces_along_polar_coordinates_are_forces_in_the_plane():
    """They are known although U is not written in positions: positions and coordinates are as many."""
    motion = follow(POLAR, 5.0, 51, outputs=("q", "reactions", "multipliers"))
    phi = motion["q/phi"]
    radial = motion["multipliers/ring"][:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    assert np.abs(motion["reactions/bob"] - radial).max() < 1e-13


@pytest.mark.parametrize("stop", [3.0, -3.0])
def test_a_block_on_an_incline(stop):
    motion = follow(INCLINE, stop, 11, outputs=("reactions",))
    normal = 2.0 * 9.81 * np.cos(0.5)
    assert np.allclose(motion["reactions/block"], [normal * np.sin(0.5), normal * np.cos(0.5)], rtol=1e-14)


def test_the_machine_of_atwood():
    motion = follow(ATWOOD, 0.5, 11, outputs=("reactions",))
    for side in ("left", "right"):
        assert np.allclose(motion[f"reactions/{side}"], 2 * 2.0 * 0.7 * 9.81 / 2.7, rtol=1e-14)


def test_a_bead_leaves_a_sphere_where_the_force_vanishes():
    motion = follow(SPHERE, 10.0, 2001, outputs=("q", "reactions", "observables"))
    direction = np.stack([motion["observables/x"], motion["observables/y"]], axis=1)
    force = motion["observables/normal"][:, None] * direction
    assert np.abs(motion["reactions/bead"] - force).max() < 1e-11
    assert 0 < motion["observables/normal"][-1] < 0.2


def test_a_bead_on_a_parabola():
    motion = follow(PARABOLA, 5.0, 101, outputs=("reactions", "observables"))
    along, up = motion["reactions/bead"].T
    assert np.abs(up - motion["observables/up"]).max() < 1e-13
    assert np.abs(along - motion["observables/along"] * up).max() < 1e-13


ANGLES = """
parameters: {g: 9.81}
coordinates: {a: {initial: 1.0}, b: {initial: 2.0}}
masses: {one: 1.0, two: 0.5}
positions: {one: [sin(a), -cos(a)], two: [one_x + 0.8*sin(b), one_y - 0.8*cos(b)]}
definitions: {one_x: sin(a), one_y: -cos(a)}
potential: g*one.y + 0.5*g*two.y
"""
RODS = """
parameters: {g: 9.81}
coordinates:
  x: {initial: sin(1)}
  y: {initial: -cos(1)}
  u: {initial: sin(1) + 0.8*sin(2)}
  v: {initial: -cos(1) - 0.8*cos(2)}
masses: {one: 1.0, two: 0.5}
positions: {one: [x, y], two: [u, v]}
potential: g*one.y + 0.5*g*two.y
constraints: {upper: dot(one, one) - 1, lower: dot(two - one, two - one) - 0.64}
"""


@pytest.mark.exhaustive(keep=0.6)
def test_a_double_pendulum_in_angles_and_with_rods():
    """A chaotic motion, over a short time."""
    angles, rods = (follow(text, 2.0, 41, outputs=("reactions", "positions")) for text in (ANGLES, RODS))
    for name in ("one", "two"):
        assert np.abs(angles[f"reactions/{name}"] - rods[f"reactions/{name}"]).max() < 1e-11
    lower = angles["positions/two"] - angles["positions/one"]
    force = angles["reactions/two"]
    assert np.abs(lower[:, 0] * force[:, 1] - lower[:, 1] * force[:, 0]).max() < 1e-13


CHARGE = """
parameters: {B: 1.7, k: 0.3}
coordinates: {x: {initial: 1.0}, y: {initial: 0.0, velocity: 1.0}}
masses: {one: 1.0}
positions: {one: [x, y]}
potential: -B*one.x*one.vy + x**2
dissipation: k*(one.vx**2 + y_dot**2)/2
forces: {one: [0, -2]}
"""


def test_what_moves_freely_feels_no_force_of_constraint():
    """Forces of a magnetic field, of friction, and applied ones count as applied."""
    motion = follow(CHARGE, 5.0, 21, outputs=("reactions",))
    assert np.abs(motion["reactions/one"]).max() < 1e-14


def test_where_a_momentum_is_in_place_of_a_velocity():
    """A planet feels no force of constraint; U is written in polar coordinates."""
    assert residual_of("central_force").cyclic_momenta
    motion = follow("central_force", 6.0, 31, outputs=("reactions",))
    assert np.abs(motion["reactions/planet"]).max() < 1e-13


OF_THE_ANGLE = ANGLE.replace("m*g*bob.y", "-m*g*l*cos(theta)")
DRIVEN = ANGLE + "generalized_forces: {theta: 1.0}\n"
RUBBED = ANGLE + "dissipation: theta_dot**2\n"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (OF_THE_ANGLE, "U contains the coordinate 'theta'"),
        (DRIVEN, "a generalized force is given along the coordinate 'theta'"),
        (RUBBED, "the dissipation contains the velocity of the coordinate 'theta'"),
    ],
)
def test_where_the_applied_force_is_not_known(text, reason):
    residual = residual_of(text)
    with pytest.raises(NotDefined, match=reason):
        make_plan(residual, frozenset({"reactions"}))
    made = make_plan(residual, frozenset({"q", "reactions"}), frozenset({"reactions"})).recording.made
    assert not made


CART = """
parameters: {g: 9.81}
coordinates: {x: {}, theta: {initial: 1.0}, free: {velocity: 1.0}}
masses: {cart: 1.0, bob: 1.0, other: 2.0}
positions: {cart: [x], bob: [x + sin(theta), -cos(theta)], other: [free]}
potential: {weight: g*bob.y, spring: x**2}
"""


def test_of_some_particles_it_is_known():
    """The spring may pull at the cart or at the bob."""
    assert set(Reactions(model_of(CART)).unknown) == {"cart", "bob"}
    assert set(Reactions(model_of(CART.replace("spring: x**2", "spring: cart.x**2"))).unknown) == set()
    plan = make_plan(residual_of(CART), frozenset({"reactions"}), frozenset({"reactions"}))
    assert [one.path for one in plan.recording.made] == ["reactions/other"]


THROWN = """
parameters: {m: 1.2, l: 0.7}
coordinates:
  z: {initial: 0, velocity: 1}
  phi: {initial: 0.1, velocity: 1}
  theta: {initial: 1, velocity: 0.2}
  psi: {initial: 0, velocity: 5}
bodies:
  top:
    mass: m
    position: [PLACE]
    inertia: [1, 1, 0.5]
    orientation: {euler: [phi, theta, psi], sequence: zxz}
potential: m*9.81*top.at(0, 0, 0.2).z
"""


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize(
    ("place", "free"),
    [("0, 0, z", True), ("l*sin(phi)*sin(theta), -l*cos(phi)*sin(theta), z + l*cos(theta)", False)],
)
def test_on_a_body(place, free):
    """A force at one of its points acts on its centre, too, and turns it, which is no reaction."""
    motion = follow(THROWN.replace("PLACE", place), 1.0, 11, outputs=("reactions",))
    assert motion["reactions/top"].shape == (11, 3)
    assert (np.abs(motion["reactions/top"]).max() < 1e-13) == free
    assert np.abs(motion["reactions/top"][:, 2]).max() < 1e-13


RESTING = """
coordinates: {z: {initial: 1.0}}
masses: {ball: 1.0}
positions: {ball: [z]}
potential: 9.81*z
events: {impact: {when: z, direction: falling, action: {set: {z_dot: -0.5*z_dot}}}}
"""


BENT = """
parameters: {mu: 0.5, g: 9.81}
coordinates: {x: {initial: 0, velocity: 1.0}, y: {initial: 0}}
masses: {block: 1.0}
positions: {block: [x, y]}
potential: g*block.y
constraints: {plane: y}
forces: {block: [-mu*plane.multiplier**1.5*sign(x_dot), 0]}
"""


@pytest.mark.parametrize(
    ("text", "what"), [(RESTING, "at event 'impact'"), (BENT, "friction that is not linear.* at rest")]
)
def test_what_holds_a_body_may_not_follow_from_its_state(text, what):
    with pytest.raises(NotDefined, match=what):
        make_plan(residual_of(text), frozenset({"reactions"}))


SLOPE = """
parameters: {m: 2.0, alpha: 0.5, g: 9.81, mu: 0.8, v0: 1.0}
coordinates: {x: {initial: 0.0, velocity: v0}, y: {initial: 0}}
masses: {block: m}
positions: {block: [x, y]}
potential: -m*g*(sin(alpha)*block.x - cos(alpha)*block.y)
constraints: {plane: y}
definitions: {friction: -mu*plane.multiplier*sign(x_dot)}
forces: {block: [friction, 0]}
observables: {friction: friction}
"""
ALONG = """
parameters: {m: 2.0, alpha: 0.5, g: 9.81, mu: 0.8, v0: 1.0}
coordinates: {s: {initial: 0.0, velocity: v0}}
masses: {block: m}
positions: {block: [s*cos(alpha), -s*sin(alpha)]}
potential: m*g*block.y
definitions: {friction: -mu*m*g*cos(alpha)*sign(s_dot)}
forces: {block: (friction*cos(alpha), -friction*sin(alpha))}
observables: {friction: friction}
"""


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("precision", ["double", DOUBLE_DOUBLE])
@pytest.mark.parametrize(("text", "normal"), [(SLOPE, [0, 1]), (ALONG, [np.sin(0.5), np.cos(0.5)])])
def test_a_block_that_comes_to_rest_on_an_incline(text, normal, precision):
    """N = m g cos(alpha) throughout; the friction is mu N while it slides, then m g sin(alpha)."""
    data = lagrange.solve(
        text, stop=2.0, samples=21, outputs=("reactions", "observables"), precision=precision
    )
    weight = 2.0 * 9.81
    stops = 1.0 / (9.81 * (0.8 * np.cos(0.5) - np.sin(0.5)))
    limit, held = 0.8 * weight * np.cos(0.5), weight * np.sin(0.5)
    force = np.outer(np.full(21, weight * np.cos(0.5)), normal)
    assert np.abs(data.datasets["reactions/block"] - force).max() < 1e-13
    friction = np.where(data.t < stops, -limit, -held)
    assert np.abs(data.datasets["observables/friction"] - friction).max() < 1e-13


STACK = """
parameters: {m1: 2.0, m2: 1.0, g: 9.81, mu1: 0.2, mu2: 0.35, k: 2.0}
coordinates: {x1: {initial: 0}, y1: {initial: 0}, x2: {initial: 0}, y2: {initial: 0}}
masses: {lower: m1, upper: m2}
positions: {lower: [x1, y1], upper: [x2, y2]}
potential: g*(m1*lower.y + m2*upper.y)
constraints: {floor: y1, deck: y2 - y1}
definitions:
  f1: -mu1*floor.multiplier*sign(x1_dot)
  f2: -mu2*deck.multiplier*sign(x2_dot - x1_dot)
forces: {lower: [k*t + f1 - f2, 0], upper: [f2, 0]}
observables: {f1: f1, f2: f2}
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("precision", ["double", DOUBLE_DOUBLE])
def test_of_two_blocks_one_on_the_other(precision):
    """Both stick until k t = mu1 (m1 + m2) g. Then they slide together with a = (k t - f1)/(m1 + m2), until
    m2 a exceeds mu2 m2 g: the upper one slides, too."""
    data = lagrange.solve(
        STACK, stop=12.0, samples=121, outputs=("multipliers", "observables"), precision=precision
    ).datasets
    pull, most, upper = 2.0 * data["t"], 0.2 * 3 * 9.81, 0.35 * 9.81
    together = (pull - most) / 3
    assert np.abs(data["multipliers/floor"] - 3 * 9.81).max() < 1e-13
    assert np.abs(data["multipliers/deck"] - 9.81).max() < 1e-13
    assert np.abs(data["observables/f1"] + np.minimum(pull, most)).max() < 1e-13
    assert np.abs(data["observables/f2"] - np.clip(together, 0, upper)).max() < 1e-13


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("precision", ["double", DOUBLE_DOUBLE])
def test_of_two_blocks_that_come_to_rest_on_an_incline(precision):
    """They stop at different times, with rounded velocities. Then each friction holds what is above it."""
    text = STACK.replace("potential: g*(", "potential: -3*(m1*lower.x + m2*upper.x) + g*(")
    text = text.replace("mu1: 0.2", "mu1: 0.4").replace("k: 2.0", "k: 0").replace("mu2: 0.35", "mu2: 0.5")
    sets = {"x1_dot": 0.7, "x2_dot": 1.3}
    data = lagrange.solve(
        text, stop=5.0, samples=26, outputs=("v", "observables"), set=sets, precision=precision
    ).datasets
    slow = np.abs(data["v/x1"]) + np.abs(data["v/x2"]) < 1e-12
    assert 10 < np.count_nonzero(slow) < 25
    assert np.abs(data["observables/f1"][slow] + 9.0).max() < 1e-13
    assert np.abs(data["observables/f2"][slow] + 3.0).max() < 1e-13


BELT = """
parameters: {w: 0.3, d: 2.0, k: 5.0}
coordinates: {x: {initial: 0.0, velocity: w}}
masses: {block: 1.0}
positions: {block: [x]}
potential: k*block.x**2/2
definitions: {friction: -d*sign(x_dot - w)}
forces: {block: [friction]}
observables: {friction: friction, slip: x_dot - w}
"""


def test_of_a_block_on_a_belt():
    """It sticks until k x = d; then it oscillates about d/k and never comes to the belt's speed but for an
    instant."""
    motion = follow(BELT, 2.0, 101, outputs=("q", "observables"))
    sticks = motion.t < 2.0 / 5.0 / 0.3
    assert np.all(np.abs(motion["observables/slip"][sticks]) < 1e-15)
    friction = np.where(sticks, 5.0 * motion["q/x"], 2.0)
    assert np.abs(motion["observables/friction"] - friction).max() < 1e-13


def test_of_a_motion_that_passes_the_place_of_a_jump():
    """A wall of sand at x = 0: the force jumps there, but holds nothing. The first sample is there."""
    text = """
    parameters: {d: 2.0}
    coordinates: {x: {initial: 0.0, velocity: 3.0}, y: {initial: 0}}
    masses: {block: 1.0}
    positions: {block: [x, y]}
    constraints: {plane: y}
    forces: {block: [-where(x > 0, d, 0), d*sign(x)]}
    """
    motion = follow(text, 1.0, 11, outputs=("q", "reactions"))
    assert motion["reactions/block"][:, 1] == pytest.approx(-2.0 * np.ones(11))


def test_of_a_driven_block_that_is_rubbed_across():
    """What drives it depends on time alone, and friction on whether it still slides."""
    text = """
    coordinates: {y: {initial: 0, velocity: 0.1}}
    masses: {block: 2}
    positions: {block: [sin(t), y]}
    forces: {block: [0, -sign(y_dot)]}
    """
    motion = follow(text, 1.0, 11, outputs=("q", "reactions"))
    expected = np.array([-2 * np.sin(motion.t), np.zeros(11)]).T
    assert motion["reactions/block"] == pytest.approx(expected, abs=1e-15)


CHAIN = """
sizes: {N: 3}
parameters: {g: 9.81}
coordinates: {a[i in range(N)]: {initial: 0.3 + 0.2*i}}
masses: {bob[i in range(N)]: 1/N}
positions:
  bob[i in range(N)]: [sum(sin(a[j]) for j in range(i + 1)), -sum(cos(a[j]) for j in range(i + 1))]
potential: sum(g/N*bob[i].y for i in range(N))
"""


def test_of_a_family():
    """The whole chain hangs on its first link: so all reactions together have its direction."""
    motion = follow(CHAIN, 1.0, 11, outputs=("q", "reactions"))
    force, angle = motion["reactions/bob"].sum(axis=1), motion["q/a[0]"]
    assert motion["reactions/bob"].shape == (11, 3, 2)
    assert np.abs(force[:, 0] * np.cos(angle) + force[:, 1] * np.sin(angle)).max() < 1e-13
