"""Chains that hang from one platform, which moves or turns, against their members one by one."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.joints import platforms
from lagrange_cli.spec.read import read_spec
from tests.families.test_closed_chains import exactly_followed
from tests.support.families import alike, followed

OUTPUTS = frozenset(["q", "v", "h", "p", "T", "U", "positions"])
SYSTEM = """
sizes: {{N: {count}, K: {arms}}}
parameters: {{g: 9.81, l: 0.4, c: 0.7, M: 3.5, "d[k in range(K)]": "0.3*k - 0.5"}}
coordinates:
  X: {{initial: 0.2, velocity: 0.3}}
  Y: {{initial: -0.1}}
  T: {{initial: 0.3, velocity: 0.5}}
{coordinates}
masses: {{hull: M, bow: 0.8, stern: 1.1, {masses}}}
embedding:
  hull: [X, Y]
  bow: ["X + c*cos(T)", "Y + c*sin(T)"]
  stern: ["X - c*cos(T)", "Y - c*sin(T)"]
{embedding}
potential: {potential}
{forces}
"""
MOUNTS = {
    "moves": ("X + {d}", "Y"),
    "turns": ("X + {d}*cos(T)", "Y + {d}*sin(T)"),
    "turns, driven": ("X + {d}*cos(T) - 0.2*sin(T) + sin(t)/9", "Y + {d}*sin(T) + 0.2*cos(T)"),
    "on a rail": ("2*X - {d}", "0.1*{d}"),
}
"""Where chains hang from their platform."""
LINKS = {
    "links": ("l*sin({a})", "-l*cos({a})"),
    "links of many lengths": ("l*(1 + {i}/5)*sin({a})", "-l*(1 + {i}/5)*cos({a})"),
    "sliding": ("0.3 + {a}", "0.2*{a}**2 - 0.1*{i}"),
}
FORCES = {
    "none": "",
    "applied": 'generalized_forces: {{X: "-0.2*X_dot", "{coordinate}": "-0.1*{rate}"}}\n'
    'forces: {{hull: [0, 1], "{member}": ["-{own}.vx/9", 0.2]}}',
    "damping": "dissipation: 0.1*T_dot**2 + sum(0.05*{swing}_dot[{at}]**2 for i in range(N))",
}


def chain(
    name: str, swing: str, size: str, mount: tuple[str, str], step: tuple[str, str], d: str
) -> list[str]:
    """The coordinates, masses and places of a chain of its own."""
    x, y = (one.format(d=d) for one in mount)
    dx, dy = (one.format(a=f"{swing}[i]", i="i") for one in step)
    return [
        f'  "{swing}[i in range({size})]": {{initial: "0.4*sin(i + 1)", velocity: "0.3*cos(i)"}}',
        f'"{name}[i in range({size})]": "0.2 + i/20"',
        f'  "{name}[i in range({size})]": ["where(i > 0, {name}[i - 1].x, {x}) + {dx}", '
        f'"where(i > 0, {name}[i - 1].y, {y}) + {dy}"]',
    ]


def drawn(chance: random.Random, count: int, mount: str, written: str) -> str:
    """The text of a random system."""
    step, forces = LINKS[chance.choice([*LINKS])], FORCES[chance.choice([*FORCES])]
    arms, place = chance.choice([1, 2, 3]), MOUNTS[mount]
    hung = "sum({b}*g*{n}.y + 2*{s}**2 for i in range({size}))"
    if written == "two indices":
        x, y = (one.format(d="d[k]") for one in place)
        dx, dy = (one.format(a="a[k, i]", i="i") for one in step)
        both = "k in range(K), i in range(N)"
        listed = [[
            f'  "a[{both}]": {{initial: "0.4*sin(i + k + 1)", velocity: "0.3*cos(i - k)"}}',
            f'"arm[{both}]": "0.2 + i/20 + k/9"',
            f'  "arm[{both}]": ["where(i > 0, arm[k, i - 1].x, {x}) + {dx}", '
            f'"where(i > 0, arm[k, i - 1].y, {y}) + {dy}"]',
        ]]  # fmt: skip
        energies = ["sum(sum(0.3*g*arm[k, i].y + 2*a[k, i]**2 for i in range(N)) for k in range(K))"]
        of = {"coordinate": f"a[{both}]", "rate": "a_dot[k, i]", "member": f"arm[{both}]", "own": "arm[k, i]"}
        swing, at = "a", "0, i"
    else:
        sizes = ("N", "N + 2") if written == "unequal chains" else ("N", "N")
        listed = [
            chain("left", "a", sizes[0], place, step, "c"),
            chain("right", "b", sizes[1], place, step, "(-c)"),
        ]
        energies = [
            hung.format(b="0.3", n="left[i]", s="a[i]", size=sizes[0]),
            hung.format(b="0.2", n="right[i]", s="b[i]", size=sizes[1]),
        ]
        of = {
            "coordinate": "a[i in range(N)]", "rate": "a_dot[i]",
            "member": "left[i in range(N)]", "own": "left[i]",
        }  # fmt: skip
        swing, at = "a", "i"
    if chance.random() < 0.5 and written != "two indices":
        energies.append("sum(3*norm(left[i] - right[i])**2 for i in range(N))")
    if chance.random() < 0.5:
        energies.append("0.5*(X - 0.3)**2 + Y**2 + cos(T)")
    coordinates, masses, embedding = zip(*listed)
    return SYSTEM.format(
        count=count, arms=arms, coordinates="\n".join(coordinates), masses=", ".join(masses),
        embedding="\n".join(embedding), potential=" + ".join(energies),
        forces=forces.format(**of, swing=swing, at=at),
    )  # fmt: skip


def fewest(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """Systems from this size on stay families."""
    monkeypatch.setattr(systems, "FEWEST", count)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", count)
    monkeypatch.setattr(platforms, "FEWEST", count)


def move_as_their_members(
    monkeypatch: pytest.MonkeyPatch, text: str, outputs: frozenset[str], most: float
) -> None:
    """A system in loops moves as written out but for rounding, up to ``most``."""
    fewest(monkeypatch, 0)
    together, found = followed(text, outputs, samples=3)
    fewest(monkeypatch, 10**9)
    apart, expected = followed(text, outputs, samples=3)
    assert together.machine.program.loops and not apart.machine.program.loops
    alike(found.data, expected.data, most)


@pytest.mark.exhaustive(keep=0.15, most=8)
@pytest.mark.parametrize("written", ["two families", "unequal chains", "two indices"])
@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
def test_chains_on_platforms_move_as_their_members_do(
    count: int, mount: str, written: str, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {count} {mount} {written}")
    text, method = drawn(chance, count, mount, written), chance.choice(["taylor", "taylor", "ias15"])
    stop = 0.4 if "driven" in mount else chance.choice([0.4, 0.4, -0.4])
    fewest(monkeypatch, 0)
    together, found = followed(text, OUTPUTS, stop=stop, method=method)
    assert together.machine.program.loops, text
    fewest(monkeypatch, 10**9)
    apart, expected = followed(text, OUTPUTS, stop=stop, method=method)
    assert not apart.machine.program.loops
    assert together.recording.datasets == apart.recording.datasets
    assert set(together.recording.conserved) <= set(apart.recording.conserved)
    alike(found.data, expected.data, 2.0**-38, text)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("mount", ["moves", "turns"])
def test_platforms_in_double_double(mount: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = drawn(random.Random(3), 3, mount, "unequal chains")
    fewest(monkeypatch, 0)
    together, found = exactly_followed(text, OUTPUTS)
    fewest(monkeypatch, 10**9)
    apart, expected = exactly_followed(text, OUTPUTS)
    assert together.machine.program.loops and not apart.machine.program.loops
    alike(found.data, expected.data, 2.0**-90)


SATELLITE = """
sizes: {N: 40}
parameters: {l: 0.05, c: 0.6}
coordinates:
  X: {initial: 0}
  Y: {initial: 0}
  T: {initial: 0.1, velocity: 0.7}
  "a[i in range(N)]": {initial: "0.1 + 0.01*sin(i)", velocity: 0.7}
  "b[i in range(N + 3)]": {initial: "0.1 - 0.01*i", velocity: 0.7}
