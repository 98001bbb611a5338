"""Families of what spins fast: steps follow the motion of the axes, beside one member and closed forms."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.families.system import family_system
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.read import read_spec
from tests.families.test_kinds import MP, exactly, followed
from tests.support.replicated import replicated

Turn: TypeAlias = Callable[[Any, int], Any]

MANY = 60
MATTER = "m: 0.1, g: 9.81, l: 0.04, I1: 1.0e-4, I3: 1.6e-4"
ANGLES = "{{euler: [phi, theta, psi], sequence: {}}}"
PLACE = "[l*sin(theta)*sin(phi), -l*sin(theta)*cos(phi), l*cos(theta)]"
MATRIX = """{matrix: [
      [cos(phi)*cos(psi) - sin(phi)*cos(theta)*sin(psi), -cos(phi)*sin(psi) - sin(phi)*cos(theta)*cos(psi),
       sin(phi)*sin(theta)],
      [sin(phi)*cos(psi) + cos(phi)*cos(theta)*sin(psi), -sin(phi)*sin(psi) + cos(phi)*cos(theta)*cos(psi),
       -cos(phi)*sin(theta)],
      [sin(theta)*sin(psi), sin(theta)*cos(psi), cos(theta)]]}"""
DRAG = "torques: {top: [0, 0, -1e-6*top.wz]}"
BRAKE = "generalized_forces: {psi: -4e-3*sign(psi_dot)}"
CARRIED = "[X + l*sin(theta)*sin(phi), -l*sin(theta)*cos(phi), l*cos(theta)]"


def top(
    matter: str = "inertia: [I1, I1, I3]",
    place: str = PLACE,
    turned: str = ANGLES.format("zxz"),
    tilt: float = 0.5,
    spin: float = 3000,
    more: str = "",
    first: str = "",
) -> str:
    """A heavy top."""
    return f"""
name: top
parameters: {{{MATTER}}}
coordinates:
  phi: {{initial: 0.3, velocity: 0.5}}
  theta: {{initial: {tilt}}}
  psi: {{initial: 0, velocity: {spin}}}
{first}
bodies:
  top:
    mass: m
    {matter}
    position: {place}
    orientation: {turned}
potential: m*g*top.z
{more}
solve: {{stop: 0.5}}
"""


GIMBALS = """
name: a rotor in gimbals
parameters: {m: 0.1, A: 2.0e-4, B: 1.5e-4, I1: 1.0e-4, I3: 1.6e-4, k: 1e-3}
coordinates:
  a: {initial: 0.1, velocity: 1}
  b: {initial: 0.5}
  psi: {initial: 0, velocity: 2000}
definitions: {rest: [0, 0, 0]}
bodies:
  outer: {mass: m, inertia: [A, 1.2*A, 1.3*A], position: rest, orientation: {euler: [a, 0, 0], sequence: zxz}}
  inner: {mass: m, inertia: [B, 1.2*B, 1.3*B], position: rest, orientation: {euler: [a, b, 0], sequence: zxz}}
  rotor: {mass: m, inertia: [I1, I1, I3], position: rest, orientation: {euler: [a, b, psi], sequence: zxz}}
potential: k*b**2/2
solve: {stop: 0.5}
"""
CONICAL = """
name: a conical pendulum
parameters: {m: 0.1, g: 9.81, l: 1}
coordinates:
  phi: {initial: 0, velocity: 300}
  theta: {initial: 1.57}
  other: {initial: 1.5}
masses: {ball: m, bob: m}
embedding:
  ball: [l*sin(theta)*cos(phi), l*sin(theta)*sin(phi), -l*cos(theta)]
  bob: [l*sin(other), 0, -l*cos(other)]
potential: m*g*(ball.z + bob.z)
solve: {stop: 0.5}
"""
CART = "  X: {initial: 0.1}\nmasses: {cart: 0.2}\nembedding: {cart: [X, 0, 0]}"
SPINNING = {
    "a top": top(),
    "close to the vertical": top(tilt=1e-3),
    "a disc": top("solid: {disc: 0.05}"),
    "about its first axis": top("inertia: [I3, I1, I1]", "[0, 0, 0.1*sin(theta)]", ANGLES.format("zyx")),
    "about its second axis": top("inertia: [I1, I3, I1]", "[0, 0, 0.1*sin(theta)]", ANGLES.format("zxy")),
    "by a matrix": top(turned=MATRIX),
    "with drag": top(more=DRAG),
    "with a brake": top(spin=30, more=BRAKE),
    "on a cart": top(place=CARRIED, first=CART, more="dissipation: 0.01*X_dot**2"),
    "in gimbals": GIMBALS,
    "a conical pendulum": CONICAL,
}


def solved(text: str, method: str = "taylor", precision: str = "double") -> lagrange.Motion:
    """The motion, without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        return lagrange.solve(text, samples=11, outputs="q,v,p,h", method=method, precision=precision)


