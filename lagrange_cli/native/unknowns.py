"""Accelerations and multipliers at one state, in machine code, from equations that are linear in them."""

from __future__ import annotations

from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.explicit import Unknowns
from lagrange_cli.native.linear.blocks import all_unrolled
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.matrix import factored, solved


def solved_for(
    unknowns: Unknowns, kind: Written[V], known: dict[Node, V | None], constants: Constants
) -> list[V | None]:
    """Accelerations, and by how much multipliers are more than what is ``known`` of them."""
    rest = [*unknowns.rest]
    emit_values(kind, rest, known, constants)
    right = [kind.neg(known[node]) for node in rest]
    modes = union(one.mode for one in unknowns.holders)
    factors, _ = factored(unknowns.residual, all_unrolled(kind), known, constants, modes)
    return solved(unknowns.residual, factors, right, kind.one)
