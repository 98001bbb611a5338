"""The series of joints of one kind, as terms (see ``balance``)."""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Term, Total
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.kinds import JointKind


def local_of(kind: JointKind) -> Local:
    """What the joints' series give."""
    graph, joints, balance = kind.graph, kind.joints, kind.balance
    arranged = balance.arrange

    def simple(node: Node) -> Node:
        """The same with arrays in place of what is constant."""
        (term,) = arranged(
            Total(Source.TOTAL, kind.domain.count, (Term(kind.domain, node, kind.every),))
        ).terms
        return term.node

    terms: list[tuple[Term, Array]] = []
    slopes: list[tuple[Term, Array]] = []
    unknowns: dict[Node, None] = {}
    work = [graph.zero for _ in kind.bends]
    moved = [(move, kind.at, balance.rest[c], balance.strain[c]) for c, move in enumerate(joints.moves)]
    moved += [
        (weight.move, kind.every, kind.rest[s], kind.strain[s]) for s, weight in enumerate(joints.weights)
    ]
    for k, (move, places, rest, strain) in enumerate(moved):
        node = simple(move)
        if node.kind is not node.kind.NUMBER:
            rate = graph.ddt(graph.ddt(node))
            terms.append((Term(kind.domain, rate, places), rest))
        force = balance.slots.symbol(kind.domain, strain, places)
        for b, symbol in zip(kind.bends, joints.coordinates):
            slope = graph.diff(node, symbol)
            if slope.is_zero:
                continue
            own = k < len(joints.moves)
            to = balance.node_slopes[k, b] if own else kind.slopes[k - len(joints.moves), b]
            slopes.append((Term(kind.domain, slope, places), to))
            if slope.symbols & kind.moving:
                work[b] = work[b] + slope * force
                unknowns[force] = None
    for b, node in enumerate(work):
        if not node.is_zero:
            terms.append((Term(kind.domain, simple(node), kind.every), kind.missing[b]))
    change = [kind.own(one) for one in kind.change]
    return Local(kind.domain, [*terms, *slopes], len(slopes), joints.coordinates, [*unknowns], change)