@pytest.mark.parametrize("name", SPINNING)
def test_what_spins_is_moved_by_its_energy(name: str) -> None:
    """This does not contain the angle."""
    spec = read_spec(replicated(SPINNING[name], MANY) or "", "system.yaml")
    system = family_system(spec)
    assert system is not None and system.joints is not None
    row = [*names_of(spec.coordinates)].index("phi[0]" if name == "a conical pendulum" else "psi[0]")
    ((joints, angle),) = (
        (one, symbol)
        for one in system.joints.joints
        for symbol, rows in zip(one.coordinates, one.rows)
        if row in rows
    )
    assert joints.free is not None
    assert not joints.free.kinetic.symbols & angle.symbols


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("method", ["taylor", "ias15", "auto"])
@pytest.mark.parametrize("name", SPINNING)
def test_members_take_steps_as_long_as_one_does(name: str, method: str) -> None:
    one, many = (solved(replicated(SPINNING[name], count) or "", method) for count in (1, MANY))
    assert many.attributes["steps"] <= 1.05 * one.attributes["steps"] + 5
    for path in ("q", "v", "p"):
        for coordinate, values in getattr(one, path).items():
            scale = max(1e-3, np.abs(values).max())
            found = getattr(many, path)[coordinate]
            assert found == pytest.approx(np.repeat(values, MANY, axis=1), abs=1e-10 * scale)
    assert many.h == pytest.approx(MANY * one.h, rel=1e-13)


A, C = MP.mpf("1e-4"), MP.mpf("1.6e-4")
HALF, WEIGHT = MP.mpf("0.1") * MP.mpf("0.04") ** 2, MP.mpf("0.1") * MP.mpf("9.81") * MP.mpf("0.04")
TILTED = """
sizes: {{N: 20}}
parameters:
  m: 0.1
  g: 9.81
  l: {length}
  I1: 1.0e-4
  I3: 1.6e-4
  spin: {spin}
  "tilt[i in range(N)]": "0.3 + 0.05*i"
  "turn[i in range(N)]": "{turn}"
coordinates:
  phi[i in range(N)]: {{initial: "0.1*i", velocity: "turn[i]"}}
  theta[i in range(N)]: {{initial: "tilt[i]"}}
  psi[i in range(N)]: {{initial: 0, velocity: "spin - turn[i]*cos(tilt[i])"}}
bodies:
  top[i in range(N)]:
    mass: m
    inertia: [I1, I1, I3]
    position: ["l*sin(theta[i])*sin(phi[i])", "-l*sin(theta[i])*cos(phi[i])", "l*cos(theta[i])"]
    orientation: {{euler: ["phi[i]", "theta[i]", "psi[i]"], sequence: zxz}}
potential: sum(m*g*top[i].z for i in range(N))
solve: {{stop: 0.5}}
"""
"""Tops that precess at a constant tilt, each with ``spin`` about its axis."""
SLOW = (
    "2*m*g*l/(I3*spin + sqrt((I3*spin)**2 - 4*(I1 + m*l**2)*m*g*l*cos(tilt[i])))",
    "0.04",
    lambda tilt, spin: (
        2 * WEIGHT / (C * spin + MP.sqrt((C * spin) ** 2 - 4 * (A + HALF) * WEIGHT * MP.cos(tilt)))
    ),
)
FREE = "I3*spin/(I1*cos(tilt[i]))", "0", lambda tilt, spin: C * spin / (A * MP.cos(tilt))


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("spin", [400, 20_000])
@pytest.mark.parametrize("case", [SLOW, FREE], ids=["heavy", "free"])
@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_tops_precess_steadily(case: tuple[str, str, Turn], spin: int, precision: str) -> None:
    """I1 W^2 cos(tilt) - I3 spin W + m g l = 0 for the precession W (H. Goldstein, Classical Mechanics, 3rd
    ed., eq. 5.76), and without weight W = I3 spin/(I1 cos(tilt))."""
    text, length, turn = case
    text = TILTED.format(length=length, turn=text, spin=spin)
    if precision == "double":
        motion = solved(text)
        t, found = motion.t, {name: motion.q[name].astype(object) for name in motion.q}
        least = 3e-13
    else:
        ready, data = followed(text)
        assert "@polynomial" in ready.machine.program.text  # type: ignore[attr-defined]
        t, found = data["t"], {name: exactly(data, f"q/{name}") for name in ("phi", "theta", "psi")}
        least = 1e-27
    for i in range(20):
        tilt = MP.mpf("0.3") + MP.mpf("0.05") * i
        rate = turn(tilt, spin)
        known = {"phi": (MP.mpf("0.1") * i, rate), "theta": (tilt, 0), "psi": (0, spin - rate * MP.cos(tilt))}
        for name, (first, speed) in known.items():
            for time, value in zip(t.tolist(), found[name][:, i]):
                assert abs(value - first - speed * time) <= least * max(1, abs(speed) / 2), (name, i, time)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize(
    "matter", ["inertia: [I1, I1, I3]", "inertia: [1.1e-4, 1.1e-4, 1.7e-4]", "solid: {disc: 0.05}"]
)
def test_the_axis_is_known_close_to_the_vertical(matter: str, precision: str) -> None:
    """A top 1e-3 rad from the vertical precesses alike by both precisions, alone and as one of a family: what
    is left of the inertia about the vertical, (I1 + m*l^2) sin(tilt)^2, has all its digits."""
    text = top(matter, tilt=1e-3, spin=200).replace("stop: 0.5", "stop: 5")
    expected = solved(replicated(text, 1) or "", precision="double-double")
    for count in (1, MANY):
        found = solved(replicated(text, count) or "", precision=precision)
        assert found.attributes["steps"] <= 1.15 * expected.attributes["steps"] + 5
        for name, values in expected.q.items():
            repeated = np.repeat(values, count, axis=1)
            assert found.q[name] == pytest.approx(repeated, abs=2e-13 * np.abs(values).max())


