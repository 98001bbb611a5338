"""Series of large systems computed block by block: the same bits as order by order."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.families import jets, series_places, tiling
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_lattices import PENDULUM
from tests.support.motion import Motion, run

CHAIN = """
sizes: {{N: {0}}}
coordinates: {{"u[i in range(N)]": {{initial: "sin(i*i)/3", velocity: "cos(i)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/N}}
embedding: {{"bead[i in range(N)]": "u[i]"}}
potential: {1}
"""
LATTICE = """
sizes: {{N: {0}, M: {1}}}
coordinates: {{"u[i in range(N), j in range(M)]": {{initial: "sin(i*i + 3*j)/3", velocity: "cos(i + j*j)"}}}}
lagrangian: >-
  sum(u_dot[i, j]**2/2 + cos(u[i, j]) - (u[(i + 1) % N, j] - u[i, j])**2
      - (u[i, (j + 1) % M] - u[i, j])**2 for i in range(N) for j in range(M))
"""
OPEN = "sum((u[i] - u[i - 1])**4 + u[i]**2 for i in range(1, N)) + u[0]**2"
LOOPS = f"{OPEN} + sum(cos(u[i + 4] - 2*u[i + 2] + u[i]) for i in range(N - 4)) + u[2]**4"
RING = "sum((u[(i + 1) % N] - u[i])**4 + sin(u[i]) for i in range(N))"
BACK = "sum((u[i] - u[(i - 1) % N])**2 + cos(u[i]*u[(i + 3) % N]) for i in range(N))"
SYSTEMS: Mapping[str, Callable[[int], str]] = {
    "chain": lambda more: CHAIN.format(320 + more, OPEN),
    "loops": lambda more: CHAIN.format(320 + more, LOOPS),
    "ring": lambda more: CHAIN.format(400 + more, RING),
    "ring, both ways": lambda more: CHAIN.format(400 + more, BACK),
    "two rings": lambda more: CHAIN.format(800 + more, f"{RING} + {BACK}"),
    "lattice": lambda more: LATTICE.format(52, 8 + more),
}
TOLERANCE = 1e-3


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, and are computed in blocks, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    monkeypatch.setattr(tiling, "PART", 1)


def ready(text: str) -> Prepared:
    """A system that has been compiled."""
    asked = Compilation("taylor", TOLERANCE, frozenset(["q", "v", "h"]))
    return prepare_system(read_spec(text, "system.yaml"), derive_system, None, asked)


def moved(text: str, prepared: Prepared) -> Motion:
    """A motion from the initial state of the text."""
    return run(prepared, resolve_values(read_spec(text, "system.yaml"), {}), 0.0, 1.0, 3)


def tilings(monkeypatch: pytest.MonkeyPatch) -> list[tiling.Tiling | None]:
    """What is found from here on."""
    found: list[tiling.Tiling | None] = []

    def kept(*given: object, shared: bool) -> tiling.Tiling | None:
        found.append(tiling.tiling_of(*given, shared=shared))  # type: ignore[arg-type]
        return found[-1]

    monkeypatch.setattr(series_places, "tiling_of", kept)
    return found


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("more", range(8))
@pytest.mark.parametrize("block", [2**8, 2**12])
@pytest.mark.parametrize("many", [0, 2**40])
def test_blocks_give_the_same_bits(
    name: str, more: int, block: int, many: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the size of blocks, where a row or the whole ends, also where dot products are begun for
    several orders."""
    text, found = SYSTEMS[name](more), tilings(monkeypatch)
    monkeypatch.setattr(jets.SeriesJet, "many", many)
    monkeypatch.setattr(tiling, "STRIDES", 1)
    monkeypatch.setattr(tiling, "MANY", 2**40)
    plain = moved(text, ready(text))
    monkeypatch.setattr(tiling, "MANY", 0)
    monkeypatch.setattr(tiling, "BLOCK", block)
    other = moved(text, ready(text))
    assert found[0] is None
    assert found[1] is not None
    assert found[1].rounds > 1
    assert found[1].ring == (name not in ("chain", "loops"))
    assert plain.outcome.steps == other.outcome.steps
    for path, values in plain.data.items():
        assert np.array_equal(values, other[path]), path


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "potential",
    ["sum(u[i]**4 for i in range(N)) + sum(u[i] for i in range(N))**2/N", f"{OPEN} + u[0]*u[N//2]"],
)
def test_what_acts_far_away_has_no_blocks(potential: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A force on all members, or a spring from the first member to the middle of a chain."""
    found = tilings(monkeypatch)
    monkeypatch.setattr(tiling, "MANY", 0)
    ready(CHAIN.format(320, potential))
    assert found in ([None], [])


@pytest.mark.exhaustive(keep=0.8)
def test_chains_of_joints_have_no_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their accelerations need sweeps from end to end."""
    found = tilings(monkeypatch)
    ready(PENDULUM)
    assert found == []


@pytest.mark.exhaustive(keep=0.55)
def test_only_coordinates_and_velocities_keep_all_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    """The memory of other series does not grow with the number of members."""
    monkeypatch.setattr(tiling, "MANY", 0)
    few, more = (ready(CHAIN.format(count, OPEN)).machine.program for count in (1600, 2400))
    others = 16  # sums, and what does not change from order to order
    assert more.work - few.work <= 800 * (2 * (few.order + 1) + others)
