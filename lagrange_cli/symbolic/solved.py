"""Accelerations as functions of the state, and of multipliers where these are not known."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

import sympy

from lagrange_cli.symbolic.constraints import attempt, forces_of
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.linear import Singular, solve


def known_accelerations(equations: Equations) -> list[Mapping[sympy.Expr, sympy.Expr]]:
    """Accelerations and multipliers as functions of the state, if they are known; and accelerations as
    functions of the state and of multipliers."""
    found: list[Mapping[sympy.Expr, sympy.Expr]] = []
    symbols = [each.multiplier for each in equations.constraints]
    if equations.accelerations is not None and equations.multipliers is not None:
        solution = (*equations.accelerations, *equations.multipliers)
        found.append(dict(zip((*equations.a, *symbols), solution, strict=True)))
    if symbols:
        linear = [each for each in equations.constraints if each.linear]
        right = [
            force + own + sympy.Add(*(each.multiplier * each.pushes[k] for each in linear if each.pushes))
            for k, (force, own) in enumerate(
                zip(equations.force, forces_of(equations.constraints, len(equations.q)), strict=True)
            )
        ]
        with suppress(Singular):
            solved = attempt(lambda: solve(equations.mass_matrix, right.__getitem__, equations.order))
            if solved is not None:
                found.append(dict(zip(equations.a, solved, strict=True)))
    return found
