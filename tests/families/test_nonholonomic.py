"""Families with constraints on velocities that stay families: beside the same systems written out member by
member, beside closed forms, and in the work that they take."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values, resolve_values
from tests.support.motion import Motion, run

OUTPUTS = frozenset(["q", "v", "p", "h", "T", "U", "positions", "constraints", "multipliers", "reactions"])
SIZES = 1, 2, 3, 8, 9, 13
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{a: 0.3, l: 1.2, R: 0.5, k: {k}}}
coordinates:
  x[i in range(N)]: {{initial: "{x}"}}
  y[i in range(N)]: {{initial: "{y}"}}
  phi[i in range(N)]: {{initial: "{phi}"{turning}}}
masses: {{"b[i in range(N)]": {mass}, "w[i in range(N)]": 0.4 + i/9}}
positions: {{"b[i in range(N)]": ["x[i]", "y[i]"], "w[i in range(N)]": "phi[i]"}}
potential: "{potential}"
{forces}
{holonomic}
nonholonomic:
  {constraints}
"""
KNIFE = "{0}.vy*cos(phi[i]) - {0}.vx*sin(phi[i])".format("b[i]")
OWN: Mapping[str, str] = {
    "knife edges": f"knife[i in range(N)]: {KNIFE} - a*phi_dot[i]",
    "edges on moving ice": f"knife[i in range(N)]: {KNIFE} + 0.2*cos(3*t + i)*sin(phi[i]) - a*phi_dot[i]",
    "wheels": "roll[i in range(N)]: x_dot[i] - R*phi_dot[i]",
    "upright disks": "rx[i in range(N)]: x_dot[i] - R*cos(y[i])*phi_dot[i]",
    "turntables": "spin[i in range(N)]: x_dot[i] + (0.3 + i/9)*y[i] - R*phi_dot[i]",
    "with powers": "twist[i in range(N)]: (y_dot[i] - sin(x[i])*phi_dot[i])*(2 + sin(x[i]))**2 - 0.1",
}
FURTHER: Mapping[str, str] = {
    "trains of gears": "gear[i in range(N - 1)]: y_dot[i + 1] - y_dot[i]*cos(phi[i + 1] - phi[i])/2",
    "every other one": "some[i in range((N + 1)//2)]: y_dot[2*i] - x[2*i]*x_dot[2*i]/5",
    "a centre at rest": "rest: sum(b[i].vy*(1 + i/5) for i in range(N)) - y_dot[0]*sin(phi[0])/3",
    "a bent sum": "flow: sum(y_dot[i]*(2 + cos(x[i])) for i in range(N)) - 0.3",
}
HOLONOMIC: Mapping[str, str] = {
    "": "",
    "rods": "rod[i in range(N - 1)]: (x[i + 1] - x[i])**2 + (y[i + 1] - y[i])**2 - l**2",
    "a mean": "level: sum(phi[i]*(1 + i/7) for i in range(N)) - sum({phi}*(1 + i/7) for i in range(N))",
}
POTENTIALS = {
    "nothing": "0",
    "weights": "sum(0.7*b[i].x for i in range(N))",
    "springs": "sum(k*((x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2)/2 for i in range(1, N))",
    "a trap": "sum(k*(x[i]**2 + y[i]**2 + cos(phi[i]))/2 for i in range(0, N, 3))",
}
FORCES = {
    "none": "",
    "friction": 'generalized_forces: {"x[i in range(N)]": "-0.1*x_dot[i]"}',
    "drive": 'generalized_forces: {"phi[0]": "cos(2*t)"}',
    "wind": 'forces: {"b[i in range(N)]": ["0.3 - 0.1*b[i].vx", "0"]}',
}


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    count, own = chance.choice(SIZES), chance.choice([*OWN])
    held = chance.choice([*HOLONOMIC]) if count > 1 else ""
    listed = [OWN[own]]
    if count > 1 and held != "rods" and chance.random() < 0.6:
        listed.append(FURTHER[chance.choice([*FURTHER])])
    phi = "0.4 + 0.7*sin(i)"
    x, y = "0.1 + 0.3*i", "0.2*cos(i)"
    if held == "rods":
        x, y = (f"sum(l*{f}(0.3 + j/3) for j in range(i))" for f in ("cos", "sin"))
        x, y = f"0.1 + {x}", f"0.2 + {y}"
    holonomic = HOLONOMIC[held] and "constraints:\n  " + HOLONOMIC[held].format(phi=f"({phi})")
    turning = ', velocity: "0.5 - i/9"' if held != "a mean" and chance.random() < 0.7 else ""
    return SYSTEM.format(
        count=count, k=chance.choice([0.7, 1.5]), x=x, y=y, phi=phi, turning=turning,
        mass=chance.choice(["1", "1 + i/7"]),
        potential=" + ".join(POTENTIALS[one] for one in chance.sample([*POTENTIALS], 2)),
        forces=FORCES[chance.choice([*FORCES])], holonomic=holonomic,
        constraints="\n  ".join(listed),
    )  # fmt: skip


