"""Systems whose M is constant but not diagonal, beside the same systems written out member by member."""

from __future__ import annotations

import random
from dataclasses import dataclass

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.native.families import program
from lagrange_cli.native.stepping.coupling import full
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.families.test_closed_chains import exactly_followed
from tests.families.test_systems import FORCES, OUTPUTS, PIECES, STRETCH, SYSTEM
from tests.support.families import alike, followed

SIZES = 2, 3, 8, 9, 17
OWN = "sum((1 + i/7)*u_dot[i]**2/2 + k*w_dot[i]**2 for i in range(N))"
KINETIC = {
    "neighbours": f"{OWN} + sum(u_dot[i]*u_dot[i + 1]/4 for i in range(N - 1))",
    "elements": (
        "sum(k*(u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 for i in range(N - 1))"
        " + sum((w_dot[i] + w_dot[(i + 1) % N]/3)**2/2 for i in range(N))"
    ),
    "two families": f"{OWN} + sum(u_dot[i]*w_dot[i]/(3 + i) for i in range(N))",
    "all": f"{OWN} + sum(g[i]*g[j]*u_dot[i]*u_dot[j]/N for i in range(N) for j in range(N))",
    "one and all": f"{OWN} + sum(u_dot[0]*w_dot[i]/(2*N) for i in range(N))",
    "of either sign": (
        "sum((-1)**i*(1 + i/7)*u_dot[i]**2/2 + k*w_dot[i]**2 for i in range(N))"
        " + sum(u_dot[i]*u_dot[i + 1]/4 for i in range(N - 1))"
    ),
    "a sum": f"{OWN} + u_dot[0]*sum(w_dot[j]/9 for j in range(N))",
    "sums": f"{OWN} + sum(u_dot[i]*sum(w_dot[j]*(1 + i*j/9)/(9*N) for j in range(N)) for i in range(N))",
    "squares of sums": (
        f"{OWN} + sum(u_dot[i]/3 for i in range(N))**2"
        " + sum(sum(u_dot[i] - w_dot[j] for j in range(N) if j % 2 == i % 2)**2/50 for i in range(N))"
    ),
    "sums of sums": f"{OWN} + (u_dot[1]/2 + sum(k*w_dot[j]/5 for j in range(1, N)))**2/3",
    "some": f"{OWN} + sum(u_dot[i]*w_dot[(3*i) % N]/5 for i in range(N) if i % 2)",
}
PLACES = """
masses: {'bead[i in range(N)]': '1 + i/7', 'other[i in range(N)]': 2.0}
embedding:
  bead[i in range(N)]: ["u[i] - w[(i + 1) % N]/3", "k*u[i]"]
  other[i in range(N)]: "k*w[i] + u[(2*i) % N]/2 - i"
"""


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    numbers = {"a": chance.choice([7, 10, 16]), "b": chance.choice([0.5, 1.25, 2])}
    pieces = chance.sample(sorted(PIECES), chance.randint(1, 3))
    potential = " + ".join(f"({PIECES[name].format(**numbers)})" for name in pieces)
    if chance.random() < 0.3:
        kinetic = f"{PLACES}potential: {potential}"
    else:
        kinetic = f"lagrangian: >-\n  {KINETIC[chance.choice(sorted(KINETIC))]}\n  - ({potential})"
    return SYSTEM.format(
        kinetic=kinetic, forces=FORCES[chance.choice(sorted(FORCES))].format(**numbers),
        count=chance.choice(SIZES), definitions=STRETCH, k=chance.choice([1.5, 2]), seed=chance.randint(1, 9),
    )  # fmt: skip


def coupled(text: str) -> CoupledMasses:
    """The masses of a system that is one of families, with an M that is not diagonal."""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None and system.coupled_masses is not None, text
    return system.coupled_masses


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(40))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {case}")
    text, method = drawn(chance), chance.choice(["taylor", "ias15"])
    stop = chance.choice([0.5, -0.5])
    monkeypatch.setattr(systems, "FEWEST", 0)
    coupled(text)
    together, found = followed(text, OUTPUTS, method=method, stop=stop)
    monkeypatch.setattr(systems, "FEWEST", 10**9)
    apart, expected = followed(text, OUTPUTS, method=method, stop=stop)
    assert together.recording.datasets == apart.recording.datasets
    alike(found.data, expected.data, 2.0**-43, text)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("kind", ["neighbours", "all", "of either sign"])
