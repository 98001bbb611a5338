"""Systems whose families stay families, beside the same systems written out member by member."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.families.long_values import LongNumbers
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.families import alike, followed
from tests.support.motion import run

OUTPUTS = frozenset(["q", "v", "p", "h", "observables"])
SIZES = 1, 2, 3, 8, 9, 17
PIECES = {
    "a ring": "k/2*sum((u[(i + 1) % N] - u[i])**2 for i in range(N))",
    "a chain": "sum((u[i] - u[i - 1])**2/2 + (u[i] - u[i - 1])**3/{a} for i in range(1, N))",
    "walls": "sum(where(i == 0 or i == N - 1, {b}, 0.1*i)*u[i]**2/2 for i in range(N))",
    "pairs": "-sum(g[i]*g[j]/sqrt({b} + (u[i] - u[j])**2) for i in range(N) for j in range(i))",
    "some pairs": "sum(cos(u[i] - u[j])/{a} for i in range(N) for j in range(N) if i != j and (i + j) % 3)",
    "neighbours": "sum((u[i] - u[j])**4/{a} for i in range(N) for j in range(N) if abs(i - j) == 1)",
    "a chain to its end": "sum(w[i]*u[min(i + 2, N - 1)]**2/{a} for i in range(N))",
    "pairs of two families": "sum(sin(u[i])*w[j]/{a} for i in range(N) for j in range(N))",
    "pendulums": "sum((1 - cos(u[i]))*(i + 1)/{a} for i in range(N))",
    "time": "sum(w[i]*cos({b}*t + i) for i in range(N))",
    "a definition": "sum(stretch[i]**4/{a} for i in range(N + 1))",
    "a running sum": "sum(cos(run[i])*w[i]/{a} for i in range(N))",
    "a square of a sum": "k*sum(u[i] for i in range(N))**2/{a}",
    "sums in sums": "sum((u[i] - sum(w[j]/N for j in range(N)))**2/2 for i in range(N))",
    "an exponent": "sum(u[i]**(2 + 2*(i % 2))/{a} for i in range(N))",
    "a Toda ring": "sum(exp(u[i] - u[(i + 1) % N])/{a} for i in range(N))",
    "bonds": "sum((1 - exp(-{b}*(w[i] - 0.1*k)))**2/{a} for i in range(N))",
    "angles": "sum(cos(atan2(u[i], w[i] - 2) - 3*atan2(u[i - 1], w[i]*u[i] - 1))/{a} for i in range(1, N))",
    "squares of angles": "sum(atan2(w[i], u[i] - 3)**2/{a} for i in range(N))",
    "steep ones": "sum((1.5 + u[i] + w[i]/4)**(-6)/{a} for i in range(N))",
    "a step": "sum(g[i]*tanh({b}*u[i])/{a} + atan(k*w[i]) for i in range(N))",
    "a steep running sum": "sum(exp(-run[i]/2)*w[i]/{a} for i in range(N))",
    "a steep sum of all": "exp(sum(u[i] for i in range(N))/N)/{a}",
    "a magnetic field": "sum({b}*(w[i]*u_dot[i] - u[i]*w_dot[i])/2 for i in range(N))",
    "a field of others": "sum(sin(u[i] - w[j])*u_dot[j]/{a} for i in range(N) for j in range(N) if i != j)",
    "a field that grows": "sum(t*u[i]**2*w_dot[(i + 1) % N]/{a} for i in range(N))",
    "a flux": "sum(w[i] for i in range(N))**2*sum(g[i]*u_dot[i] for i in range(N))/{a}",
    "a field along a chain": "sum(run[i]**2*u_dot[i]/{a} for i in range(N))",
    "a gauge": "sum(cos(u[i]*w[i])*(u[i]*w_dot[i] + w[i]*u_dot[i]) + u[i]**4 + w[i]**4 for i in range(N))",
    "every other one": "sum(w[i]**2/2 for i in range(0, N, 2)) + sum(w[i]**2 for i in range(1, N, 2))",
}
FORCES = {
    "none": "",
    "drive": 'generalized_forces: {{"u[i in range(N)]": "sin({b}*t + i) - 0.1*u_dot[i]*u[i]"}}',
    "headings": 'generalized_forces: {{"w[i in range(N)]": "0.1*sin(3*atan2(u_dot[i], w_dot[i] - 1))"}}',
    "one": 'generalized_forces: {{"w[0]": "cos(t)/{a}"}}',
    "damping": "dissipation: sum((u_dot[i] - w_dot[i])**2/{a} for i in range(N))",
}
DEFINED = {"a definition", "a running sum", "a steep running sum", "a field along a chain"}
STRETCH = (
    '{"stretch[0]": "u[0]", "stretch[i in range(1, N)]": "u[i] - u[i - 1]", "stretch[N]": "-u[N - 1]",'
    ' "run[0]": "u[0]", "run[i in range(1, N)]": "run[i - 1] + w[i]*k"}'
)
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{k: {k}, "g[i in range(N)]": "0.3 + 0.1*sin(i)"}}
coordinates:
  u[i in range(N)]: {{initial: "0.5*sin({seed} + i)", velocity: "0.1*cos({seed}*i)"}}
  w[i in range(N)]: {{initial: "0.2*cos({seed} + 2*i)", velocity: 0.1}}
definitions: {definitions}
{kinetic}
{forces}
observables:
  mode[j in range(2)]: sum(u[i]*sin(pi*(i + 1)*(j + 1)/(N + 1)) for i in range(N))
  speed: sum(u_dot[i]**2 for i in range(N))
solve: {{stop: 0.5, step: 0.1}}
"""


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    count = chance.choice(SIZES)
    numbers = {"a": chance.choice([7, 10, 16]), "b": chance.choice([0.5, 1.25, 2])}
    known = sorted(PIECES.keys() - (DEFINED if count == 1 else set()))
    pieces = chance.sample(known, chance.randint(2, 4))
    potential = " + ".join(f"({PIECES[name].format(**numbers)})" for name in pieces)
    if chance.random() < 0.5:
        mass = chance.choice(["1 + i/7", "where(i % 3 == 1, k, 1 + i/7)"])
        kinetic = (
            f"masses: {{'bead[i in range(N)]': '{mass}', 'other[i in range(N)]': 2.0}}\n"
            "embedding: {'bead[i in range(N)]': ['u[i]', 3.0], 'other[i in range(N)]': 'k*w[i] - i'}\n"
            f"potential: {potential}"
        )
    else:
        kinetic = (
            "lagrangian: >-\n  sum((1 + i/7)*u_dot[i]**2/2 + k*w_dot[i]**2 for i in range(N))\n  - "
            f"({potential})"
        )
    forces = FORCES[chance.choice(sorted(FORCES))].format(**numbers)
    given = {
        "count": count,
        "definitions": STRETCH if count > 1 else "{}",
        "k": chance.choice([1.5, 2]),
        "seed": chance.randint(1, 9),
    }
    return SYSTEM.format(kinetic=kinetic, forces=forces, **given)


