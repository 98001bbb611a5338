"""Numbers of the section ``draw``, which are made of parameters: angles, and the ends of ranges."""

from __future__ import annotations

from lagrange_cli.spec.kinds import CONSTANT, Rule
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.wanted import Range

NUMBERS = "numbers of draw"
"""The key of their rule among those of the sections."""
RULE = Rule(CONSTANT, "ranges and angles may use numbers and parameters")


def number(names: Names, expression: Expression | None, where: str) -> Expression | None:
    """The expression, checked to be a number."""
    if expression is not None:
        check_scalar(names, expression, NUMBERS, where)
    return expression


def ends(names: Names, given: Range, where: str) -> Range:
    """Both ends of a range, checked."""
    for one in given:
        number(names, one, where)
    return given
