"""Rigid bodies whose families stay families, beside the same systems written out member by member."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import OF_BODIES, OUTPUTS, family_run
from lagrange_cli.integrate.family_program import write_families
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.check import classify
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_chains import fewest
from tests.support.families import alike, followed
from tests.support.motion import run

ALL = OUTPUTS - {"conserved"} | OF_BODIES | {"constraints", "multipliers"}
MATTER = {
    "a top": "inertia: [0.02, 0.02, 0.03]",
    "any body": "inertia: [0.02, 0.025, 0.03*(1 + i/(9*N))]",
    "a tensor": "inertia: [[0.02, 0.004, 0], [0.004, 0.025, 0.002], [0, 0.002, 0.03]]",
    "a box": "solid: {box: [0.3, 0.4 + i/9, 0.5]}",
    "a cylinder": "solid: {cylinder: [0.3, 0.5]}",
}
ANGLES = '{{euler: ["a[i]", "b[i]", "c[i]"], sequence: {sequence}}}'
PLANAR = '{matrix: [[1, 0, 0], [0, "cos(a[i])", "-sin(a[i])"], [0, "sin(a[i])", "cos(a[i])"]]}'
THREE = """
  a[i in range(N)]: {{initial: "0.3*i + sin({seed})", velocity: "1 + 0.1*cos({seed}*i)"}}
  b[i in range(N)]: {{initial: "{middle} + 0.2*sin({seed} + i)", velocity: 0.5}}
  c[i in range(N)]: {{initial: 0.2, velocity: "3 + 0.1*i"}}"""
"""Angles that stay where they are known well: at ``middle`` the axes of a and c are at right angles."""
QUATERNION = '{quaternion: ["a[i]", "b[i]", "c[i]", "d[i]"]}'
N, U, V, W = "(0.4 + 0.3*i + sin({seed}))", "(1 + 0.1*cos({seed}*i))", "(0.5*sin({seed} + i))", "(3 + 0.1*i)"
"""Half an angle about the axis (0.6, 0, 0.8), and an angular velocity in the body."""
FOUR = f"""
  a[i in range(N)]: {{{{initial: "cos({N})", velocity: "-sin({N})*(0.6*{U} + 0.8*{W})/2"}}}}
  b[i in range(N)]: {{{{initial: "0.6*sin({N})", velocity: "(cos({N})*{U} - 0.8*sin({N})*{V})/2"}}}}
  c[i in range(N)]: {{{{initial: 0, velocity: "(cos({N})*{V} + sin({N})*(0.8*{U} - 0.6*{W}))/2"}}}}
  d[i in range(N)]: {{{{initial: "0.8*sin({N})", velocity: "(cos({N})*{W} + 0.6*sin({N})*{V})/2"}}}}"""
AXIS = "[2*(b[i]*d[i] + a[i]*c[i]), 2*(c[i]*d[i] - a[i]*b[i]), a[i]**2 - b[i]**2 - c[i]**2 + d[i]**2]"
PLACES = "".join(f'\n  {x}[i in range(N)]: {{{{initial: "i + 0.1*sin({{seed}}*i)"}}}}' for x in "xyz")
HINGES = """definitions:
  h[0]: [0, l*sin(a[0]), -l*cos(a[0])]
  h[i in range(1, N)]: h[i - 1] + [0, l*sin(a[i]), -l*cos(a[i])]"""
BALLS = f"""definitions:
  h[0]: "l*{AXIS.replace("[i]", "[0]")}"
  h[i in range(1, N)]: "h[i - 1] + l*{AXIS}\""""