@pytest.mark.exhaustive(keep=0.25, most=12)
@pytest.mark.parametrize("case", range(60))
def test_families_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {case}")
    text, method = drawn(chance), chance.choice(["taylor", "ias15"])
    monkeypatch.setattr(systems, "FEWEST", 0)
    assert systems.family_system(read_spec(text, "system.yaml")) is not None, text
    together, found = followed(text, OUTPUTS, method=method)
    monkeypatch.setattr(systems, "FEWEST", 10**9)
    apart, expected = followed(text, OUTPUTS, method=method)
    assert together.recording.datasets == apart.recording.datasets
    assert set(together.recording.conserved) <= set(apart.recording.conserved)
    alike(found.data, expected.data, 2.0**-43, text)


@pytest.mark.exhaustive(keep=0.15)
def test_what_is_said_of_a_family_does_not_grow_with_it() -> None:
    def counted(count: int) -> tuple[int, int]:
        text = SYSTEM.format(
            count=count, definitions=STRETCH, k=2, seed=1, forces=FORCES["drive"].format(b=2),
            kinetic="lagrangian: >-\n  sum(u_dot[i]**2/2 + w_dot[i]**2/2 for i in range(N))"
            + "".join(f"\n  - ({PIECES[name].format(a=7, b=2)})" for name in sorted(PIECES)),
        )  # fmt: skip
        spec = read_spec(text, "system.yaml")
        system = systems.family_system(spec)
        assert system is not None
        ready = prepare_system(spec, derive_system, None, Compilation("ias15", 2.0**-52, OUTPUTS))
        return len(system.slots.graph.nodes), len(ready.machine.program.text.splitlines())

    assert counted(40) == counted(64)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "change",
    {
        "a kink": ("k/2", "abs(u[0]) + k/2"),
        "velocities in U": ("k/2", "u_dot[0]**3*w[0] + k/2"),
        "a mass that moves": ("sum(u_dot[i]**2/2", "u[0]**2*w_dot[0]**2/2 + sum(u_dot[i]**2/2"),
    }.items(),
    ids=lambda change: change[0],
)
def test_other_systems_go_through_their_members(
    change: tuple[str, tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = SYSTEM.format(
        count=3, definitions=STRETCH, k=2, seed=1, forces="",
        kinetic=f"lagrangian: sum(u_dot[i]**2/2 + w_dot[i]**2/2 for i in range(N)) - {PIECES['a ring']}",
    )  # fmt: skip
    assert systems.family_system(read_spec(text, "system.yaml")) is not None
    old, new = change[1]
    assert old in text
    assert systems.family_system(read_spec(text.replace(old, new, 1), "system.yaml")) is None


def test_springs_between_headings_keep_energy_and_angular_momentum(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is conserved is found from values of the forces."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = """
sizes: {N: 4}
coordinates: {"x[i in range(N)]": {initial: i}, "y[i in range(N)]": {initial: 1}}
masses: {"tip[i in range(N)]": 1 + i}
embedding: {"tip[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(cos(atan2(y[i], x[i]) - atan2(y[i - 1], x[i - 1])) for i in range(1, N))
"""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None
    assert {one.quantity for one in constants_of(system).conserved} == {"h", "L_z"}
    forces = FamilyValues(system, 0.0, np.arange(1.0, 9.0), np.zeros(8), np.zeros(0), kind=LongNumbers())
    plain = FamilyValues(system, 0.0, np.arange(1.0, 9.0), np.zeros(8), np.zeros(0))
    assert np.max(np.abs(forces.of(system.forces) - plain.of(system.forces))) < 1e-15


def test_definitions_that_follow_from_one_another_otherwise_go_through_their_members(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = """
sizes: {N: 30}
coordinates: {"s[i in range(N)]": {initial: 0.1}}
definitions:
  x[0]: s[0]
  x[i in range(1, N)]: HOW
lagrangian: sum(s_dot[i]**2/2 for i in range(N)) - sum(x[i]**2/2 for i in range(N))
"""
    for how, stay in (
        ("x[i - 1] + s[i]", True),
        ("x[i - 1]/2 + s[i]", False),
        ("sin(x[i - 1]) + s[i]", False),
    ):
        found = systems.family_system(read_spec(text.replace("HOW", how), "system.yaml"))
        assert (found is not None) is stay, how


def test_charges_in_a_magnetic_field_move_on_circles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = """
sizes: {N: 9}
parameters: {B: 3}
coordinates: {"x[i in range(N)]": {initial: i, velocity: 1}, "y[i in range(N)]": {initial: 2}}
masses: {"ion[i in range(N)]": 1 + i}
embedding: {"ion[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(B*y[i]*x_dot[i] for i in range(N))
"""
    spec = read_spec(text, "system.yaml")
    system = systems.family_system(spec)
    assert system is not None
    found = {one.quantity for one in constants_of(system).conserved}
    momenta = {"h", *(f"p_x[{i}]" for i in range(9))}
    assert found == {*momenta, *(f"h_x[{i}]" for i in range(9))} and momenta == {*system.conserved}
    outputs = frozenset(["q", "p"])
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
    data = run(ready, resolve_values(spec, {}), 0.0, 1.0, 2).data
    turned = np.exp(-1j * 3 / (1 + np.arange(9)))
    place = np.arange(9) + 2j + (turned - 1) * (1 + np.arange(9)) / -3j
    assert np.max(np.abs(data["q/x"][-1] + 1j * data["q/y"][-1] - place)) < 1e-14
    assert np.max(np.abs(data["diagnostics/p/x"] - (np.arange(9) - 5))) < 1e-14


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_what_falls_freely_falls_as_galileo_says(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = """
sizes: {N: 9}
parameters: {g: 9.81}
coordinates: {"y[i in range(N)]": {initial: 2*i}}
masses: {"ball[i in range(N)]": 1 + i}
embedding: {"ball[i in range(N)]": "y[i]"}
potential: sum((1 + i)*g*y[i] for i in range(N))
"""
    spec = read_spec(text, "system.yaml")
    assert systems.family_system(spec) is not None
    ready = prepare_system(spec, derive_system, None, Compilation(method, 2.0**-52, frozenset(["q"])))
    found = run(ready, resolve_values(spec, {}), 0.0, 1.0, 2).data["q/y"][-1]
    assert np.max(np.abs(found - (2 * np.arange(9) - 9.81 / 2))) < 1e-13


@pytest.mark.exhaustive(keep=0.6)
def test_expressions_that_stand_alone_are_written_as_such() -> None:
    """Loops of one round save nothing: bonds that are written one by one, between members of a family, are
    compiled as those between coordinates with names of their own."""
    count, chance = 40, random.Random(5)
    ends = [(i, chance.randrange(i)) for i in range(1, count)] * 2
    text = f"""\
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: i}}, "y[i in range(N)]": {{initial: 0}}}}
masses: {{"p[i in range(N)]": 1}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: """
    written = text + " + ".join(f"(norm(p[{a}] - p[{b}]) - 1)**2" for a, b in ends)
    together = text + "sum((norm(p[i] - p[(i*i + j) % i]) - 1)**2 for i in range(1, N) for j in range(2))"
    assert systems.any_family_system(read_spec(written, "system.yaml")) is not None
    assert systems.family_system(read_spec(written, "system.yaml")) is None
    assert systems.family_system(read_spec(together, "system.yaml")) is not None
