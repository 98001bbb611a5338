"""Constraints where M is constant but not diagonal, beside the same systems written out member by member."""

from __future__ import annotations

import random
from dataclasses import dataclass

import numpy as np
import pytest

from lagrange_cli.families import consistency, elimination
from lagrange_cli.families import system as systems
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.model.start import shortest
from lagrange_cli.native.llvm import length
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_closed_chains import exactly_followed
from tests.families.test_coupled_masses import KINETIC as COUPLED
from tests.families.test_coupled_masses import OWN
from tests.support.families import alike, followed

SIZES = 3, 4, 8, 9, 17
OUTPUTS = frozenset(["q", "v", "p", "h", "T", "U", "constraints", "multipliers", "conserved"])
PLACES = {"u": "0.2*({} + 1) + sin({})/9", "w": "cos(2*({}))/2"}
"""The coordinates at the start."""
KINETIC = {
    **{name: COUPLED[name] for name in ("neighbours", "elements", "two families", "some")},
    "all": f"{OWN} + sum(u_dot[i]*u_dot[j]/(4*N) for i in range(N) for j in range(N))",
}
PARTICLES = """
masses: {'bead[i in range(N)]': '1 + i/7', 'other[i in range(N)]': 2.0}
embedding:
  bead[i in range(N)]: ["u[i] - w[(i + 1) % N]/3", "k*u[i]"]
  other[i in range(N)]: "k*w[i] + u[(2*i) % N]/2"
"""
POTENTIALS = {
    "springs": "sum(k*(u[i + 1] - u[i])**2/2 for i in range(N - 1)) + sum(w[i]**2 for i in range(N))",
    "waves": "sum(cos(u[i] + 2*w[i]) for i in range(N))",
    "pairs": "sum(u[i]*w[i] + (u[i] - w[(i + 1) % N])**4/4 for i in range(N))",
}
FORCES = {
    "none": "",
    "pushes": "generalized_forces: {'u[i in range(N)]': 0.3*sin(2*t + i)}",
    "drag": "dissipation: sum(u_dot[i]**2/20 + w_dot[i]*u_dot[i]/30 for i in range(N))",
}
HOLONOMIC = {
    "a pin": "pin: u[0] - {u0}",
    "links": "link[i in range(N//3)]: u[3*i] - w[3*i + 1] - ({u3} - {w3})",
    "curves": "curve[i in range(N//2)]: sin(u[2*i]) + w[2*i]*u[2*i] - sin({u2}) - {w2}*{u2}",
    "a mean": "mean: sum(u[i] for i in range(N)) - sum({ui} for i in range(N))",
    "a sphere": "whole: sum(u[i]**2 + w[i]**2 for i in range(N)) - sum({ui}**2 + {wi}**2 for i in range(N))",
    "a drive": "drive: w[0] - {w0} - t**2/3",
    "a turning line": "line: u[1]*cos(t) + w[1]*sin(t) - {u1}",
}
NONHOLONOMIC = {
    "a skate": "skate: cos(u[2])*u_dot[1] - sin(u[2])*w_dot[2]",
    "rolling": "roll[i in range(N//2)]: w_dot[2*i + 1] - u[2*i]*u_dot[2*i]",
    "a speed": "speed: u_dot[N - 1] + w_dot[N - 1]/2 - cos(t)/5",
}


def places() -> dict[str, str]:
    """The coordinates at the start, as constraints need them."""
    found = {}
    for name, text in PLACES.items():
        for key, index in {"0": "0", "1": "1", "3": "3*i", "2": "2*i", "i": "i"}.items():
            value = text.format(index, index)
            found[f"{name}{key}"] = f"({value})"
    found["w3"] = f"({PLACES['w'].format('3*i + 1')})"
    return found


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    potential = POTENTIALS[chance.choice(sorted(POTENTIALS))]
    if chance.random() < 0.3:
        kinetic = f"{PARTICLES}potential: {potential}"
    else:
        kinetic = f"lagrangian: >-\n  {KINETIC[chance.choice(sorted(KINETIC))]}\n  - ({potential})"
    bound = chance.sample(sorted(HOLONOMIC), chance.randint(0, 2))
    rolling = chance.sample(sorted(NONHOLONOMIC), chance.randint(0 if bound else 1, 1))
    return text_of(
        kinetic, chance.choice(SIZES), FORCES[chance.choice(sorted(FORCES))],
        [HOLONOMIC[one] for one in bound], [NONHOLONOMIC[one] for one in rolling],
    )  # fmt: skip


def text_of(kinetic: str, count: int, forces: str, holonomic: list[str], nonholonomic: list[str]) -> str:
    """The text of a system."""
    known = places()
    lines = [f"sizes: {{N: {count}}}", "parameters: {k: 1.5}", "coordinates:"]
    for name, value in PLACES.items():
        lines.append(f'  {name}[i in range(N)]: {{initial: "{value.format("i", "i")}"}}')
    lines += [kinetic, forces]
    for key, listed in (("constraints", holonomic), ("nonholonomic", nonholonomic)):
        written = [one.format(**known).split(": ", 1) for one in listed]
        lines += [f"{key}:"] * bool(listed) + [f'  {name}: "{text}"' for name, text in written]
    return "\n".join(lines)