KINDS = {
    "tops": (THREE, "", '["l*sin(b[i])*sin(a[i])", "-l*sin(b[i])*cos(a[i])", "l*cos(b[i])"]', "zxz"),
    "bodies in space": (THREE + PLACES, "", '["x[i]", "y[i]", "z[i]"]', "xyz"),
    "gyroscopes in a row": (THREE, "", '["2*i", 0, 0]', "yxz"),
    "tops by quaternions": (FOUR, "", f'"l*{AXIS}"', QUATERNION),
    "bodies in space by quaternions": (FOUR + PLACES, "", '["x[i]", "y[i]", "z[i]"]', QUATERNION),
    "rods on ball joints": (FOUR, BALLS, f'"h[i] - l/2*{AXIS}"', QUATERNION),
    "hinged rods": (
        '\n  a[i in range(N)]: {{initial: "0.5*sin({seed} + i)", velocity: "cos(i)"}}', HINGES,
        "h[i] - [0, l/2*sin(a[i]), -l/2*cos(a[i])]", "",
    ),
    "gyroscopes on a chain": (
        '\n  a[i in range(N)]: {{initial: "0.5*sin({seed} + i)", velocity: "cos(i)"}}'
        '\n  c[i in range(N)]: {{initial: 0.1, velocity: "5 + i"}}', HINGES, "h[i]", "turning",
    ),
}  # fmt: skip
POTENTIALS = {
    "weight": "sum(m*g*body[i].z for i in range(N))",
    "a point's weight": "sum(m*g*body[i].at(0.1, 0.2, 0.3).z for i in range(N))",
    "springs": "sum(k/2*norm(body[i].at(l, 0, 0) - body[i - 1].at(0, 0.1, l))**2 for i in range(1, N))",
    "twists": "sum(k*(a[i] - a[i - 1])**2/2 for i in range(1, N))",
    "a drive": "sum(k*body[i].R33*sin(2*t) for i in range(N))",
}
FORCES = {
    "none": "",
    "drag": 'forces: {"body[i in range(N)]": ["-0.1*body[i].vx", "-0.1*body[i].vy", "0.1*sin(t)"]}',
    "torques": 'torques: {"body[i in range(N)]": ["-0.01*body[i].wx", "0.02*sin(t)", "0.01*i"]}',
}
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{m: 0.3, g: 2.0, l: 0.4, k: 0.7}}
coordinates: {coordinates}
{definitions}
bodies:
  body[i in range(N)]:
    mass: m*(1 + i/9)
    {matter}
    position: {place}
    orientation: {orientation}
potential: {potential}
{forces}
observables:
  spin[i in range(N)]: body[i].w3 + body[i].wy
  tip: body[N - 1].at(0, 0, l).vz
solve: {{stop: 0.5, step: 0.1}}
"""


def drawn(chance: random.Random, kind: str, count: int) -> str:
    """The text of a random system."""
    coordinates, definitions, place, sequence = KINDS[kind]
    orientation = ANGLES.format(sequence=sequence) if sequence else PLANAR
    if sequence == QUATERNION:
        orientation = sequence
    if sequence == "turning":
        orientation = '{euler: ["0.3*t", "a[i]", "c[i]"], sequence: xyz}'
    potentials = chance.sample([*POTENTIALS], chance.randint(1, 2))
    return SYSTEM.format(
        count=count, definitions=definitions,
        coordinates=coordinates.format(seed=chance.randint(1, 9), middle="pi/2" if sequence == "zxz" else 0),
        matter=MATTER[chance.choice([*MATTER])], place=place, orientation=orientation,
        potential=" + ".join(POTENTIALS[one] for one in potentials), forces=FORCES[chance.choice([*FORCES])],
    )  # fmt: skip


def bodies_from(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """Systems from this size on stay families."""
    fewest(monkeypatch, count)
    monkeypatch.setattr(systems, "FEWEST_TURNING", count)


@pytest.mark.exhaustive(keep=0.35, most=10)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("kind", KINDS)
def test_bodies_move_as_their_members_do(
    kind: str, count: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {kind} {count}")
    text, method = drawn(chance, kind, count), chance.choice(["taylor", "ias15"])
    bodies_from(monkeypatch, 0)
    outputs = ALL - {"reactions"} if POTENTIALS["twists"] in text else ALL  # angles say nothing of forces
    spec, compilation = read_spec(text, "system.yaml"), Compilation(method, 2.0**-52, outputs)
    assert family_run(spec, compilation) is not None, text
    together, found = followed(text, outputs, 0.2, method=method)
    bodies_from(monkeypatch, 10**9)
    apart, expected = followed(text, outputs, 0.2, method=method)
    assert together.recording.datasets == apart.recording.datasets
    assert set(together.recording.conserved) <= set(apart.recording.conserved)
    alike(found.data, expected.data, 2.0**-38, text)


TOPS = """
sizes: {N: COUNT}
parameters: {m: 0.1, g: 9.81, l: 0.04, I1: 1.0e-4, I3: 5.0e-5, w: 300.0}
coordinates:
  phi[i in range(N)]: {initial: 0, velocity: slow[i]}
  theta[i in range(N)]: {initial: "0.3 + i/N"}
  psi[i in range(N)]: {initial: 0, velocity: "w - slow[i]*cos(0.3 + i/N)"}
