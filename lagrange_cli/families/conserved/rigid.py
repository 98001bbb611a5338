"""Translations and rotations of all particles on chains and trees, or in a field, as changes of coordinates:
members of a family that change alike, or by the members of another, as in a rotation of x and y."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.conserved.displacements import TURNS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Family, grouped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]

ParticleVectors: TypeAlias = "Mapping[tuple[str, int], Numbers]"
"""Numbers (members,) of the particles of a family, by its name and an axis."""

MOST_FAMILIES = 6
"""Families of coordinates whose combinations are tried."""
STATES = 2
"""Random states at which they are compared."""
DIGITS = 9
"""Decimals of the factors of a combination."""
EXACT = 1e-10
"""What differs from a displacement, but for rounding, is at most so large a part of it."""


@dataclass(frozen=True)
class Part:
    """All members of a ``family`` change by the ``factor``, times those of ``other`` if there is one."""

    factor: float
    family: Family
    first: int
    other: Family | None
    other_first: int = 0

    def change(self, q: Numbers) -> Numbers:
        """The change of all coordinates."""
        found, count = np.zeros(len(q)), len(self.family.members)
        by: Numbers | float = 1.0
        if self.other is not None:
            by = q[self.other_first : self.other_first + count]
        found[self.first : self.first + count] = self.factor * by
        return found


def candidates(system: FamilySystem) -> list[Part]:
    """The changes that are combined."""
    spec, first = system.spec, 0
    families: list[tuple[Family, int]] = []
    for family in grouped(names_of(spec.coordinates), spec.coordinate_families):
        families.append((family, first))
        first += len(family.members)
    if len(families) > MOST_FAMILIES:
        return []
    found = [Part(1.0, family, k, None) for family, k in families]
    found += [
        Part(1.0, one, k, other, n)
        for one, k in families
        for other, n in families
        if one is not other and one.shape == other.shape
    ]
    return found


class Rigid:
    """Which changes of coordinates move all particles in some way, found at random states."""

    def __init__(self, system: FamilySystem) -> None:
        self.tried = candidates(system)
        self.places, self.speeds, self.axes = {**system.positions}, {**system.speeds}, set[str]()
        """Axes of bodies turn as particles do, and are not shifted."""
        for body, turned in system.bodies.items():
            for i, (places, speeds) in enumerate(zip(turned.axes, turned.rates)):
                name = f"{body} axis {i + 1}"
                self.places[name], self.speeds[name] = places, speeds
                self.axes.add(name)
        self.names = [(name, k) for name, several in self.speeds.items() for k in range(len(several))]
        self._places: list[ParticleVectors] = []
        self._columns: list[Numbers] = []
        for seed in range(STATES if self.tried else 0):
            chance = np.random.default_rng(seed)
            q, t = chance.uniform(0.2, 1.2, system.q.count), float(chance.uniform(0.2, 1.2))
            parameters = chance.uniform(0.5, 1.5, len(system.spec.parameters))
            at = partial(FamilyValues, system, t, q, parameters=parameters)

            def moved(v: Numbers, at: Callable[..., FamilyValues] = at) -> Numbers:
                values = at(v=v)
                listed = []
                for name, axis in self.names:
                    total, count = self.speeds[name][axis], self.places[name][axis].count
                    listed.append(np.zeros(count) if total is None else values.of(total))
                return np.concatenate(listed)

            values, rest = at(v=np.zeros(len(q))), moved(np.zeros(len(q)))
            self._places.append({(n, k): values.of(self.places[n][k]) for n, k in self.names})
            self._columns.append(np.stack([moved(one.change(q)) - rest for one in self.tried], axis=1))

    def parts(self, quantity: str) -> tuple[Part, ...] | None:
        """The changes that together move particles as conserves P_x, K_x or L_z; None where none do."""
        if not self.tried or not self.has(quantity):
            return None
        wanted = [displacement(quantity)(places) for places in self._places]
        if not quantity.startswith("L"):
            wanted = [{k: x * (k[0] not in self.axes) for k, x in one.items()} for one in wanted]
        aim = np.concatenate([one[name] for one in wanted for name in self.names])
        columns, (across, small) = self._factored
        factors: Numbers = np.linalg.lstsq(small, across.T @ aim, rcond=1e-9)[0].round(DIGITS)
        sizes = np.abs(columns) @ np.abs(factors) + np.max(np.abs(aim))
        if np.any(np.abs(columns @ factors - aim) > EXACT * sizes):
            return None
        return tuple(replace(one, factor=x) for x, one in zip(factors.tolist(), self.tried) if x)

    @cached_property
    def _factored(self) -> tuple[Numbers, tuple[Numbers, Numbers]]:
        """How particles move by each change, column by column, and the factors Q and R of that."""
        columns = np.concatenate(self._columns)
        return columns, np.linalg.qr(columns)

    def has(self, quantity: str) -> bool:
        """Whether particles have the axes that a quantity is of."""
        kind, _, name = quantity.partition("_")
        if name not in COMPONENTS:
            return False
        if kind == "L":
            return {(one, k) for one, _ in self.names for k in TURNS[name]} <= {*self.names}
        return any(axis == COMPONENTS.index(name) for _, axis in self.names)


def together(parts: Sequence[Part], q: Numbers) -> Numbers:
    """The change of all coordinates by several parts."""
    made = np.zeros(len(q))
    for one in parts:
        made += one.change(q)
    return made


def growing(parts: Sequence[Part], v: Numbers) -> Numbers:
    """How fast it grows."""
    return together([one for one in parts if one.other is not None], v)


def shift(places: ParticleVectors, axis: int) -> ParticleVectors:
    """All particles move along an axis."""
    return {place: np.full(len(x), float(place[1] == axis)) for place, x in places.items()}


def turn(places: ParticleVectors, i: int, j: int) -> ParticleVectors:
    """All particles turn from axis i to axis j."""
    moved = {place: np.zeros(len(x)) for place, x in places.items()}
    for name, axis in places:
        if axis == i:
            moved[name, i], moved[name, j] = -places[name, j], places[name, i]
    return moved


def displacement(quantity: str) -> Callable[[ParticleVectors], ParticleVectors]:
    """What conserves P_x, K_x or L_z."""
    kind, _, name = quantity.partition("_")
    if kind == "L":
        i, j = TURNS[name]
        return partial(turn, i=i, j=j)
    return partial(shift, axis=COMPONENTS.index(name))