def coupled(text: str) -> FamilySystem:
    """A system that is one of families, with constraints and an M that is not diagonal."""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None and system.saddle is not None, text
    return system


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", range(60))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} coupled {case}")
    text, method = drawn(chance), chance.choice(["taylor", "taylor", "ias15", "DOP853", "Radau"])
    in_loops(monkeypatch, loops=True)
    coupled(text)
    together, found = followed(text, OUTPUTS, method=method)
    assert together.machine.program.loops
    in_loops(monkeypatch, loops=False)
    apart, expected = followed(text, OUTPUTS, method=method)
    assert not apart.machine.program.loops
    own, others = ({one.path for one in each.recording.datasets} for each in (together, apart))
    assert {path for path in own ^ others if "conserved" not in path} == set()
    shared = {path: values for path, values in expected.data.items() if path in found.data}
    alike(found.data, shared, 2.0**-40 if method in ("taylor", "ias15") else 1e-8, text, method)
    for path, values in found.data.items():
        if "conserved" in path or ("constraints" in path and method != "DOP853"):
            assert np.ptp(values) < 1e-9 if method == "DOP853" else 1e-13, (path, text)


def in_loops(monkeypatch: pytest.MonkeyPatch, *, loops: bool) -> None:
    """Members are followed in loops however few, or never."""
    for least in ("FEWEST", "FEWEST_BOUND"):
        monkeypatch.setattr(systems, least, 0 if loops else 10**9)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("case", range(12))
