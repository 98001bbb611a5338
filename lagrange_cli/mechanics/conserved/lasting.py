"""Combinations of conserved quantities that no event changes, although events change the quantities.

An impact changes momenta in proportion to an impulse: the sums whose changes cancel are the momentum and the
angular momentum of all that collides, or the angular momentum about the point of contact. Elastic walls that
fit the symmetries of the motion leave products of momenta alone: in an elliptic billiard, the product of the
angular momenta about the foci (V. V. Kozlov and D. V. Treshchev, Billiards, Am. Math. Soc. 1991).
"""

from __future__ import annotations

from itertools import combinations_with_replacement

from lagrange_cli.expression.text import joined
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.found import Found, Symmetry
from lagrange_cli.mechanics.conserved.jumps import Jumps
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import current_text, term
from lagrange_cli.model.events import between_events
from lagrange_cli.records import replace

MOST_EVENTS, MOST_CURRENTS, MOST_FACTORS = 12, 40, 7
"""The largest numbers of events, of linear quantities, and of those that products are formed of."""
ALONE = "no event changes it, although events change what it is made of"


def combined(found: Found) -> None:
    """Report them: linear ones, and those of second degree."""
    jumps = Jumps(found.model)
    every = {*found.kept, *(one.node for one in found.symmetries)}
    if len(jumps.events) > MOST_EVENTS or every <= {*found.lasting}:
        return
    for one in [*found.symmetries]:
        if one.conserved.breaks and jumps.keep(one.node):
            survive(found, one)
    linear(found, jumps)
    products(found, jumps)


def survive(found: Found, one: Symmetry) -> None:
    """Report it without the events, which do not change it where they happen."""
    ending = f"; {between_events(one.conserved.breaks)}"
    each = replace(one.conserved, because=one.conserved.because.removesuffix(ending), breaks=())
    found.symmetries[found.symmetries.index(one)] = Symmetry(each, one.node)
    found.lasting.append(one.node)


def linear(found: Found, jumps: Jumps) -> None:
    """Sums of momenta and of other currents."""
    model, one = found.model, found.graph.one
    momenta = [Change({k: one}) for k, name in enumerate(model.coordinates) if f"p_{name}" in found.names]
    given = [*momenta, *(change for _, change in found.currents if change.time is None)]
    if len(given) > MOST_CURRENTS:
        return
    number = sum(name.startswith("C_") for name in found.names)
    sums = list[tuple[str, Change]]()
    for relation in jumps.sums([found.noether.current(change) for change in given]):
        if len(relation) > 1:  # others are reported already, or grow in proportion to t
            change = found.noether.together([(factor, given[i]) for i, factor in relation.items()])
            sums += [(current_text(model, change), change)] if change.directions else []
    for text, change in sorted(sums, key=lambda one: len(one[0])):
        node = found.noether.current(change)
        if found.is_independent(node, found.lasting) and jumps.keep(node):
            number += 1
            name, because = found.free_name(f"C_{number}"), f"a sum of conserved quantities: {ALONE}"
            found.store_lasting(Conserved(name, text, because), node)


def products(found: Found, jumps: Jumps) -> None:
    """Sums of products of two of these, and of others."""
    time = found.model.time.symbols
    momenta = zip(found.model.coordinates, found.noether.energetics.momenta)
    factors = {f"p_{name}": p for name, p in momenta if f"p_{name}" in found.names}
    currents = [(name, change) for name, change in found.currents if name and change.time is None]
    factors |= {name: found.noether.current(change) for name, change in currents}
    given = {
        one.conserved.quantity: one.node
        for one in found.symmetries
        if one.conserved.quantity not in factors and not one.node.symbols & time
    }
    steady = [(name, node) for name, node in factors.items() if not node.symbols & time]
    if len(steady) <= MOST_FACTORS:
        for (a, x), (b, y) in combinations_with_replacement(reversed(steady), 2):
            given[f"{b}**2" if a == b else f"{b}*{a}"] = x * y
    names, nodes = [*given], [*given.values()]
    for relation in jumps.sums(nodes):
        node = found.graph.sum([(factor * nodes[i], 1.0) for i, factor in relation.items()])
        if found.is_independent(node, found.lasting) and jumps.keep(node):
            text = joined([term(factor, names[i]) for i, factor in reversed([*relation.items()])])
            number = sum(name.startswith("I_") for name in found.names) + 1
            because = f"made of products of conserved quantities: {ALONE}"
            found.store_lasting(Conserved(found.free_name(f"I_{number}"), text, because), node)