parameters: {m: 0.1, g: 9.81, l: 0.04, I1: 1.0e-4, I3: 5.0e-5, w: 300.0, A: I1 + m*l**2,
  "slow[i in range(N)]":
    "(I3*w - sqrt((I3*w)**2 - 4*A*m*g*l*cos(0.3 + i/N)))/(2*A*cos(0.3 + i/N))"}
bodies:
  top[i in range(N)]:
    mass: m
    inertia: [I1, I1, I3]
    position: [l*sin(theta[i])*sin(phi[i]), -l*sin(theta[i])*cos(phi[i]), l*cos(theta[i])]
    orientation: {euler: [phi[i], theta[i], psi[i]], sequence: zxz}
potential: sum(m*g*top[i].z for i in range(N))
solve: {stop: 0.2, step: 0.1}
""".replace("parameters: {m: 0.1, g: 9.81, l: 0.04, I1: 1.0e-4, I3: 5.0e-5, w: 300.0}\n", "", 1)


@pytest.mark.exhaustive(keep=0.2)
def test_tops_precess_regularly_at_every_tilt() -> None:
    """Goldstein, 3rd ed., sec. 5.7: A cos(theta) slow^2 - I3 w slow + m g l = 0."""
    spec = read_spec(TOPS.replace("COUNT", "20"), "tops.yaml")
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, ALL | {"conserved"}))
    data = run(ready, resolve_values(spec, {}), 0.0, 0.2, 3).data
    theta, slow = 0.3 + np.arange(20) / 20, data["v/phi"][0]
    assert np.max(np.abs(data["q/theta"] - theta)) < 1e-11
    assert np.max(np.abs(data["q/phi"] - slow * np.array([[0.0], [0.1], [0.2]]))) < 1e-9
    spin, axis = data["angular_velocities/top"], data["orientations/top"][..., 2]
    assert np.max(np.abs(np.sum(spin * axis, axis=-1) - 300)) < 1e-9
    assert {"h", "p_phi[3]", "p_psi[19]"} <= {*ready.recording.conserved}
    assert np.ptp(data["diagnostics/conserved/L_z"]) < 1e-13


@pytest.mark.exhaustive(keep=0.2)
def test_ledgers_that_are_rounding_of_large_terms_are_followed() -> None:
    """The torque along theta is 0, but the terms that cancel in it are those of the spin."""
    spec = read_spec(TOPS.replace("COUNT", "20").replace("w: 300.0", "w: 3000.0"), "tops.yaml")
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, frozenset({"ledger"})))
    motion = run(ready, resolve_values(spec, {}), 0.0, 0.001, 2)
    assert motion.outcome.steps < 20
    assert np.max(np.abs(motion.data["diagnostics/ledger/p/theta"])) < 1e-14  # I3 w^2 times the time is 0.45


@pytest.mark.exhaustive(keep=0.35)
def test_what_the_rotation_does_not_depend_on_is_cyclic() -> None:
    """It is not seen by the form of T, in which the masses at the axes depend on all three angles."""
    found = classify(read_spec(TOPS.replace("COUNT", "20"), "tops.yaml")).mechanics
    assert {one[:3] for one in found.cyclic} == {"phi", "psi"} and len(found.cyclic) == 40
    kept = {one.quantity: one for one in found.conserved}
    assert kept.keys() == {"h", "L_z"} | {f"p_{one}" for one in found.cyclic}
    assert kept["L_z"].expression == "sum of x*m*vy - y*m*vx + spins"
    assert kept["L_z"].because.startswith("turning everything about the z axis")


@pytest.mark.exhaustive(keep=0.35)
def test_the_code_does_not_grow_with_the_bodies() -> None:
    def size(count: int) -> tuple[int, int]:
        spec = read_spec(TOPS.replace("COUNT", str(count)), "tops.yaml")
        system, compilation = systems.family_system(spec), Compilation("taylor", 2.0**-52, frozenset("qp"))
        assert system is not None
        program, _ = write_families(system, compilation)
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert size(40) == size(24)


def test_a_matrix_that_is_no_rotation_is_refused_at_its_place() -> None:
    text = TOPS.replace("COUNT", "20").replace(
        "{euler: [phi[i], theta[i], psi[i]], sequence: zxz}",
        "{matrix: [[cos(phi[i]), sin(phi[i]), 0], [sin(phi[i]), cos(phi[i]), 0], [0, 0, 1]]}",
    )
    with pytest.raises(SpecError, match=r"body 'top\[0\]' is not a rotation: columns 1 and 2"):
        systems.any_family_system(read_spec(text, "tops.yaml"))


ROTORS = """
sizes: {N: 12}
coordinates:
  w[i in range(N)]: {initial: 1}
  x[i in range(N)]: {initial: 0, velocity: 0.1*i}
  y[i in range(N)]: {initial: 0, velocity: 0.5}
  z[i in range(N)]: {initial: 0}
  s[i in range(N)]: {initial: 0.3, velocity: 0.2}
