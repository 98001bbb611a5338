"""What the series of joints of one kind give (see ``balance``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Term, Total
from lagrange_cli.families.joints.joints import FreeEnergy
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.joints.kinds import JointKind
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True, eq=False)
class PushedJoints:
    """Contacts add u (``pushed``) to accelerations of the joints' coordinates, which are ``of_joints`` then;
    those of the system's coordinates are the ``rates``, and of sums ``of_sums``. Series give what they have
    of u without what is newest (``gained``), and of J u of nodes (``jolts``); ``series`` are those of the
    contacts. ``of_kind`` has terms of u for a kind of joints with these moves, and the unknown of each."""

    pushed: Total
    of_joints: Total
    rates: Total
    of_sums: Sequence[Total]
    gained: Array
    jolts: Sequence[Array]
    series: Sequence[Local]
    of_kind: Callable[[JointKind, Sequence[Node]], Iterable[tuple[Node, Term]]]


def in_series(kind: JointKind, free: FreeEnergy, simple: Callable[[Node], Node]) -> FreeEnergy:
    """An energy by the series of coordinates and their rates."""
    graph, velocities = kind.graph, [*map(kind.balance.arranged_symbol, free.velocities)]
    rates = {u: graph.ddt(x) for u, x in zip(velocities, kind.coordinates)}

    def by_series(nodes: Iterable[Node]) -> tuple[Node, ...]:
        return substituted(graph, map(simple, nodes), rates)

    momenta, slopes = by_series(free.momenta), by_series(free.slopes)
    masses, beside = (tuple(map(by_series, one)) for one in (free.masses, free.beside))
    return replace(free, momenta=momenta, slopes=slopes, masses=masses, beside=beside)


def local_of(kind: JointKind, touched: PushedJoints | None = None) -> Local:
    """What the joints' series give; without what contacts add to accelerations."""
    graph, joints, balance = kind.graph, kind.joints, kind.balance
    arranged = balance.arrange

    def simple(node: Node) -> Node:
        """The same with arrays in place of what is constant."""
        (term,) = arranged(
            Total(Source.TOTAL, kind.domain.count, (Term(kind.domain, node, kind.domain.every),))
        ).terms
        return term.node

    terms: list[tuple[Term, Array]] = []
    slopes: list[tuple[Term, Array]] = []
    unknowns: dict[Node, None] = {}
    work = [graph.zero for _ in kind.bends]
    moved = [(move, kind.at, balance.rest[c], balance.strain[c]) for c, move in enumerate(joints.moves)]
    moved += [
        (weight.move, kind.domain.every, kind.rest[s], kind.strain[s])
        for s, weight in enumerate(kind.weights)
    ]
    pushed = [] if touched is None else [kind.at_rows(touched.pushed, b) for b in kind.bends]
    for k, (move, places, rest, strain) in enumerate(moved):
        node = simple(move)
        if node.symbols & kind.moving:
            rate = graph.ddt(graph.ddt(node))
            pairs = [(graph.diff(node, x) * u, 1.0) for x, u in zip(kind.coordinates, pushed)]
            if pairs:
                jolt = graph.sum(pairs)
                unknowns |= dict.fromkeys(u for u in pushed if jolt.symbols & u.symbols)
                rate = rate - jolt
                if touched is not None and k < len(joints.moves) and not jolt.is_zero:
                    terms.append((Term(kind.domain, jolt, places), touched.jolts[k]))
            terms.append((Term(kind.domain, rate, places), rest))
        force = balance.slots.symbol(kind.domain, strain, places)
        for b, symbol in zip(kind.bends, kind.coordinates):
            slope = graph.diff(node, symbol)
            if slope.is_zero:
                continue
            own = k < len(joints.moves)
            to = balance.node_slopes[k, b] if own else kind.slopes[k - len(joints.moves), b]
            slopes.append((Term(kind.domain, slope, places), to))
            if slope.symbols & kind.moving:
                work[b] = work[b] + slope * force
                unknowns[force] = None
    if touched is not None:
        for unknown, term in touched.of_kind(kind, [*map(simple, joints.moves)]):
            unknowns[unknown] = None
            terms.append((term, touched.gained))
    work = [simple(node) for node in work]
    if joints.free is not None:
        energy = in_series(kind, joints.free, simple)
        masses = [(kind.free_masses, energy.masses), (kind.beside, energy.beside)]
        for listed, nodes in masses:
            for (b, d), to in listed.items():
                if not nodes[b][d].is_zero:
                    slopes.append((Term(kind.domain, nodes[b][d], kind.domain.every), to))
        for b, (p, slope) in enumerate(zip(energy.momenta, energy.slopes)):
            known = graph.sum([(mass * u, 1.0) for mass, u in zip(energy.masses[b], pushed)])
            unknowns |= dict.fromkeys(u for u in pushed if known.symbols & u.symbols)
            work[b] = work[b] + graph.ddt(p) - slope - known
    for b, node in enumerate(work):
        if not node.is_zero:
            terms.append((Term(kind.domain, node, kind.domain.every), kind.missing[b]))
    change = [kind.own(one) for one in kind.change]
    if touched is not None:
        change = [kind.at_rows(touched.of_joints, b) for b in kind.bends]
    return Local(kind.domain, [*terms, *slopes], len(slopes), kind.coordinates, [*unknowns], change)
