"""Motions of rigid bodies, against closed forms, conservation laws and other ways to describe them."""

from __future__ import annotations

import math
from textwrap import dedent

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.node import Kind, reachable
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.equations import derive
from lagrange_cli.spec.read import read_spec
from tests.support.families import followed
from tests.support.motion import SYSTEMS, consistent, follow, prepared, residual_of, run, spec_of, values_of

FREE = """
parameters: {{A: 1, B: 2, C: 2.5, spin: 1.2}}
coordinates:
  w: {{initial: 1}}
  x: {{initial: 0, velocity: 0.15}}
  y: {{initial: 0, velocity: 0.0}}
  z: {{initial: 0, velocity: spin/2}}
bodies:
  top: {{mass: 1, position: [0, 0, 0], {inertia}, orientation: {{quaternion: [w, x, y, z]}}}}
observables:
  w1: top.w1
  w2: top.w2
  w3: top.w3
  wx: top.wx
  norm: w**2 + x**2 + y**2 + z**2 - 1
  Lx: {momentum}
"""
PRINCIPAL = "A*top.w1*top.R11 + B*top.w2*top.R12 + C*top.w3*top.R13"


@pytest.mark.exhaustive(keep=0.5)
def test_a_free_top_turns_by_jacobis_functions():
    """Landau and Lifshitz, Mechanics, sec. 37, with I1 < I2 < I3 and L^2 > 2 E I2: w2 begins at 0."""
    text = FREE.format(inertia="inertia: [A, B, C]", momentum=PRINCIPAL)
    motion = follow(text, 60.0, 301, outputs=("observables", "h"))
    a, b, c, first, third = 1.0, 2.0, 2.5, 0.3, 1.2
    energy, square = (a * first**2 + c * third**2) / 2, (a * first) ** 2 + (c * third) ** 2
    rate = math.sqrt((c - b) * (square - 2 * energy * a) / (a * b * c))
    modulus = (b - a) * (2 * energy * c - square) / ((c - b) * (square - 2 * energy * a))
    sn, cn, dn, _ = ellipj(rate * motion["t"], modulus)
    assert np.abs(motion["observables/w1"] - first * cn).max() < 1e-13
    second = math.sqrt((2 * energy * c - square) / (b * (c - b)))
    assert np.abs(motion["observables/w2"] - second * sn).max() < 1e-13
    assert np.abs(motion["observables/w3"] - third * dn).max() < 1e-13
    assert np.abs(motion["observables/norm"]).max() < 1e-15
    for name in ("observables/Lx", "diagnostics/h"):
        assert np.ptp(motion[name]) < 2e-14


@pytest.mark.exhaustive(keep=0.3)
def test_axes_need_not_be_principal_ones():
    """The same top with its first two axes turned by 30 degrees about the third."""
    rows = "[A*0.75 + B*0.25, D, 0], [D, A*0.25 + B*0.75, 0], [0, 0, C]".replace("D", "(B - A)*sqrt(3)/4")
    turned = f"inertia: [{rows}]"
    own = FREE.format(inertia="inertia: [A, B, C]", momentum=PRINCIPAL)
    other = FREE.format(inertia=turned, momentum="0*top.w1")
    other = other.replace("w: {initial: 1}", "w: {initial: cos(pi/12), velocity: -spin/2*sin(pi/12)}")
    other = other.replace("{initial: 0, velocity: 0.15}", "{initial: 0, velocity: 0.15*cos(pi/12)}")
    other = other.replace("{initial: 0, velocity: 0.0}", "{initial: 0, velocity: -0.15*sin(pi/12)}")
    other = other.replace("velocity: spin/2}", "velocity: spin/2*cos(pi/12)}").replace(
        "z: {initial: 0", "z: {initial: sin(pi/12)"
    )
    one, two = (follow(text, 20.0, 101, outputs=("observables",)) for text in (own, other))
    assert two["observables/w3"] == pytest.approx(one["observables/w3"], abs=1e-13)
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    along = c * two["observables/w1"] - s * two["observables/w2"]
    assert along == pytest.approx(one["observables/w1"], abs=1e-13)


