"""``Numbers``: those of ``--over`` and ``--random``, from texts such as ``2*pi/omega`` to values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.reals import SMALLEST, TOO_SMALL, underflows
from lagrange_cli.expression.syntax import ExpressionError, names
from lagrange_cli.expression.vocabulary import CONSTANTS, family_name
from lagrange_cli.run.times import check_names, evaluated
from lagrange_cli.spec.evaluation import Evaluation

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

CONSTANT = "write numbers, or expressions in parameters"
COMMON = "--table can give each member numbers of its own"


class Numbers:
    """The numbers of a system that all members share: those of the file and of ``overrides`` that do not
    depend on what is ``swept``, by the names that the user gave."""

    def __init__(self, spec: Spec, overrides: Mapping[str, str], swept: Iterable[str]) -> None:
        self._spec, self._overrides = spec, overrides
        self._swept = {family_name(name) for name in swept}

    @cached_property
    def _parameters(self) -> Mapping[str, float]:
        evaluation = Evaluation(self._spec, self._overrides, NumberAlgebra(), {}, None)
        evaluation.parameters()
        differing = set(self._swept)
        while further := {
            base
            for base, trees in evaluation.trees.items()
            if base not in differing and any(one.base in differing for tree in trees for one in names(tree))
        }:
            differing |= further
        return {name: x for name, x in evaluation.values.items() if family_name(name) not in differing}

    def number(self, text: str, asked: str, hint: str = "") -> float:
        """A finite number, or an expression such as ``-pi/2``; a message about a text that is none begins
        with what was ``asked`` and ends with ``hint``. Raises ``UsageError``."""
        try:
            value = float(text)
            if underflows(text):
                raise UsageError(f"{asked}: {TOO_SMALL}: {text.strip()}; {SMALLEST}")
        except ValueError:
            try:
                tree = parse(text)
            except ExpressionError as error:
                raise UsageError(f"{asked}: expected a number, not {text.strip()[:50]!r}{hint}") from error
            try:
                known = self._parameters if {one.identifier for one in names(tree)} - set(CONSTANTS) else {}
                check_names(tree, self._spec, known, CONSTANT, COMMON)
                value = evaluated(tree, self._spec, known, exact=False)
            except ExpressionError as error:
                way_out = f"; {error.hint}" if error.hint else ""
                raise UsageError(f"{asked}: {error.message}{way_out}") from error
        if not math.isfinite(value):
            raise UsageError(f"{asked}: {text.strip()} is not a finite number")
        return value