SLEIGHS = """
sizes: {{N: {count}}}
parameters: {{a: 0.3, b: 0.5, l: 0.8}}
coordinates:
  x[i in range(N)]: {{initial: 0.4*i}}
  y[i in range(N)]: {{initial: 0.1*i}}
  phi[i in range(N)]: {{initial: "0.4 + 0.7*sin(i)", velocity: "0.5 - i/9"}}
masses: {{"f[i in range(N)]": 1 + i/7, "r[i in range(N)]": 0.6}}
embedding:
  f[i in range(N)]: ["x[i] + (a + b)*cos(phi[i])", "y[i] + (a + b)*sin(phi[i])"]
  r[i in range(N)]: ["x[i] + (a - b)*cos(phi[i])", "y[i] + (a - b)*sin(phi[i])"]
potential: "{potential}"
{forces}
{holonomic}
nonholonomic:
  {constraints}
"""
TRAIN = """
sizes: {{N: {count}}}
parameters: {{a: 0.3, b: 0.5, l: 0.8}}
coordinates:
  x: {{initial: 0}}
  y: {{initial: 0, velocity: 1.2}}
  phi[i in range(N)]: {{initial: "0.4 + 0.7*sin(i)"}}
definitions:
  X[0]: x
  X[i in range(1, N)]: X[i - 1] - l*cos(phi[i])
  Y[0]: y
  Y[i in range(1, N)]: Y[i - 1] - l*sin(phi[i])
masses: {{"f[i in range(N)]": 1 + i/7, "r[i in range(N)]": 0.6}}
embedding:
  f[i in range(N)]: ["X[i]", "Y[i]"]
  r[0]: ["x + a*cos(phi[0])", "y + a*sin(phi[0])"]
  r[i in range(1, N)]: ["X[i - 1] - a*cos(phi[i])", "Y[i - 1] - a*sin(phi[i])"]
potential: "{potential}"
{forces}
{holonomic}
nonholonomic:
  {constraints}
"""
EDGE = "f[i].vy*cos(phi[i]) - f[i].vx*sin(phi[i])"
ON_TREES: Mapping[str, tuple[str, str]] = {
    "sleighs": (SLEIGHS, "knife[i in range(N)]: y_dot[i]*cos(phi[i]) - x_dot[i]*sin(phi[i])"),
    "sleighs, held in front": (SLEIGHS, f"knife[i in range(N)]: {EDGE}"),
    "on turntables": (SLEIGHS, f"knife[i in range(N)]: {EDGE} - 0.3*(f[i].x*cos(phi[i]) + y[i]*sin(phi[i]))"),
    "of neighbours": (
        SLEIGHS,
        f"knife[i in range(N)]: {EDGE}\n  "
        "gear[i in range((N + 1)//2)]: phi_dot[2*i] + cos(x[i])*phi_dot[(2*i + 1) % N]/3 - 0.2",
    ),
    "a train": (TRAIN, f"knife[i in range(N)]: {EDGE}"),
    "a train that is pulled": (TRAIN, f"knife[i in range(N)]: {EDGE}\n  pull: f[0].vx - sin(t)/3"),
    "the last one steers": (TRAIN, "last: f[N - 1].vx*sin(x) - r[N - 1].vy - phi_dot[0]/5"),
}
FOR_TREES = {
    "nothing": "0",
    "a slope": "sum(0.7*f[i].x + r[i].y/3 for i in range(N))",
    "a trap": "sum((f[i].x**2 + r[i].y**2)/3 for i in range(N))",
}