SHARED = """
parameters: {spin: 1.2}
coordinates:
  w: {initial: 1}
  x: {initial: 0, velocity: 0.15}
  y: {initial: 0, velocity: 0}
  z: {initial: 0, velocity: spin/2}
bodies:
  one: {mass: 1, inertia: [1, 2, 2.5], position: [0, 0, 0], orientation: {quaternion: [w, x, y, z]}}
  two: {mass: 1, inertia: [3, 1, 2.2], position: [0, 0, 0], orientation: {quaternion: [w, x, y, z]}}
"""


@pytest.mark.exhaustive(keep=0.3)
def test_bodies_that_turn_together_share_the_norm_of_their_quaternion():
    """They are one body with the sum of the moments."""
    assert list(spec_of(SHARED).all_constraints) == ["one.norm"]
    sum_of_both = "\n".join(SHARED.splitlines()[:-1]).replace("[1, 2, 2.5]", "[4, 3, 4.7]")
    both, one = (follow(text, 5.0, 21, outputs=("q",)) for text in (SHARED, sum_of_both))
    for name in "wxyz":
        assert np.abs(both[f"q/{name}"] - one[f"q/{name}"]).max() < 1e-14


HEAVY = """
parameters: {{A: 1, B: 2, C: 2.5, m: 1.5, g: 9.81}}
coordinates: {coordinates}
bodies:
  top:
    mass: m
    inertia: [A, B, C]
    position: [0, 0, 0]
    orientation: {orientation}
potential: m*g*dot((0, 0, 1), top.at(0.1, 0.2, 0.3))
torques: {{top: [0.3*top.R13, 0.2*top.vz, -0.1*top.wz]}}
observables: {{px: "top.at(1, 2, 3).x", vy: "top.at(1, 2, 3).vy", w2: top.w2, wz: top.wz, R12: top.R12}}
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("sequence", ["zxz", "zyz", "xyx", "xyz", "zyx", "yxz"])
def test_angles_in_any_sequence_agree_with_a_quaternion(sequence):
    """The same start, spinning about all axes, in each of them."""
    angles = HEAVY.format(
        coordinates="{a: {initial: 0.3, velocity: 0.5}, b: {initial: 0.8, velocity: -0.4}, "
        "c: {initial: -0.2, velocity: 1.1}}",
        orientation=f"{{euler: [a, b, c], sequence: {sequence}}}",
    )
    one = follow(angles, 2.0, 41, outputs=("observables", "ledger"))
    half = [0.15, 0.4, -0.1]
    speed = [0.25, -0.2, 0.55]
    turn, spin = np.array([1.0, 0, 0, 0]), np.zeros(4)
    for axis, a, v in zip(sequence, half, speed):
        here, moving = np.zeros(4), np.zeros(4)
        here[0], here[1 + "xyz".index(axis)] = math.cos(a), math.sin(a)
        moving[0], moving[1 + "xyz".index(axis)] = -v * math.sin(a), v * math.cos(a)
        turn, spin = times(turn, here), times(spin, here) + times(turn, moving)
    start = ", ".join(
        f"{n}: {{initial: {float(x)!r}, velocity: {float(u)!r}}}" for n, x, u in zip("wxyz", turn, spin)
    )
    quaternion = HEAVY.format(coordinates=f"{{{start}}}", orientation="{quaternion: [w, x, y, z]}")
    two = follow(quaternion, 2.0, 41, outputs=("observables", "ledger"))
    for name in ("px", "vy", "w2", "wz", "R12"):
        assert two[f"observables/{name}"] == pytest.approx(one[f"observables/{name}"], abs=1e-12)
    for motion in (one, two):
        assert np.abs(motion["diagnostics/ledger/h"]).max() < 1e-13


def times(p, q):
    """The product of two quaternions."""
    a, u, b, v = p[0], p[1:], q[0], q[1:]
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


SOLIDS = {
    "sphere: 0.3": 0.4 * 0.3**2,
    "cylinder: [0.3, 0.5]": 0.3**2 / 2,
    "box: [0.3, 0.4, 0.5]": (0.3**2 + 0.4**2) / 12,
    "disc: 0.3": 0.3**2 / 2,
}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("solid", SOLIDS)
def test_a_solid_under_a_torque_about_its_third_axis(solid):
    """theta = tau t^2/(2 I), given by a matrix, in a family of two."""
    text = f"""
    sizes: {{N: 2}}
    parameters: {{m: 2, tau: [0.01, 0.02]}}
    coordinates: {{"s[i in range(N)]": {{initial: 0}}}}
    bodies:
      wheel[i in range(N)]:
        mass: m
        solid: {{{solid}}}
        position: [i, 0, 0]
        orientation: {{matrix: [[cos(s[i]), -sin(s[i]), 0], [sin(s[i]), cos(s[i]), 0], [0, 0, 1]]}}
    torques: {{"wheel[i in range(N)]": [0, 0, "tau[i]"]}}
    observables: {{"w[i in range(N)]": "wheel[i].w3"}}
    """
    motion = follow(text, 2.0, 11, outputs=("q", "observables", "positions"))
    for i, torque in enumerate((0.01, 0.02)):
        rate = torque / (2 * SOLIDS[solid])
        assert motion["q/s"][:, i] == pytest.approx(rate * motion["t"] ** 2 / 2, rel=1e-14)
        assert motion["observables/w"][:, i] == pytest.approx(rate * motion["t"], rel=1e-14)
    assert motion["positions/wheel"].shape == (11, 2, 3)


@pytest.mark.exhaustive(keep=0.75)
def test_what_is_written_of_bodies():
    """In components of space, from those along the axes of the body, which the file writes out."""
    text = FREE.format(inertia="inertia: [A, B, C]", momentum=PRINCIPAL)
    outputs = (
        "observables",
        "angular_velocities",
        "angular_momenta",
        "rotational_energies",
        "orientations",
        "T",
    )
    motion = follow(text, 10.0, 21, outputs=outputs)
    turn, omega = motion["orientations/top"], motion["angular_velocities/top"]
    assert turn.shape == (21, 3, 3)
    inner = np.stack([motion[f"observables/w{i}"] for i in (1, 2, 3)], axis=1)
    assert np.einsum("nij,nj->ni", turn, inner) == pytest.approx(omega, abs=1e-14)
    assert np.einsum("nij,nkj->nik", turn, turn) == pytest.approx(
        np.broadcast_to(np.eye(3), (21, 3, 3)), abs=1e-14
    )
    momentum = np.einsum("nij,nj->ni", turn, inner * [1.0, 2.0, 2.5])
    assert motion["angular_momenta/top"] == pytest.approx(momentum, abs=1e-14)
    assert motion["angular_momenta/top"][:, 0] == pytest.approx(motion["observables/Lx"], abs=1e-14)
    energy = (inner**2 @ [1.0, 2.0, 2.5]) / 2
    assert motion["rotational_energies/top"] == pytest.approx(energy, abs=1e-14)
    assert motion["diagnostics/T"] == pytest.approx(energy, abs=1e-14)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("[[cos(s), -sin(s), 0], [sin(s), cos(s), 0], [0, 0, 2]]", "column 3"),
        ("[[cos(s), sin(s), 0], [sin(s), cos(s), 0], [0, 0, 1]]", "columns 1 and 2 are not at right angles"),
        ("[[cos(s), sin(s), 0], [sin(s), -cos(s), 0], [0, 0, 1]]", "determinant -1"),
    ],
)
def test_a_matrix_that_is_no_rotation_is_refused(rows, message):
    body = f"{{mass: 1, solid: {{disc: 1}}, position: [0, 0, 0], orientation: {{matrix: {rows}}}}}"
    with pytest.raises(SpecError, match="is not a rotation") as caught:
        residual_of(f"coordinates: {{s: {{initial: 0}}}}\nbodies: {{wheel: {body}}}\n")
    assert message in str(caught.value)


ROTOR = """
    coordinates:
      w: {{initial: 1}}
      x: {{initial: 0, velocity: 0.1}}
      y: {{initial: 0, velocity: 0.5}}
      z: {{initial: 0, velocity: 0}}
      s: {{initial: 0.3, velocity: 0.2}}
    definitions: {{c: cos(s/2), d: sin(s/2)}}
    bodies:
      base: {{mass: 1, inertia: [1, 2, 2.5], position: [0, 0, 0], {base}}}
      rotor: {{mass: 1, inertia: [0.2, 0.2, 0.3], position: "base.at(0.1, 0, 0.4)", {rotor}}}
    {constraints}
