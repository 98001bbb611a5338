"""Families with constraints on velocities that stay families: beside the same systems written out member by
member, beside closed forms, and in the work that they take."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np
import pytest

from lagrange_cli.families import bonds
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.written_out import unsuited
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.support.families import begun, followed
from tests.support.motion import Motion

OUTPUTS = frozenset(
    ["q", "v", "p", "h", "T", "U", "positions", "constraints", "multipliers", "reactions", "ledger", "action"]
)
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
    # where y_dot follows from phi_dot, and obeys another constraint, phi_dot cannot be given
    settled = held == "a mean" or (own == "with powers" and len(listed) > 1)
    turning = ', velocity: "0.5 - i/9"' if not settled and chance.random() < 0.7 else ""
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


def compared(text: str, motion: Motion, expected: Motion, most: float = 2.0**-40) -> None:
    """Motions are the same but for rounding."""
    for path, values in motion.data.items():
        if path in expected.data:
            size = np.max(np.abs(expected.data[path]), initial=1.0)
            assert np.max(np.abs(values - expected.data[path])) <= most * size, (path, text)
        if "diagnostics/constraints/" in path:
            assert np.max(np.abs(values)) < 1e-13, (path, text)
        if "diagnostics/ledger/" in path:
            assert np.max(np.abs(values)) < 1e-12, (path, text)


@pytest.mark.exhaustive(keep=0.2, most=16)
@pytest.mark.parametrize("case", range(80))
def test_families_with_constraints_on_velocities_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} {case}"))
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    found = systems.family_system(begun(text)[0])
    assert found is not None and found.bonds is not None, text
    together, motion = followed(text, OUTPUTS)
    monkeypatch.setattr(systems, "FEWEST_BOUND", 10**9)
    apart, expected = followed(text, OUTPUTS)
    assert together.machine.program.loops and not apart.machine.program.loops, text
    own = [one.path for one in together.recording.datasets]
    assert own == [one.path for one in apart.recording.datasets], text
    assert set(together.recording.conserved) <= set(apart.recording.conserved), text
    compared(text, motion, expected)


@pytest.mark.exhaustive(keep=0.15, most=10)
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


CHAPLYGIN = """
sizes: {{N: {count}}}
parameters: {{m: 1.5, J: 0.7, a: 0.3, I: J + m*a**2, V: 1.3, W: V*sqrt(m/I)}}
coordinates:
  x[i in range(N)]: {{initial: "3*i + {0}*cos(i)", velocity: "V*tanh({s})*cos(i) - {0}*W/cosh({s})*sin(i)"}}
  y[i in range(N)]: {{initial: "{0}*sin(i)", velocity: "V*tanh({s})*sin(i) + {0}*W/cosh({s})*cos(i)"}}
  phi[i in range(N)]: {{initial: i, velocity: "W/cosh({s})"}}
"""
CENTRES = """
lagrangian: "sum(m*(x_dot[i]**2 + y_dot[i]**2)/2 + J*phi_dot[i]**2/2 for i in range(N))"
nonholonomic: {"knife[i in range(N)]": "y_dot[i]*cos(phi[i]) - x_dot[i]*sin(phi[i]) - a*phi_dot[i]"}
"""
POINTS = """
masses: {"f[i in range(N)]": m/2, "r[i in range(N)]": m/2}
definitions: {b: sqrt(J/m)}
positions:
  f[i in range(N)]: ["x[i] + (a + b)*cos(phi[i])", "y[i] + (a + b)*sin(phi[i])"]
  r[i in range(N)]: ["x[i] + (a - b)*cos(phi[i])", "y[i] + (a - b)*sin(phi[i])"]