def test_dense_factors_give_the_same(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} dense {case}"))
    in_loops(monkeypatch, loops=True)
    _, expected = followed(text, OUTPUTS)
    monkeypatch.setattr(elimination, "MOST", 0)
    monkeypatch.setattr(systems, "_LATEST", [])
    assert coupled(text).saddle.elimination is None  # type: ignore[union-attr]
    _, found = followed(text, OUTPUTS)
    alike(found.data, expected.data, 2.0**-40, text)  # velocities to 100 ulp make multipliers to 1000


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(12))
def test_motions_in_double_double(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, motions = drawn(random.Random(f"{pytestconfig.option.seed} long {case}")), []
    monkeypatch.setattr(length, "MOST_INSTRUCTIONS", 10**7)  # those of 34 members, written out
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = exactly_followed(text, frozenset(["q", "v", "h", "multipliers", "constraints"]))
        assert ready.machine.program.loops == loops
        motions.append(motion.data)
    alike(*motions, 2.0**-92, text)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("case", range(20))
def test_starts_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where values are moved, with velocities."""
    text = drawn(random.Random(f"{pytestconfig.option.seed} starts {case}"))
    text = text.replace('/9"}', '/9 + 1e-4*sin(7*i)", velocity: "0.01*cos(i)"}', 1)
    found = []
    for few in (0, 10**6):
        for name in ("FEWEST", "DENSE"):
            monkeypatch.setattr(consistency, name, few)
        monkeypatch.setattr(shortest, "DENSE", few)
        monkeypatch.setattr(consistency, "_LATEST", [])
        spec = read_spec(text, "system.yaml")
        if few == 0:
            known = consistency.whole(spec)
            assert known is None or known.coupled is not None or known.joints is not None
        spec, values, _ = consistent_values(spec, resolve_values(spec, {}), 0.0, (), forced=True)
        found.append((np.array([*values.q, *values.v]), spec.left_out))
    (one, left), (other, others) = found
    assert left == others
    assert np.max(np.abs(one - other)) < 2.0**-40, text  # the least change is found by iteration


@dataclass(frozen=True)
class Clamped:
    """A rod of ``count`` finite elements of length 1, with consistent masses, the first end held by a
    constraint: standing waves sin(a x) with a = pi (number + 1/2)/count have the frequency of the elements,
    w^2 = 6 (1 - cos a)/(2 + cos a), and the support the force of the last element."""

    count: int
    number: int

    @property
    def wave(self) -> float:
        return float(np.pi * (self.number + 0.5) / self.count)

    @property
    def frequency(self) -> float:
        return float(np.sqrt(6 * (1 - np.cos(self.wave)) / (2 + np.cos(self.wave))))

    @property
    def text(self) -> str:
        return f"""
sizes: {{N: {self.count}}}
coordinates: {{"u[i in range(N + 1)]": {{initial: "0.01*sin(pi*{self.number + 0.5}*i/N)"}}}}
lagrangian: >-
  sum((u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 - (u[i + 1] - u[i])**2/2 for i in range(N))
constraints: {{end: "u[0]"}}
"""


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_standing_waves_of_a_clamped_rod(method: str) -> None:
    """The force of the support is that which the first element's equation lacks: M_01 a_1 - K_01 u_1."""
    rod, stop = Clamped(200, 40), 10.0
    outputs = frozenset(["q", "h", "multipliers", "constraints"])
    ready, motion = followed(rod.text, outputs, stop=stop, samples=11, method=method)
    assert ready.machine.program.loops
    x, t = np.arange(rod.count + 1), np.linspace(0.0, stop, 11)
    shape = np.cos(rod.frequency * t)
    exact = 0.01 * np.sin(rod.wave * x) * shape[:, None]
    least = 1e-9 if method == "DOP853" else 2e-15
    assert np.max(np.abs(motion["q/u"] - exact)) < least
    force = 0.01 * np.sin(rod.wave) * shape * (-(rod.frequency**2) / 6 - 1)
    assert np.max(np.abs(motion["multipliers/end"] - force)) < least
    assert np.ptp(motion["diagnostics/h"]) < least
    assert np.max(np.abs(motion["diagnostics/constraints/end"])) < 1e-17


@pytest.mark.exhaustive(keep=0.4)
def test_the_program_does_not_grow_with_the_members() -> None:
    def counted(count: int) -> int:
        return len(
            followed(Clamped(count, 1).text, OUTPUTS - {"T", "U"})[0].machine.program.text.splitlines()
        )

    assert counted(1500) <= 1.1 * counted(400)  # the last eight unknowns or fewer are written one by one


@pytest.mark.exhaustive(keep=0.45)
def test_masses_that_constraints_complete_go_through_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beads halfway between N + 1 places say nothing of a motion that alternates: M is singular, and with a
    constraint the equations are not."""
    text = """
sizes: {N: 9}
coordinates: {"x[i in range(N + 1)]": {initial: "0.1*cos(i)"}}
masses: {"b[i in range(N)]": 1}
embedding: {"b[i in range(N)]": ["(x[i] + x[i + 1])/2"]}
potential: sum((b[i].x - b[i + 1].x)**2/2 for i in range(N - 1))
constraints: {c: "x[0] - x[3] - 0.1*(1 - cos(3))"}
"""
    in_loops(monkeypatch, loops=True)
    ready, motion = followed(text, frozenset(["q", "h"]))
    assert not ready.machine.program.loops
    assert np.ptp(motion["diagnostics/h"]) < 1e-15
    held = text.replace('"x[0] - x[3] - 0.1*(1 - cos(3))"', "x[0] - 0.1").replace(
        'masses: {"b[i', 'masses: {"a[i in range(N + 1)]": 0.1, "b[i'
    )
    held = held.replace('embedding: {"b[i', 'embedding: {"a[i in range(N + 1)]": ["x[i]"], "b[i')
    assert followed(held, frozenset(["q"]))[0].machine.program.loops


PAIRS = """
sizes: {{N: 9}}
coordinates: {{"x[i in range(N)]": {{initial: "0.1*sin(i)"}}}}
masses: {{"b[i in range(N)]": 1, "a[i in range(N - 1)]": 2}}
embedding: {{"b[i in range(N)]": ["x[i]", "2*x[i]"], "a[i in range(N - 1)]": ["(x[i] + x[i + 1])/2"]}}
potential: sum((b[i].x - b[i + 1].x)**2/2 for i in range(N - 1))
{constraints}
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("constraints", ["", "constraints: {c: x[1]*x[2] - 0.01*sin(1)*sin(2)}"])
def test_reactions_are_those_of_the_members(constraints: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rods that carry beads, with accelerations that are found together."""
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(PAIRS.format(constraints=constraints), frozenset(["q", "reactions"]))
        assert ready.machine.program.loops == loops
        motions.append(motion.data)
    assert np.max(np.abs(motions[0]["reactions/a"])) > 0.01
    alike(*motions, 2.0**-48)


@pytest.mark.exhaustive(keep=0.2)
def test_ledgers_have_the_work_of_constraints() -> None:
    """A driven end, a constraint that bends, and one on velocities."""
    text = Clamped(120, 3).text.replace(
        '{end: "u[0]"}',
        '{end: "u[0] - 0.01*t**2", bent: "u[3]**2 + u[5] - u3**2 - u5"}\n'
        "parameters: {u3: 0.01*sin(pi*3.5*3/N), u5: 0.01*sin(pi*3.5*5/N)}\n"
        'nonholonomic: {roll: "u_dot[9] - u[8]*u_dot[7]"}\ngeneralized_forces: {"u[20]": "0.1*sin(t)"}',
    )
    ready, motion = followed(text, frozenset(["q", "ledger", "constraints", "action"]), stop=2.0)
    assert ready.machine.program.loops
    found = [values for path, values in motion.data.items() if "ledger" in path or "constraints" in path]
    assert len(found) == 5
    assert max(float(np.max(np.abs(one))) for one in found) < 1e-16