masses: {hull: 3, bow: 0.5, stern: 0.5, "left[i in range(N)]": 1/N, "right[i in range(N + 3)]": 1/N}
embedding:
  hull: [X, Y]
  bow: ["X + c*cos(T)", "Y + c*sin(T)"]
  stern: ["X - c*cos(T)", "Y - c*sin(T)"]
  "left[i in range(N)]": where(i > 0, left[i - 1], stern) - [l*cos(a[i]), l*sin(a[i])]
  "right[i in range(N + 3)]": where(i > 0, right[i - 1], bow) + [l*cos(b[i]), l*sin(b[i])]
potential: sum(5*(a[i] - where(i > 0, a[i - 1], T))**2 for i in range(N))
  + sum(5*(b[i] - where(i > 0, b[i - 1], T))**2 for i in range(N + 3))
observables:
  spin: 3*(X*hull.vy - Y*hull.vx) + 0.5*(bow.x*bow.vy - bow.y*bow.vx + stern.x*stern.vy - stern.y*stern.vx)
    + sum(left[i].x*left[i].vy - left[i].y*left[i].vx for i in range(N))/N
    + sum(right[i].x*right[i].vy - right[i].y*right[i].vx for i in range(N + 3))/N
"""


@pytest.mark.exhaustive(keep=0.5)
def test_a_satellite_keeps_its_momenta_and_its_centre() -> None:
    """Its booms bend and turn it, and its angular momentum stays; its centre moves in a straight line."""
    ready, motion = followed(SATELLITE, frozenset(["q", "h", "p", "observables", "positions"]), stop=1.0)
    assert ready.machine.program.loops
    h, spin = motion.data["diagnostics/h"], motion.data["observables/spin"]
    assert np.ptp(h) < 1e-12 * np.max(np.abs(h))
    assert np.ptp(spin) < 1e-12 * np.max(np.abs(spin))
    assert all(np.ptp(motion.data[f"diagnostics/p/{axis}"]) < 1e-12 for axis in "XY")
    assert np.ptp(motion.data["q/T"]) > 0.5


@pytest.mark.exhaustive(keep=0.3)
def test_a_boom_may_be_pinned(monkeypatch: pytest.MonkeyPatch) -> None:
    """The forces of constraint on its tip act on the platform, and on the other boom."""
    text = SATELLITE.replace("N: 40", "N: 3").replace("initial: 0}", "}")
    text += 'constraints: {pin: ["left[N - 1].x + 1.5", "left[N - 1].y - 0.1"]}\n'
    outputs = frozenset(["q", "v", "h", "positions", "constraints", "multipliers"])
    move_as_their_members(monkeypatch, text, outputs, 2.0**-36)


HULL = """
sizes: {N: 4}
parameters: {l: 0.1, m: 1, M: 5, b: 0.5, J: 0.4}
coordinates:
  x: {initial: 0, velocity: 0.1}
  y: {initial: 0}
  T: {initial: 0.2, velocity: 0.3}
  "u[i in range(N)]": {initial: "0.2*i", velocity: 0.1}
  "w[i in range(N)]": {initial: 0.5, velocity: -0.1}