bodies:
  base[i in range(N)]:
    mass: 1
    inertia: [1, 2, 2.5]
    position: [0, 0, 0]
    orientation: {quaternion: ["w[i]", "x[i]", "y[i]", "z[i]"]}
  rotor[i in range(N)]:
    mass: 1
    inertia: [0.2, 0.2, 0.3]
    position: base[i].at(0.1, 0, 0.4)
    orientation: ORIENTATION
"""
SPUN = (
    '["cos(s[i])*base[i].R{0}1 + sin(s[i])*base[i].R{0}2", '
    '"cos(s[i])*base[i].R{0}2 - sin(s[i])*base[i].R{0}1", "base[i].R{0}3"]'
)
BY_AXES = f"{{matrix: [{', '.join(map(SPUN.format, '123'))}]}}"
PRODUCT = (
    '{quaternion: ["w[i]*cos(s[i]/2) - z[i]*sin(s[i]/2)", "x[i]*cos(s[i]/2) + y[i]*sin(s[i]/2)", '
    '"y[i]*cos(s[i]/2) - x[i]*sin(s[i]/2)", "z[i]*cos(s[i]/2) + w[i]*sin(s[i]/2)"]}'
)


@pytest.mark.exhaustive(keep=0.5)
def test_rotors_on_bodies_turned_by_quaternions() -> None:
    """By the axes of the bodies, whose quaternions have the length 1, and by products of quaternions."""
    (ready, motion), (_, expected) = (
        followed(ROTORS.replace("ORIENTATION", how), frozenset("q")) for how in (BY_AXES, PRODUCT)
    )
    assert ready.machine.program.loops
    alike(motion.data, expected.data, 1e-13)


DIMERS = """
sizes: {{N: {count}}}
parameters: {{a: 0.3}}
coordinates:
  x[i in range(N)]: {{initial: 2*(i % 6), velocity: 0.3*sin(i)}}
  y[i in range(N)]: {{initial: 2*(i // 6), velocity: 0.3*cos(i)}}
  th[i in range(N)]: {{initial: i, velocity: 0.5}}
bodies:
  d[i in range(N)]:
    {{mass: 1, inertia: [0.1, 0.1, 0.1], position: "[x[i], y[i], {height}]",
      orientation: {{euler: ["th[i]", 0, 0], sequence: zxz}}}}
potential: >-
  sum(1/norm(d[i].at((2*s - 1)*a, 0, 0) - d[j].at((2*r - 1)*a, 0, 0))**12
      for i in range(N) for j in range(i) for s in range(2) for r in range(2))
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("height", ["0", "i/99", "x[i]/9"])
def test_pairs_of_points_of_few_bodies_are_read_at_once(height: str) -> None:
    """However many terms the sum has if it is written out; numbers among the components of positions are
    known for each of the bodies."""
    for count in 12, 30:
        spec = read_spec(DIMERS.format(count=count, height=height), "dimers.yaml")
        found = systems.family_system(spec)
        assert found is not None and found.bodies, (count, height)
