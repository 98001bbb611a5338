"""Chains and trees whose joints have relative coordinates, as the angles between the links of an arm: they
move as in absolute ones, and as with members written out."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.spec.read import read_spec
from tests.families.test_chains import fewest
from tests.support.families import alike, followed

WRITTEN = frozenset(["q", "v", "h", "p", "positions", "energy"])
ARM = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, k: {k}, "l[i in range(N)]": "0.5 + 0.1*sin(3*i)",
  "m[i in range(N)]": "1 + 0.2*cos(i)"}}
coordinates:
  {base}"phi[i in range(N)]": {{initial: "{seed}*sin(i + {seed})", velocity: "0.3*cos({seed}*i)"}}
definitions:
  {angles}
  x[0]: "{x} + l[0]*cos(th[0])"
  y[0]: "{y} + l[0]*sin(th[0])"
  x[i in range(1, N)]: "x[{parent}] + l[i]*cos(th[i])"
  y[i in range(1, N)]: "y[{parent}] + l[i]*sin(th[i])"
{masses}
potential:
  weight: sum(m[i]*g*b[i].y for i in range(N))
  springs: sum(2*(1 - cos(phi[i])) for i in range(1, N))
  level: sum(0.3*sin(th[i]) for i in range(N))
{more}
"""
ANGLES = {
    "one after the other": "th[0]: phi[0]\n  th[i in range(1, N)]: th[i - 1] + phi[i]",
    "a sum": "th[i in range(N)]: sum(phi[j] for j in range(i + 1))",
    "times a factor, from a direction": "th[0]: k*phi[0] - pi/2\n  "
    "th[i in range(1, N)]: th[i - 1] + k*phi[i] + pi/7",
    "geared": "th[0]: phi[0]\n  th[i in range(1, N)]: th[i - 1] + l[i]*phi[i]",
    "driven": "th[0]: phi[0] + 0.5*t\n  th[i in range(1, N)]: th[i - 1] + k*phi[i] + 0.1*sin(2*t + i)",
    "a tree": "th[0]: phi[0]\n  th[i in range(1, N)]: th[(i - 1)//2] + phi[i]",
}
MASSES = {
    "points": 'masses: {{"b[i in range(N)]": "m[i]"}}\nembedding: {{"b[i in range(N)]": "[x[i], y[i]]"}}',
    "centres": 'masses: {{"b[i in range(N)]": "m[i]"}}\nembedding:\n  "b[i in range(N)]": '
    '"[x[i] - l[i]/2*cos(th[i]), y[i] - l[i]/2*sin(th[i])]"',
    "bodies": """bodies:
  b[i in range(N)]:
    {{mass: "m[i]", inertia: [0.1, 0.1, "m[i]*l[i]**2/12"], position: "[x[i], y[i], 0]",
      orientation: {{euler: ["th[i]", 0, 0], sequence: zxz}}}}""",
}
BASES = {
    "fixed": ("", "0", "0"),
    "driven": ("", "0.1*sin(2*t)", "0"),
    "free": ("X: {initial: 0.1, velocity: 0.3}\n  Y: {initial: -0.2}\n  ", "X", "Y"),
}
FORCES = {
    "none": "",
    "motors": 'generalized_forces: {"phi[i in range(N)]": "sin(t + i) - 0.1*phi_dot[i]"}',
    "oil": "dissipation: sum(0.1*phi_dot[i]**2 for i in range(N)) + sum(0.05*th_dot[i]**2 for i in range(N))",
    "wind": 'forces: {"b[i in range(N)]": "WIND"}',
}


def text(count: int, angles: str, masses: str, base: str, forces: str, seed: float) -> str:
    """An arm."""
    free, x, y = BASES[base]
    more = FORCES[forces].replace(
        "WIND", "[0.3*cos(t), 0.1, 0]" if masses == "bodies" else "[0.3*cos(t), 0.1]"
    )
    if forces == "oil":
        more = more.replace("th_dot[i]**2", "phi_dot[i]**2*(1 + cos(th[i])**2)")
    return ARM.format(
        count=count, angles=ANGLES[angles], masses=MASSES[masses].format(), base=free, x=x, y=y, k=0.7,
        more=more, seed=seed, parent="(i - 1)//2" if angles == "a tree" else "i - 1",
    )  # fmt: skip


def is_relative(given: str) -> bool:
    """Whether an arm is a family whose joints have sums of coordinates."""
    system = systems.any_family_system(read_spec(given, "arm.yaml"))
    return system is not None and system.joints is not None and system.joints.relative is not None


def drawn(config: pytest.Config, *case: object) -> tuple[random.Random, float, str]:
    """What is drawn for a case: chance, the seed of an arm, and a method."""
    chance = random.Random(f"{config.option.seed} {case}")
    return chance, round(chance.uniform(0.3, 1.0), 2), chance.choice(["taylor", "ias15"])


