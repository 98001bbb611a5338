"""What a system of families conserves: h, momenta of cyclic coordinates, and what displacements of all
particles show by Noether's theorem (see ``mechanics.conserved.noether``).

No member is written out: rates are compared with their terms at random states, for all members at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.vocabulary import COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.conserved.breaks import Actions, actions_in, with_breaks
from lagrange_cli.families.conserved.frames import contains_time
from lagrange_cli.families.conserved.parts import energies_of_parts
from lagrange_cli.families.conserved.rigid import ParticleVectors, Rigid, displacement, growing, together
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.inertia import curved
from lagrange_cli.families.slopes import slopes
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.conservation import Conserved, kept_energy, kept_momentum
from lagrange_cli.mechanics.conserved.displacements import TURNS
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import grouped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

STATES = 2
"""Random states at which rates are compared."""
ROUNDED = 1e-10
"""What is left of terms that cancel, but for rounding, is at most so large a part of them."""


@dataclass(frozen=True)
class Trial:
    """A displacement: ``of`` a state it gives the change of each coordinate, None where there is none. What
    it conserves is the ``quantity``; ``how`` says how it is done, or why that is conserved if it ``boosts``.
    In a field, ``growth`` is the rate of the change.
    """

    quantity: str
    text: str
    how: str
    of: Callable[[RandomState], Values | None]
    boosts: bool = False
    growth: Callable[[RandomState], Values] | None = None
    alike: bool = False
    """Whether it changes all members of a family of coordinates, whatever these do to particles."""


class RandomState:
    """A random state: forces on coordinates, their sizes, and where particles are."""

    def __init__(self, system: FamilySystem, seed: int) -> None:
        chance, spec = np.random.default_rng(seed), system.spec
        count = system.q.count
        q, v = chance.uniform(0.2, 1.2, count), chance.uniform(-1.0, 1.0, count)
        self.system, self.v, self.t = system, v, float(chance.uniform(0.2, 1.2))
        self.q, self.parameters = q, chance.uniform(0.5, 1.5, len(spec.parameters))
        signs: dict[Array, Values] = {}
        if system.modes is not None:  # each member is on either side in two states, one after the other
            count = system.modes.signs.count
            signs[system.modes.signs] = (
                np.random.default_rng(STATES).choice([-1.0, 1.0], count) * (-1) ** seed
            )
        self.signs = signs
        self.values = FamilyValues(system, self.t, q, v, self.parameters, signs)
        self.slopes, self.slope_sizes = self._pair(system.gradient)
        self.applied, self.applied_sizes = self._pair(system.applied)
        none = np.zeros((2, system.q.count))
        self.vector, self.vector_sizes = none if system.vector is None else self._pair(system.vector)

    def _pair(self, total: Total) -> tuple[Values, Values]:
        values = self.values
        return values.of(total), values.added(total.count, total.terms, sizes=True)

    @property
    def places(self) -> ParticleVectors:
        """Where the particles are."""
        return {
            (name, axis): self.values.of(total)
            for name, totals in self.system.positions.items()
            for axis, total in enumerate(totals)
        }

    def change(self, displacements: ParticleVectors) -> Values | None:
        """The change of coordinates that moves particles so far; None where there is none."""
        found = np.full(self.system.q.count, np.nan)
        left = {place: values != 0 for place, values in displacements.items()}
        for one in self.system.components:
            place = one.family, one.axis
            wanted = displacements[place][one.members] / self.values.node(one.slope)
            known = found[one.rows]
            if np.any(np.abs(known - wanted) > ROUNDED * np.abs(wanted)):
                return None
            found[one.rows] = wanted
            left[place][one.members] = False
        return None if any(np.any(one) for one in left.values()) else np.nan_to_num(found)

    def keeps_kinetic(self, direction: Values) -> bool:
        """Whether T is the same far away in a direction, at the same velocities."""
        moved = FamilyValues(self.system, self.t, self.q + direction, self.v, self.parameters)
        before, after = (float(np.sum(one.node(self.system.kinetic))) for one in (self.values, moved))
        return abs(after - before) <= ROUNDED * abs(before)

    def moved(self, q: Values, v: Values, parameters: Values | None = None) -> tuple[FamilyValues, Values]:
        """The values where these are others, also at several states (coordinates, states); and v."""
        beside = (..., *(None for _ in q.shape[1:]))
        signs = {array: values[beside] for array, values in self.signs.items()}
        parameters = self.parameters if parameters is None else parameters
        return FamilyValues(self.system, self.t, q, v, parameters, signs), v

    def idles(self, direction: Values) -> bool:
        """Whether applied forces do no work in a direction."""
        with np.errstate(all="ignore"):
            size = np.abs(direction) @ self.applied_sizes
            return bool(np.abs(direction @ self.applied) <= ROUNDED * size)

    def keeps(self, trial: Trial, direction: Values) -> bool:
        """Whether U changes in the direction of a trial by the work of applied forces, if at all."""
        growth = 0.0 * self.v if trial.growth is None else trial.growth(self)
        with np.errstate(all="ignore"):
            grows, sizes = -self.vector, self.vector_sizes
            if self.system.curved:  # slopes are those of L then, and not of U
                grows, sizes = self._pair(self.system.momenta)
            work = direction @ (self.applied - self.slopes) + growth @ grows
            size = np.abs(direction) @ (self.applied_sizes + self.slope_sizes)
            size += np.abs(growth) @ sizes
            lost = direction @ self.vector * trial.boosts
            least = ROUNDED * (np.abs(direction) @ self.vector_sizes)
            return bool(np.abs(work) <= ROUNDED * size and np.abs(lost) <= least)

    def allows(self, direction: Values) -> bool:
        """Whether constraints stay as they are in a direction."""
        bonds = self.system.bonds
        if bonds and any(bound.holds for bound in bonds.bounds):
            return False  # nodes of chains are not looked at
        total, size = np.zeros((2, bonds.count if bonds else 0))
        for bound in bonds.bounds if bonds else ():
            for slope, rows in zip(bound.slopes, bound.rows):
                changes = self.values.node(slope) * direction[rows]
                np.add.at(total, bound.numbers, changes)
                np.add.at(size, bound.numbers, np.abs(changes))
        return not np.any(np.abs(total) > ROUNDED * size)


@dataclass(frozen=True)
class ConservedQuantities:
    """The ``cyclic`` coordinates, what is ``conserved``, and whether L is ``timed``: t is in it."""

    cyclic: tuple[str, ...]
    conserved: tuple[Conserved, ...]
    timed: bool


def constants_of(system: FamilySystem, actions: Actions | None = None) -> ConservedQuantities:
    """What L does not contain, and what every motion keeps between events; ``actions`` are those of the
    system's own, unless others are given."""
    system = system.smooth or system
    with np.errstate(all="ignore"):
        states = [RandomState(system, seed) for seed in range(STATES)]
        straight = np.ones(system.q.count, dtype=bool)
        if system.joints is not None:
            straight = ~curved(system.slots.graph, system.joints, system.q.count) | without_kinetic(states)
        free = straight & np.all([np.abs(one.slopes) <= ROUNDED * one.slope_sizes for one in states], axis=0)
        idle = np.all([np.abs(one.applied) <= ROUNDED * one.applied_sizes for one in states], axis=0)
        names, constrained = names_of(system.spec.coordinates), system.bonds is not None
        for bound in system.bonds.bounds if system.bonds else ():
            for rows in bound.rows:
                idle[rows] = False
            if bound.holds:
                idle[:] = False
        kept = free & idle
        found = [kept_momentum(names[k], constrained=constrained) for k in np.flatnonzero(kept).tolist()]
        idle_power = all(one.idles(one.v) for one in states)
        timed = contains_time(system, states)
        if not timed and system.idle_bonds and idle_power:
            plain = system.spec.lagrangian is None and system.vector is None
            fixed = "positions" if plain and not system.moved_in_time else ""
            found.append(kept_energy(applied=system.driven, constrained=constrained, fixed=fixed))
        found += further(system, states, kept)
        found += energies_of_parts(system, states, kept)
        found = [*with_breaks(system, states, found, actions or actions_in(system))]
    return ConservedQuantities(tuple(names[k] for k in np.flatnonzero(free).tolist()), tuple(found), timed)


