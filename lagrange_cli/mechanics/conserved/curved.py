"""Terms of the integrals of systems in spaces of constant curvature, such as a sphere or a hyperbolic plane.

There, as in flat space, a free motion conserves n (n + 1)/2 independent sums K = xi M v, and the quadratic
parts of integrals, the Killing tensors, are sums of products of these (G. Thompson, J. Math. Phys. 27, 2693,
1986). What is added to them are functions of place: terms of U times products of rates xi. Examples are the
counterparts of the Laplace-Runge-Lenz vector and of Fradkin's tensor (P. W. Higgs, J. Phys. A 12, 309, 1979).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, islice

from lagrange_cli.expression.modular import solved
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.residues import SMALL
from lagrange_cli.expression.text import text_of
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.ansatz import Term, Variables, powers, split
from lagrange_cli.mechanics.conserved.combinations import combinations
from lagrange_cli.mechanics.conserved.displacements import displaced
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.embedding import solution
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

DIMENSIONS = (2, 3)
"""Those of the spaces that are recognized."""
STATES = 2
"""Places at which the curvature is computed."""
HALF = (SMALL + 1) // 2
"""1/2 modulo the prime."""


def products_of_symmetries(states: States) -> Iterator[tuple[Variables, list[Term]]]:
    """Sums of products of the momenta of a free motion and of functions of place, short ones first."""
    model, graph = states.model, states.graph
    freedoms = len(model.q) - len(model.constraints)
    lagrangian = states.noether.energetics.lagrangian
    still, *linear = substituted(
        graph, [lagrangian, *states.noether.energetics.momenta], dict.fromkeys(model.v, graph.zero)
    )
    if freedoms not in DIMENSIONS or any(one.body for one in model.particles) or not all(map(is_zero, linear)):
        return
    if not all(map(is_zero, states.noether.energetics.applied)):
        return
    if not model.constraints and not has_constant_curvature(states):
        return
    momenta = momenta_of_free_motion(model, lagrangian - still)
    if len(momenta) != freedoms * (freedoms + 1) // 2:
        return
    names = [f"({text_of(one)})" if one.kind is Kind.SUM else text_of(one) for one in momenta]
    given, none = Variables((), momenta, (), names), (0,) * len(momenta)
    places = rates(states, momenta)
    fields = [graph.one]
    for term, _ in terms_of_sum(still, -1.0):
        fields += [term, split(term, model, variables(model), True)[0] or graph.one]
    fields = [*dict.fromkeys(graph.split_parameters(one, variables(model))[1] for one in fields)]
    quadratic = [Term(one, ()) for one in powers(len(momenta), 2)]
    pairs = [a * b for i, a in enumerate(places) for b in places[i:]]
    for some in (places, [*places, *pairs]):
        functions = [u * a for u in fields for a in (graph.one, *some)]
        functions = [*dict.fromkeys(one for one in functions if one.symbols & variables(model))]
        yield given, [*(Term(none, (), (one,)) for one in functions), *quadratic]


def momenta_of_free_motion(model: Model[Node], kinetic: Node) -> list[Node]:
    """The conserved functions that are linear in the velocities, without a potential."""
    graph = graph_of(model)
    given = None if model.lagrangian is None else kinetic
    free = replace(model, lagrangian=given, potential=graph.zero, events=())
    found = Found(free, conservation(free)[1])
    displaced(found)
    if not model.constraints:
        combinations(found)
    time, energy = model.time.symbols, found.noether.energy
    kept = [one for one in found.kept if one is not energy and not one.symbols & time]
    return [one for one in kept if not any(graph.diff(one, v).symbols & w.symbols for v in model.v for w in model.v)]


def rates(states: States, momenta: Sequence[Node]) -> list[Node]:
    """The functions of place that the rates xi of K = xi M v consist of, without constant factors."""
    graph, moving, found = states.graph, variables(states.model), dict[Node, None]()
    for one in momenta:
        slopes = [graph.diff(one, v) for v in states.model.v]
        for xi in solution(graph, states.matrix, slopes) or ():
            for term, _ in terms_of_sum(xi, 1.0):
                if term.symbols & moving:
                    found[graph.split_parameters(term, moving)[1]] = None
    return [*found]


def has_constant_curvature(states: States) -> bool:
    """Whether R_ijkl = K (g_ik g_jl - g_il g_jk) with the same K at random places, for the metric M."""
    graph, model, metric, n = states.graph, states.model, states.matrix, len(states.model.q)
    if any(m.symbols & variables(model) & ~sum(q.symbols for q in model.q) for row in metric for m in row):
        return False
    span = range(n)
    slopes = [[[graph.diff(m, q) for q in model.q] for m in row] for row in metric]
    bends = [[[[graph.diff(one, q) for q in model.q] for one in m] for m in row] for row in slopes]
    nodes = [*chain.from_iterable(metric)]
    nodes += [one for row in slopes for m in row for one in m]
    nodes += [two for row in bends for m in row for one in m for two in one]
    names = {name: 3 + 7 * i for i, name in enumerate(map(str, model.parameters))}
    curvatures = set[int]()
    for state in islice(states.random(SMALL, nodes, names), STATES):
        value = state.values
        g = [[value[m] for m in row] for row in metric]
        first = [[[value[one] for one in m] for m in row] for row in slopes]
        second = [[[[value[two] for two in one] for one in m] for m in row] for row in bends]
        lower = [  # of Christoffel, the first index lowered
            [[(first[m][j][k] + first[m][k][j] - first[j][k][m]) * HALF for m in span] for k in span]
            for j in span
        ]
        upper = [[solved(g, lower[j][k], SMALL) or [] for k in span] for j in span]
        if any(not one for row in upper for one in row):
            return False

        def riemann(i: int, j: int, k: int, m: int) -> int:
            terms = second[i][m][j][k] + second[j][k][i][m] - second[i][k][j][m] - second[j][m][i][k]
            products = sum(lower[j][k][a] * upper[i][m][a] - lower[j][m][a] * upper[i][k][a] for a in span)
            return terms * HALF + products

        area = (g[0][0] * g[1][1] - g[0][1] * g[0][1]) % SMALL
        (curvature,) = solved([[area]], [riemann(0, 1, 0, 1) % SMALL], SMALL) or [0]
        curvatures.add(curvature)
        for i, j, k, m in ((i, j, k, m) for i in span for j in span for k in span for m in span):
            if (riemann(i, j, k, m) - curvature * (g[i][k] * g[j][m] - g[i][m] * g[j][k])) % SMALL:
                return False
    return len(curvatures) == 1
