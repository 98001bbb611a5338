"""Energies that jump: the force there is infinite, and no motion is defined.

L, U and Rayleigh's function may have kinks, where forces jump. Momenta may have kinks in time; so may
velocities of masses, and the slopes of constraints; where these jump, the force is infinite. Whether
something is continuous where a switch changes may depend on the values of parameters: ``refuse_jumps``
refuses what jumps with any, ``refuse_jumps_in_numbers`` what jumps with those that stand in the model.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TypeAlias

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, numbered, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

ROUNDING = 1e-9
"""A jump this small beside the terms that it is the difference of is rounding."""
NEVER_ZERO = Kind.NUMBER, Kind.SYMBOL, Kind.PRODUCT
"""Products of parameters, which are 0 only if one of them is."""
POINTS = 5
"""Random arguments at which there must be a jump."""
PLAIN, NEARBY = 1e-6, 1e-7
"""A jump at a root is larger than this part of the terms, and there at this distance, too."""
PLACES = [-(10.0 ** (k / 6)) for k in range(18, -18, -1)] + [10.0 ** (k / 6) for k in range(-17, 19)]
LENGTHS, SEEN = (1e-8, 1e-10, 1e-12), 1e-10
"""How long secants are, and which part of a position is more than rounding."""
AT_ONCE = 99
"""So many times steeper is a secant a hundredth as long across a jump."""
HALVINGS, MOST_SYMBOLS = 60, 4
"""Between which places roots are looked for, how exactly, and in how many directions."""


@dataclass(frozen=True)
class Continuous:
    """An expression that must not jump where any of ``symbols`` changes, and what the file calls it: its
    ``key`` there, its ``name`` within, and whether it is a slope of that. It matters only where the
    ``constraint`` is 0, if there is one."""

    key: str
    node: Node
    symbols: Sequence[Node]
    name: str = ""
    slope: bool = False
    constraint: Node | None = None

    def is_avoided(self, graph: Graph, u: Node, moving: int) -> bool:
        """Whether the constraint is not 0 where u is: abs(r) = l keeps away from r = 0. Parameters may decide
        that; where they are symbols, numbers are to follow."""
        if self.constraint is None:
            return False
        for at in solutions(graph, u, moving):
            left = substituted(graph, sides(graph, self.constraint, u), at)
            return all(is_never_zero(one, moving) for one in left)
        return False

    @property
    def moves(self) -> bool:
        """Whether its rate is a velocity."""
        return self.key in ("embedding", "constraints") and not self.slope

    def refusal(self, when: str = "", *, rush: bool = False) -> InfiniteForce:
        """The error if it jumps, or changes in a ``rush``."""
        return InfiniteForce(self.key, when, name=self.name, kink=self.slope, rush=rush)


def is_never_zero(node: Node, moving: int) -> bool:
    """Whether that is visible; of what does not move, numbers are to tell it."""
    if not node.symbols & moving:
        return not node.is_zero
    return any(signs(one, {}) is Sign.POSITIVE for one in (node, -node))


Case: TypeAlias = "tuple[Continuous, Node, list[Node], Node]"
"""What must not jump, the argument of a switch in it, symbols of this, and the terms that change with it."""


def refuse_jumps(model: Model[Node]) -> None:
    """Raises ``InfiniteForce`` where an energy has a jump of constant size, or where velocities jump."""
    graph = graph_of(model)
    places = variables(model) & ~model.time.symbols
    for one, u, _, part in switched(model):
        if one.is_avoided(graph, u, variables(model)):
            continue
        if one.moves and not u.symbols & places and rushes(part, u, model.time):
            raise one.refusal(rush=True)
        if is_certain(graph, *sides(graph, part, u), u, variables(model)):
            raise one.refusal()


def switched(model: Model[Node]) -> Iterator[Case]:
    """What must not jump in a model, by switches."""
    return cases(graph_of(model), continuous(model))


def cases(graph: Graph, listed: Iterable[Continuous]) -> Iterator[Case]:
    """What must not jump, and the arguments of switches in it: with those of its symbols that are in the
    argument, and the terms that change with it."""
    for one in listed:
        for u, part in parts(graph, one.node).items():
            own = [symbol for symbol in one.symbols if symbol.symbols & u.symbols]
            if own:
                yield one, u, own, part


def continuous(model: Model[Node]) -> Iterator[Continuous]:
    """The expressions that must not jump."""
    graph, by_place, at_any_time = graph_of(model), [*model.q, *model.v], [*model.q, model.time]
    given = model.lagrangian
    key, energy = ("potential", model.potential) if given is None else ("lagrangian", given)
    yield Continuous(key, energy, by_place)
    for v in model.v:  # an energy may be switched on; a momentum p = dL/dv that jumps takes an infinite force
        if energy.symbols & v.symbols:
            yield Continuous(key, graph.diff(energy, v), [model.time])
    yield Continuous("dissipation", model.dissipation, model.v)
    for particle in model.particles:
        if particle.mass.is_zero or not switching([*particle.position, *particle.velocity]):
            continue
        name = particle.body or particle.name
        for x in particle.position:
            yield Continuous("embedding", x, at_any_time, name)
        kinetic = graph.sum([(particle.mass * u * u, 0.5) for u in particle.velocity])
        yield Continuous("embedding", kinetic, model.q, name, slope=True)
        for v in model.v:
            yield Continuous("embedding", graph.diff(kinetic, v), [model.time], name, slope=True)
    for event in model.events:
        if switching([event.argument]):
            yield Continuous("events", event.argument, [*model.q, *model.v, model.time], event.name)
    places = numbered(at_any_time)
    for constraint in model.constraints:
        f, key = constraint.expression, "constraints" if constraint.holonomic else "nonholonomic"
        slopes = [*graph.gradient(f, places).values()]
        if not switching([f, *slopes]):
            continue
        own = f if constraint.holonomic else None
        yield Continuous(key, f, at_any_time, constraint.name, constraint=own)
        for slope in slopes if constraint.holonomic else ():
            yield Continuous(key, slope, at_any_time, constraint.name, slope=True, constraint=own)


def switching(nodes: Sequence[Node]) -> bool:
    """Whether there is a switch below the nodes."""
    return any(one.kind is Kind.SWITCH for one in reachable(nodes))


def parts(graph: Graph, node: Node) -> dict[Node, Node]:
    """The arguments of the switches below a node, each with the terms of the node that change with it."""
    found: dict[Node, list[tuple[Node, float]]] = {}
    for term, coefficient in addends(graph, node):
        for u in arguments(term):
            found.setdefault(u, []).append((term, coefficient))
    return {u: graph.sum(terms) for u, terms in found.items()}


def addends(graph: Graph, node: Node) -> list[tuple[Node, float]]:
    """The terms of a sum, or of a sum times something else, with their coefficients."""
    if node.kind is Kind.PRODUCT:
        factors = factors_of(node)
        sums = [one for one in factors if one[0].kind is Kind.SUM and one[1] == 1 and arguments(one[0])]
        if len(sums) == 1:
            rest = [one for one in factors if one is not sums[0]]
            return [(graph.product([*rest, (x, 1)]), c) for x, c in terms_of(sums[0][0])]
    return terms_of(node)


def refuse_jumps_in_numbers(model: Model[Node], whose: str = "this run") -> None:
    """Raises ``InfiniteForce`` where an energy jumps, in a model that has numbers in place of parameters:
    those of ``whose``."""
    from lagrange_cli.mechanics.switching.switches import vanishes_with  # seldom needed

    graph = graph_of(model)
    for one, u, own, part in switched(model):
        if one.is_avoided(graph, u, variables(model)):
            continue
        above, below = sides(graph, part, u)
        if vanishes_with(graph, above - below, u):
            continue
        if is_certain(graph, above, below, u, variables(model)) or jumps_at_a_root(above, below, u, own):
            raise one.refusal(f"with the parameters of {whose}, ")


def jumps_at_a_root(above: Node, below: Node, u: Node, own: Sequence[Node]) -> bool:
    """Whether the sides differ at a root of u, found on lines through random states in the directions of its
    ``own`` symbols: by a jump that is there in its neighbourhood, too."""
    source = random.Random(0)
    names = {str(one.data) for one in reachable([above, below, u]) if one.kind is Kind.SYMBOL}

    def value(node: Node, values: Mapping[str, float]) -> float:
        found: float = evaluate([node], values)[0][node]
        return found

    for symbol in own[:MOST_SYMBOLS]:
        name = str(symbol.data)
        for _ in range(POINTS):
            values = {one: source.uniform(0.2, 1.3) * source.choice((-1, 1)) for one in sorted(names)}
            for root in roots(lambda x: value(u, {**values, name: x})):  # noqa: B023
                there, close = ({**values, name: x} for x in (root, root + NEARBY * max(1.0, abs(root))))
                each, size = evaluate([above, below], there)
                jump = each[above] - each[below]
                if not abs(jump) > PLAIN * max(size[above], size[below]):
                    continue
                if abs(value(above, close) - value(below, close) - jump) <= 0.1 * abs(jump):
                    return True
    return False


def roots(function: Callable[[float], float]) -> Iterator[float]:
    """Where a function is 0 or changes its sign between some places, by bisection."""
    ends = [(x, function(x)) for x in PLACES]
    yield from (x for x, y in ends if y == 0)
    for (low, first), (high, last) in pairwise(ends):
        if first * last < 0:
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if function(middle) * first > 0 else (low, middle)
            yield low


def rushes(part: Node, u: Node, time: Node) -> bool:
    """Whether a position changes infinitely fast at a time when u = 0, as max(0, t - 1)**0.5 does at t = 1.

    Its secants to this time grow like a power of how short they are.
    """
    source, name = random.Random(0), str(time.data)
    names = {str(one.data) for one in reachable([part, u]) if one.kind is Kind.SYMBOL}
    for _ in range(POINTS):
        others = {one: source.uniform(0.2, 1.3) for one in sorted(names)}

        def value(node: Node, t: float) -> float:
            found: float = evaluate([node], {**others, name: t})[0][node]  # noqa: B023
            return found

        for root in roots(partial(value, u)):
            for side in (1, -1):
                ends = [root + side * length * max(1.0, abs(root)) for length in LENGTHS]
                steps = [abs(value(part, t) - value(part, root)) for t in ends]
                secants = [step / abs(t - root) for step, t in zip(steps, ends)]
                seen = all(math.isfinite(one) for one in steps) and steps[-1] > SEEN * max(steps[0], 1.0)
                if seen and all(2 * a < b < AT_ONCE * a for a, b in pairwise(secants)):
                    return True
    return False


def arguments(node: Node) -> list[Node]:
    """The arguments of the switches below a node."""
    return list(dict.fromkeys(one.arguments[0] for one in reachable([node]) if one.kind is Kind.SWITCH))


def sides(graph: Graph, node: Node, u: Node) -> tuple[Node, Node]:
    """``node`` where u > 0, and where u < 0."""
    switches = [one for one in reachable([node]) if one.kind is Kind.SWITCH and one.arguments[0] is u]
    above, below = (
        substituted(graph, [node], {one: one.arguments[side] for one in switches})[0] for side in (1, 2)
    )
    return above, below


def is_certain(graph: Graph, above: Node, below: Node, u: Node, moving: int) -> bool:
    """Whether both sides differ where u is 0, unless a parameter is 0."""
    jump = above - below
    if not jump.symbols & moving:
        return stays(graph, jump, moving) and differ(graph, above, below, {})
    for at in solutions(graph, u, moving):
        (left,) = substituted(graph, [jump], at)
        return stays(graph, left, moving) and differ(graph, above, below, at)
    return False


def solutions(graph: Graph, u: Node, moving: int) -> Iterator[dict[Node, Node]]:
    """For each symbol that u is linear in, what it is where u is 0."""
    terms = terms_of(u)
    for term, coefficient in terms:
        rest = graph.sum([*terms, (term, -coefficient)])
        if term.kind is Kind.SYMBOL and term.symbols & moving and not rest.symbols & term.symbols:
            yield {term: -1.0 / coefficient * rest}


def stays(graph: Graph, left: Node, moving: int) -> bool:
    """Whether a sum is not 0, whatever its parameters are: a product of what moves has one term, which no
    other cancels. Of those that contain parameters, such as sin(k x), some may be equal."""
    found: dict[Node, int] = {}
    for term, coefficient in terms_of(left):
        if not math.isfinite(coefficient):
            return False  # a pole
        scale, factor = graph.split_parameters(term, moving)
        vanishes = any(one.kind not in NEVER_ZERO for one in reachable([scale]))
        found[factor] = found.get(factor, 0) + (coefficient != 0) * (2 if vanishes else 1)
    return 1 in found.values() and (len(found) == 1 or not any(one.symbols & ~moving for one in found))


def differ(graph: Graph, above: Node, below: Node, at: Mapping[Node, Node]) -> bool:
    """Whether the sides differ by more than rounding at random arguments, ``at`` which u is 0."""
    nodes, source, count = [above, below, *at.values()], random.Random(0), 0
    symbols = [one for node in nodes for one in graph.symbols_of(node)]
    for _ in range(POINTS):
        values = {str(one.data): source.uniform(0.2, 1.3) for one in symbols}
        for symbol, node in at.items():
            values[str(symbol.data)] = evaluate([node], values)[0][node]
        value, size = evaluate([above, below], values)
        if math.isfinite(value[above]) and math.isfinite(value[below]):
            count += 1
            if abs(value[above] - value[below]) <= ROUNDING * max(size[above], size[below]):
                return False
    return count > 0
