"""Turning one rigid body alone, about its centre of mass or about one of its own axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.operations import cross
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.embedding import Component, Embedding
from lagrange_cli.mechanics.laurent import primitive
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model, Particle

MOST_BODIES = 10
"""This is tried for at most so many bodies."""

Turn = tuple[str, Change, str, str]
"""What it may conserve, the change of the coordinates, a formula, and how it is done."""


def spins(model: Model[Node], embedding: Embedding) -> Iterator[Turn]:
    """The turns of each body that coordinates allow.

    Where its centre moves as it turns, as that of a top does on its tip, only its axis through the centre is
    left: the particles that stand for its rotation (see ``model.rigid_body``) turn and nothing else does.
    """
    graph = graph_of(model)
    bodies: dict[str, list[Particle[Node]]] = {}
    for one in model.particles:
        if one.body:
            bodies.setdefault(one.body, []).append(one)
    if len(bodies) > MOST_BODIES:
        return
    units = [[graph.one if i == j else graph.zero for j in range(3)] for i in range(3)]
    for body, carriers in bodies.items():
        prefix, turns = "" if len(bodies) == 1 else f"{body}_", dict[int, Mapping[int, Node]]()
        for i in (2, 0, 1):
            axis, number = COMPONENTS[i], i + 1
            around = {one: cross(units[i], one.position) for one in carriers}
            change = change_of(embedding, around)
            if change:
                turns[i] = change
                text = f"angular momentum of {body} about its centre, along {axis}"
                how = f"turning {body} about its centre around {axis}"
                yield f"S_{prefix}{axis}", Change(change), text, how
            change = change_of(embedding, within(model, carriers, i))
            if change:
                text = f"angular momentum of {body} about its centre, along its axis {number}"
                yield f"L_{prefix}{number}", Change(change), text, f"turning {body} about its axis {number}"
        pivot = pivoting(model, turns)
        if pivot:
            text = f"angular momentum of {body} about its centre, along the axis on which it may pivot"
            how = f"turning {body} on the axis on which it may pivot"
            yield f"S_{prefix}n", Change(pivot), text, how


def pivoting(model: Model[Node], turns: Mapping[int, Mapping[int, Node]]) -> Mapping[int, Node] | None:
    """The turn of a body that two constraints on velocities leave to it where its centre rests: for a ball
    that rolls, about the normal n of the surface. With turns about the axes of space they are c.omega = 0 and
    d.omega = 0, so that n is c x d, divided by its length."""
    graph, given = graph_of(model), zip(model.constraints, Constraints(model).slopes)
    slopes = [row for one, row in given if not one.holonomic]
    if len(turns) < len(COMPONENTS) or len(slopes) != 2:
        return None
    c, d = (
        [graph.sum([(row[k] * xi, 1.0) for k, xi in turns[i].items() if k in row]) for i in range(3)]
        for row in slopes
    )
    normal = primitive(graph, cross(c, d))
    square = graph.sum([(x * x, 1.0) for x in normal])
    if is_zero(square):
        return None
    scale = graph.one if is_zero(square - 1.0) else graph.product([(square, -0.5)])
    found: dict[int, list[tuple[Node, float]]] = {}
    for i, turn in turns.items():
        for k, xi in turn.items():
            found.setdefault(k, []).append((normal[i] * xi * scale, 1.0))
    return {k: graph.sum(parts) for k, parts in found.items()}


def within(
    model: Model[Node], carriers: Sequence[Particle[Node]], i: int
) -> Mapping[Particle[Node], Sequence[Node]]:
    """The displacements when the body turns about its own axis: the next axis moves along the last one, and
    that against the next. The first three carriers are at e_1, e_2, e_3, the others at sums of two."""
    graph = graph_of(model)
    axes, j, k = [one.position for one in carriers[:3]], (i + 1) % 3, (i + 2) % 3
    moves = {i: [graph.zero] * 3, j: [*axes[k]], k: [-x for x in axes[j]]}
    found: dict[Particle[Node], Sequence[Node]] = {one: moves[n] for n, one in enumerate(carriers[:3])}
    for one in carriers[3:]:
        first, second = (int(number) - 1 for number in one.name.split()[-2:])
        found[one] = [a + b for a, b in zip(moves[first], moves[second])]
    return found


def change_of(
    embedding: Embedding, displacements: Mapping[Particle[Node], Sequence[Node]]
) -> Mapping[int, Node] | None:
    """The change of the coordinates by which particles are displaced so, and nothing else is."""
    turn: dict[Component, Node] = {
        (one.name, i): x for one, by in displacements.items() for i, x in enumerate(by)
    }
    return embedding.change(turn)
