"""Systems that move like one particle in a plane or in space, written in curvilinear coordinates.

Where T is a quadratic form of the velocities whose metric M is flat, there are coordinates X with
T = m (dX/dt)^2/2. In free motion, with L = T, they change uniformly. So sums of products of functions of
one coordinate are looked for whose second derivative vanishes then: linear equations for the coefficients.

The functions are those that M consists of. A coordinate phi on which M does not depend turns everything at
a rate w, where G = M_phi,phi is w^2 rho^2 with the distance rho from an axis: w^2 = |grad G|^2/(4 G).
It is 1 in polar coordinates and 1/2 in Atwood's swinging machine with masses 3 : 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, product

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.text import text_of
from lagrange_cli.expression.written import as_written
from lagrange_cli.expression.zero import zeros
from lagrange_cli.mechanics.conserved.ansatz import Term, Variables
from lagrange_cli.mechanics.conserved.columns import conserved_sums, independent
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.reasons import is_plain
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.embedding import solution
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model, Particle
from lagrange_cli.records import replace

MOST_PRODUCTS = 80
"""Products of functions that are tried."""
SOMEWHERE = 0.71875
"""The value of all coordinates at which constants are computed."""
PAIRS = {"sin": ("cos", "sin"), "cos": ("cos", "sin"), "sinh": ("cosh", "sinh"), "cosh": ("cosh", "sinh")}
"""Functions that occur together."""


def flat_space(model: Model[Node]) -> Model[Node] | None:
    """The same system as one particle in a plane or in space; None where none is found."""
    noether, graph = Noether(model), graph_of(model)
    momenta, lagrangian = noether.energetics.momenta, noether.energetics.lagrangian
    matrix = noether.matrix
    moving = variables(model) & ~sum(q.symbols for q in model.q)
    if any(m.symbols & moving for row in matrix for m in row):
        return None
    kinetic = kinetic_energy(model, matrix)
    still, *linear = substituted(graph, [lagrangian, *momenta], dict.fromkeys(model.v, graph.zero))
    potential = graph.sum([(still, -1.0), *((p * v, -1.0) for p, v in zip(linear, model.v))])
    functions = [functions_of(model, matrix, k) for k in range(len(model.q))]
    count = 1
    for some in functions:
        count *= len(some)
    if not 1 < count <= MOST_PRODUCTS:
        return None
    found = uniform(model, kinetic, [graph.product((f, 1) for f in one) for one in product(*functions)])
    if len(found) != len(model.q):
        return None
    return as_particle(model, noether, potential, matrix, sorted(found, key=partial(rank, model)))


def rank(model: Model[Node], node: Node) -> tuple[int, tuple[bool, ...]]:
    """Functions of many coordinates come first, those of the first coordinates before others."""
    absent = tuple(not node.symbols & q.symbols for q in model.q)
    return sum(absent), absent


def kinetic_energy(model: Model[Node], matrix: Sequence[Sequence[Node]]) -> Node:
    """v M v/2."""
    return graph_of(model).sum(
        [(m * v * u, 0.5) for row, v in zip(matrix, model.v) for m, u in zip(row, model.v)]
    )


def functions_of(model: Model[Node], matrix: Sequence[Sequence[Node]], k: int) -> list[Node]:
    """Functions of one coordinate, of which its factors in flat coordinates may be sums; none if the metric
    is not flat."""
    graph, q = graph_of(model), model.q[k]
    entries = [m for m in chain.from_iterable(matrix) if m.symbols & q.symbols]
    if not entries:
        turning = rate_of_turning(model, matrix, matrix[k][k])
        if turning is None:
            return []
        if turning.is_zero:
            return [graph.one, q]
        return [graph.one, *(graph.function(name, (turning * q,)) for name in ("cos", "sin"))]
    others = variables(model) & ~q.symbols
    found = [one for m in entries for one in factors_in(m, q, others)]
    return [*dict.fromkeys([graph.one, *found])]


def factors_in(node: Node, q: Node, others: int) -> Iterator[Node]:
    """Square roots of the factors of an expression that depend on q and on no ``others``, and the functions
    and small powers of q that it consists of."""
    graph = node.graph
    factors = [*zip(node.arguments, node.data)] if node.kind is Kind.PRODUCT else [(node, 1)]
    for one, exponent in factors:
        if not one.symbols & q.symbols:
            continue
        own = one.kind is Kind.FUNCTION and (one.data in PAIRS or one.data == "exp")
        if not one.symbols & others and not (own and exponent % 2):
            half = abs(exponent) // 2 if exponent % 2 == 0 else abs(exponent) / 2
            yield graph.product([(one, half)])
        if one is q:
            yield from (q, q * q)
        elif own and one.data == "exp":
            yield graph.function("exp", (0.5 * one.arguments[0],))
        elif own:
            yield from (graph.function(name, one.arguments) for name in PAIRS[one.data])
        elif one.kind is Kind.SUM:
            for term in one.arguments:
                yield from factors_in(term, q, others)


def rate_of_turning(model: Model[Node], matrix: Sequence[Sequence[Node]], entry: Node) -> Node | None:
    """w; None where it is not constant."""
    graph = graph_of(model)
    slopes = [graph.diff(entry, q) for q in model.q]
    if all(slope.is_zero for slope in slopes):
        return graph.zero
    raised = solution(graph, matrix, slopes)
    if raised is None:
        return None
    rate = graph.sum([(a * b, 0.25) for a, b in zip(slopes, raised)]) / entry
    if zeros(slopes := [graph.diff(rate, q) for q in model.q]) < {*slopes}:
        return None
    square = constant(model, rate)
    return None if square is None else root(graph, square)


def root(graph: Graph, square: Node) -> Node:
    """A root of a positive function, of any sign: sin(alpha) of sin(alpha)**2."""
    number, rest = graph.split_coefficient(square)
    if number <= 0 or rest.kind is not Kind.PRODUCT:
        return graph.product([(square, 0.5)])
    factors = zip(rest.arguments, rest.data)
    halves = [(one, exponent // 2 if exponent % 2 == 0 else exponent / 2) for one, exponent in factors]
    return graph.product(halves) * math.sqrt(number)


def constant(model: Model[Node], node: Node) -> Node | None:
    """A positive function that does not depend on the coordinates; None where it is found not to be
    positive."""
    graph = graph_of(model)
    (value,) = substituted(graph, [node], dict.fromkeys(model.q, graph.constant(SOMEWHERE)))
    if value.kind is Kind.NUMBER:
        if not 0 < value.data < math.inf:
            return None
        fraction, root, _ = as_written(value.data)
        value = value if root else graph.constant(float(fraction))
    return value


def uniform(model: Model[Node], kinetic: Node, functions: Sequence[Node]) -> list[Node]:
    """Sums of functions of place that change uniformly in free motion."""
    graph = graph_of(model)
    still = tuple(graph.zero for _ in model.q)
    free = replace(
        model, lagrangian=kinetic, potential=graph.zero, particles=(), generalized_forces=still,
        dissipation=graph.zero, events=(),
    )  # fmt: skip
    states = States(free, Noether(free))
    speeds = {states.noether.rate(one): one for one in functions if one.symbols & variables(model)}
    given = Variables((), (), (), ())
    ansatz = independent(states, given, [Term((), (), (one,)) for one in speeds])
    found = []
    for terms, coefficients in conserved_sums(states, given, ansatz):
        places = [speeds[term.functions[0]] for term in terms]
        found.append(graph.sum([(c * x, 1.0) for c, x in zip(coefficients, places)]))
    return found


def as_particle(
    model: Model[Node],
    noether: Noether,
    potential: Node,
    matrix: Sequence[Sequence[Node]],
    place: Sequence[Node],
) -> Model[Node] | None:
    """The model with one particle at a ``place``, which is scaled such that T = m v^2/2."""
    graph = graph_of(model)
    slopes = [[graph.diff(x, q) for q in model.q] for x in place]
    raised = [solution(graph, matrix, one) for one in slopes]
    if any(one is None for one in raised):
        return None
    squares = [
        graph.sum([(a * b, 1.0) for a, b in zip(one, other or ())]) for one, other in zip(slopes, raised)
    ]
    inverse = [one for one in (constant(model, square) for square in squares) if one is not None]
    if len(inverse) < len(squares):
        return None
    mass = graph.one / inverse[0]
    place = [x / root(graph, mass * one) for x, one in zip(place, inverse)]
    slopes = [[graph.diff(x, q) for q in model.q] for x in place]
    left = [
        graph.sum([(m, -1.0), *((mass * row[k] * row[j], 1.0) for row in slopes)])
        for k, entries in enumerate(matrix)
        for j, m in enumerate(entries[: k + 1])
    ]
    if zeros(left) < {*left}:
        return None
    velocity = tuple(noether.rate(x) for x in place)
    still = tuple(graph.zero for _ in place)
    return replace(
        model, lagrangian=None, potential=potential, dissipation=graph.zero,
        particles=(Particle("", mass, tuple(place), velocity, still),),
        generalized_forces=tuple(noether.energetics.applied),
    )  # fmt: skip


def as_text(model: Model[Node]) -> str:
    """Where the particle is, in words."""
    (one,) = model.particles
    if is_plain(model):
        return ""
    place = ", ".join(map(text_of, one.position))
    return f"; the system moves like one particle of mass {text_of(one.mass)} at ({place})"
