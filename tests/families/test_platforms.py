"""Chains that hang from one platform, which moves or turns, against their members one by one."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.families import system as systems
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


def chain(name: str, swing: str, size: str, mount: tuple[str, str], step: tuple[str, str], d: str) -> list[str]:
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
            chain("left", "a", sizes[0], place, step, "c"), chain("right", "b", sizes[1], place, step, "(-c)"),
        ]  # fmt: skip
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


@pytest.mark.exhaustive(keep=0.15, most=8)
@pytest.mark.parametrize("written", ["two families", "unequal chains", "two indices"])
@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
def test_chains_on_platforms_move_as_their_members_do(
    count: int, mount: str, written: str, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {count} {mount} {written}")
    text, method = drawn(chance, count, mount, written), chance.choice(["taylor", "taylor", "ias15"])
    stop = chance.choice([0.4, 0.4, -0.4])
    fewest(monkeypatch, 0)
    together, found = followed(text, OUTPUTS, stop=stop, method=method)
    assert together.machine.program.loops, text
    fewest(monkeypatch, 10**9)
    apart, expected = followed(text, OUTPUTS, stop=stop, method=method)
    assert not apart.machine.program.loops
    assert together.recording.datasets == apart.recording.datasets
    assert set(together.recording.conserved) <= set(apart.recording.conserved)
    alike(found.data, expected.data, 2.0**-38, text)
