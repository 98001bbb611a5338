"""Merging of switches: several with the same argument become one.

Terms of a sum, or factors of a product, may jump where their sum or product does not. And a power of a switch
is a switch between powers, each of which has a series where it is taken."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable
from lagrange_cli.expression.signs import Sign, in_terms_of, proportional, signs
from lagrange_cli.mechanics.multiplied_out import monomials
from lagrange_cli.mechanics.substitution import rebuilt, rewritten, substituted

ROUNDED = 2.0**-45
"""Constants that cancel up to rounding leave at most this fraction of their size."""
MOST = 6
"""Switches in the base of a power: their branches, up to 2^6, are looked at one by one."""


def switches(nodes: Iterable[Node], moving: int) -> list[Node]:
    """The switches below ``nodes`` whose arguments move."""
    found = reachable(nodes)
    return [node for node in found if node.kind is Kind.SWITCH and node.arguments[0].symbols & moving]


def has_rates(node: Node, multiplier: Node | None = None) -> bool:
    """Whether a time derivative stands in it, of something that contains the multiplier."""
    inside = reachable([node], lambda one: multiplier is None or bool(one.symbols & multiplier.symbols))
    return any(one.kind is Kind.DDT for one in inside)


def vanishes_with(graph: Graph, node: Node, argument: Node) -> bool:
    """Whether ``node`` is 0 wherever ``argument`` is, by its normal form: one term of the argument is put in
    terms of the others. A product is 0 where a factor is."""
    factors = factors_of(graph.split_coefficient(argument)[1])
    if len(factors) > 1 and all(exponent > 0 for _, exponent in factors):
        return all(vanishes_with(graph, node, one) for one, _ in factors)
    node = without_powers(graph, node, argument)
    if node.is_zero:
        return True
    for left in where_it_vanishes(graph, node, argument):
        if left.is_zero or (left.kind is Kind.NUMBER and abs(left.data) <= ROUNDED * largest(node)):
            return True
    return False


def where_it_vanishes(graph: Graph, node: Node, argument: Node) -> Iterator[Node]:
    """``node`` where ``argument`` is 0, in several ways: one of its terms is put in terms of the others."""
    _, argument = graph.split_coefficient(argument)
    if argument.kind is not Kind.SUM:
        yield where_zero(graph, node, argument)
        return
    for term, others in solutions(graph, argument):
        yield substituted(graph, [node], {term: others})[0]


def on_a_sphere(graph: Graph, node: Node, argument: Node) -> Iterator[Node]:
    """``node`` where an argument is 0 that contains a length: this, and its square, in whose powers forces
    along it are written, are put in terms of the others, and products multiplied out."""
    _, argument = graph.split_coefficient(argument)
    for term, others in solutions(graph, argument) if argument.kind is Kind.SUM else ():
        if term.kind is Kind.PRODUCT and len(term.arguments) == 1:
            ((base, exponent),) = factors_of(term)
            whole = graph.product([(others, 1.0 / exponent)])
            left = substituted(graph, [node], {base: whole, term: others})[0]
            left = substituted(graph, [left], {graph.product([(whole, exponent)]): others})[0]
            terms = monomials(graph, left)
            yield left if terms is None else graph.sum(terms)


def solutions(graph: Graph, total: Node) -> Iterator[tuple[Node, Node]]:
    """The terms of a sum that is 0, each with what it is in terms of the others, unless these contain it."""
    constant, coefficients = total.data
    for term, coefficient in zip(total.arguments, coefficients):
        rest = [(a, -k / coefficient) for a, k in zip(total.arguments, coefficients) if a is not term]
        others = graph.sum([(graph.constant(constant), -1.0 / coefficient), *rest])
        if term not in reachable([others]):
            yield term, others


def where_zero(graph: Graph, node: Node, argument: Node) -> Node:
    """``node`` where ``argument`` is 0: powers of it and of its multiples in one product count together."""
    node, gone = without_powers(graph, node, argument), {}
    for one in reachable([node]):
        if one.kind is Kind.PRODUCT:
            multiples = [
                e for a, e in zip(one.arguments, one.data) if graph.split_coefficient(a)[1] is argument
            ]
            if len(multiples) > 1 and sum(multiples) > 0:
                gone[one] = graph.zero
    return substituted(graph, [node], {**gone, argument: graph.zero})[0]


def without_powers(graph: Graph, node: Node, argument: Node) -> Node:
    """``node`` without powers of what vanishes with ``argument`` whose exponents do not change, and are not
    known yet: those of contact forces are positive."""
    gone = {}
    for one in reachable([node], lambda one: bool(one.symbols)):
        if one.kind is Kind.POWER and not one.arguments[1].symbols & argument.symbols:
            base = one.arguments[0]
            if base.symbols & argument.symbols and vanishes_with(graph, base, argument):
                gone[one] = graph.zero
        elif one.kind is Kind.SWITCH and one.arguments[1].is_zero and is_undefined(one.arguments[2]):
            gone[one] = graph.zero
    return substituted(graph, [node], gone)[0] if gone else node


def is_undefined(node: Node) -> bool:
    """Whether it is no number, as a power of 0 with a negative exponent."""
    return node.kind is Kind.NUMBER and math.isnan(node.data)


def largest(node: Node) -> float:
    """The largest constant of sums below ``node``: what is left of a rounded one is a small part of it."""
    return max((abs(float(one.data[0])) for one in reachable([node]) if one.kind is Kind.SUM), default=0.0)


def one_sided(graph: Graph, nodes: Sequence[Node], moving: int) -> Sequence[Node]:
    """``nodes`` that have, where a switch changes, the value of both sides if this is one: sign(u)**2 is 1
    where u = 0, although sign(u) is 0 there."""
    return Merging(graph, moving).merged(nodes) if switches(nodes, moving) else nodes


def _has_zero(graph: Graph, node: Node) -> bool:
    """Whether a branch is 0."""
    _, inner = graph.split_coefficient(node)
    branches = inner.arguments[1:] if inner.kind is Kind.SWITCH else ()
    return node.is_zero or any(_has_zero(graph, one) for one in branches)


def _known_side(u: Node, argument: Node, side: int) -> int | None:
    """The branch of a switch by ``u`` within the branch ``side`` of one by ``argument``, if that tells it."""
    if u is argument:
        return side
    if u.symbols != argument.symbols:
        return None
    ratio, rest = in_terms_of(argument, u)
    slope = ratio if side == 1 else -ratio
    return 1 if slope > 0 < rest else 2 if slope < 0 > rest else None


class Merging:
    """Merges switches whose arguments are among what is ``moving``, a bit set of symbols."""

    def __init__(self, graph: Graph, moving: int) -> None:
        self.graph, self.moving = graph, moving
        self._made: dict[Node, Node] = {}
        self._known: dict[Node, Sign] = {}

    def merged(self, nodes: Sequence[Node]) -> tuple[Node, ...]:
        """``nodes`` with one switch in place of several by the same argument, where these are terms of a sum
        or factors of a product: what jumps in each of them may cancel."""
        made = self._made
        for node in reachable(nodes, lambda node: node not in made):
            arguments = [made[argument] for argument in node.arguments]
            if node.kind is Kind.SUM:
                terms = [(self.graph.constant(node.data[0]), 1.0), *zip(arguments, node.data[1])]
                made[node] = self.graph.sum(self._united(terms, self.graph.sum))
            elif node.kind is Kind.PRODUCT:
                bases = [self._base(a) if e != int(e) else a for a, e in zip(arguments, node.data)]
                beside = any(self._switches(self.graph.split_coefficient(a)[1]) for a in bases)
                factors = [
                    (self._lifted(a) if e == int(e) and (beside or e != 1) else a, e)
                    for a, e in zip(bases, node.data)
                ]
                parts = [part for factor in factors for part in self._without_scale(*factor)]
                made[node] = self.graph.product(self._united(parts, self.graph.product))
            elif node.kind is Kind.POWER:
                made[node] = self._raised(self._base(arguments[0]), arguments[1])
            elif node.kind is Kind.FUNCTION:
                made[node] = self._applied(node, [*map(self._lifted, arguments)])
            elif node.kind is Kind.DDT:
                made[node] = self.graph.ddt(arguments[0])
            elif node.kind is Kind.SWITCH:
                made[node] = self._switched(node.data, *arguments)
            else:
                made[node] = rebuilt(self.graph, node, arguments)
        return tuple(made[node] for node in nodes)

    def _switches(self, node: Node) -> bool:
        """Whether it is a switch that changes."""
        return node.kind is Kind.SWITCH and bool(node.arguments[0].symbols & self.moving)

    def _without_scale(self, node: Node, exponent: float) -> list[tuple[Node, float]]:
        """A power of a number times a switch as powers of both; a root of a switch as a switch of roots."""
        scale, inner = self.graph.split_coefficient(node)
        if not self._switches(inner):
            return [(node, exponent)]
        if exponent != int(exponent):
            return self._without_scale(self._raised(node, self.graph.constant(exponent)), 1)
        return (
            [(node, exponent)]
            if scale == 1.0
            else [(self.graph.constant(scale), exponent), (inner, exponent)]
        )

    def _raised(self, base: Node, exponent: Node) -> Node:
        """A power of a number times a switch, as a switch between powers; a power of 0 has no series."""
        scale, inner = self.graph.split_coefficient(base)
        if self._switches(inner):
            argument, above, below = inner.arguments
            above, below = (self._raised(scale * one, exponent) for one in (above, below))
            return self._between(argument, above, below)
        if base.is_zero:
            return self.graph.switch(exponent, self.graph.zero, self.graph.constant(math.nan))
        positive = [one for one in factors_of(inner) if signs(one[0], self._known) is Sign.POSITIVE]
        rest = self.graph.product([(base, 1), *((one, -e) for one, e in positive)])
        powers = [(self.graph.power(one, exponent), e) for one, e in positive]
        return self.graph.product([*powers, (self.graph.power(rest, exponent), 1)])

    def _base(self, node: Node) -> Node:
        """The base of a power without a series at 0, as a switch if it is 0 all along in some branch, or a
        product with one."""
        lifted = self._multiplied(self._lifted(node))
        if self._switches(self.graph.split_coefficient(lifted)[1]) or has_rates(node):
            return lifted
        found = {one.arguments[0]: one for one in switches([node], self.moving)}
        if not 0 < len(found) <= MOST:
            return lifted
        branched = self._branched(node, [*found])
        return branched if _has_zero(self.graph, branched) else lifted

    def _branched(self, node: Node, arguments: Sequence[Node]) -> Node:
        """``node`` as switches by these arguments between expressions without such switches."""
        if not arguments:
            return node
        argument, *rest = arguments
        above, below = (self._branched(self._on_side(node, argument, side), rest) for side in (1, 2))
        return self.graph.switch(argument, above, below)

    def _lifted(self, node: Node) -> Node:
        """A sum that contains switches as a switch between sums, unless it contains rates."""
        if node.kind is not Kind.SUM or has_rates(node):
            return node
        found = next((one for one in node.arguments if self._switches(one)), None)
        if found is None:
            return node
        place = node.arguments.index(found)
        rest = node - node.data[1][place] * found
        first, second = (self._lifted(rest + node.data[1][place] * one) for one in found.arguments[1:])
        return self._between(found.arguments[0], first, second)

    def _multiplied(self, node: Node) -> Node:
        """A product that contains switches as a switch between products, unless it contains rates."""
        inner = self.graph.split_coefficient(node)[1]
        if inner.kind is not Kind.PRODUCT or has_rates(node):
            return node
        found = next(((one, e) for one, e in factors_of(inner) if self._switches(one)), None)
        if found is None:
            return node
        switch, exponent = found
        rest = self.graph.product([(node, 1), (switch, -exponent)])
        first, second = (
            self._multiplied(self.graph.product([(rest, 1), (one, exponent)])) for one in switch.arguments[1:]
        )
        return self._between(switch.arguments[0], first, second)

    def _applied(self, node: Node, arguments: list[Node]) -> Node:
        """A function of switches as a switch between functions."""
        found = next((i for i, one in enumerate(arguments) if self._switches(one)), None)
        if found is None:
            return rebuilt(self.graph, node, arguments)
        first, second = (
            self._applied(node, [*arguments[:found], one, *arguments[found + 1 :]])
            for one in arguments[found].arguments[1:]
        )
        return self._between(arguments[found].arguments[0], first, second)

    def _switched(self, at: int, argument: Node, above: Node, below: Node) -> Node:
        """A switch; one whose argument is a switch is one by what that depends on."""
        scale, inner = self.graph.split_coefficient(argument)
        if inner.kind is not Kind.SWITCH or not inner.arguments[0].symbols & self.moving:
            return self._between(argument, above, below, at)
        first, second = (self._switched(at, scale * one, above, below) for one in inner.arguments[1:])
        return self._between(inner.arguments[0], first, second, inner.data)

    def _between(self, argument: Node, above: Node, below: Node, at: int = 0) -> Node:
        """A switch in whose branches no other one by the same argument stands: its side is known there,
        unless the argument is a constant, which may be 0."""
        if argument.symbols & self.moving:
            above, below = self._within(above, argument, 1), self._within(below, argument, 2)
        return self.graph.switch(argument, above, below, at)

    def _within(self, branch: Node, argument: Node, side: int) -> Node:
        """A branch without switches whose side is known there; others may come together then."""
        taken = self._on_side(branch, argument, side)
        return branch if taken is branch else self.merged((taken,))[0]

    def _on_side(self, node: Node, argument: Node, side: int) -> Node:
        """``node`` where its switches by ``argument`` take the branch ``side``, and those by others that have
        one sign there, as y - 9 has where y < 0."""

        def change(one: Node, arguments: list[Node]) -> Node | None:
            taken = _known_side(one.arguments[0], argument, side) if one.kind is Kind.SWITCH else None
            if taken:
                return arguments[taken]
            derived = one.kind is Kind.DDT and arguments[0] is not one.arguments[0]
            return self.graph.ddt(arguments[0]) if derived else None

        return rewritten(self.graph, [node], change)[0]

    def _ratio(self, node: Node, argument: Node) -> Node:
        """The number by which an argument is multiplied in ``node``, a sum of the same terms or itself."""
        if node is argument:
            return self.graph.one
        return self.graph.constant(node.data[1][0] / argument.data[1][0])

    def _united(
        self, parts: list[tuple[Node, float]], total: Callable[[Iterable[tuple[Node, float]]], Node]
    ) -> list[tuple[Node, float]]:
        """Terms with coefficients, or factors with exponents: of switches by one argument one each."""
        grouped: dict[Node, list[tuple[Node, float]]] = {}
        for node, number in parts:
            if node.kind is Kind.SWITCH and node.arguments[0].symbols & self.moving:
                grouped.setdefault(node.arguments[0], []).append((node, number))
        plain = [node for node, _ in parts if node.symbols & self.moving]
        if all(len(group) == 1 for group in grouped.values()) and total == self.graph.sum and len(plain) > 1:
            return parts
        united = {node for group in grouped.values() for node, _ in group}
        rest = [(node, number) for node, number in parts if node not in united]
        if total == self.graph.sum and len(grouped) == 1 and len(plain) == len(united):  # constants go along
            grouped = {argument: [*group, *rest] for argument, group in grouped.items()}
            rest = []
        for argument, group in grouped.items():
            if total == self.graph.product:  # u/|u| has its value on either side, and so has (2 u)/|u|
                own = {node for node, _ in rest if proportional(node, argument)}
                scales = [(self._ratio(node, argument), e) for node, e in rest if node in own]
                group += [(argument, e) for node, e in rest if node in own]
                rest = [*scales, *((node, e) for node, e in rest if node not in own)]
            above, below = (
                total([(node.arguments[i] if node in united else node, number) for node, number in group])
                for i in (1, 2)
            )
            if len(group) > 1:  # switches by other arguments may come together in a branch
                above, below = self.merged((above, below))
            sides = {node.data for node, _ in group if node in united}
            rest.append((self._between(argument, above, below, sides.pop() if len(sides) == 1 else 0), 1))
        return rest
