"""The printed equations, read back and evaluated at a state with many digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from operator import mul
from typing import Any

import mpmath
import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import read_printed
from lagrange_cli.expression.syntax import ExpressionError, Tree
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.measured import Measured, MeasuredAlgebra, are_dependent, solve_measured
from lagrange_cli.symbolic.norms import by_norms
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.render import render

MOST, SETTLED = 300, 1e-30
"""Iterations for multipliers in forces that are not linear in them: at most so many, and the last change."""
ROUNDED = 2.0**-52
"""An unknown that is a smaller part of its scale is 0 but for rounding, and is measured by this part."""

Named = list[tuple[str, Measured]]
"""Quantities by name."""


@dataclass(frozen=True)
class Printed:
    """The printed equations, parsed: M, f, p, h, the constraints, their A and b, all as trees.

    ``quiet`` is f without what is not linear in multipliers. ``explicit`` accelerations and multipliers, and
    both sides of the ``equations`` of motion, are None where they are not printed, or nested deeper than an
    expression may be.
    """

    explicit: list[Tree] | None
    equations: list[tuple[Tree, Tree]] | None
    mass_matrix: list[list[Tree]]
    force: list[Tree]
    quiet: list[Tree]
    momenta: list[Tree]
    h: Tree
    constraints: list[Tree]
    slopes: list[list[Tree]]
    columns: list[list[Tree]]
    rates: list[Tree]


@dataclass(frozen=True)
class Evaluated:
    """Values at a state. ``functions`` of it are p, h and the constraints; ``equations`` are the differences
    of both sides of the equations of motion, and of M a = f + A^T lambda and A a = b, which are 0; ``zeros``
    are 0 with the scales that the latter have. Where constraints depend on one another,
    the multipliers are the least possible."""

    accelerations: Named
    multipliers: Named
    functions: Named
    equations: Named
    zeros: Named

    @property
    def all(self) -> Named:
        """The unknowns, and the functions of the state."""
        return [*self.accelerations, *self.multipliers, *self.functions]


def quiet(equations: Equations) -> list[sympy.Expr]:
    """The force without generalized forces that are not linear in multipliers."""
    symbols = [each.multiplier for each in equations.constraints if not each.linear]
    return [
        force if own.free_symbols.isdisjoint(symbols) else tidy(force - own, equations.order)
        for force, own in zip(equations.force, equations.generalized_forces, strict=True)
    ]


def read_back(equations: Equations) -> Printed:
    """The printed text of the equations, parsed. Raises ``UsageError`` where it is nested too deep."""

    def tree(expression: sympy.Expr) -> Tree:
        return read_printed(render(expression, Text(), equations.order))

    def trees(expressions: Sequence[sympy.Expr]) -> list[Tree]:
        return [tree(each) for each in expressions]

    constraints = equations.constraints
    explicit = sides = None
    with suppress(ExpressionError):
        if equations.accelerations is not None:
            explicit = trees((*equations.accelerations, *(equations.multipliers or ())))
    with suppress(ExpressionError):
        sides = [(tree(each.left), tree(each.right)) for each in equations.equations]
    try:
        return Printed(
            explicit,
            sides,
            [trees(row) for row in equations.mass_matrix],
            trees(equations.force),
            trees(quiet(equations)),
            trees(equations.momenta),
            tree(equations.h),
            trees([each.expression for each in constraints]),
            [trees(each.slopes) for each in constraints],
            [trees([each.column(k) for k in range(len(equations.q))]) for each in constraints],
            trees([each.rate for each in constraints]),
        )
    except ExpressionError as error:
        raise unreadable(error) from error


def unreadable(error: ExpressionError) -> UsageError:
    """The message for printed text that is nested too deep to be read back."""
    return UsageError(
        f"the printed equations cannot be read back ({error.message}): leave out --verify, or write the "
        "system with fewer parts inside one another"
    )


def evaluate(
    equations: Equations, printed: Printed, known: Mapping[str, Measured], bound: float | None = None
) -> Evaluated:
    """The values where symbols have the values ``known``, and exponentials grow up to arguments of ``bound``
    only."""
    algebra = MeasuredAlgebra(bound)

    def value(tree: Tree) -> Measured:
        result: Measured = build(tree, known.__getitem__, algebra)
        return result

    zero = nothing()
    slopes = [[value(entry) for entry in row] for row in printed.slopes]
    rows = [[value(entry) for entry in row] for row in printed.mass_matrix]
    columns = [[value(entry) for entry in row] for row in printed.columns]
    matrix = [[*row, *(-column[k] for column in columns)] for k, row in enumerate(rows)]
    matrix += [[*(-entry for entry in row), *(zero for _ in slopes)] for row in slopes]
    dependent = are_dependent(slopes)
    right = [*map(value, printed.quiet), *(-value(each) for each in printed.rates)]
    unknowns = solve_measured(matrix, right, dependent=dependent)
    for _ in range(0 if all(each.linear for each in equations.constraints) else MOST):
        before = [each.value for each in unknowns]
        multipliers = zip((str(each.multiplier) for each in equations.constraints), unknowns[len(rows) :])
        known = {**known, **{name: Measured(one.value, abs(one.value)) for name, one in multipliers}}
        right[: len(rows)] = map(value, printed.force)
        unknowns = solve_measured(matrix, right, dependent=dependent)
        moved = max(abs(each.value - old) for each, old in zip(unknowns, before, strict=True))
        if moved <= SETTLED * max(map(abs, before)):
            break
    else:
        if not all(each.linear for each in equations.constraints):
            raise ArithmeticError("forces that depend on multipliers too strongly")
    if printed.explicit is not None:  # the compiled side always solves M a = f, which has its own scale
        unknowns = [
            Measured(own.value, max(own.scale, solved.scale))
            for own, solved in zip(map(value, printed.explicit), unknowns, strict=True)
        ]
    unknowns = by_norms(rows, right[: len(rows)], columns, slopes, right[len(rows) :], unknowns)
    symbols = [*map(str, equations.a), *(str(each.multiplier) for each in equations.constraints)]
    n = len(equations.a)
    sizes = [max(abs(each.value), ROUNDED * each.scale) for each in unknowns]
    whole = [each.scale for each in unknowns]
    left = [
        sum(entry.value * each.value for entry, each in zip(row, unknowns, strict=True)) for row in matrix
    ]
    scales = [
        one.scale + sum(map(mul, (entry.scale for entry in row), sizes if k < n else whole))
        for k, (row, one) in enumerate(zip(matrix, right, strict=True))
    ]
    named = list(zip(symbols, unknowns, strict=True))
    names = [each.name for each in equations.constraints]
    momenta = [*map(value, printed.momenta)]
    moving = sum(abs(known[str(v)].value) * p.scale for v, p in zip(equations.v, momenta, strict=True))
    momenta = [  # a component that is 0 up to rounding is measured by all that moves
        Measured(p.value, max(p.scale, mpmath.sqrt(row[k].scale * moving)))
        for k, (p, row) in enumerate(zip(momenta, rows, strict=True))
    ]
    functions = [
        *zip((f"p_{name}" for name in equations.coordinates), momenta, strict=True),
        ("h", value(printed.h)),
        *zip((f"constraint {name}" for name in names), map(value, printed.constraints), strict=True),
    ]
    everything = {**known, **{name: Measured(one.value, size) for (name, one), size in zip(named, sizes)}}
    return Evaluated(
        accelerations=named[:n],
        multipliers=named[n:],
        functions=functions,
        equations=[
            *differences(equations, printed, everything),
            *(
                (f"the linear system, row of {name}", Measured(side - one.value, scale))
                for name, side, one, scale in zip(symbols, left, right, scales, strict=True)
            ),
        ],
        zeros=[(name, Measured(mpmath.mpf(0), scale)) for name, scale in zip(symbols, scales, strict=True)],
    )


def nothing() -> Measured:
    """0."""
    return Measured(mpmath.mpf(0), mpmath.mpf(0))


def differences(equations: Equations, printed: Printed, known: Mapping[str, Any]) -> Named:
    """left - right of each equation of motion; none where they are not compared."""
    algebra = MeasuredAlgebra()
    return [
        (
            f"the equation of {name}",
            build(left, known.__getitem__, algebra) - build(right, known.__getitem__, algebra),
        )
        for name, (left, right) in zip(equations.coordinates, printed.equations or ())
    ]