def outputs_of(given: str) -> frozenset[str]:
    """All that loops compute of an arm."""
    return WRITTEN if "t)" in given or "*t" in given else WRITTEN | {"ledger"}


def is_as_written_out(
    given: str, method: str, outputs: frozenset[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An arm is a family with sums of coordinates, and moves as with its members written out."""
    fewest(monkeypatch, 0)
    assert is_relative(given)
    ready, found = followed(given, outputs, stop=0.3, method=method)
    assert ready.machine.program.loops
    fewest(monkeypatch, 10**9)
    ready, expected = followed(given, outputs, stop=0.3, method=method)
    assert not ready.machine.program.loops
    alike(found.data, expected.data, 2.0**-36, given)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("masses", MASSES)
@pytest.mark.parametrize("angles", ANGLES)
def test_arms_move_as_with_members_written_out(
    angles: str, masses: str, count: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance, seed, method = drawn(pytestconfig, angles, masses, count)
    bases = [*BASES] if masses == "bodies" else ["fixed", "driven"]  # else M may be singular
    given = text(count, angles, masses, chance.choice(bases), chance.choice([*FORCES]), seed)
    is_as_written_out(given, method, outputs_of(given), monkeypatch)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("strength", [0.01, 0.5, 5.0])
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("angles", [one for one in ANGLES if one != "driven"])
def test_dry_friction_holds_links_as_with_members_written_out(
    angles: str, count: int, strength: float, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance, seed, _ = drawn(pytestconfig, angles, strength, count)
    given = text(count, angles, chance.choice([*MASSES]), "fixed", "none", seed)
    given = given.replace("0.3*cos(", f"{chance.choice([0, 0.3])}*cos(")
    given += f"dissipation: sum({strength}*(1 + 0.1*i)*abs(phi_dot[i]) for i in range(N))\n"
    outputs = frozenset(["q", "v", "positions"])  # with others, members are written out
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    fewest(monkeypatch, 0)
    system = systems.family_system(read_spec(given, "arm.yaml"))
    assert system is not None and system.smooth is not None and system.smooth.modes is not None
    assert system.smooth.modes.locks is not None and system.smooth.modes.locks.carries
    _, found = followed(given, outputs, stop=0.3)
    fewest(monkeypatch, 10**9)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    _, expected = followed(given, outputs, stop=0.3)
    alike(found.data, expected.data, 2.0**-33, given)


@pytest.mark.exhaustive(keep=0.2)
def test_hinges_that_t_turns_do_not_hold_links_in_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is held there would be turned with t. Friction in other hinges may hold links."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    given = text(5, "one after the other", "points", "fixed", "none", 0.5)
    given = given.replace("th[0]: phi[0]", "th[0]: phi[0] + 0.3*sin(t)")
    rubbing = [f"dissipation: sum(3*abs(phi_dot[i]) for i in range({i}, N))\n" for i in (0, 1)]
    assert systems.any_family_system(read_spec(given + rubbing[0], "arm.yaml")) is None
    outputs, found = frozenset(["q", "v", "positions"]), []
    for count in (0, 10**9):
        fewest(monkeypatch, count)
        ready, motion = followed(given + rubbing[1], outputs, stop=0.3)
        assert ready.machine.program.loops == (count == 0)
        found.append(motion.data)
    alike(*found, 2.0**-33)
    assert np.any(found[0]["v/phi"][-1, 1:] == 0.0)


@pytest.mark.exhaustive(keep=0.2)
def test_long_arms_with_dry_friction_are_held_as_in_absolute_angles() -> None:
    """60 links. With members written out 15 took steps without an end."""
    relative = text(60, "one after the other", "points", "fixed", "none", 0.5)
    relative += "dissipation: sum(0.5*abs(phi_dot[i]) for i in range(N))\n"
    absolute = in_absolute_angles(relative)
    absolute = absolute.replace(
        "sum(0.5*abs(phi_dot[i]) for i in range(N))",
        "0.5*abs(th_dot[0]) + sum(0.5*abs(th_dot[i] - th_dot[i - 1]) for i in range(1, N))",
    )
    found, expected = (followed(one, frozenset(["q", "v"]), 0.2)[1] for one in (relative, absolute))
    assert found.outcome.steps <= 2 * expected.outcome.steps
    held = found["v/phi"] == 0.0
    assert np.any(held[-1]) and not np.all(held[-1])
    assert np.max(np.abs(np.cumsum(found["q/phi"], axis=1) - expected["q/th"])) < 2.0**-36


def in_absolute_angles(relative: str) -> str:
    """The same arm, with the directions of its links as coordinates."""
    absolute = relative.replace(
        '"phi[i in range(N)]": {initial: "0.5*sin(i + 0.5)", velocity: "0.3*cos(0.5*i)"}',
        '"th[i in range(N)]": {initial: "sum(0.5*sin(j + 0.5) for j in range(i + 1))", '
        'velocity: "sum(0.3*cos(0.5*j) for j in range(i + 1))"}',
    )
    absolute = absolute.replace(f"  {ANGLES['one after the other']}\n", "")
    return absolute.replace("cos(phi[i])", "cos(th[i] - th[i - 1])")


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_long_arms_take_as_many_steps_as_in_absolute_angles(method: str) -> None:
    """100 links. With members written out the accelerations, differences of large ones, had few digits, and
    20 links took 30 times as many steps."""
    relative = text(100, "one after the other", "points", "fixed", "none", 0.5)
    absolute = in_absolute_angles(relative)
    found, expected = (followed(one, WRITTEN - {"p"}, 0.2, method=method)[1] for one in (relative, absolute))
    assert found.outcome.steps <= 2 * expected.outcome.steps
    most = 2.0**-40 if method in ("taylor", "ias15") else 1e-7
    off = np.cumsum(found["q/phi"], axis=1) - expected["q/th"]
    assert np.max(np.abs(off)) < most


INLINE = """
sizes: {N: 14}
parameters: {l: 0.2, g: 9.81}
coordinates: {"phi[i in range(N)]": {initial: "0.5*sin(i + 0.5)"}}
masses: {"b[i in range(N)]": 1}
embedding:
  b[i in range(N)]:
    - sum(l*cos(sum(phi[k] for k in range(j + 1))) for j in range(i + 1))
    - sum(l*sin(sum(phi[k] for k in range(j + 1))) for j in range(i + 1))
potential: sum(g*b[i].y for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.35)
def test_sums_in_sums_are_those_of_definitions() -> None:
    """The sum of phi is written twice, and is one."""
    places = "\n".join(f"    - {name}[i]" for name in "xy")
    named = INLINE[: INLINE.index("    - sum")] + places + INLINE[INLINE.index("\npotential") :]
    named += """
definitions:
  th[i in range(N)]: sum(phi[j] for j in range(i + 1))
  x[i in range(N)]: sum(l*cos(th[j]) for j in range(i + 1))
  y[i in range(N)]: sum(l*sin(th[j]) for j in range(i + 1))
"""
    for given in (INLINE, named):
        assert is_relative(given)
    found, expected = (followed(one, WRITTEN, 0.3)[1].data for one in (INLINE, named))
    alike(found, expected, 2.0**-45)


@pytest.mark.parametrize(
    ("angle", "base", "up"),
    [
        ("2*phi[i]", "phi[0]", ""),  # x[0] has the coordinate itself, and th[0] twice of it
        ("phi[i % 3]", "th[0]", ""),  # one coordinate turns several links
        ("phi[i] + phi[(i + 1) % N]", "th[0]", ""),
        ("phi[i]", "th[0]", " + 0.01*phi[i]"),
    ],
)
def test_coordinates_that_are_no_differences_are_written_out(angle: str, base: str, up: str) -> None:
    given = f"""
sizes: {{N: 12}}
coordinates: {{"phi[i in range(N)]": {{initial: 0.1}}}}
definitions:
  th[i in range(N)]: where(i > 0, th[i - 1], 0) + {angle}
  x[0]: cos({base})
  x[i in range(1, N)]: x[i - 1] + cos(th[i])
  y[0]: sin({base})
  y[i in range(1, N)]: y[i - 1] + sin(th[i])
masses: {{"b[i in range(N)]": 1}}
embedding: {{"b[i in range(N)]": ["x[i]", "y[i]{up}"]}}
potential: sum(b[i].y for i in range(N))
"""
    assert systems.any_family_system(read_spec(given, "arm.yaml")) is None
    simple = given.replace(up or "none", "").replace(angle, "phi[i]").replace(f"({base})", "(th[0])")
    assert systems.any_family_system(read_spec(simple, "arm.yaml")) is not None


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_links_that_rest_are_those_that_others_hang_from(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first link has a fixed direction."""
    given = """
sizes: {N: 5}
parameters: {l: 0.2, g: 9.81, a: 0.3}
coordinates: {"phi[i in range(N)]": {initial: "0.1 + 0.05*i"}}
definitions:
  th[0]: a
  th[i in range(1, N + 1)]: th[i - 1] + phi[i - 1]
  x[0]: l*cos(th[0])
  x[i in range(1, N + 1)]: x[i - 1] + l*cos(th[i])
  y[0]: l*sin(th[0])
  y[i in range(1, N + 1)]: y[i - 1] + l*sin(th[i])
masses: {"b[i in range(N + 1)]": 1}
embedding: {"b[i in range(N + 1)]": ["x[i] - l/2*cos(th[i])", "y[i] - l/2*sin(th[i])"]}
potential: sum(g*b[i].y for i in range(N + 1)) + sum(0.1*th[i]**2 for i in range(N + 1))
dissipation: sum(0.1*phi_dot[i]**2 for i in range(N))
"""
    is_as_written_out(given, method, outputs_of(given), monkeypatch)
