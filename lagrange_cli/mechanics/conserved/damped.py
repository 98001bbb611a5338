"""What linear drag makes fall as exp(-g t): its product with exp(g t) is conserved.

If all drag forces are -g times the momenta of masses, Q_k = -g sum_l M_kl q_dot_l, a momentum of a symmetry
falls at the rate g, in a central field, too. The energy of a free motion falls at the rate 2 g. In a field of
springs, h + (g/2) sum x p_x falls at the rate g (E. Kanai, Prog. Theor. Phys. 3, 1948, 440).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.combinations import MOST_COMBINED
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import current_text, summed
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Falling:
    """A change whose current may be conserved, the product of exp(``rate`` t) and of what has the formula
    ``text``; ``meaning`` explains that."""

    change: Change
    rate: Node
    text: str
    meaning: str = ""


def growing(found: Found) -> None:
    """The products with exp(g t) that are conserved."""
    model = found.model
    if len(model.q) > MOST_COMBINED:
        return
    rate, number = rate_of(found), 1
    for one in [] if rate is None else candidates(found, rate):
        node = found.noether.current(one.change)
        if not found.is_independent(node) or not found.noether.keeps(one.change):
            continue
        growth = f"exp({text_of(one.rate * model.time, moving=model.time.symbols)})"
        because = f"by drag, {one.text} changes at the rate {text_of(-one.rate)} times itself{one.meaning}"
        text = f"({one.text})" if " " in one.text else one.text
        found.kept.append(node)
        found.store(Conserved(found.free_name(f"D_{number}"), f"{growth}*{text}", because), node)
        number += 1


def rate_of(found: Found) -> Node | None:
    """g, if all forces contain velocities as -g sum_l M_kl q_dot_l, with a constant g."""
    graph, model, energetics = found.graph, found.model, found.noether.energetics
    masses = [graph.diff(p, v) for p in energetics.momenta for v in model.v]
    drags = [-graph.diff(force, v) for force in energetics.applied for v in model.v]
    if all(one.is_zero for one in drags):
        return None
    for relation in found.relations.relations([masses, drags]):
        if relation.keys() == {0, 1}:
            return -relation[0] / relation[1]
    return None


def candidates(found: Found, rate: Node) -> Iterator[Falling]:
    """Momenta of displacements and of coordinates, and energies."""
    model, graph = found.model, found.graph
    growth, twice = (graph.function("exp", (n * rate * model.time,)) for n in (1.0, 2.0))
    the = "the " if summed(model) else ""
    named = [
        (trial.change.directions, trial.name, f"; {trial.name} is {the}{trial.text}")
        for trial in found.trials
        if trial.change.gain is None and trial.change.time is None
    ]
    named += [({k: graph.one}, f"p_{name}", "") for k, name in enumerate(model.coordinates)]
    for directions, name, meaning in named:
        growing = {k: growth * xi for k, xi in directions.items()}
        force = force_along(found, directions)
        if force.is_zero or force.symbols & variables(model):
            yield Falling(Change(growing), rate, name, meaning)
        else:
            left = force / rate
            text = joined([name, text_of(-left)])
            yield Falling(Change(growing, gain=growth * left), rate, text, meaning)
    yield Falling(Change(time=-twice), 2.0 * rate, "h")
    stretched = {k: 0.5 * rate * xi for k, xi in stretching(found).items()}
    text = current_text(model, Change(stretched, time=-graph.one))
    growing = {k: growth * xi for k, xi in stretched.items()}
    yield Falling(Change(growing, time=-growth), rate, text)


def force_along(found: Found, directions: Mapping[int, Node]) -> Node:
    """The generalized force in a displacement while nothing moves."""
    energetics, model = found.noether.energetics, found.model
    terms = [
        (xi * (energetics.lagrangian_rate(model.q[k]) + energetics.applied[k]), 1.0)
        for k, xi in directions.items()
    ]
    (force,) = substituted(found.graph, [found.graph.sum(terms)], dict.fromkeys(model.v, found.graph.zero))
    return force


def stretching(found: Found) -> Mapping[int, Node]:
    """The change of the coordinates that moves all particles away from the origin, in proportion to their
    distance, if it is found; else that of all coordinates in proportion."""
    places = {(one.name, i): x for one in found.model.particles for i, x in enumerate(one.position)}
    changed = found.embedding.change(places) if places else None
    return dict(enumerate(found.model.q)) if changed is None else changed
