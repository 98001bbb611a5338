"""Chains and trees whose joints have relative coordinates, with constraints: they move as in absolute ones,
and as with members written out."""

from __future__ import annotations

import re
from math import cos, pi, sin

import numpy as np
import pytest

from tests.families.test_closed_chains import exactly_followed
from tests.families.test_relative_joints import ANGLES, MASSES, drawn, is_as_written_out, text
from tests.support.families import followed

OUTPUTS = frozenset(["q", "v", "p", "h", "positions", "energy", "constraints", "multipliers"])
CONSTRAINTS = {
    "an end on a curve": "constraints:\n  end: y[N - 1] - Y - 0.3*(sin(x[N - 1]) - sin(X))",
    "an end that is moved": "constraints:\n  right: x[N - 1] - X - 0.1*t**2",
    "an end that is held": "constraints:\n  right: x[N - 1] - X\n  up: y[N - 1] - Y",
    "an angle": "constraints:\n  level: th[N - 1] - B - 0.1*sin(t)**2",
    "a hinge": "constraints:\n  stiff: phi[N - 1] - phi[0]**2/2 - C",
    "a mean angle": "constraints:\n  mean: sum(th[i]/N for i in range(N)) - D",
    "angles and places": "constraints:\n  drum: y[N - 1] - Y - 0.2*(th[0] - A)\n"
    "  stiff: phi[N - 1] - phi[0]**2/2 - C",
    "a wheel": "nonholonomic:\n  blade: sin(th[N - 1])*b[N - 1].vx - cos(th[N - 1])*b[N - 1].vy",
    "rates": "nonholonomic:\n  geared: phi_dot[N - 1] - 0.5*phi_dot[0]*(1 + 0.1*sin(x[0]))",
}
BESIDE = {"N": 0, "i": 0, "sin": sin, "cos": cos, "pi": pi}


def bound(angles: str, masses: str, base: str, case: str, count: int, forces: str, seed: float) -> str:
    """An arm with constraints, which hold at its start, at rest."""
    given = re.sub(r', velocity: ("[^"]*"|[^}]*)', "", text(count, angles, masses, base, forces, seed))
    given = given.replace("0.1*sin(2*t)", "0.1*sin(2*t)**2")
    given = given.replace("0.5*t", "0.5*t**2").replace("sin(2*t + i)", "sin(t**2 + i)")
    lengths = [0.5 + 0.1 * sin(3 * i) for i in range(count)]
    phi = [seed * sin(i + seed) for i in range(count)]
    parents = [(i - 1) // 2 if angles == "a tree" else i - 1 for i in range(count)]
    th, x, y = list[float](), list[float](), list[float]()
    for i, (parent, own) in enumerate(zip(parents, lengths)):
        step = phi[i]
        if angles == "times a factor, from a direction":
            step = 0.7 * step + (pi / 7 if i else -pi / 2)
        elif angles == "geared" and i:
            step *= own
        elif angles == "driven" and i:
            step = 0.7 * step + 0.1 * sin(i)
        th.append(step + (th[parent] if i else 0.0))
        begin = (x[parent], y[parent]) if i else {"free": (0.1, -0.2)}.get(base, (0.0, 0.0))
        x.append(begin[0] + own * cos(th[i]))
        y.append(begin[1] + own * sin(th[i]))
    start = {
        "X": x[-1], "Y": y[-1], "A": th[0], "B": th[-1], "C": phi[-1] - phi[0] ** 2 / 2, "D": sum(th) / count,
    }  # fmt: skip
    if base == "free":  # X and Y are coordinates
        start = {f"{name}0" if name in "XY" else name: value for name, value in start.items()}
    more = re.sub(r"\b([XY])\b", r"\g<1>0", CONSTRAINTS[case]) if base == "free" else CONSTRAINTS[case]
    named = ", ".join(f"{name}: {value!r}" for name, value in start.items())
    return given.replace("parameters: {", f"parameters: {{{named}, ") + more + "\n"


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [3, 8, 9])
@pytest.mark.parametrize("case", CONSTRAINTS)
@pytest.mark.parametrize("angles", ANGLES)
def test_arms_move_as_with_members_written_out(
    angles: str, case: str, count: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance, seed, method = drawn(pytestconfig, angles, case, count)
    masses = chance.choice([*MASSES])
    base = chance.choice(["fixed", "driven", "free"] if masses == "bodies" else ["fixed", "driven"])
    forces = chance.choice(["none", "motors", "oil", "wind"])
    given = bound(angles, masses, base, case, count, forces, seed)
    is_as_written_out(given, method, OUTPUTS, monkeypatch)


RING = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, l: 4/N}}
coordinates:
  {coordinates}
