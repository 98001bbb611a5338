"""Collects the mistakes of a file, so that all of them are shown at once."""

from __future__ import annotations

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.expression.syntax import ExpressionError, Tree
from lagrange_cli.spec.source import Place, Source
from lagrange_cli.spec.spec import Expression

MOST = 50
"""The largest number of problems that are shown; further ones are likely to follow from them."""


class Problems:
    """The problems found so far in ``source``.

    ``broken`` are names whose declaration is wrong: their use is no further mistake.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.found: list[Problem] = []
        self.broken: set[str] = set()
        self._unsound: dict[int, Tree] = {}

    def distrust(self, tree: Tree) -> None:
        """Remember that an expression is wrong: what follows from it is no further mistake."""
        self._unsound[id(tree)] = tree

    def trusts(self, tree: Tree) -> bool:
        """Whether nothing wrong has been found in an expression."""
        return id(tree) not in self._unsound

    def at(self, place: Place) -> bool:
        """Whether there is a problem at this place."""
        return any((one.line, one.column) == (place.line, place.column) for one in self.found)

    def add(self, place: Place, message: str, hint: str = "") -> None:
        """Note a problem; the file is given up where there are too many."""
        self.found.append(self.source.problem(place, message, hint))
        if len(self.found) >= MOST:
            self.stop_if_any()

    def add_once(self, place: Place, message: str, hint: str = "") -> None:
        """Report a problem that every member of a family may have, but only for the first one."""
        if not self.at(place):
            self.add(place, message, hint)

    def add_expression(self, expression: Expression, error: ExpressionError, where: str = "") -> None:
        """Note a mistake within an expression, at the exact piece."""
        self.distrust(expression.tree)
        message = f"{error.message} in {where}" if where else error.message
        self.add(expression.at(error.span), message, error.hint)

    def stop_if_any(self) -> None:
        """Raise SpecError with everything found."""
        if self.found:
            raise SpecError(self.source.filename, self.found)
