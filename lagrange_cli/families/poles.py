"""Poles of forces, such as r^-13, and by how much a step may bring a motion nearer to them.

Where bodies are far from each other a steep or weak force is less than rounding, and where they meet it is a
wall. So a step could end behind the wall and nothing would have been seen of it.

What becomes 0 at the pole, b, is a sum of squares of what is linear in places. With |q(s) - q - s v| <= d
within a step of length h, b is at least b - h max(0, -db/dt) - sum_k |db/dq_k| d_k at each place in it, as
squares of changes only add to that; the sum is at most the root of sum (db/dq_k)^2 sum d_k^2.

An exponent u = c + s r may be 0 at any distance r = b^(1/2). If b = |A q|^2 + ..., r changes by at most l =
h |A v| + |A| |d|, so that u^2 becomes less by 2 |u s| l at most.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.mechanics.approach import approached, is_linear, lost, revealed, shells, tails
from lagrange_cli.records import dataclass

WIDTH = 8.0
"""Exponents that are that large have about as much room in a step as larger ones."""


def moving(system: FamilySystem) -> tuple[int, int]:
    """The symbols of t, q and v, and of what is made of them; those of v, and of what may contain them."""
    speeds = system.slots.symbols_of(system.v, totals=True)
    return places(system) | speeds, speeds


def places(system: FamilySystem) -> int:
    """The symbols of t and q."""
    return system.time.symbols | system.slots.symbols_of(system.q)


def poles(system: FamilySystem, totals: Iterable[Total]) -> dict[Node, Domain]:
    """What becomes 0 at each pole in the terms of ``totals``, if that can be told, and whose it is."""
    found = dict[Node, Domain]()
    if system.joints is None and system.bonds is None:
        variables = moving(system)[0]
        for term in (term for total in totals for term in total.terms):
            listed = approached(reachable([term.node]), variables, places(system))
            found |= dict.fromkeys(listed, term.domain)
    return found


def slow(system: FamilySystem, totals: Iterable[Total]) -> tuple[dict[Node, Domain], frozenset[Node]]:
    """What steps approach slowly in the terms of ``totals``: poles, and what tells where exponentials begin
    to matter, and whose these are; and those exponentials."""
    listed = [*totals]
    found, exponentials = poles(system, listed), set[Node]()
    if system.joints is None and system.bonds is None:
        variables, bounded = moving(system)[0], frozenset(found)
        for term in (term for total in listed for term in total.terms):
            ends = tails(reachable([term.node]), variables, places(system), bounded)
            exponentials |= ends.keys()
            found |= dict.fromkeys((one for one in ends.values() if one is not None), term.domain)
        exponentials |= distant(system, listed).keys()
    return found, frozenset(exponentials)


def distant(system: FamilySystem, totals: Iterable[Total]) -> dict[Node, tuple[Node, Node, Domain]]:
    """The exponentials in the terms of ``totals`` whose exponents are linear in a distance: its square, the
    slope, and whose it is."""
    listed, found = [*totals], dict[Node, tuple[Node, Node, Domain]]()
    if system.joints is None and system.bonds is None:
        variables = moving(system)[0]
        bounded = {one for one in poles(system, listed) if not one.symbols & system.time.symbols}
        for term in (term for total in listed for term in total.terms):
            for node, (b, slope) in shells(reachable([term.node]), variables, bounded).items():
                found[node] = b, slope, term.domain
    return found


@dataclass(frozen=True)
class Moved:
    """What coordinates and velocities do in a step: how far they are at most from straight lines, and the
    lengths of these, in arrays of each."""

    bounds: Mapping[Array, Array]
    shifts: Mapping[Array, Array]


def moved_by(system: FamilySystem, degrees: int) -> Moved:
    """New arrays of these."""
    both = system.q, system.v
    bounds, shifts = ({one: Array(Source.TOTAL, degrees) for one in both} for _ in range(2))
    return Moved(bounds, shifts)


def nearing(system: FamilySystem, totals: Iterable[Total], moved: Moved, span: Node) -> list[Term]:
    """For each pole the part of b by which it may become less in a step of the length ``span``, in which q
    is not straight by up to its bounds. The targets mean nothing."""
    bounds = moved.bounds[system.q]
    slots, graph, found, listed = system.slots, system.slots.graph, list[Term](), [*totals]
    for base, domain in slow(system, listed)[0].items():
        b = base * base if is_linear(base, places(system)) else base
        rate, slope, size = graph.diff(b, system.time), graph.zero, graph.zero
        for symbol, slot in slots.inside(base):
            if slot.array is system.q:
                one = graph.diff(b, symbol)
                bound = slots.symbol(domain, bounds, slot.table)
                rate += one * slots.symbol(domain, system.v, slot.table)
                slope, size = slope + one * one, size + bound * bound
        less = (slope * size) ** graph.number(0.5) - span * rate
        found.append(Term(domain, less / b, domain.together))
    return [*found, *crossing(system, listed, bounds, span)]


def shown_slowly(
    system: FamilySystem, totals: Iterable[Total]
) -> tuple[dict[Node, Domain], frozenset[Node], frozenset[Node]]:
    """What steps approach slowly that look at coordinates and velocities alike, in the terms of ``totals``,
    and whose it is; the functions that do not hide then, and what has no poles."""
    variables, seen = moving(system)[0], places(system) | system.slots.symbols_of(system.v)
    found, tame, plain = dict[Node, Domain](), set[Node](), set[Node]()
    for term in (term for total in totals for term in total.terms):
        listed, slow_ones, poleless = revealed(reachable([term.node]), variables, seen)
        found |= dict.fromkeys(listed, term.domain)
        tame |= slow_ones
        plain |= poleless
    return found, frozenset(tame), frozenset(plain)


def nearing_alike(system: FamilySystem, totals: Iterable[Total], moved: Moved, span: Node) -> list[Term]:
    """For each of these the part by which it may become less in a step of the length ``span``. The targets
    mean nothing."""
    slots, found = system.slots, list[Term]()
    for base, domain in shown_slowly(system, totals)[0].items():
        rows = list[tuple[Node, Node, Node]]()
        for symbol, slot in slots.inside(base):
            if slot.array in moved.bounds:
                given = moved.bounds[slot.array], moved.shifts[slot.array]
                bound, shift = (slots.symbol(domain, one, slot.table) for one in given)
                rows.append((symbol, bound, shift))
        part = lost(slots.graph, base, moving(system)[0], (system.time, span), rows)
        found.append(Term(domain, part, domain.together))
    return found


def crossing(system: FamilySystem, totals: Iterable[Total], bounds: Array, span: Node) -> Iterator[Term]:
    """The same for each exponential whose exponent u is linear in a distance: of 1 + (u/WIDTH)^2."""
    slots, graph = system.slots, system.slots.graph
    half = graph.number(0.5)
    seen = set[tuple[Node, Node]]()
    for node, (b, slope, domain) in distant(system, totals).items():
        u = node.arguments[0]
        if (u, b) in seen:
            continue
        seen.add((u, b))
        speed, trace, size = graph.zero, graph.zero, graph.zero
        coordinates = [(one, slot) for one, slot in slots.inside(b) if slot.array is system.q]
        for one, slot in coordinates:
            rate, bound = graph.diff(b, one), slots.symbol(domain, bounds, slot.table)
            trace, size = trace + graph.diff(rate, one) / 2, size + bound * bound
            v = slots.symbol(domain, system.v, slot.table)
            for other, place in coordinates:
                w = slots.symbol(domain, system.v, place.table)
                speed += graph.diff(rate, other) * v * w / 2
        steep = slope * slope
        moved = span * (steep * speed) ** half + (steep * trace * size) ** half
        high = WIDTH**2 + u * u
        yield Term(domain, 2 * moved * (1 + u * u) ** half / high, domain.together)