def drawn_on_trees(chance: random.Random) -> str:
    """The text of a random system of which each member is a tree, or all of them are one."""
    text, constraints = ON_TREES[chance.choice([*ON_TREES])]
    first = "x[0]" if text is SLEIGHS else "x"
    held = chance.choice(["", "", f"constraints:\n  rail: phi[0] - 0.4 - {first}/3 - {first}**2/9"])
    if "gear" in constraints:
        text = text.replace(', velocity: "0.5 - i/9"', "")
    if held or "pull" in constraints:
        text = text.replace(", velocity: 1.2", "")
    friction = 'generalized_forces: {"phi[i in range(N)]": "-0.1*phi_dot[i]"}'
    return text.format(
        count=chance.choice(SIZES), potential=FOR_TREES[chance.choice([*FOR_TREES])], holonomic=held,
        forces=chance.choice(["", friction]), constraints=constraints,
    )  # fmt: skip


def begun(text: str) -> tuple[Spec, Values]:
    """A system and its consistent start."""
    spec = read_spec(text, "system.yaml")
    spec, values, _ = consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    return spec, values


def followed(text: str, outputs: frozenset[str] = OUTPUTS, stop: float = 0.5) -> tuple[Prepared, Motion]:
    """A motion of a system, and what it was followed by."""
    spec, values = begun(text)
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
    return ready, run(ready, values, 0.0, stop, 6)


def compared(text: str, motion: Motion, expected: Motion, most: float = 2.0**-40) -> None:
    """Motions are the same but for rounding."""
    for path, values in motion.data.items():
        if path in expected.data:
            size = np.max(np.abs(expected.data[path]), initial=1.0)
            assert np.max(np.abs(values - expected.data[path])) <= most * size, (path, text)
        if "diagnostics/constraints/" in path:
            assert np.max(np.abs(values)) < 1e-13, (path, text)


@pytest.mark.exhaustive(keep=0.5, most=16)
@pytest.mark.parametrize("case", range(80))
def test_families_with_constraints_on_velocities_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} {case}"))
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    found = systems.family_system(begun(text)[0])
    assert found is not None and found.bonds is not None, text
    together, motion = followed(text)
    monkeypatch.setattr(systems, "FEWEST_BOUND", 10**9)
    apart, expected = followed(text)
    assert together.machine.program.loops and not apart.machine.program.loops, text
    own = [one.path for one in together.recording.datasets]
    assert own == [one.path for one in apart.recording.datasets], text
    assert set(together.recording.conserved) <= set(apart.recording.conserved), text
    compared(text, motion, expected)


@pytest.mark.exhaustive(keep=0.5, most=10)
@pytest.mark.parametrize("case", range(60))
def test_chains_and_trees_with_constraints_on_velocities_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn_on_trees(random.Random(f"{pytestconfig.option.seed} {case}"))
    outputs = OUTPUTS - {"reactions"}
    for least in ("FEWEST_BOUND", "FEWEST_JOINTED", "FEWEST_NONHOLONOMIC"):
        monkeypatch.setattr(systems, least, 0)
    together, motion = followed(text, outputs)
    for least in ("FEWEST_BOUND", "FEWEST_JOINTED", "FEWEST_NONHOLONOMIC"):
        monkeypatch.setattr(systems, least, 10**9)
    apart, expected = followed(text, outputs)
    assert together.machine.program.loops and not apart.machine.program.loops, text
    assert set(together.recording.conserved) <= set(apart.recording.conserved), text
    compared(text, motion, expected)
