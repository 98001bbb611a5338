"""``@project`` of chains and trees with constraints: the state back to these (see ``stepping.projection``).

Places of nodes are sums along chains, of many terms. They are added up with what rounding loses (T. J.
Dekker, Numerische Mathematik 18, 1971), and with what the low parts of the state add. Masses at the state,
and what forces of constraint do there, are those of ``@jet`` without series.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Chain, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bound, Hold
from lagrange_cli.native.families.constraints.jet import saddle_of, solve
from lagrange_cli.native.families.constraints.projection import add_to_state
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.joints.closed import ClosedJet, respond
from lagrange_cli.native.families.joints.closure import Closure
from lagrange_cli.native.families.joints.node_arrays import array
from lagrange_cli.native.families.joints.sweeps import Sweeps
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Pointer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.projection import LOOSE, places_of
from lagrange_cli.records import dataclass, replace

AT_A_STATE = "at_a_state"
"""The name of the jet without series."""


@dataclass(frozen=True, eq=False)
class Added:
    """A ``chain`` of nodes' places or velocities: its ``steps`` without what is lost in ``sums``, what the
    state's low parts add to the steps, what is lost in the sums, and the squares of all terms."""

    chain: Chain
    sums: Total
    steps: Total
    low: Total
    lost: Array
    squares: Total


