"""Derivatives of a sum over arrays, taken once for each term and not for each member.

By the chain rule from the sum back to the coordinates (reverse mode; A. Griewank and A. Walther, Evaluating
Derivatives, 2008, ch. 3): what a slot was read from is what its derivative is added to.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Chain, Domain, Slots, Source, Term, Total, number_of, total_of


def slopes(
    root: Node, domain: Domain, totals: Sequence[Total], slots: Slots, *by: Array
) -> tuple[list[Total], list[Total]]:
    """d root/d ``by``, where ``root`` belongs to a domain of one member; and the totals that these take, in
    the order in which they can be computed.

    ``totals`` are those that ``root`` is made of, in such an order; those in ``by`` are as if given.
    """
    graph, zeros = slots.graph, np.zeros(1, dtype=np.int64)
    start = Total(Source.TOTAL, 1, (Term(domain, root, zeros),))
    changes: dict[Array, list[Term]] = {}
    known: dict[Array, Total] = {}
    made: list[Total] = []
    wanted = {*by, *totals}
    for total in (start, *reversed([one for one in totals if one not in by])):
        factor: Node | None = graph.one
        if total is not start:
            if total not in changes:
                continue
            known[total] = adjoint(total, changes.pop(total), graph)
            factor = number_of(known[total])
            if factor is None:
                made.append(known[total])
        for term in total.terms:
            change = factor
            for symbol, slot in slots.inside(term.node):
                if slot.array not in wanted:
                    continue
                if change is None:
                    change = slots.symbol(term.domain, known[total], term.targets)
                slope = change * graph.diff(term.node, symbol)
                if not slope.is_zero:
                    changes.setdefault(slot.array, []).append(Term(term.domain, slope, slot.table))
    return [total_of(one.count, changes.get(one, []), graph) for one in by], made


def adjoint(total: Total, terms: Sequence[Term], graph: Graph) -> Total:
    """What the terms of a total are multiplied with, where ``terms`` are what its sums are."""
    if not isinstance(total, Chain):
        return total_of(total.count, terms, graph)
    return total_of(total.count, terms, graph, total.tree, back=not total.back)


def factors(
    root: Node, slots: Slots, known: Callable[[Node], bool] = lambda _: False
) -> Mapping[Total, Node]:
    """The totals that ``root`` is a linear function of, directly or through others, with coefficients that
    are numbers or otherwise ``known``, and these coefficients. No other total is among them."""
    graph = slots.graph
    found: dict[Total, Node] = {}
    pending: list[tuple[Node, Node]] = [(root, graph.one)]
    while pending:
        node, factor = pending.pop()
        for symbol, slot in slots.inside(node):
            slope = graph.diff(node, symbol)
            if not isinstance(slot.array, Total) or slot.array.count > 1:
                continue
            if not slope.symbols or (graph.diff(slope, symbol).is_zero and known(slope)):
                found[slot.array] = found.get(slot.array, graph.zero) + factor * slope
                pending += [(one.node, factor * slope) for one in slot.array.terms if one.domain.count == 1]
    return found