@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_spins_that_come_to_rest_on_swinging_axes_take_no_steps(method: str) -> None:
    """psi' = spin exp(-c t/I3) of a rotor with drag, whose place swings on a spring, however fast it is."""
    text = """
parameters: {m: 0.1, k: 0.4, c: 1.6e-5, I1: 1.0e-4, I3: 1.6e-4}
coordinates:
  x: {initial: 1}
  psi: {initial: 0, velocity: SPIN}
bodies:
  rotor:
    mass: m
    inertia: [I1, I1, I3]
    position: [x, 0, 0]
    orientation: {euler: [0.2, x, psi], sequence: zxz}
potential: k*x**2/2
generalized_forces: {psi: -c*psi_dot}
solve: {stop: 10}
"""
    steps = []
    for spin in (100, 100_000):
        motion = solved(replicated(text.replace("SPIN", str(spin)), MANY) or "", method)
        t = motion.t[:, None]
        known = {"x": np.cos(np.sqrt(0.4 / 0.1001) * t), "psi": spin * 10 * (1 - np.exp(-t / 10))}
        for name, values in known.items():
            least = (1e-8 if method == "DOP853" else 1e-13) * np.abs(values).max()
            assert motion.q[name] == pytest.approx(np.repeat(values, MANY, axis=1), abs=least)
        steps.append(motion.attributes["steps"])
    assert steps[1] <= (2 if method == "ias15" else 1) * steps[0]


CHAIN = """
sizes: {N: 20}
parameters: {m: 0.1, g: 9.81, l: 0.1, I1: 1.0e-4, I3: 1.6e-4}
coordinates:
  a[i in range(N)]: {initial: "0.5 + 0.1*i"}
  psi[i in range(N)]: {initial: 0, velocity: SPIN}
definitions:
  h[0]: [l*sin(a[0]), 0, -l*cos(a[0])]
  h[i in range(1, N)]: h[i - 1] + [l*sin(a[i]), 0, -l*cos(a[i])]
bodies:
  rotor[i in range(N)]:
    mass: m
    inertia: [I1, I1, I3]
    position: h[i]
    orientation: {euler: [0.3, "a[i]", "psi[i]"], sequence: zxz}
potential: sum(m*g*rotor[i].z for i in range(N))
solve: {stop: 0.3}
"""
BALLS = """
sizes: {N: 20}
parameters: {m: 0.1, g: 9.81, l: 0.1, I1: 1.0e-4, I3: 1.6e-4}
coordinates:
  phi[i in range(N)]: {initial: "0.1*i", velocity: 1}
  theta[i in range(N)]: {initial: "pi - 0.001*(2 + cos(i))"}
  psi[i in range(N)]: {initial: 0, velocity: "500 + 10*i"}
definitions:
  e[i in range(N)]: [sin(theta[i])*sin(phi[i]), -sin(theta[i])*cos(phi[i]), cos(theta[i])]
  h[0]: l*e[0]
  h[i in range(1, N)]: h[i - 1] + l*e[i]
bodies:
  rod[i in range(N)]:
    mass: m
    inertia: [I1, I1, I3]
    position: h[i] - l/2*e[i]
    orientation: {euler: ["phi[i]", "theta[i]", "psi[i]"], sequence: zxz}
potential: sum(m*g*rod[i].z for i in range(N))
solve: {stop: 0.05}
"""


def test_a_chain_swings_in_a_plane_as_if_its_rotors_were_at_rest() -> None:
    """Their axes stay in that plane, and psi' is constant."""
    still, fast = (solved(CHAIN.replace("SPIN", str(spin))) for spin in (0, 20_000))
    assert fast.attributes["steps"] == still.attributes["steps"]
    assert fast.q["a"] == pytest.approx(still.q["a"], abs=1e-13)
    assert fast.q["psi"] == pytest.approx(20_000 * np.repeat(fast.t[:, None], 20, axis=1), rel=1e-14)


def test_rods_that_hang_from_each_other_and_spin_keep_their_digits_close_to_the_vertical() -> None:
    """By both precisions alike, in as many steps."""
    found, expected = (solved(BALLS, precision=one) for one in ("double", "double-double"))
    assert found.attributes["steps"] <= 1.15 * expected.attributes["steps"] + 5
    for name, values in expected.q.items():
        assert found.q[name] == pytest.approx(values, abs=1e-12 * np.abs(values).max())
