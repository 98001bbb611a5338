"""Initial states at which a force has no Taylor series, as that of the potential x**1.5 where x is 0.

A root has no value beyond. Where the file says what is there, as with abs(x) or max(0, x) in place of x, the
motion goes on (``integrate.guards.crossing``), unless the force is infinite.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import SpecError

if TYPE_CHECKING:
    from lagrange_cli.expression.borders import Border
    from lagrange_cli.mechanics.guards.roots import Root
    from lagrange_cli.spec.spec import Expression, Spec


def without_series(spec: Spec, known: Mapping[str, float]) -> SpecError | None:
    """What is said of a root in the file whose argument is 0 with these values of all symbols, so that a
    force has no series; None if there is none."""
    from lagrange_cli.mechanics.guards.roots import root_in_forces
    from lagrange_cli.run.jumps import symbolic

    found = [*at_ends(spec, known)]
    if not found:
        return None
    root = root_in_forces(symbolic(spec), known)
    return None if root is None else refusal(spec, root, *found[0])


def refusal(spec: Spec, root: Root, expression: Expression, border: Border, value: float) -> SpecError:
    """The error, at its place."""
    from lagrange_cli.run.causes import text
    from lagrange_cli.spec.source import Source

    whole, argument = text(expression, border.whole), text(expression, border.argument)
    lacks = "derivative" if root.divided else "Taylor series"
    shown = "it" if border.whole is border.argument else argument
    message = f"{whole} has no {lacks} where the motion begins: {shown} is {decimal(value)}"
    hint = "start from another state"
    if root.passes and not root.divided:
        hint += f", or write max(0, {argument}) if there is no force beyond"
    return Source(spec.filename, spec.text).error(expression.at(border.whole.span), message, hint)


def at_ends(spec: Spec, known: Mapping[str, float]) -> Iterator[tuple[Expression, Border, float]]:
    """The roots in the equations whose arguments are at the end of their domain."""
    from lagrange_cli.expression.borders import borders
    from lagrange_cli.expression.numbers import NumberAlgebra
    from lagrange_cli.expression.syntax import Binary, ExpressionError
    from lagrange_cli.model.scope import Scope

    try:
        scope = Scope(spec, NumberAlgebra(known))
    except (SpecError, LookupError, NotImplementedError):  # a number too large, a multiplier, or a velocity
        return
    for expression in scope.in_equations:
        for border, indices in borders(expression.tree, {**spec.sizes, **expression.indices}):
            whole, power = border.whole, 0.5
            if isinstance(whole, Binary) and whole.operator == "/":
                continue
            try:
                value = scope.builder.build(border.argument, indices)
                if isinstance(whole, Binary):
                    power = scope.builder.build(whole.right, indices)
            except (ExpressionError, LookupError, NotImplementedError, ValueError, ArithmeticError):
                continue
            if abs(value) in map(abs, border.ends) and power > 0.0 and power % 1.0:
                yield expression, border, float(value)