bodies:
  hull:
    mass: M
    inertia: [J, J, J]
    position: [x, y, 0]
    orientation: {euler: [T, 0, 0]}
masses: {"p[i in range(N)]": m, "q[i in range(N)]": m}
positions:
  "p[0]": "hull.at(b, 0, 0) + l*[cos(u[0]), sin(u[0]), 0]"
  "p[i in range(1, N)]": "p[i - 1] + l*[cos(u[i]), sin(u[i]), 0]"
  "q[0]": "hull.at(-b, 0, 0) - l*[cos(w[0]), sin(w[0]), 0]"
  "q[i in range(1, N)]": "q[i - 1] - l*[cos(w[i]), sin(w[i]), 0]"
potential: 9.81*m*sum(p[i].y for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.4)
def test_a_rigid_body_is_a_platform(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chains hang at points of it."""
    move_as_their_members(monkeypatch, HULL, frozenset(["q", "v", "h", "p", "positions"]), 2.0**-38)


REFUSED = {
    "within a chain": ('"where(i > 0, left[i - 1].x, X', '"where(i > 0, left[i - 1].x + 0.1*T, X'),
    "not apart": ("l*sin(a[i])", "l*sin(a[i] + T)"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_platform_is_written_out(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Coordinates that move several nodes otherwise."""
    fewest(monkeypatch, 0)
    monkeypatch.setitem(LINKS, "sliding", LINKS["links"])
    monkeypatch.setitem(LINKS, "links of many lengths", LINKS["links"])
    text = drawn(random.Random(1), 3, "turns", "unequal chains")
    assert systems.family_system(read_spec(text, "system.yaml")) is not None
    other = text.replace(*REFUSED[case])
    assert other != text
    assert systems.family_system(read_spec(other, "system.yaml")) is None