nonholonomic: {"knife[i in range(N)]": "y_dot[i]*cos(phi[i]) - x_dot[i]*sin(phi[i])"}
"""
BEGIN = "(2*i/N - 1)"


def chaplygin(form: str, count: int) -> str:
    """Sleighs whose centres of mass are ahead of their knife edges, by their centres or as points."""
    return CHAPLYGIN.format("a" if form == "centres" else "0", count=count, s=BEGIN) + (
        CENTRES if form == "centres" else POINTS
    )


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("form", ["centres", "points"])
def test_sleighs_move_as_a_textbook_says(form: str) -> None:
    """Along the edge v, and w about the axis: v' = a w^2 and I w' = -m a v w, so that v = V tanh(s) and
    w = W/cosh(s) with s' = a V m/I (A. M. Bloch, Nonholonomic Mechanics and Control, 2015, sec. 1.7).
    The edge pushes with m (v w + a w')."""
    count = 120
    ready, motion = followed(chaplygin(form, count), frozenset(["q", "v", "h", "multipliers"]), stop=2.0)
    assert ready.machine.program.loops
    a, m, inertia, speed = 0.3, 1.5, 0.7 + 1.5 * 0.3**2, 1.3
    turn, rate = speed * np.sqrt(m / inertia), a * speed * m / inertia
    members = np.arange(count)
    begin = 2 * members / count - 1
    s = begin + rate * motion.t[:, None]
    v, w = speed * np.tanh(s), turn / np.cosh(s)
    angle = members + turn / rate * 2 * (np.arctan(np.tanh(s / 2)) - np.arctan(np.tanh(begin / 2)))
    assert np.max(np.abs(motion.data["v/phi"] - w)) < 1e-14
    assert np.max(np.abs(motion.data["q/phi"] - angle)) < 2e-14 * count
    across = 0.0 if form == "points" else a * w
    along = motion.data["v/x"] * np.cos(angle) + motion.data["v/y"] * np.sin(angle)
    aside = motion.data["v/y"] * np.cos(angle) - motion.data["v/x"] * np.sin(angle)
    assert np.max(np.abs(along - v)) < 1e-13 and np.max(np.abs(aside - across)) < 1e-13
    push = m * (v * w - a * rate * w * np.tanh(s))
    assert np.max(np.abs(motion.data["multipliers/knife"] - push)) < 1e-13
    assert "h" in ready.recording.conserved
    assert np.max(np.abs(motion.data["diagnostics/h"] / motion.data["diagnostics/h"][0] - 1)) < 1e-14


TRAILERS = """
sizes: {N: 60}
parameters: {l: 0.8, m: 1.1, J: 0.2}
"""
IN_PLACES = """
coordinates:
  x[i in range(N)]: {initial: "-sum(l*cos(sin(j)/2) for j in range(1, i + 1))"}
  y[i in range(N)]: {initial: "-sum(l*sin(sin(j)/2) for j in range(1, i + 1))"}
  phi[i in range(N)]: {initial: sin(i)/2, velocity: "where(i == 0, 0.5, 0)"}
lagrangian: "sum(m*(x_dot[i]**2 + y_dot[i]**2)/2 + J*phi_dot[i]**2/2 - m*y[i]/9 for i in range(N))"
constraints:
  hx[i in range(N - 1)]: x[i] - l*cos(phi[i + 1]) - x[i + 1]
  hy[i in range(N - 1)]: y[i] - l*sin(phi[i + 1]) - y[i + 1]
nonholonomic: {"knife[i in range(N)]": "y_dot[i]*cos(phi[i]) - x_dot[i]*sin(phi[i])"}
"""
IN_ANGLES = """
coordinates:
  u: {initial: 0}
  w: {initial: 0}
  phi[i in range(N)]: {initial: sin(i)/2, velocity: "where(i == 0, 0.5, 0)"}
definitions:
  X[0]: u
  X[i in range(1, N)]: X[i - 1] - l*cos(phi[i])
  Y[0]: w
  Y[i in range(1, N)]: Y[i - 1] - l*sin(phi[i])
masses: {"b[i in range(N)]": m, "s[i in range(N)]": J}
positions: {"b[i in range(N)]": ["X[i]", "Y[i]"], "s[i in range(N)]": "phi[i]"}
potential: "sum(m*b[i].y/9 for i in range(N))"
nonholonomic: {"knife[i in range(N)]": "b[i].vy*cos(phi[i]) - b[i].vx*sin(phi[i])"}
"""


@pytest.mark.exhaustive(keep=0.15)
def test_trailers_move_as_one_tree_as_they_do_tied_together() -> None:
    """In places, with hitches as holonomic constraints, and in the angles of one tree."""
    outputs = frozenset(["q", "v", "h", "multipliers"])
    freely = (
        IN_PLACES.replace('"where(i == 0, 0.5, 0)"', "0"),
        IN_ANGLES.replace('"where(i == 0, 0.5, 0)"', "0"),
    )
    tied, expected = followed(TRAILERS + freely[0], outputs, stop=1.0)
    tree, motion = followed(TRAILERS + freely[1], outputs, stop=1.0)
    assert tied.machine.program.loops and tree.machine.program.loops
    for path in ("q/phi", "v/phi", "multipliers/knife", "diagnostics/h"):
        size = np.max(np.abs(expected.data[path]), initial=1.0)
        assert np.max(np.abs(motion.data[path] - expected.data[path])) < 1e-12 * size, path


def test_a_long_train_in_angles_is_to_be_written_in_places(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bonds, "DENSE", 64)
    spec = read_spec((TRAILERS + IN_ANGLES).replace("N: 60", "N: 70"), "system.yaml")
    found = unsuited(spec)
    assert found.what == "more than 64 constraints on one chain or tree"
    assert "joints as holonomic constraints" in found.way
    assert found.place == spec.nonholonomic["knife[0]"].place


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("form", ["centres", "points"])
def test_code_and_work_grow_as_they_should(form: str) -> None:
    """The code does not grow with the members, and the arrays grow with their number."""

    def sizes(count: int) -> tuple[int, int]:
        spec = read_spec(chaplygin(form, count), "system.yaml")
        asked = Compilation("taylor", 2.0**-52, frozenset(["q", "multipliers"]))
        program = prepare_system(spec, derive_system, None, asked).machine.program
        return len(program.text.split("@tables")[0].splitlines()), program.work

    (lines, work), (more, larger) = sizes(2000), sizes(4000)
    assert more <= 1.01 * lines
    assert larger < 2.01 * work


def test_wide_chains_are_eliminated_in_few_rounds() -> None:
    """Three constraints for each trailer: as many rounds as the number of trailers has bits, or few more."""
    rounds = []
    for count in (60, 480):
        spec, _ = begun(TRAILERS.replace("60", f"{count}") + IN_PLACES)
        system = systems.family_system(spec)
        assert system is not None and system.bonds is not None
        found = system.bonds.elimination
        assert found is not None and found.entries < 5 * system.bonds.count
        rounds.append(len(found.rounds))
    assert rounds[1] < rounds[0] + 15 < 40