def without_kinetic(states: Sequence[RandomState]) -> NDArray[np.bool_]:
    """The coordinates that T does not depend on at some states, but for rounding of the terms of T that their
    joints have. At others, it may be that it does."""
    system = states[0].system
    assert system.joints is not None
    (rates,), _ = slopes(system.kinetic, system.root, system.totals, system.slots, system.q)
    found = np.ones(system.q.count, dtype=bool)
    for one in states:
        work = np.abs(one.values.of(system.momenta) * one.v)
        for joints in system.joints.joints:
            whole = sum(work[rows] for rows in joints.rows)
            for rows in joints.rows:
                found[rows] &= np.abs(one.values.of(rates)[rows]) <= ROUNDED * whole
    return found


def further(
    system: FamilySystem, states: Sequence[RandomState], kept: NDArray[np.bool_]
) -> Iterator[Conserved]:
    """What displacements conserve; not sums of momenta that are all ``kept``."""
    known: dict[str, list[Values]] = {}
    for trial in trials(system):
        directions = [trial.of(one) for one in states]
        if any(one is None or not np.any(one) for one in directions):
            continue
        pairs = [(one, state) for one, state in zip(directions, states) if one is not None]
        if trial.alike and not system.straight:
            if not all(state.keeps_kinetic(one) for one, state in pairs):
                continue
            if trial.quantity in known or any(follows(pairs, one) for one in known.values()):
                continue
        if not all(state.keeps(trial, one) and state.allows(one) for one, state in pairs):
            continue
        constant = trial.quantity.startswith("P")
        if constant and all(np.all(kept[np.flatnonzero(one)]) for one, _ in pairs):
            continue
        known[trial.quantity] = [one for one, _ in pairs]
        because = trial.how
        if not trial.boosts:
            idle = all(state.idles(one) for one, state in pairs)
            because = f"{trial.how} {unchanged(system, idle=idle)}"
        yield Conserved(trial.quantity, trial.text, because)


