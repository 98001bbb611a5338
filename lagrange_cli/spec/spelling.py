"""The text of an expression of a family's member, with numbers in place of the indices."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.syntax import ExpressionError, Name, Tree, children
from lagrange_cli.spec.spec import Expression


def spelled(expression: Expression, sizes: Mapping[str, int]) -> str:
    """``x[1] - x[0]`` for ``x[i] - x[i - 1]`` where i is 1. Indices of sums stay as they are."""
    if not expression.indices:
        return expression.text
    known = {**sizes, **expression.indices}
    found: set[tuple[int, int, str]] = set()  # the components of a point of a body share its places
    pending: list[Tree] = [expression.tree]
    while pending:
        tree = pending.pop()
        replaced = _replaced(tree, expression, known) if isinstance(tree, Name) else None
        if replaced is not None:
            found.add(replaced)
        else:
            pending += children(tree)
    made = expression.text
    for start, stop, text in sorted(found, reverse=True):
        made = made[:start] + text + made[stop:]
    return made


def _replaced(name: Name, expression: Expression, known: Mapping[str, int]) -> tuple[int, int, str] | None:
    """What stands in place of an index, or of the indices of a name: from where to where, and what. Nothing
    where a name has others than those that are known, or none."""
    start, stop = name.span.start, name.span.stop
    if not name.indices:
        own = expression.indices.get(name.identifier)
        return None if own is None else (start, stop, str(own))
    try:
        numbers = [integer(index, known) for index in name.indices]
    except ExpressionError:
        return None
    first, last = expression.text.index("[", start), name.indices[-1].span.stop
    return first, expression.text.index("]", last) + 1, f"[{','.join(map(str, numbers))}]"
