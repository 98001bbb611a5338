"""The matrix of the equations at a state: M, or with constraints [[M, -A^T], [-A, 0]], block by block."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.linear.blocks import Factored, Factorization
from lagrange_cli.native.numbers.kind import Condition, V
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values


def factored(
    residual: Residual,
    factorization: Factorization[V],
    known: dict[Node, V | None],
    constants: Constants,
    moving_too: int = 0,
) -> tuple[list[Factored[V]], Condition]:
    """The matrix of the equations at a state, block by block, and whether it is regular.

    ``known`` has the values of the state, and gets those of the entries. Further symbols than the variables
    may be ``moving_too`` (their bits).
    """
    kind, factors = factorization.kind, list[Factored[V]]()
    regular, variables = kind.true, residual.variables | moving_too
    moving = [entry for row in residual.entries for entry in row.values() if entry.symbols & variables]
    emit_values(kind, moving, known, constants)
    for block in residual.blocks:
        places = {j: place for place, j in enumerate(block)}
        matrix: list[list[V | None]] = [[None] * len(block) for _ in block]
        for j, row in zip(block, matrix):
            for k, entry in residual.entries[j].items():
                fixed = not entry.symbols & variables
                row[places[k]] = constants.value(kind, entry) if fixed else known[entry]
        constraints = [k - len(residual.model.q) for k in block if k >= len(residual.model.q)]
        loose = not residual.weightless.isdisjoint(block)
        surplus = len(residual.surplus.intersection(constraints))
        given = matrix, residual.definite, len(constraints)
        made, good = factorization.factor(*given, loose=loose, surplus=surplus)
        factors.append(made)
        regular = kind.both(regular, good)
    return factors, regular


def solved(
    residual: Residual, factors: Sequence[Factored[V]], right: list[V | None], scale: V | None
) -> list[V | None]:
    """x with K x = ``scale * right``, K the matrix of the equations."""
    result: list[V | None] = [None] * len(right)
    for block, factor in zip(residual.blocks, factors):
        here = [right[j] for j in block]
        if any(value is not None for value in here):
            for j, value in zip(block, factor.solve(here, scale)):
                result[j] = value
    return result
