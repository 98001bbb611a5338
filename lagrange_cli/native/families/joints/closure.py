"""Constraints on chains and trees, such as closed loops, as totals beside those of ``balance``.

With A for the slopes of the constraints f and c for the rest of their second derivatives, or of the first
ones of constraints g on velocities,

    M a = F + A^T lambda,    A a + c = 0,    so that    A M^-1 A^T lambda = -c - A M^-1 F.

M is never written down. Forces A^T lambda act on the nodes and coordinates that constraints contain, and what
M^-1 makes of them, the ``reply``, takes a sweep to the roots and back. So do the columns of A M^-1 A^T, those
on different trees together, once a step (see ``families.joints.responses``). Each order takes two sweeps: one
without the newest lambda, and one with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slot, Term, Total, opposite
from lagrange_cli.families.bonds import Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.restraint import Bonded
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.node_arrays import array
from lagrange_cli.native.families.lasting import Lasting


class Closure(Bonded):
    """The totals of the constraints, and the ``balance`` of all forces with theirs among them."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        assert system.joints is not None
        self.joints = system.joints
        moved = enumerate(system.joints.speeds)
        self.places: Sequence[Array] = [lasting.arranged(one) for one in system.joints.places]
        self.rates: Mapping[int, Array] = {c: lasting.arranged(one) for c, one in moved if one is not None}
        self.slopes: Sequence[Sequence[Array]] = [self.columns(one) for one in self.bounds]
        self.holds = [[array(one.domain.count) for _ in one.holds] for one in self.bounds]
        """A: by coordinates, and by places of nodes, or sums of coordinates."""
        self.pull = array(self.size)
        self.pulls = [array(one.count) for one in self.places]
        """A^T lambda without what is newest in it: on coordinates, and on places with the opposite sign."""
        forces = lasting.arranged(self.forces_besides, kept=False)
        loads = [lasting.arranged(one, kept=False) for one in system.loads]
        self.given = forces, *loads
        """Forces without those of constraint."""
        bent = self.bent
        given = [forces] * bool(forces.terms) + [self.pull] * bent
        self.forces = self.total(self.size, [*self.all_of(given, self.size), *self.on_coordinates()])
        self.loads = [
            self.total(
                one.count,
                [
                    *self.all_of([one] * bool(one.terms) + [self.pulls[c]] * bent, one.count),
                    *self.on_places(c),
                ],
            )
            for c, one in enumerate(loads)
        ]
        self.balance = Balance(system, lasting.arranged, self.forces, self.loads)
        self.own_forces = self.total(self.size, [*self.on_coordinates()])
        self.own_loads = [self.total(one.count, [*self.on_places(c)]) for c, one in enumerate(loads)]
        self.reply = self.balance.alone(self.own_forces, self.own_loads)
        """What forces of constraint do alone."""
        self.right = self.right_side()
        self.column = self.of_bounds(self.entries)
        """A M^-1 A^T lambda."""
        assert self.bonds.responses is not None
        self.responses = self.bonds.responses
        self.square = array(len(self.responses.places) + 2)
        """The entries of A M^-1 A^T, and behind them 0 and 1."""
        self.series = self.locals()

    @property
    def forces_besides(self) -> Total:
        """The forces on coordinates without those of constraint."""
        return self.system.forces

    def columns(self, bound: Bound) -> Sequence[Array]:
        """A of a bound, by coordinates."""
        return [array(bound.domain.count) for _ in bound.slopes]

    def right_side(self) -> Total:
        """-c - A M^-1 F."""
        return self.of_bounds(lambda b: -self.along(b, self.balance), less=self.rest)

    def entries(self, number: int) -> Node:
        """A M^-1 A^T lambda of a bound."""
        return self.along(number, self.reply)

    def locals(self) -> Sequence[Local]:
        """What the series of the bounds give."""
        return [self._local(b, one) for b, one in enumerate(self.bounds) if one.rows or one.holds]

    @property
    def by_coordinates(self) -> bool:
        """Whether constraints contain coordinates, or sums of these, besides nodes."""
        nodes = len(self.joints.nodes)
        return any(one.rows or any(hold.component >= nodes for hold in one.holds) for one in self.bounds)

    @property
    def bent(self) -> bool:
        """Whether a slope moves."""
        system, moves = self.system, {self.system.q, *self.joints.places}
        return any(
            slope.symbols & system.time.symbols or self.slots.moving(slope, moves)
            for one in self.bounds
            for slope in (*one.slopes, *(hold.slope for hold in one.holds))
        )

    @property
    def components(self) -> frozenset[int]:
        """The components of places that constraints contain, or their velocities."""
        joints, found = self.joints, set[int]()
        for one in self.bounds:
            inside = [slot.array for _, slot in self.slots.inside(one.node)]
            for c, both in enumerate(joints.followed):
                if any(array in both for array in inside):
                    found.add(c)
        return frozenset(found)

    @property
    def in_order(self) -> Sequence[Array]:
        """What the series of the constraints give in every order."""
        return [self.rest, self.pull, *self.pulls]

    @property
    def in_first(self) -> Sequence[Array]:
        """What they give in order 0."""
        return [one for some in (*self.slopes, *self.holds) for one in some]

    @property
    def acting(self) -> Sequence[Total]:
        """All forces."""
        return [self.forces, *self.loads, *self.of_joints(self.balance)]

    @property
    def alone(self) -> Sequence[Total]:
        """Those of the constraints."""
        return [self.own_forces, *self.own_loads, *self.of_joints(self.reply)]

    def of_joints(self, balance: Balance) -> Sequence[Total]:
        """The forces on the joints' coordinates, where these are sums."""
        return [] if self.joints.relative is None else [balance.forces]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        found = [self.multipliers, self.square, self.right, self.column, *self.in_order, *self.in_first]
        return list(dict.fromkeys([*found, *self.acting, *self.alone, *self.reply.arrays]))

    def total(self, count: int, terms: Sequence[Term]) -> Total:
        return super().total(count, [one for one in terms if not one.node.is_zero])

    def all_of(self, arrays: Sequence[Array], count: int) -> list[Term]:
        """The sum of arrays."""
        if not arrays:
            return []
        domain = Domain(count)
        symbols = [(self.slots.own(domain, one), 1.0) for one in arrays]
        return [Term(domain, self.graph.sum(symbols), domain.every)]

    def multiplier(self, bound: Bound) -> Node:
        return self.slots.symbol(bound.domain, self.multipliers, bound.numbers)

    def on_coordinates(self) -> list[Term]:
        """A^T lambda on coordinates."""
        return [
            Term(one.domain, self.slots.own(one.domain, slope) * self.multiplier(one), rows)
            for one, slopes in zip(self.bounds, self.slopes)
            for slope, rows in zip(slopes, one.rows)
        ]

    def on_places(self, component: int) -> list[Term]:
        """-A^T lambda on a component of places."""
        return [
            Term(one.domain, -(self.slots.own(one.domain, slope) * self.multiplier(one)), hold.places)
            for one, slopes in zip(self.bounds, self.holds)
            for slope, hold in zip(slopes, one.holds)
            if hold.component == component
        ]

    def of_bounds(self, make: Callable[[int], Node], less: Array | None = None) -> Total:
        """A total with a number for each constraint, ``less`` one of each besides."""
        terms = [Term(one.domain, make(b), one.numbers) for b, one in enumerate(self.bounds)]
        if less is not None:
            terms += opposite(self.all_of([less], self.count))
        return self.total(self.count, terms)

    def along(self, number: int, balance: Balance) -> Node:
        """A times accelerations."""
        bound = self.bounds[number]
        changes = self.changes(bound, balance)
        slopes = [self.slots.own(bound.domain, one) for one in (*self.slopes[number], *self.holds[number])]
        return self.graph.sum([(slope * change, 1.0) for slope, change in zip(slopes, changes)])

    def changes(self, bound: Bound, balance: Balance) -> list[Node]:
        """The accelerations of what a bound contains."""
        domain = bound.domain
        found = [self.slots.symbol(domain, balance.of_coordinates, rows) for rows in bound.rows]
        return found + [balance.of_place(domain, hold.component, hold.places) for hold in bound.holds]

    def _local(self, number: int, bound: Bound) -> Local:
        """What the series of a bound give."""
        domain, held = bound.domain, self.places if bound.holonomic else self.rates
        nodes = [self.slots.symbol(domain, held[one.component], one.places) for one in bound.holds]
        pulled = [(rows, self.pull, 1.0) for rows in bound.rows]
        pulled += [(one.places, self.pulls[one.component], -1.0) for one in bound.holds]
        columns = *self.slopes[number], *self.holds[number]
        slopes = [*zip((*bound.symbols, *nodes), columns, pulled)]
        placed = {self.system.v: self.system.q} | {rate: self.places[c] for c, rate in self.rates.items()}
        change = partial(self.change, domain)
        return self.series_of(bound, placed, slopes, self.multiplier(bound), change)

    def change(self, domain: Domain, place: Slot) -> Node:
        """The acceleration of a coordinate or of a place."""
        if place.array is self.system.q:
            return self.slots.symbol(domain, self.balance.of_coordinates, place.table)
        return self.balance.of_place(domain, self.places.index(place.array), place.table)
