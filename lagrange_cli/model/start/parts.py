"""Some of a system's constraints as functions of the few coordinates that they contain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.sloped import Sloped, SlopedAlgebra
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import COMPONENTS, TIME
from lagrange_cli.limits import Work
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression, Spec


class Parts:
    """Holonomic constraints of ``spec``, in doubles: a constraint takes the work of its own terms."""

    def __init__(self, spec: Spec, parameters: Mapping[str, Any], coordinates: Sequence[str]) -> None:
        self.spec, self.parameters = spec, parameters
        self.numbers = {name: k for k, name in enumerate(coordinates)}
        self.names = [*spec.constraints]
        self.work = Work()

    def at(
        self, t: float, q: Sequence[float], chosen: Sequence[int]
    ) -> tuple[dict[int, Any], dict[int, dict[int, Any]]]:
        """The ``chosen`` constraints at a place, and their slopes. Raises ``SpecError`` where one of them has
        no value."""
        known = Names(self, t, q)
        values, rows = dict[int, Any](), dict[int, dict[int, Any]]()
        for i in chosen:
            f: Sloped = known.build(self.spec.constraints[self.names[i]])
            values[i] = f.value
            rows[i] = {slot - 1: slope for slot, slope in f.slopes.items() if slot > 0}
        return values, rows


class Names:
    """The values of names at a place, each found when it is first asked for."""

    def __init__(self, parts: Parts, t: float, q: Sequence[float]) -> None:
        self.parts, self.q = parts, q
        self.algebra = SlopedAlgebra({}, (), (t, (), ()), parts.work)
        self.values: dict[str, Value] = {TIME: self.algebra.symbol(TIME)}
        self.builder = Builder(self, self.algebra, parts.spec.sizes)

    def __call__(self, identifier: str) -> Value:
        base, _, component = identifier.partition(".")
        if base not in self.values:
            self.values[base] = self._found(base)
        value = self.values[base]
        return value[COMPONENTS.index(component)] if component else value

    def _found(self, name: str) -> Value:
        parts = self.parts
        if name in parts.numbers:
            k = parts.numbers[name]
            return Sloped(self.q[k], parts.work, {k + 1: 1.0})
        if name in parts.parameters:
            return Sloped(parts.parameters[name], parts.work)
        if name in parts.spec.definitions:
            return self.build(parts.spec.definitions[name])
        position = self.build(parts.spec.embedding[name])
        return position if isinstance(position, tuple) else (position,)

    def build(self, expression: Expression) -> Value:
        """The value of an expression."""
        try:
            return self.builder.build(expression.tree, expression.indices)
        except ExpressionError as error:
            spec = self.parts.spec
            source, place = Source(spec.filename, spec.text), expression.at(error.span)
            raise SpecError(source.filename, [source.problem(place, error.message, error.hint)]) from error