definitions:
  {angles}x[0]: l*cos(th[0])
  y[0]: l*sin(th[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(th[i])
  y[i in range(1, N)]: y[i - 1] + l*sin(th[i])
masses: {{"b[i in range(N)]": 1 + 0.5*sin(i)}}
embedding: {{"b[i in range(N)]": "[x[i], y[i]]"}}
potential: sum((1 + 0.5*sin(i))*g*b[i].y for i in range(N))
constraints:
  closed: y[N - 1]
  level: x[N - 1]
"""
RELATIVE = (
    '"phi[i in range(N)]": {initial: "2*pi/N", velocity: 0}',
    "th[0]: phi[0]\n  th[i in range(1, N)]: th[i - 1] + phi[i]\n  ",
)
ABSOLUTE = '"th[i in range(N)]": {initial: "2*pi*(i + 1)/N", velocity: 0}', ""


def rings(count: int) -> list[str]:
    """A closed ring of links, in relative and in absolute angles."""
    return [RING.format(count=count, coordinates=one, angles=more) for one, more in (RELATIVE, ABSOLUTE)]


@pytest.mark.exhaustive(keep=0.2)
def test_long_rings_move_as_in_absolute_angles() -> None:
    """150 links. With members written out 24 took half a minute to compile."""
    outputs = frozenset(["q", "v", "multipliers", "h"])
    found, expected = (followed(one, outputs, 0.1)[1] for one in rings(150))
    assert found.outcome.steps <= 2 * expected.outcome.steps
    assert np.max(np.abs(np.cumsum(found["q/phi"], axis=1) - expected["q/th"])) < 2.0**-40
    most = np.max(np.abs(expected["multipliers/closed"]))
    assert np.max(np.abs(found["multipliers/closed"] - expected["multipliers/closed"])) < 2.0**-36 * most


@pytest.mark.exhaustive(keep=0.15)
def test_rings_in_double_double() -> None:
    """Constraints hold, and h is kept, to double-double rounding."""
    outputs = frozenset(["q", "v", "h", "constraints"])
    _, found = exactly_followed(rings(20)[0], outputs, 0.2)
    _, expected = followed(rings(20)[0], outputs, 0.2, samples=3)
    assert np.max(np.abs(found["q/phi"] - expected["q/phi"])) < 2.0**-40
    h = (found["diagnostics/h"] - found["diagnostics/h"][0]) + (
        found["low/diagnostics/h"] - found["low/diagnostics/h"][0]
    )
    assert np.max(np.abs(h)) < 1e-25
    for name in ("closed", "level"):
        assert np.max(np.abs(found[f"diagnostics/constraints/{name}"])) < 1e-28


@pytest.mark.exhaustive(keep=0.15)
def test_rings_go_back_to_their_start() -> None:
    given, outputs = rings(20)[0], frozenset(["q", "v"])
    _, forth = followed(given, outputs, 0.3)
    turned = given.replace('"2*pi/N", velocity: 0', '"Q[i]", velocity: "W[i]"')
    for name, path in (("Q", "q/phi"), ("W", "v/phi")):
        listed = ", ".join(map(repr, forth[path][-1].tolist()))
        turned = turned.replace("parameters: {", f"parameters: {{{name}: [{listed}], ")
    _, back = followed(turned, outputs, -0.3)
    assert np.max(np.abs(back["q/phi"][-1] - 2 * np.pi / 20)) < 1e-10
