"""Terms of the integrals of systems in spaces of constant curvature, such as a sphere or a hyperbolic plane.

There, as in flat space, a free motion conserves n (n + 1)/2 independent sums K = xi M v, and the quadratic
parts of integrals, the Killing tensors, are sums of products of these (G. Thompson, J. Math. Phys. 27, 2693,
1986). What is added to them are functions of place: terms of U times products of rates xi. Examples are the
counterparts of the Laplace-Runge-Lenz vector and of Fradkin's tensor (P. W. Higgs, J. Phys. A 12, 309, 1979).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.ansatz import Term, Variables, powers, split
from lagrange_cli.mechanics.conserved.combinations import elementary, scaled
from lagrange_cli.mechanics.conserved.curvature import may_be_uniform
from lagrange_cli.mechanics.conserved.displacements import displacements
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import current_text
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

DIMENSIONS = (2, 3)
"""Those of the spaces that are recognized."""


def products_of_symmetries(states: States) -> Iterator[tuple[Variables, list[Term]]]:
    """Sums of products of the momenta of a free motion and of functions of place, short ones first."""
    model, graph = states.model, states.graph
    freedoms = len(model.q) - len(model.constraints)
    lagrangian = states.noether.energetics.lagrangian
    still, *linear = substituted(
        graph, [lagrangian, *states.noether.energetics.momenta], dict.fromkeys(model.v, graph.zero)
    )
    if (
        freedoms not in DIMENSIONS
        or any(one.body for one in model.particles)
        or not all(map(is_zero, linear))
    ):
        return
    if not all(map(is_zero, states.noether.energetics.applied)):
        return
    if not model.constraints and not may_be_uniform(states):
        return
    changes = symmetries_of_free_motion(model, lagrangian - still)
    if len(changes) != freedoms * (freedoms + 1) // 2:
        return
    momenta = [states.noether.current(one) for one in changes]
    texts = [current_text(model, one) for one in changes]
    names = [one if one.isidentifier() else f"({one})" for one in texts]
    given, none = Variables((), momenta, (), names), (0,) * len(momenta)
    places = rates(model, changes, still)
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


def symmetries_of_free_motion(model: Model[Node], kinetic: Node) -> list[Change]:
    """Changes of coordinates that leave the kinetic energy as it is, none of them a sum of others."""
    given = None if model.lagrangian is None else kinetic
    free = replace(model, lagrangian=given, potential=graph_of(model).zero, events=())
    found, kept = Found(free, conservation(free)[1]), list[Node]()
    changes = [one.change for one in displacements(free, found.embedding)]
    if not model.constraints:
        changes += [*elementary(found), *turns_of_hyperspheres(found)]
    plain = [one for one in changes if is_of_place(model, one)]
    symmetries = []
    for relation in found.relations.relations(found.noether.conditions(plain)):
        change = found.noether.together(scaled(found, [(c, plain[i]) for i, c in relation.items()]))
        node = found.noether.current(change)
        if not found.is_known(node, change, kept) and found.noether.keeps(change):
            kept.append(node)
            symmetries.append(change)
    return symmetries


def turns_of_hyperspheres(found: Found) -> Iterator[Change]:
    """Parts of rotations of a sphere of three dimensions, on which theta and phi are angles of one of
    two: its first angle chi changes by cos(theta), sin(theta)*cos(phi) or sin(theta)*sin(phi)."""
    model, graph = found.model, found.graph
    inside = {one for one in reachable([found.noether.energetics.lagrangian]) if one.kind is Kind.FUNCTION}
    for chi, theta, phi in permutations(range(len(model.q))) if len(model.q) == 3 else ():
        across, along, *turns = (
            graph.function(name, (model.q[k],)) for k in (theta, phi) for name in ("sin", "cos")
        )
        for names in (("sin", "cos"), ("sinh", "cosh")):
            radius, height = (graph.function(name, (model.q[chi],)) for name in names)
            if not inside.isdisjoint((radius, height)) and not inside.isdisjoint((across, along)):
                cotangent = height / radius
                yield from (Change({chi: along}), Change({theta: cotangent * across}))
                for turned in turns:
                    yield Change({chi: across * turned})
                    yield Change({theta: cotangent * along * turned})
                    yield Change({phi: cotangent * turned / across})


def is_of_place(model: Model[Node], change: Change) -> bool:
    """Whether it changes nothing but coordinates, and does not depend on t."""
    moved = change.directions.values()
    return not (change.time or change.gain or any(xi.symbols & model.time.symbols for xi in moved))


def rates(model: Model[Node], changes: Sequence[Change], potential: Node) -> list[Node]:
    """The functions of place that the changes of coordinates in the potential consist of, without constant
    factors."""
    graph, moving = graph_of(model), variables(model)
    inside = [k for k, q in enumerate(model.q) if potential.symbols & q.symbols]
    moved = [one.directions[k] for one in changes for k in inside if k in one.directions]
    terms = [term for xi in moved for term, _ in terms_of_sum(xi, 1.0) if term.symbols & moving]
    return [*dict.fromkeys(graph.split_parameters(term, moving)[1] for term in terms)]
