"""Constraints and observables whose families lack members, beside the same systems written out member by
member: triangles, strips, and what satisfies random conditions."""

from __future__ import annotations

import random
import runpy
from pathlib import Path

import h5py
import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.errors import SpecError
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from lagrange_cli.store.csv_file import column_names
from lagrange_cli.store.layout import Series, labels
from tests.support.families import alike, begun, followed
from tests.support.motion import FULL

OUTPUTS = frozenset(["q", "v", "h", "constraints", "multipliers", "observables"])
SIZES = 1, 2, 3, 8, 9
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{k: 1.5}}
coordinates:
  x[i in range(N)]: {{initial: 0.3 + 0.1*i, velocity: 0.2}}
  u[i in range(N), j in range(N)]:
    initial: 0.3*(0.3 + 0.1*i)*(0.3 + 0.1*j) + 0.1*i
    velocity: 0.06*(0.6 + 0.1*i + 0.1*j)
masses: {{"a[i in range(N)]": 1 + i/7, "b[i in range(N), j in range(N)]": "1"}}
positions: {{"a[i in range(N)]": ["x[i]"], "b[i in range(N), j in range(N)]": ["u[i,j]"]}}
potential: >-
  sum(k*x[i]**2/2 for i in range(N)) + sum(k*(u[i,j] - 1)**2/2 for i in range(N) for j in range(N))
{section}:
{constraints}
observables:
{observables}
"""
"""Each constraint has a coordinate of its own, so that any of them go together."""
HELD = {
    "constraints": "u[i,j] - 0.3*x[i]*x[j] - 0.1*i",
    "nonholonomic": "u_dot[i,j] - 0.3*(x_dot[i]*x[j] + x[i]*x_dot[j])",
}


def condition(chance: random.Random, depth: int = 2) -> str:
    """A condition on i and j."""
    kind = chance.choice(["%", "<", "and", "or", "not"]) if depth else "%"
    if kind in ("and", "or"):
        return f"({condition(chance, depth - 1)} {kind} {condition(chance, depth - 1)})"
    if kind == "not":
        return f"not {condition(chance, depth - 1)}"
    left = f"{chance.randint(1, 3)}*i + {chance.randint(1, 3)}*j"
    if kind == "<":
        return f"{left} {chance.choice(['<', '>=', '!='])} {chance.randint(1, 3)}*N - {chance.randint(0, 3)}"
    modulus = chance.randint(2, 4)
    return f"({left}) % {modulus} {chance.choice(['==', '!=', '<'])} {chance.randint(1, modulus - 1)}"


def keys(chance: random.Random, name: str) -> list[str]:
    """The keys of a family: one piece, or a piece on each side of the diagonal."""
    lower, upper = ("j in range(i)", "j in range(i, N)")
    step = f"j in range({chance.randint(0, 1)}, N, {chance.randint(2, 3)})"
    pieces = chance.choice([[lower], [upper], ["j in range(N)"], [step], [lower, upper]])
    some = (f" if {condition(chance)}" if chance.random() < 0.8 else "" for _ in pieces)
    return [f"{name}[i in range(N), {piece}{own}]" for piece, own in zip(pieces, some)]


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    section = chance.choice([*HELD])
    constraints = [f'  "{key}": {HELD[section]}' for key in keys(chance, "hold")]
    observables = [f'  "{key}": (x[i] - x[j])**2 + u[i,j]' for key in keys(chance, "gap")]
    observables.append("  odd[i in range(N) if (i + 1) % 2]: x[i]")
    return SYSTEM.format(
        count=chance.choice(SIZES), section=section, constraints="\n".join(constraints),
        observables="\n".join(observables),
    )  # fmt: skip


def triangle(count: int) -> str:
    """A system with a constraint and an observable for each pair of neighbours."""
    return SYSTEM.format(
        count=count, section="constraints",
        constraints=f"  hold[i in range(N), j in range(i) if i - j < 3]: {HELD['constraints']}",
        observables="  gap[i in range(N), j in range(i)]: x[i] - x[j]\n  odd[i in range(1, N, 2)]: x[i]",
    )  # fmt: skip


def in_loops(monkeypatch: pytest.MonkeyPatch, yes: bool) -> None:
    """Let systems be followed in loops, or member by member, however small they are."""
    for name in ("FEWEST", "FEWEST_BOUND"):
        monkeypatch.setattr(systems, name, 0 if yes else 10**9)


@pytest.mark.exhaustive(keep=0.15, most=12)
@pytest.mark.parametrize("case", range(60))
def test_families_without_some_members_are_written_as_their_members_are(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} {case}"))
    try:
        begun(text)
    except SpecError as error:  # none satisfies the condition
        assert "no members" in str(error) or "empty range" in str(error), text
        return
    in_loops(monkeypatch, True)
    assert systems.family_system(begun(text)[0]) is not None, text
    together, motion = followed(text, OUTPUTS)
    in_loops(monkeypatch, False)
    apart, expected = followed(text, OUTPUTS)
    assert together.machine.program.loops and not apart.machine.program.loops
    assert together.recording.datasets == apart.recording.datasets, text
    alike(motion.data, expected.data, 2.0**-40, text)
    spec, printed = read_spec(text, "system.yaml"), None
    printed = derive_printed(spec, "lagrange", indexed=True)
    assert isinstance(printed, DerivedFamilies)
    if len(spec.coordinates) <= 20:
        assert verify_families(printed, {}).difference < 1e-12, text


@pytest.mark.exhaustive(keep=0.2)
def test_what_is_said_of_pairs_does_not_grow_with_them() -> None:
    def counted(count: int) -> tuple[int, int]:
        spec, _ = begun(triangle(count))
        system = systems.family_system(spec)
        assert system is not None and system.bonds is not None
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", FULL, OUTPUTS))
        rounds = len(system.bonds.elimination.rounds)  # type: ignore[union-attr]
        return len(system.slots.graph.nodes), len(ready.machine.program.text.splitlines()) // rounds

    (nodes, lines), (more, longer) = counted(8), counted(16)
    assert nodes == more
    assert longer <= lines


@pytest.mark.exhaustive(keep=0.5)
def test_the_file_lists_the_members_that_there_are(tmp_path: Path) -> None:
    lagrange_cli.solve(triangle(4), stop=0.1, samples=2, outputs=[*OUTPUTS]).save(tmp_path / "pairs.h5")
    pairs = [(i, j) for i in range(4) for j in range(i)]
    with h5py.File(tmp_path / "pairs.h5") as file:
        gap, q = file["observables/gap"], file["q/x"][:]
        scale = gap.dims[1][0]
        assert scale.name == "/gap_index"
        assert scale.asstr()[:].tolist() == [f"{i},{j}" for i, j in pairs]
        assert gap[:].tolist() == [[row[i] - row[j] for i, j in pairs] for row in q]
        assert file["observables/odd"].dims[1][0][:].tolist() == [1, 3]
        near = [f"{i},{j}" for i, j in pairs if i - j < 3]
        for path in ("multipliers/hold", "diagnostics/constraints/hold"):
            assert file[path].dims[1][0].asstr()[:].tolist() == near
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(tmp_path / "pairs.h5", group="observables") as found:
        assert found.gap.sel(gap_index="3,1").values.tolist() == (q[:, 3] - q[:, 1]).tolist()


def test_tables_name_the_members_that_there_are() -> None:
    places = ((1, 0), (2, 1))
    gap = Series("observables/gap", (2, 2), axes=("gap_index",), components=2, places=places)
    assert column_names([gap]) == ["t", "gap[1,0].x", "gap[1,0].y", "gap[2,1].x", "gap[2,1].y"]
    assert [*labels(places)] == ["1,0", "2,1"]
    assert [*labels(((1,), (3,)))] == [1, 3]


@pytest.mark.exhaustive(keep=0.6)
def test_the_module_in_python_has_the_accelerations_of_the_members(tmp_path: Path) -> None:
    found = []
    for indexed in (True, False):
        path = tmp_path / f"{indexed}.py"
        path.write_text(lagrange_cli.equations(triangle(3), indexed=indexed).write("python"))
        found.append(runpy.run_path(str(path)))
    chance = np.random.default_rng(1)
    q, v = chance.normal(size=(2, len(found[0]["COORDINATES"]))).tolist()
    for name in ("accelerations", "multipliers"):
        one, other = (module[name](0.0, q, v) for module in found)
        assert np.allclose(one, other, rtol=1e-12, atol=1e-12)