"""
PRODUCT = "orientation: {quaternion: [w*c - z*d, x*c + y*d, y*c - x*d, z*c + w*d]}"
SPUN = "[cos(s)*base.R{0}1 + sin(s)*base.R{0}2, cos(s)*base.R{0}2 - sin(s)*base.R{0}1, base.R{0}3]"
BY_AXES = f"orientation: {{matrix: [{', '.join(map(SPUN.format, '123'))}]}}"
BY_QUATERNION = "orientation: {quaternion: [w, x, y, z]}"
BY_SQUARES = (
    "orientation: {matrix: [[w**2 + x**2 - y**2 - z**2, 2*(x*y - w*z), 2*(x*z + w*y)], "
    "[2*(x*y + w*z), w**2 - x**2 + y**2 - z**2, 2*(y*z - w*x)], "
    "[2*(x*z - w*y), 2*(y*z + w*x), w**2 - x**2 - y**2 + z**2]]}"
)
NORM = "constraints: {norm: w**2 + x**2 + y**2 + z**2 - 1}"


@pytest.mark.exhaustive(keep=0.5)
def test_a_matrix_may_be_a_rotation_because_of_constraints():
    """A rotor on a body turned by a quaternion: as a product, by the axes of the body, and with a matrix."""
    written = ((BY_QUATERNION, PRODUCT, ""), (BY_QUATERNION, BY_AXES, ""), (BY_SQUARES, BY_AXES, NORM))
    texts = [ROTOR.format(base=base, rotor=rotor, constraints=bound) for base, rotor, bound in written]
    first, *others = (followed(dedent(text), frozenset("q"), 20.0, 21)[1] for text in texts)
    for other in others:
        for name in "wxyzs":
            np.testing.assert_allclose(other[f"q/{name}"], first[f"q/{name}"], rtol=0, atol=1e-12)
    with pytest.raises(SpecError, match="is not a rotation"):
        residual_of(texts[2].replace("z**2 - 1}", "z**2 - 2}").replace("initial: 1", "initial: sqrt(2)"))


@pytest.mark.exhaustive(keep=0.6)
def test_a_free_top_flips():
    motion = follow("free_top", 20.0, 2001, outputs=("observables", "angular_momenta", "h"))
    spin = motion["observables/w2"]
    assert spin.max() > 9.99
    assert spin.min() < -9.99
    scale = np.linalg.norm(motion["angular_momenta/top"][0])
    assert np.ptp(motion["angular_momenta/top"], axis=0).max() < 1e-13 * scale


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize(
    ("moments", "spin"),
    [
        ((1.3, 1.1, 1.9), (4.0, 7.0, 3.0)),
        ((1.3, 1.7, 1.9), (9.0, 2.0, 5.0)),
        ((1.1, 1.6, 1.7), (3.456, 8.216, 3.304)),
        ((1.1, 1.2, 1.3), (3.456, 8.216, 3.304)),
    ],
)
def test_the_energy_of_a_free_top_does_a_random_walk(moments, spin):
    """4000 s are some 5000 turns in 20,000 steps. With other masses in M than in the residual, were it by one
    rounding, h would drift by 4e-13. So it would where masses are (1.1 + 1.6 - 1.7)/2 and the like, if
    products with them were rounded before they are added."""
    sets = dict(zip(("I1", "I2", "I3"), moments)) | dict(zip(("x_dot", "y_dot", "z_dot"), np.array(spin) / 2))
    energy = follow("free_top", 4000.0, 11, sets=sets, outputs=("h",))["diagnostics/h"]
    assert np.abs(energy / energy[0] - 1).max() < 1.5e-13


@pytest.mark.parametrize("inertia", ["[A, B, C]", "[[A, D, E], [D, B, F], [E, F, C]]"])
def test_the_mass_matrix_of_a_body_has_the_masses_of_its_equations(inertia):
    """Sums of parameters that are rounded: the same in both."""
    text = (
        "parameters: {A: 1.1, B: 1.3, C: 1.7, D: 0.1, E: 0.2, F: 0.3}\n"
        "coordinates: {w: {initial: 1}, x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}\n"
        f"bodies: {{top: {{mass: 1, position: [0, 0, 0], inertia: {inertia}, "
        "orientation: {quaternion: [w, x, y, z]}}}\n"
    )
    residual = residual_of(text)

    def sums(nodes):
        every = reachable([*nodes], lambda node: True)
        fixed = (node for node in every if node.kind is Kind.SUM and not node.symbols & residual.variables)
        return {frozenset(zip(node.arguments, map(abs, node.data[1]))) for node in fixed}

    entries = [entry for row in residual.entries for entry in row.values()]
    assert sums(entries)
    assert sums(entries) <= sums(residual.residual)


def test_kovalevskayas_top_has_her_integral():
    fourth = follow("kovalevskaya_top", 10.0, 1001, outputs=("observables",))["observables/K"]
    assert np.ptp(fourth) < 1e-12 * fourth[0]


@pytest.mark.exhaustive(keep=0.8)
def test_lagranges_top_nods_between_the_zeros_of_a_cubic():
    """(du/dt)^2 = (1 - u^2)(alpha - beta u) - (b - a u)^2 for u = cos theta (Goldstein, eq. 5.62)."""
    theta = follow("lagrange_top", 5.0, 20001, outputs=("q",))["q/theta"]
    across, u = 1e-4 + 0.1 * 0.04**2, math.cos(0.5)
    a, beta = 5e-5 * 200 / across, 2 * 0.1 * 9.81 * 0.04 / across
    roots = np.roots([1, -(a**2) / beta, a**2 * u / beta - 1])  # without the root u: it begins at rest
    assert math.cos(theta.max()) == pytest.approx(min(roots, key=lambda x: abs(x - u)), abs=1e-6)
    assert theta.min() == pytest.approx(0.5, abs=1e-12)


def test_a_physical_pendulum_is_a_simple_one_of_reduced_length():
    motion = follow("physical_pendulum", 10.0, 101, outputs=("q",))
    simple = f"""
    coordinates: {{theta: {{initial: 2.5}}}}
    masses: {{bob: 1}}
    positions: {{bob: [l*sin(theta), -l*cos(theta)]}}
    parameters: {{l: {0.3 + 1 / 12 / 0.3!r}}}
    potential: 9.81*bob.y
    """
    assert motion["q/theta"] == pytest.approx(follow(simple, 10.0, 101, outputs=("q",))["q/theta"], abs=1e-12)


@pytest.mark.exhaustive(keep=0.5)
def test_a_gyroscope_passes_the_vertical():
    """Its angle is that of an inverted pendulum with the moment of inertia about the tip."""
    motion = follow("gyroscope", 2.0, 201, outputs=("observables", "h", "constraints"))
    assert motion["observables/height"].max() > 0.999
    pendulum = """
    parameters: {I: 1.0e-4 + 0.1*0.04**2}
    coordinates: {a: {initial: 0.5, velocity: -20}}
    lagrangian: I*a_dot**2/2 - 0.1*9.81*0.04*cos(a)
    observables: {height: cos(a)}
    """
    plane = follow(pendulum, 2.0, 201, outputs=("observables",))
    assert motion["observables/height"] == pytest.approx(plane["observables/height"], abs=1e-11)


def test_a_satellite_librates_as_a_pendulum():
    """I2 theta'' = -3 n^2 (I1 - I3) sin(theta) cos(theta)."""
    motion = follow("gravity_gradient", 20000.0, 101, outputs=("q",))
    plane = """
    parameters: {n: "sqrt(3.986e14/7.0e6**3)"}
    coordinates: {theta: {initial: 0.3}}
    lagrangian: 120*theta_dot**2/2 - 3*n**2*60*sin(theta)**2/2
    """
    assert motion["q/theta"] == pytest.approx(
        follow(plane, 20000.0, 101, outputs=("q",))["q/theta"], abs=1e-11
    )


@pytest.mark.exhaustive(keep=0.8)
def test_foucaults_gyroscope_swings_about_the_meridian():
    """I1 phi'' = -I3 (psi' + Omega cos(latitude) cos(phi)) Omega cos(latitude) sin(phi) + I1 (Omega
    cos(latitude))^2 sin(phi) cos(phi), where what is in brackets is constant."""
    motion = follow("foucault_gyroscope", 20.0, 41, outputs=("q", "v"))
    a, c, spin, turn = 1.0e-4, 1.6e-4, 1000.0, 7.292115e-5 * math.cos(0.8527)
    whole = spin + turn * math.cos(1.0)

    def rates(_, state):
        phi, speed = state
        return speed, -c / a * whole * turn * math.sin(phi) + turn**2 * math.sin(phi) * math.cos(phi)

    known = solve_ivp(rates, (0, 20), (1.0, 0.0), "DOP853", motion.t, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(motion["q/phi"], known.y[0], rtol=0, atol=1e-11)


@pytest.mark.exhaustive(keep=0.55)
def test_a_coin_rolls_in_a_circle():
    """Steady if m g R tan(lean) = (C + m R^2) w turn + A turn^2 sin(lean), w the rate at which it rolls."""
    values = values_of("coin")
    motion = run(prepared("coin", outputs=("q", "v", "h")), consistent("coin"), 0.0, 5.0, 51)
    np.testing.assert_allclose(motion["q/theta"], math.pi / 2 - 0.2, rtol=0, atol=1e-13)
    radius = 0.02 * values.parameters["roll"] / 4.0
    np.testing.assert_allclose(np.hypot(motion["q/x"], motion["q/y"] - radius), radius, rtol=1e-12)


def rattling(_, state):
    """A rattleback's angular velocity and the vertical in body axes: m d(v)/dt = F - m g n, the moment of F
    at the point of contact r, and v = r x omega (T. R. Kane and D. A. Levinson, 1982)."""
    m, g, a, b, c, h = 1.0, 9.81, 0.2, 0.03, 0.02, 0.01
    inertia = np.array([[2.0e-4, -2.0e-5, 0], [-2.0e-5, 1.6e-3, 0], [0, 0, 1.7e-3]])
    omega, n = state[:3], state[3:]
    squares = np.array([a, b, c]) ** 2
    size = math.sqrt(squares @ n**2)
    r = np.array([0, 0, h]) - squares * n / size
    turning = np.cross(n, omega)
    moving = -squares * turning / size + squares * n * (squares @ (n * turning)) / size**3
    speed = np.cross(r, omega)
    cross = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    # F = m (r x omega' + moving x omega + omega x speed + g n), I omega' + omega x I omega = r x F
    known = np.cross(moving, omega) + np.cross(omega, speed) + g * n
    right = m * np.cross(r, known) - np.cross(omega, inertia @ omega)
    return [*np.linalg.solve(inertia - m * cross @ cross, right), *turning]


@pytest.mark.exhaustive(keep=0)
def test_a_rattleback_turns_back():
    outputs = ("q", "v", "h", "observables", "constraints")
    motion = run(prepared("rattleback", outputs=outputs), consistent("rattleback"), 0.0, 10.0, 101)
    start = [0, 0, -5.0, 0, math.sin(0.05), math.cos(0.05)]
    known = solve_ivp(rattling, (0, 2), start, "DOP853", motion.t[:21], rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(motion["observables/spin"][:21], known.y[2], rtol=0, atol=1e-9)
    assert motion["observables/spin"][0] < -4.9 and motion["observables/spin"].max() > 3
    assert np.ptp(motion["diagnostics/h"]) < 1e-13


@pytest.mark.exhaustive(keep=0)
def test_the_whole_bicycle_has_the_eigenvalues_of_the_linear_one():
    """At 5 m/s (J. P. Meijaard, J. M. Papadopoulos, A. Ruina and A. L. Schwab, Proc. R. Soc. A 463, 2007,
    table 2); from small motions over half a second."""
    free = (SYSTEMS / "bicycle.yaml").read_text(encoding="utf-8")
    for given in ("push*rR", "-v/rR", "-v/rF"):  # what follows from the constraints
        free = free.replace(f"velocity: {given}, ", "")
    ready, small, names = prepared(free, outputs=("q", "v")), 1e-5, ("roll", "steer")

    def end(name: str, value: float) -> np.ndarray:
        values = consistent(free, **{"v": 5.0, "push": 0.0, name: value})
        motion = run(ready, values, 0.0, 0.5, 2)
        return np.array([motion[f"{kind}/{one}"][-1] for kind in "qv" for one in names])

    starts = [*names, *(f"{name}_dot" for name in names)]
    columns = [(end(name, small) - end(name, -small)) / (2 * small) for name in starts]
    found = np.log(np.linalg.eigvals(np.array(columns).T).astype(complex)) / 0.5
    weave = -0.77534188219585 + 4.46486771378823j
    known = [-14.07838969279822, weave.conjugate(), weave, -0.32286642900409]
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.array(known)), rtol=0, atol=1e-6)


@pytest.mark.exhaustive(keep=0.25)
def test_nothing_determines_how_a_thin_rod_spins_in_a_quaternion():
    """A constraint on its spin does, and it falls as angles say."""
    text = """
        parameters: {m: 1.0, g: 9.81, l: 1.0, tilt: 0.5}
        coordinates:
          w: {initial: cos(tilt/2)}
          x: {initial: sin(tilt/2)}
          y: {initial: 0}
          z: {initial: 0}
        definitions:
          e: [2*(x*z + w*y), 2*(y*z - w*x), w**2 - x**2 - y**2 + z**2]
        bodies:
          rod: {mass: m, solid: {rod: l}, position: -l/2*e, orientation: {quaternion: [w, x, y, z]}}
        potential: m*g*rod.z
        observables: {height: rod.R33}
        """
    spec = read_spec(dedent(text), "rod.yaml")
    with pytest.raises(SpecError, match=r"(?s)'rod' has no moment of inertia about its own axis.*rod.w3"):
        derive_system(spec)
    bound = follow(f"{dedent(text)}nonholonomic: {{spin: rod.w3}}\n", 1.0, 11, outputs=("observables", "h"))
    angle = """
        parameters: {g: 9.81, l: 1.0, tilt: 0.5}
        coordinates: {theta: {initial: tilt}}
        lagrangian: l**2*theta_dot**2/6 + g*l/2*cos(theta)
        observables: {height: cos(theta)}
        """
    known = follow(angle, 1.0, 11, outputs=("observables",))
    np.testing.assert_allclose(bound["observables/height"], known["observables/height"], rtol=0, atol=1e-13)


def test_a_thin_rod_that_only_turns_about_its_own_axis_is_refused():
    """What was meant, a rod that falls over in the x-y plane, has the moment m l^2/3 about its foot."""
    text = dedent("""
        parameters: {m: 2.0, l: 1.5, g: 9.81}
        coordinates: {a: {initial: 1.2, velocity: 0.5}}
        bodies:
          ladder:
            mass: m
            solid: {rod: l}
            position: [l/2*cos(a), l/2*sin(a), 0]
            orientation: {euler: [a, 0, 0], sequence: zyx}
        potential: m*g*ladder.y
        """)
    for refusing in (derive_system, derive):
        with pytest.raises(
            SpecError, match=r"(?s)'ladder' has no moment.*that axis only.*pi/2, 0\], sequence:"
        ):
            refusing(read_spec(text, "ladder.yaml"))
    meant = follow(text.replace("[a, 0, 0]", "[a, pi/2, 0]"), 1.0, 3)
    np.testing.assert_allclose(meant["diagnostics/p/a"], 2.0 * 1.5**2 / 3 * meant["v/a"], rtol=1e-14)