def follows(pairs: Sequence[tuple[Values, RandomState]], known: Sequence[Values]) -> bool:
    """Whether a displacement is the same in all states as one that is known."""
    return all(np.array_equal(one, other) for (one, _), other in zip(pairs, known))


def unchanged(system: FamilySystem, *, idle: bool) -> str:
    """The end of a sentence on a displacement that leaves the equations as they are."""
    compatible = ", and is compatible with the constraints" if system.bonds else ""
    if system.spec.lagrangian is not None:
        whole = "leaves the equations of motion unchanged" if system.driven else "leaves L unchanged"
        return whole + compatible
    if not system.driven:
        return f"changes neither T nor U{compatible}"
    if idle:
        return f"changes neither T nor U{compatible}; the other forces do no work in it"
    return f"leaves T unchanged{compatible}; U changes by the work of the other forces"


def trials(system: FamilySystem) -> Iterator[Trial]:
    """Displacements of all particles; of all members of a family, where L is given, and of chains."""
    if system.spec.lagrangian is not None:
        yield from shifts(system)
        return
    rigid = None if system.straight else Rigid(system)
    counts = {name: len(totals) for name, totals in system.positions.items()}
    axes = range(max(counts.values()))
    everything, spins = ("everything", " + spins") if system.bodies else ("all particles", "")
    field = system.vector is not None
    growing = rigid is not None and (field or system.curved)
    for axis in axes:
        name = COMPONENTS[axis]
        how = f"moving {everything} along {name}"
        text = f"sum of m*v{name}" + f" - dU/dv{name}" * field
        yield Trial(f"P_{name}", text, how, partial(moved, quantity=f"P_{name}", rigid=rigid))
    if len({*counts.values()}) == 1:
        for name, (i, j) in TURNS.items():
            if max(i, j) in axes:
                about = f"the {name} axis" if len(axes) == len(COMPONENTS) else "the origin"
                x, y = COMPONENTS[i], COMPONENTS[j]
                u, w = (
                    f"(m*{one} - dU/d{one})" if field else f"m*{one}"
                    for one in (VELOCITY_COMPONENTS[i], VELOCITY_COMPONENTS[j])
                )
                yield Trial(
                    f"L_{name}", f"sum of {x}*{w} - {y}*{u}{spins}", f"turning {everything} about {about}",
                    partial(moved, quantity=f"L_{name}", rigid=rigid),
                    growth=partial(grown, quantity=f"L_{name}", rigid=rigid) if rigid and growing else None,
                )  # fmt: skip
    for axis in axes if len(system.spec.embedding) > 1 else ():
        name = COMPONENTS[axis]
        how = f"the centre of mass moves uniformly along {name} (Galilean boosts)"
        text = f"t*P_{name} - sum of m*{name}"
        yield Trial(f"K_{name}", text, how, partial(moved, quantity=f"K_{name}", rigid=rigid), boosts=True)
    if rigid is not None:
        moves = {f"P_{name}" for name in COMPONENTS if rigid.parts(f"P_{name}") is not None}
        yield from (one for one in shifts(system) if one.quantity not in moves)


def moved(state: RandomState, quantity: str, rigid: Rigid | None) -> Values | None:
    """The change of coordinates by a displacement of all particles; None where there is none."""
    if rigid is None:
        return state.change(displacement(quantity)(state.places))
    parts = rigid.parts(quantity)
    return None if parts is None else together(parts, state.q)


def grown(state: RandomState, quantity: str, rigid: Rigid) -> Values:
    """The rate of that change."""
    return growing(rigid.parts(quantity) or (), state.v)


def shifts(system: FamilySystem) -> Iterator[Trial]:
    """All members of a family of coordinates change alike."""
    spec, first = system.spec, 0
    for family in grouped(names_of(spec.coordinates), spec.coordinate_families):
        direction = np.zeros(system.q.count)
        direction[first : first + len(family.members)] = 1.0
        first += len(family.members)
        if len(family.members) > 1:
            how = f"changing all {family.label} alike"
            text = f"sum of p_{family.label}"
            yield Trial(f"P_{family.name}", text, how, partial(constant, direction=direction), alike=True)


def constant(state: RandomState, direction: Values) -> Values:
    """The same change in every state."""
    return direction
