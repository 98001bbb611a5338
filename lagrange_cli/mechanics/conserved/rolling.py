"""Terms of conserved quantities of first and second degree in the velocities, along constraints on them.

They are momenta and angular momenta times functions of place. Along the displacements that the constraints
allow, momenta change in proportion to each other and to the rates of such functions. Sums that do not change
are elementary for a skate, an upright disc, and a ball in a vertical cylinder (Ju. I. Neimark and N. A.
Fufaev, Dynamics of Nonholonomic Systems, 1972, chapter III).
"""

from __future__ import annotations

from collections.abc import Iterator

from lagrange_cli.expression.node import Kind, Node, factors_of, terms_of, union
from lagrange_cli.mechanics.conserved.ansatz import Powers, Term, Variables
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.spins import spins
from lagrange_cli.mechanics.embedding import Embedding

POWERS = (1, 2, -1, -2)
"""Powers of factors of the constraints and masses that are tried; sines have the first alone."""


def terms_along_constraints(states: States) -> Iterator[tuple[Variables, list[Term]]]:
    """Each momentum and angular momentum, alone and times each function; then the same times a momentum that
    is conserved, and the functions."""
    model, noether = states.model, states.noether
    named = {f"p_{name}": Change({k: states.graph.one}) for k, name in enumerate(model.coordinates)}
    if any(one.body for one in model.particles):
        turns = spins(model, Embedding(model))
        named |= {name: change for name, change, _, _ in turns if name.startswith("S_")}
    speeds = [noether.current(change) for change in named.values()]
    given, none = Variables((), speeds, (), [*named]), (0,) * len(named)
    functions = [(), *((one,) for one in dict.fromkeys(functions_of(states)))]
    singles = [with_one(none, k) for k in range(len(named))]
    yield given, [Term(speed, (), some) for some in functions for speed in singles]
    for k, p in enumerate(noether.energetics.momenta):
        if states.conserves(p):
            alone = [Term(none, (), some) for some in functions[1:]]
            yield (
                given,
                [*alone, *(Term(with_one(one, k), (), some) for some in functions for one in singles)],
            )


def with_one(powers: Powers, k: int) -> Powers:
    """A product of powers, times one more factor."""
    return tuple(n + (i == k) for i, n in enumerate(powers))


def functions_of(states: States) -> Iterator[Node]:
    """The coordinates, and powers of the factors of the constraints and masses that depend on one. Those by
    which bodies only turn are in the angular momenta."""
    model = states.model
    still = [one for one in model.particles if not one.body]
    inside = union(x for one in still for x in one.position) if len(still) < len(model.particles) else ~0
    places = [q for q in model.q if q.symbols & inside]
    yield from places
    rows = [*states.noether.constraints.slopes, *(dict(enumerate(row)) for row in states.noether.matrix)]
    for factor in (one for row in rows for slope in row.values() for one in factors(slope)):
        moving = [q for q in model.q if factor.symbols & q.symbols]
        if len(moving) == 1 and moving[0] in places:
            several = factor.kind in (Kind.SYMBOL, Kind.SUM)
            yield from (states.graph.product([(factor, n)]) for n in (POWERS if several else POWERS[:1]))


def factors(node: Node) -> Iterator[Node]:
    """The factors of the terms of a sum, without their exponents."""
    for term, _ in terms_of(node):
        yield from (base for base, _ in factors_of(term))