def test_motions_in_double_double(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With sparse factors and with dense ones, and with pivots of either sign."""
    text = SYSTEM.format(
        kinetic=f"lagrangian: >-\n  {KINETIC[kind]}\n  - {PIECES['pairs'].format(b=2)}",
        forces="", count=9, definitions=STRETCH, k=2, seed=1,
    )  # fmt: skip
    motions = []
    for fewest in 0, 10**9:
        monkeypatch.setattr(systems, "FEWEST", fewest)
        ready, motion = exactly_followed(text, frozenset(["q", "v", "h"]))
        assert ready.machine.program.loops == (fewest == 0)
        motions.append(motion.data)
    alike(*motions, 2.0**-94, kind)


@dataclass(frozen=True)
class Rod:
    """A rod of ``count`` finite elements of length 1, with free ends, mass per length and stiffness 1: its
    standing waves are cos(pi n x/count), with w^2 = 6 (1 - cos a)/(2 + cos a), a = pi n/count (K.-J. Bathe,
    Finite Element Procedures, 1996, with consistent masses)."""

    count: int
    number: int

    @property
    def frequency(self) -> float:
        cosine = np.cos(np.pi * self.number / self.count)
        return float(np.sqrt(6 * (1 - cosine) / (2 + cosine)))

    @property
    def text(self) -> str:
        return f"""
sizes: {{N: {self.count}}}
coordinates: {{"u[i in range(N + 1)]": {{initial: "0.01*cos(pi*{self.number}*i/N)"}}}}
lagrangian: >-
  sum((u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 - (u[i + 1] - u[i])**2/2 for i in range(N))
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_standing_waves_of_finite_elements(method: str) -> None:
    """In loops, as there are many."""
    rod = Rod(200, 60)
    stop = 10.0
    ready, motion = followed(rod.text, frozenset(["q", "h"]), stop=stop, samples=11, method=method)
    assert ready.machine.program.loops
    x, t = np.arange(rod.count + 1), np.linspace(0.0, stop, 11)
    exact = 0.01 * np.cos(np.pi * rod.number * x / rod.count) * np.cos(rod.frequency * t[:, None])
    off = np.max(np.abs(motion["q/u"] - exact))
    assert off < (1e-15 if method != "DOP853" else 1e-9), off


def test_what_is_coupled_is_found_sparse_or_dense(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neighbours in a chain take a factor with few entries; a block of all is dense."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    chain = coupled(Rod(500, 1).text).elimination
    assert chain is not None and chain.entries < 2 * 501
    pairs = "for i in range(N) for j in range(N)"
    whole = f"lagrangian: sum(u_dot[i]*u_dot[j]/(1 + (i - j)**2) - u[i]*u[j]/9 {pairs})"
    text = f"sizes: {{N: 150}}\ncoordinates: {{'u[i in range(N)]': {{initial: 1}}}}\n{whole}"
    assert coupled(text).elimination is None


@pytest.mark.exhaustive(keep=0.35)
def test_the_program_does_not_grow_with_the_members() -> None:
    def counted(count: int) -> int:
        spec = read_spec(Rod(count, 1).text, "system.yaml")
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, OUTPUTS))
        return len(ready.machine.program.text.splitlines())

    assert counted(3000) <= 1.1 * counted(400)  # the last eight unknowns or fewer are written one by one


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    "change",
    [
        ("coordinates:", "events: {e: {when: u[0], action: {set: {u_dot[0]: -u_dot[0]/2}}}}\ncoordinates:"),
        ("forces: none", "generalized_forces: {'u[0]': -0.1*sign(u_dot[0])}"),
        ("u_dot[i]*u_dot[i + 1]/4", "abs(u[i])*u_dot[i]*u_dot[i + 1]/4"),
        ("u_dot[i]*u_dot[i + 1]/4", "cos(u[i])*u_dot[i]*sum(u_dot[j]/99 for j in range(N))"),
        ("u_dot[i]*u_dot[i + 1]/4", "sum(u_dot[j]*u_dot[0]/99 for j in range(N))**2"),
        ("u_dot[i]*u_dot[i + 1]/4", "sum(u_dot[j] + u[j]/99 for j in range(N))**2/99"),
    ],
    ids=["impacts", "friction", "masses with kinks", "sums times places", "fourth powers", "sums of both"],
)
def test_what_needs_the_inverse_goes_through_the_members(
    change: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    text = SYSTEM.format(
        kinetic=f"lagrangian: >-\n  {KINETIC['neighbours']}\n  - {PIECES['a ring'].format()}",
        forces="# forces: none", count=3, definitions=STRETCH, k=2, seed=1,
    ).replace("# forces", "forces")  # fmt: skip
    assert change[0] in text
    other = text.replace(*change, 1).replace("forces: none", "")
    assert systems.family_system(read_spec(text.replace("forces: none", ""), "system.yaml")) is not None
    assert systems.family_system(read_spec(other, "system.yaml")) is None


STIFF = """
sizes: {{N: {count}}}
coordinates:
  u[i in range(N)]: {{initial: "0.3*sin(3*i)", velocity: "0.2*cos(i)"}}
  w[i in range(N)]: {{initial: 0.1}}
lagrangian: >-
  sum((u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 for i in range(N - 1))
  - 450*sum((u[i + 1] - u[i])**2 for i in range(N - 1))
  + sum(w_dot[i]**2 + w_dot[i]*u_dot[(i + 3) % N]/4 - cos(w[i] - u[i]) for i in range(N))
dissipation: >-
  sum(40*(u_dot[i + 1] - u_dot[i])**2 for i in range(N - 1))
  + sum(w_dot[i]**2*(1 + u[i]**2) for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.15)
def test_implicit_steps_take_banded_matrices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of M and of the forces, in place of full ones: the motion is the same, in as many steps."""
    text, motions, steps = STIFF.format(count=30), [], []
    for banded in True, False:
        monkeypatch.setattr(systems, "_LATEST", [])
        if not banded:
            monkeypatch.setattr(program, "of_families", lambda system: full(system.q.count))
        ready, motion = followed(text, frozenset(["q", "v"]), method="Radau", stop=2.0)
        assert ready.machine.program.loops
        assert ("@pushed(" in ready.machine.program.text) == banded
        motions.append(motion.data)
        steps.append(motion.outcome.steps)
    alike(*motions, 1e-10)
    assert abs(steps[0] - steps[1]) <= 0.1 * steps[1], steps
    _, exact = followed(text, frozenset(["q", "v"]), stop=2.0)
    alike(motions[0], exact.data, 1e-10)
