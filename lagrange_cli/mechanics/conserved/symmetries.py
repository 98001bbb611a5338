"""Conserved quantities that do not belong to a cyclic coordinate: found by Noether's theorem, and proven.

The candidates are displacements of all particles (translations, rotations, Galilean boosts), and combinations
of changes of coordinates by constants, by t, or linear ones, in time or along nonholonomic constraints
(``combinations``). Polynomials of a higher degree in the velocities do not come from such a change
(``hidden``, ``tops``, ``polynomial_integrals``). Each stage takes what was ``found`` before and adds to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.zero import is_zero, zeros
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.conserved.combinations import combine
from lagrange_cli.mechanics.conserved.displacements import Trial, displacements, rotations_about_the_centre
from lagrange_cli.mechanics.conserved.found import Found, Symmetry
from lagrange_cli.mechanics.conserved.hidden import candidates, described, is_turning
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import unchanged
from lagrange_cli.mechanics.conserved.separation import separate_energies
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

MOST_IN_POLYNOMIALS = 5
"""The largest number of coordinates for which polynomials are tried."""
MOST_NAMES = 3
"""Coordinates that are named in one sentence."""
LONGEST_INTEGRAL = 600
"""Characters of its formula."""
WORTH = 2_500_000
"""Steps of work that each stage of the search may take."""
WORTH_OF_POLYNOMIALS = 800_000
"""The same for conserved polynomials, which many systems do not have: half a second."""


def symmetries(model: Model[Node], known: Sequence[Conserved] = ()) -> tuple[Symmetry, ...]:
    """Conserved quantities beyond those ``known``, which are h and momenta of cyclic coordinates."""
    energy = model.potential if model.lagrangian is None else model.lagrangian
    if any(one.kind is Kind.SWITCH for one in reachable([energy])):
        # loaded where something was saturated
        from lagrange_cli.mechanics.switching.saturation import released

        model = released(model)
    found, work = Found(model, known), graph_of(model).work
    for stage in (
        _displacements,
        combine,
        _separate_parts,
        _hidden,
        _tops,
        _polynomials,
        _without_total_derivatives,
    ):
        work.attempt(WORTH_OF_POLYNOMIALS if stage is _polynomials else WORTH, partial(stage, found))
    return tuple(found.symmetries)


def _displacements(found: Found) -> None:
    """Translations, rotations and boosts: all are proven at once, as they have most terms in common."""
    embedding = Embedding(found.model)
    trials = [*displacements(found.model, embedding)]
    if any(one.body for one in found.model.particles):
        from lagrange_cli.mechanics.conserved.spins import spins

        trials += [Trial(*one) for one in spins(found.model, embedding)]
    trials += rotations_about_the_centre(found.model, embedding)
    conditions = [found.noether.conditions(one.change) for one in trials]
    kept = zeros([node for nodes in conditions for node in nodes])
    for one, nodes in zip(trials, conditions):
        if kept >= {*nodes}:
            if one.new and not found.is_independent(found.noether.current(one.change)):
                continue
            because = one.because or f"{one.how} {unchanged(found.noether, one.change)}"
            found.add(one.name, one.text, because, one.change)
        elif one.how:
            found.trials.append(one.change)


def _separate_parts(found: Found) -> None:
    """Energies of parts of the system."""
    for names, node in separate_energies(found.model, found.names):
        listed = ", ".join(names[:MOST_NAMES]) + ", ..." * (len(names) > MOST_NAMES)
        because = f"no other coordinate is in the same terms of L as {listed}, nor is t"
        found.store(Conserved(f"h_{names[0]}", f"the part of h with {listed}", because), node)


def _hidden(found: Found) -> None:
    """Conserved quantities that are quadratic in velocities, for one particle or two."""
    given = candidates(found.model, found.noether) if "h" in found.names else []
    number, before = 0, len(found.symmetries)
    for relation in found.relations.relations([[one.rate] for one in given]):
        parts = [(given[i], factor) for i, factor in relation.items()]
        rate = found.graph.sum([(factor * one.rate, 1.0) for one, factor in parts])
        name, text, because, sign = described(given, relation, number + 1, found.model.potential)
        node = found.graph.sum([(factor * one.node, sign) for one, factor in parts])
        if not is_turning(given, relation) and not found.is_made(node) and is_zero(rate):
            number += name[0] == "I"
            if sum(not one.body for one in found.model.particles) > 1:
                because += "; m, r and v are those of the relative motion"
            found.store(Conserved(found.free_name(name), text, because), node)
    found.symmetries[before:] = sorted(found.symmetries[before:], key=lambda one: one.conserved.quantity)


def _tops(found: Found) -> None:
    """The integral of a heavy top that belongs to no symmetry."""
    if found.model.spec is None or not found.model.spec.bodies or "h" not in found.names:
        return
    from lagrange_cli.mechanics.conserved.tops import kovalevskaya  # and all about bodies

    top = kovalevskaya(found.model, found.noether)
    if top is not None:
        each, node = top
        found.store(replace(each, quantity=found.free_name(each.quantity)), node)


def _polynomials(found: Found) -> None:
    """Other polynomials in the velocities."""
    freedoms = len(found.model.q) - len(found.model.constraints)
    if "h" not in found.names or freedoms < 2 or len(found.model.q) > MOST_IN_POLYNOMIALS:
        return
    from lagrange_cli.mechanics.conserved.polynomial_integrals import (
        PolynomialIntegrals,  # and what it needs
    )

    for one in PolynomialIntegrals(found.model, found.noether, found.every).found():
        number = sum(name.startswith("I_") for name in found.names) + 1
        text = one.text if len(one.text) <= LONGEST_INTEGRAL else "a long sum"
        because = f"a hidden symmetry, of degree {one.degree} in the velocities: "
        where = "where the constraints hold, " if found.model.constraints else ""
        because += f"{where}it is constant by the equations of motion"
        found.store(Conserved(found.free_name(f"I_{number}"), text, because), one.node)


def _without_total_derivatives(found: Found) -> None:
    """The quantities that L conserves without its terms that are a total time derivative dF/dt, which
    have no effect: in place of h that is h + dF/dt, in place of p_k it is p_k - dF/dq_k (partial
    derivatives)."""
    model, given = found.model, found.model.lagrangian
    lagrangian = -model.potential if given is None else given
    left = acting(model, found.graph, lagrangian)
    if left is lagrangian:
        return
    other = replace(model, potential=-left) if given is None else replace(model, lagrangian=left)
    energetics, (_, known) = Energetics(other), conservation(other)
    plain = {f"p_{name}": p for name, p in zip(model.coordinates, energetics.momenta)}
    nodes = [(each, {**plain, "h": energetics.energy_function}[each.quantity]) for each in known]
    nodes += [(one.conserved, one.node) for one in symmetries(other, known)]
    gone = lagrangian - left
    lacks = {f"p_{name}": -found.graph.diff(gone, v) for name, v in zip(model.coordinates, model.v)}
    (lacks["h"],) = substituted(found.graph, [gone], dict.fromkeys(model.v, found.graph.zero))
    for each, node in nodes:
        if found.is_known(node, Change(time=found.graph.one), found.every):
            continue
        text = f"{each.quantity} = {each.expression}, of L without dF/dt"
        if each.quantity in lacks:
            text = joined([each.quantity, text_of(lacks[each.quantity])])
        because = f"without the terms of L that are a total time derivative dF/dt, {each.because}"
        found.store(Conserved(found.free_name(f"{each.quantity}_0"), text, because), node)