class Residuals:
    """The totals of what should be 0: ``off`` f, and then df/dt or g, each with the square of its ``sizes``.
    They are computed with what rounding loses if they are ``careful``, as with doubles, and else plainly."""

    def __init__(self, closure: Closure, *, careful: bool) -> None:
        system, self.careful = closure.system, careful
        self.closure, self.system, self.slots, self.graph = closure, system, closure.slots, closure.graph
        self.low_q, self.low_v, self.low_time = array(system.q.count), array(system.q.count), array(1)
        self.lower: dict[Array, Array] = {system.q: self.low_q, system.v: self.low_v} if careful else {}
        self.added = {one: self._added(one) for c in self._components() for one in self._chains(c)}
        self.off = [self._off(speed=speed) for speed in (False, True)]
        self.sizes = [self._sizes(speed=speed) for speed in (False, True)]

    def _components(self) -> list[int]:
        """Those of places that constraints contain; before nodes, the sums of coordinates that these are
        made of."""
        held, nodes = self.closure.components, len(self.closure.joints.nodes)
        sums = {*range(nodes, len(self.closure.joints.places))}
        return [*sorted(sums if min(held, default=nodes) < nodes else sums & held), *sorted(held - sums)]

    def _chains(self, component: int) -> list[Chain]:
        """Places of a component, and their velocities."""
        joints = self.closure.joints
        both = joints.places[component], joints.speeds[component]
        return [one for one in both if isinstance(one, Chain)]

    def _added(self, chain: Chain) -> Added:
        closure, graph, terms = self.closure, self.graph, list[Term]()
        for term in chain.terms:
            parts = [term.node, *self._terms(term.node)]
            terms.append(replace(term, node=graph.sum([(part * part, 1.0) for part in parts])))
        squares = Chain(Source.TOTAL, chain.count, tuple(terms), chain.tree)
        low = [replace(one, node=self._low(one.node, one.domain)) for one in chain.terms]
        made = Added(
            chain, closure.lasting.arranged(chain), closure.total(chain.count, chain.terms),
            closure.total(chain.count, low), array(chain.count),
            closure.lasting.arranged(squares, kept=False),
        )  # fmt: skip
        if self.careful:
            self.lower[chain] = made.lost
        return made

    def _terms(self, node: Node) -> list[Node]:
        """What velocities add to a rate; else what coordinates add to a place."""
        slots, sums = [*self.slots.inside(node)], len(self.closure.joints.nodes)
        speeds = {self.system.v, *self.closure.joints.speeds[sums:]}
        if not any(slot.array in speeds for _, slot in slots):
            speeds = {self.system.q, *self.closure.joints.places[sums:]}
        return [self.graph.diff(node, symbol) * symbol for symbol, slot in slots if slot.array in speeds]

    def _low(self, node: Node, domain: Domain) -> Node:
        """What the low parts add to an expression."""
        graph = self.graph
        rate = graph.diff(node, self.system.time)
        moves = self.careful and not rate.is_zero
        terms = [rate * self.slots.symbol(domain, self.low_time, domain.together)] if moves else []
        for symbol, slot in [*self.slots.inside(node)]:
            if slot.array in self.lower:
                low = self.slots.symbol(domain, self.lower[slot.array], slot.table)
                terms.append(graph.diff(node, symbol) * low)
        return graph.sum([(one, 1.0) for one in terms])

    def judged(self, *, speed: bool) -> Sequence[Bound]:
        """The constraints that velocities or places have to satisfy."""
        return [one for one in self.closure.bounds if speed or one.holonomic]

    def _off(self, *, speed: bool) -> Total:
        terms = []
        for one in self.judged(speed=speed):
            node = one.speed if speed else one.node
            terms.append(Term(one.domain, node + self._low(node, one.domain), one.numbers))
        return self.closure.total(self.closure.count, terms)

    def _sizes(self, *, speed: bool) -> Total:
        terms, symbol = [], self.slots.symbol
        amount = self.system.v if speed else self.system.q
        for one in self.judged(speed=speed):
            parts = []
            for slope, rows in zip(one.slopes, one.rows):
                x = slope * symbol(one.domain, amount, rows)
                parts.append(x * x)
            for hold in one.holds:
                parts += [
                    hold.slope * hold.slope * square for square in self._squares(one.domain, hold, speed)
                ]
            terms.append(Term(one.domain, self.graph.sum([(part, 1.0) for part in parts]), one.numbers))
        return self.closure.total(self.closure.count, terms)

    def _squares(self, domain: Domain, hold: Hold, speed: bool) -> list[Node]:
        """The square of a node's place or velocity, and those of all terms in it."""
        found = self._chains(hold.component)[int(speed) :]
        if not found:
            return []
        x = self.slots.symbol(domain, found[0], hold.places)
        return [x * x, self.slots.symbol(domain, self.added[found[0]].squares, hold.places)]

    def parts_of(self, one: Added) -> Sequence[Total]:
        """What is computed before sums along a chain, or with these."""
        return (one.steps, one.low, one.squares) if self.careful else (one.sums, one.squares)

    @property
    def parts(self) -> Sequence[Total]:
        """The same of all chains."""
        return [total for one in self.added.values() for total in self.parts_of(one)]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed, but for those in the state."""
        if not self.careful:
            return list(dict.fromkeys([*self.parts, *self.off, *self.sizes]))
        sums = [array for one in self.added.values() for array in (one.sums, one.lost)]
        return list(dict.fromkeys([self.low_time, *self.parts, *sums, *self.off, *self.sizes]))


@dataclass(frozen=True)
class ClosedProjection:
    """Writes ``@project(constants, state)``, in the function of the ``evaluation``, where the low parts of t
    are ``low_time``. The ``jet`` has no series, and room at ``work``."""

    residuals: Residuals
    evaluation: Evaluation
    layout: StateLayout
    jet: ClosedJet
    work: Pointer
    time: Real
    low_time: Real
    fixed: frozenset[Array]

    def text(self) -> str:
        """The function's text."""
        f, vectors, found = self.evaluation.f, self.evaluation.vectors, self.residuals
        if found.careful:
            vectors.store(self.low_time, self.evaluation.where(found.low_time))
        fine = f.variable(Bit(f, "true", 1))
        self._look()
        for k in range(2):
            self._judge(k, fine)
        with f.when(~fine.get()):
            constants, state = f.pointers("constants", "state")
            times = times_of(vectors, self.time, self.low_time)
            regular = f.call(Bit, AT_A_STATE, constants, *times, state, self.work)
            with f.when(regular):
                self._move()
        f.give()
        return f.text()

    def _look(self) -> None:
        """What should be 0, at the state as it is."""
        evaluation, found = self.evaluation, self.residuals
        known = [one.sums for one in found.added.values()]
        for one in found.added.values():
            evaluation.write([part for part in found.parts_of(one) if part not in self.fixed])
            if found.careful:
                assert one.chain.tree is not None
                sweeps = Sweeps(evaluation.vectors, evaluation.tables, one.chain.tree, evaluation.where)
                sweeps.add_up(one.steps, one.low, one.sums, one.lost)
        totals = [*found.off, *found.sizes]
        evaluation.write([one for one in totals if one not in known])

    def _judge(self, k: int, fine: Variable[Bit]) -> None:
        """Whether that is rounding."""
        f, vectors, where = self.evaluation.f, self.evaluation.vectors, self.evaluation.where
        loose = f.constant((LOOSE * self.evaluation.emitter.unit) ** 2)
        off, sizes = where(self.residuals.off[k]), where(self.residuals.sizes[k])
        with f.loop(0, self.residuals.closure.count, tested=False) as i:
            value, size = vectors.high(vectors.load(off, i)), vectors.high(vectors.load(sizes, i))
            fine.set(fine.get() & (value * value <= size * loose))

    def _move(self) -> None:
        """Coordinates and then velocities back to where that is so."""
        f, vectors, jet, closure = self.evaluation.f, self.evaluation.vectors, self.jet, self.jet.closure
        at = places_of(self.layout)

        def where(one: Array) -> Pointer:
            if one in jet.planes:
                return vectors.place(self.work, jet.planes[one][0])
            return self.evaluation.where(one)

        evaluation = replace(self.evaluation, where=where)
        sweeps = None
        if jet.sweeps is not None:
            sweeps = Sweeps(vectors, self.evaluation.tables, jet.sweeps.tree, where)
        saddle = saddle_of(vectors, jet.tabled, self.work, jet.first)
        for k, row in enumerate((at.q, at.v)):
            if k:
                self._look()
            off, right = self.evaluation.where(self.residuals.off[k]), where(closure.right)
            with f.loop(0, closure.count, tested=False) as i:
                vectors.store(-vectors.load(off, i), right, i)
            solve(saddle, right, where(closure.multipliers))
            respond(evaluation, closure.alone, closure.reply, sweeps, self.fixed, coordinates=True)
            add_to_state(vectors, where(closure.reply.of_coordinates), row, self.layout)
        at.counted(f)


def times_of(vectors: Vectors, time: Real, low: Real) -> Sequence[Real]:
    """The times with which a jet without series is called (``Vectors.times``)."""
    return (time,) if vectors.parts == 1 else (time, low, vectors.f.constant(1.0))
