"""``SeriesBuilder``: the series of one node after the other, each made once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import cast

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.series.factoring import associate, reciprocals
from lagrange_cli.series.program import FREE, SHORT, UNBOUNDED, Op, Series
from lagrange_cli.series.sums import Sums


@dataclass
class SeriesBuilder:
    graph: Graph
    variables: int
    series: list[Series] = field(default_factory=list)
    by_node: dict[Node, int] = field(default_factory=dict)
    derivatives: dict[int, int] = field(default_factory=dict)
    products: dict[tuple[int, int], int] = field(default_factory=dict)
    powers: dict[tuple[int, Node], int] = field(default_factory=dict)
    selected: dict[tuple[Node, int, int, int], int] = field(default_factory=dict)
    pairs: dict[Node, tuple[Node, Node]] = field(default_factory=dict)
    """Which two parts a product is multiplied from."""
    inverted: set[Node] = field(default_factory=set)
    """The nodes whose negative integer powers are made from their reciprocal."""
    pending: list[Node] = field(default_factory=list)
    sums: Sums = field(default_factory=Sums)
    """Series of sums without a constant."""
    unfinished: list[tuple[int, tuple[int, ...], Node]] = field(default_factory=list)
    """Rates of functions whose partial derivatives are not lowered yet: (rate, arguments' rates,
    function)."""
    symbols: dict[Node, Node] = field(default_factory=dict)
    """The symbols of rows of the state that follow from others, by what they are."""
    rates: set[int] = field(default_factory=set)
    """The rates of all functions."""

    def add(self, series: Series) -> int:
        self.series.append(series)
        return len(self.series) - 1

    def follow(self, q: Node, place: Node | None, v: Node, speed: Node) -> None:
        """The series of a coordinate and of its velocity that are functions of others, which are lowered.

        They are rows of the state: each is a series of its own, and its coefficient 0 is read from there.
        """
        velocity = self.own(speed, v)
        if place is None:
            order = self.series[velocity].order - 1
            coordinate = self.add(Series(Op.PRIMITIVE, (velocity,), order=max(order, FREE)))
        else:
            coordinate = self.own(place, q)
        self.by_node[q], self.by_node[v] = coordinate, velocity
        self.derivatives[coordinate] = velocity

    def own(self, node: Node, symbol: Node) -> int:
        """A series of its own for what is lowered already, which takes its place."""
        index = self.by_node[node]
        one = self.series[index]
        if one.op is Op.LINEAR and one.node is None and node.symbols & self.variables:
            self.symbols[node] = symbol
            self.by_node[node] = made = self.add(replace(one, node=symbol))
            return made
        copied = (self.graph.zero, (self.graph.one,))
        return self.add(Series(Op.LINEAR, (index,), copied, node=symbol, order=one.order, degree=one.degree))

    def integral(self, rate: int) -> int:
        """The quadrature of a series, which may depend on accelerations."""
        order = self.series[rate].order - 1
        return self.add(Series(Op.PRIMITIVE, (rate,), order=order if order > 0 else FREE))

    def lower_all(self, roots: Iterable[Node]) -> None:
        """Lower ``roots`` and, until none is left, the partial derivatives that they need."""
        self.pending = list(roots)
        finished = len(self.unfinished)
        while self.pending:
            batch, self.pending = self.pending, []
            nodes = reachable(batch, lambda n: n not in self.by_node)
            parts = (self.graph.split_parameters(node, self.variables)[1] for node in nodes)
            products = [part for part in dict.fromkeys(parts) if part.kind is Kind.PRODUCT]
            self.pairs |= associate(self.graph, products)
            self.inverted |= reciprocals(products)
            for node in _smaller_sums_first(nodes):
                if node.symbols & self.variables or node in batch:
                    self.by_node[node] = self.lower(node)
        for index, rates, node in self.unfinished[finished:]:
            terms = []
            for rate, partial in zip(rates, self.moving_partials(node)):
                scale, moving = self.graph.split_parameters(partial, self.variables)
                terms.append((self.multiply(rate, self.moving(moving)), scale))
            self.series[index].arguments = tuple(product for product, _ in terms)
            self.series[index].data = (self.graph.zero, tuple(scale for _, scale in terms))

    def lower(self, node: Node) -> int:
        """The series of one node whose arguments are lowered already."""
        if not node.symbols & self.variables:
            return self.linear(node, [])
        if node.kind is Kind.SUM:
            constant, coefficients = node.data
            terms: dict[int, Node] = {}
            fixed = self.graph.constant(constant)
            for argument, coefficient in zip(node.arguments, coefficients):
                if not argument.symbols & self.variables:
                    fixed = fixed + coefficient * argument
                    continue
                scale, moving = self.graph.split_parameters(argument, self.variables)
                index = self.moving(moving)
                terms[index] = terms.get(index, self.graph.zero) + coefficient * scale
            return self.linear(fixed, list(terms.items()))
        if node.kind is Kind.PRODUCT:
            scale, moving = self.graph.split_parameters(node, self.variables)
            index = self.moving(moving)
            return index if scale is self.graph.one else self.linear(self.graph.zero, [(index, scale)])
        if node.kind is Kind.DDT:
            return self.derivative(self.by_node[node.arguments[0]])
        if node.kind is Kind.POWER:
            base, exponent = node.arguments
            if not exponent.symbols & self.variables:
                return self.power(self.by_node[base], exponent)
        if node.kind is Kind.SWITCH:
            return self.switch(node)
        return self.compose(node)

    def switch(self, node: Node) -> int:
        """One branch or the other: by a constant, or by the sign of a moving argument at the start of the
        step."""
        u, above, below = node.arguments
        first, second = (
            self.by_node[a] if a.symbols & self.variables else self.linear(a, []) for a in (above, below)
        )
        sources = (self.by_node[u],) if u.symbols & self.variables else ()
        return self.select((u, node.data), first, second, sources)

    def select(self, decides: tuple[Node, int], above: int, below: int, sources: tuple[int, ...] = ()) -> int:
        key = (*decides, above, below)
        if key not in self.selected:
            branches = (above, below)
            degree = max(self.series[i].degree for i in branches)
            made = Series(
                Op.SELECT, branches, decides, sources=sources,
                order=self.highest((*branches, *sources)), degree=degree,
            )  # fmt: skip
            self.selected[key] = self.add(made)
        return self.selected[key]

    def moving(self, node: Node) -> int:
        """The series of a product without constant factors (or of any lowered node)."""
        if node in self.by_node:
            return self.by_node[node]
        if node.kind is not Kind.PRODUCT:
            self.by_node[node] = self.lower(node)
            return self.by_node[node]
        if node in self.pairs:
            a, b = self.pairs[node]
            index = self.multiply(self.moving(a), self.moving(b))
        else:
            index, *others = (self.factor(a, e) for a, e in zip(node.arguments, node.data))
            for other in others:
                index = self.multiply(index, other)
        self.by_node[node] = index
        return index

    def factor(self, base: Node, exponent: int | float) -> int:
        """The series of a power with a number as its exponent."""
        index = self.by_node[base]
        if isinstance(exponent, int) and (exponent > 0 or base in self.inverted):
            return self.repeated(index if exponent > 0 else self.power(index, -self.graph.one), abs(exponent))
        return self.power(index, self.graph.constant(exponent))

    def repeated(self, index: int, exponent: int) -> int:
        """A whole power from two halves."""
        if exponent == 1:
            return index
        half = exponent // 2
        return self.multiply(self.repeated(index, half), self.repeated(index, exponent - half))

    def multiply(self, a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in self.products:
            degree = min(self.series[a].degree + self.series[b].degree, UNBOUNDED)
            self.products[key] = self.add(
                Series(
                    Op.MULTIPLY, key, order=self.highest(key), degree=degree if degree <= SHORT else UNBOUNDED
                )
            )
        return self.products[key]

    def power(self, base: int, exponent: Node) -> int:
        key = (base, exponent)
        if key not in self.powers:
            degree = 0 if self.series[base].degree == 0 else UNBOUNDED
            self.powers[key] = self.add(
                Series(Op.POWER, (base,), exponent, order=self.series[base].order, degree=degree)
            )
        return self.powers[key]

    def linear(self, constant: Node, terms: list[tuple[int, Node]]) -> int:
        terms = [(index, scale) for index, scale in terms if not scale.is_zero]
        if constant.is_zero and len(terms) == 1 and terms[0][1] is self.graph.one:
            return terms[0][0]
        whole = frozenset(terms)
        if constant.is_zero and whole in self.sums.known:
            return self.sums.known[whole]
        shared = self.sums.longest_part(whole)
        if shared is not None:
            rest = (term for term in terms if term not in shared)
            terms = [(self.sums.known[shared], self.graph.one), *rest]
        arguments = tuple(index for index, _ in terms)
        degree = max((self.series[i].degree for i in arguments), default=0)
        made = self.add(
            Series(
                Op.LINEAR,
                arguments,
                (constant, tuple(scale for _, scale in terms)),
                order=self.highest(arguments),
                degree=degree,
            )
        )
        if constant.is_zero and len(whole) > 1:
            self.sums.enter(whole, made)
        return made

    def derivative(self, index: int) -> int:
        """The derivative of a series; that of a sum or a function in terms of what they are made of."""
        if index not in self.derivatives:
            one = self.series[index]
            if one.op is Op.LINEAR and one.degree == UNBOUNDED and index not in self.rates:
                assert isinstance(one.data, tuple)
                terms = [(self.derivative(i), scale) for i, scale in zip(one.arguments, one.data[1])]
                made = self.linear(self.graph.zero, terms)
            elif one.op is Op.SELECT and one.degree == UNBOUNDED:
                above, below = map(self.derivative, one.arguments)
                made = self.select(cast("tuple[Node, int]", one.data), above, below, one.sources)
            else:
                order = one.order + 1 if one.order >= 0 else FREE
                degree = max(one.degree - 1, 0) if one.degree != UNBOUNDED else UNBOUNDED
                made = self.add(Series(Op.DERIVATIVE, (index,), order=order, degree=degree))
            self.derivatives[index] = made
        return self.derivatives[index]

    def compose(self, node: Node) -> int:
        """A function: its rate, sum_i (its derivative by u_i) u_i', and the primitive of that."""
        arguments = tuple(a for a in node.arguments if a.symbols & self.variables)
        sources = tuple(self.by_node[a] for a in arguments)
        rates = tuple(self.derivative(i) for i in sources)
        rate = self.add(Series(Op.LINEAR, (), (self.graph.zero, ()), order=self.highest(rates)))
        self.unfinished.append((rate, rates, node))
        self.rates.add(rate)
        self.pending += [p for p in self.moving_partials(node) if p not in self.by_node]
        index = self.add(
            Series(Op.PRIMITIVE, (rate,), node=self.named(node), sources=sources, order=self.highest(sources))
        )
        self.derivatives[index] = rate
        return index

    def named(self, node: Node) -> Node:
        """A function with the symbols of arguments that are rows of the state."""
        arguments = [self.symbols.get(a, a) for a in node.arguments]
        if arguments == [*node.arguments]:
            return node
        if node.kind is Kind.POWER:
            return self.graph.power(*arguments)
        return self.graph.function(str(node.data), arguments)

    def moving_partials(self, node: Node) -> list[Node]:
        """Partial derivatives by the arguments that move, in terms of the node itself where it is a power.

        (In terms of another power, each would call for the next.)
        """
        partials = self.graph.partials(node)
        if node.kind is Kind.POWER:
            base, exponent = node.arguments
            partials = (node * exponent / base, partials[1])
        pairs = zip(node.arguments, partials)
        return [partial for argument, partial in pairs if argument.symbols & self.variables]

    def highest(self, indices: Iterable[int]) -> int:
        return max((self.series[i].order for i in indices), default=FREE)


def _smaller_sums_first(nodes: Sequence[Node]) -> list[Node]:
    """Arguments before users and, at equal height, short sums before the long ones that contain them."""
    height: dict[Node, int] = {}
    for node in nodes:
        height[node] = 1 + max((height.get(a, 0) for a in node.arguments), default=0)
    return sorted(nodes, key=lambda n: (height[n], len(n.arguments), n.number))
