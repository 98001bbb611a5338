"""Resting contacts at places of nodes, as totals (see ``joint_contacts``).

Such a contact c, with dg/dx = s and a direction that is f_k times dg/dq_k along coordinate k, has a part
f_k s J_k N in u_k, with the slope J_k = dx/dq_k of the coordinate's own joint. So

    u_k = J_k X_k,    X_k = sum over c of f_k (s N)_c,

where f does not move: a product of series for each joint, and one for each contact, but none for pairs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Term, Total
from lagrange_cli.families.contacts import Reach
from lagrange_cli.native.families.constraints.restraint import Bonded
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.kinds import JointKind
from lagrange_cli.native.families.joints.node_arrays import array


class Reaching:
    """What contacts that ``touch`` have of places of nodes."""

    def __init__(self, touch: Bonded, balance: Balance, reaches: Sequence[Reach]) -> None:
        self.touch, self.balance, self.slots = touch, balance, touch.slots
        self.reaches = reaches
        self.columns = [[array(one.domain.count) for _ in one.holds] for one in touch.bounds]
        """s."""
        self.rests = [[array(one.domain.count) for _ in one.holds] for one in touch.bounds]
        """s N without what is newest in N."""
        self.pulls = [
            [touch.total(one.domain.count, [self._pull(b, h)]) for h, _ in enumerate(one.holds)]
            for b, one in enumerate(touch.bounds)
        ]
        """What is newest in it."""
        self.early, self.newest = ([*self._sums(one)] for one in (self.rests, self.pulls))
        """X along each axis, without the newest N and of this alone."""
        self.whole = [self._sum(*one) for one in zip(self.early, self.newest)]

    @property
    def any(self) -> bool:
        """Whether contacts are at places of nodes."""
        return any(one.holds for one in self.touch.bounds)

    @property
    def components(self) -> frozenset[int]:
        """The axes of these."""
        return frozenset(hold.component for one in self.touch.bounds for hold in one.holds)

    @property
    def in_order(self) -> Sequence[Array]:
        """What series give in every order."""
        return [one for some in self.rests for one in some]

    @property
    def in_first(self) -> Sequence[Array]:
        """What they give in order 0."""
        return [one for some in self.columns for one in some]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        pulls = [one for some in self.pulls for one in some]
        return [*self.in_order, *self.in_first, *pulls, *self.early, *self.newest, *self.whole]

    def _pull(self, b: int, h: int) -> Term:
        bound = self.touch.bounds[b]
        multiplier = self.slots.symbol(bound.domain, self.touch.multipliers, bound.numbers)
        column = self.slots.own(bound.domain, self.columns[b][h])
        return Term(bound.domain, column * multiplier, bound.domain.every)

    def _sum(self, *arrays: Array) -> Total:
        """The sum of arrays of all coordinates."""
        domain = self.touch.system.everyone
        node = self.touch.graph.sum([(self.slots.own(domain, one), 1.0) for one in arrays])
        return self.touch.total(self.touch.size, [Term(domain, node, domain.every)])

    def _sums(self, pulls: Sequence[Sequence[Array]]) -> Iterator[Total]:
        touch = self.touch
        for c in self.balance.axes:
            terms = []
            for one in self.reaches:
                if touch.bounds[one.bound].holds[one.hold].component == c:
                    pull = self.slots.symbol(one.domain, pulls[one.bound][one.hold], one.members)
                    terms.append(Term(one.domain, one.node * pull, one.rows))
            yield touch.total(touch.size, terms)

    def pushed(self, sums: Sequence[Total]) -> Iterator[Term]:
        """J X."""
        for kind in self.balance.kinds:
            if kind.is_node and self.any:
                for b in kind.bends:
                    parts = [kind.whole_slope(c, b) * kind.at_rows(one, b) for c, one in enumerate(sums)]
                    yield Term(kind.domain, kind.summed(parts), kind.joints.rows[b])

    def of_kind(self, kind: JointKind, moves: Sequence[Node]) -> Iterator[tuple[Node, Term]]:
        """What the series of a kind of joints give of J X, without what is newest in X: X, and its term."""
        if not (kind.is_node and self.any):
            return
        for b, q in zip(kind.bends, kind.joints.coordinates):
            for move, one in zip(moves, self.whole):
                slope = kind.graph.diff(move, q)
                if one.terms and slope.symbols & kind.moving:
                    own = kind.at_rows(one, b)
                    yield own, Term(kind.domain, slope * own, kind.joints.rows[b])
