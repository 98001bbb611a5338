"""The text of an expression of a family's member, with numbers in place of the indices."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.syntax import ExpressionError, Name, Tree, children
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.spec.spec import Expression


def spelled(expression: Expression, sizes: Mapping[str, int]) -> str:
    """``x[1] - x[0]`` for ``x[i] - x[i - 1]`` where i is 1. Indices of sums stay as they are."""
    if not expression.indices:
        return expression.text
    known = {**sizes, **expression.indices}
    found: list[tuple[int, int, str]] = []
    pending: list[Tree] = [expression.tree]
    while pending:
        tree = pending.pop()
        text = _spelled_name(tree, known, expression.indices) if isinstance(tree, Name) else ""
        if text:
            found.append((tree.span.start, tree.span.stop, text))
        else:
            pending += children(tree)
    made = expression.text
    for start, stop, text in sorted(found, reverse=True):
        made = made[:start] + text + made[stop:]
    return made


def _spelled_name(name: Name, known: Mapping[str, int], own: Mapping[str, int]) -> str:
    """A name without the indices that are known; nothing where it has others, or none."""
    if not name.indices:
        return str(own[name.identifier]) if name.identifier in own else ""
    try:
        return member_name(name.identifier, [integer(index, known) for index in name.indices])
    except ExpressionError:
        return ""
