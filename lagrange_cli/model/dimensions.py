"""``Walk``: the quantities of expressions, from their trees.

All members of a family have one unit, so trees are gone through as they are written, and a sum once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from itertools import pairwise
from typing import Any

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.operations import OPERATIONS, call
from lagrange_cli.expression.syntax import (
    WHOLE,
    Binary,
    Call,
    Comparison,
    Logic,
    Name,
    Negative,
    Number,
    Span,
    Sum,
    Tree,
    Vector,
)
from lagrange_cli.expression.vocabulary import (
    AXES_COMPONENTS,
    BODY_COMPONENTS,
    COMPONENTS,
    MULTIPLIER,
    VELOCITY_COMPONENTS,
)
from lagrange_cli.model.quantity import (
    BROKEN,
    COUNT,
    UNKNOWN,
    Contradiction,
    Quantity,
    QuantityAlgebra,
    alternative,
    compared,
    number,
    varying,
)
from lagrange_cli.model.unit import ONE


class Walk:
    """The quantities of trees: ``values`` has those of names, particles' as tuples of components.

    ``note`` gets every contradiction, and its place in the text.
    """

    def __init__(
        self,
        values: Mapping[str, Value],
        velocity: Callable[[Quantity], Quantity],
        note: Callable[[Contradiction, Span], None],
        counts: Collection[str],
    ) -> None:
        self.values = values
        self.velocity = velocity
        self.note = note
        self.counts = frozenset(counts)
        self.algebra: Any = QuantityAlgebra()

    def value(self, tree: Tree) -> Value:
        """A quantity, or a tuple of them for a vector."""
        spine: list[Binary] = []  # sums and products lean to the left
        while isinstance(tree, Binary) and tree.operator not in WHOLE:
            spine.append(tree)
            tree = tree.left
        value = self._operand(tree)
        for binary in reversed(spine):
            value = self._done(OPERATIONS[binary.operator], binary, value, self.value(binary.right), binary)
        return value

    def _done(self, operation: Callable[..., Value], tree: Tree, *operands: Any) -> Value:
        try:
            return operation(*operands)
        except Contradiction as error:
            self.note(error, tree.span)
        vectors = [operand for operand in operands[:2] if isinstance(operand, tuple)]
        return (BROKEN,) * len(vectors[0]) if vectors else BROKEN

    def _operand(self, tree: Tree) -> Value:
        if isinstance(tree, Number):
            return number(float(tree.text))
        if isinstance(tree, Name):
            return self._name(tree)
        if isinstance(tree, Negative):
            operand = self.value(tree.operand)
            return tuple(-item for item in operand) if isinstance(operand, tuple) else -operand
        if isinstance(tree, Vector):
            return tuple(map(self.value, tree.items))
        if isinstance(tree, Sum):
            return self._sum(tree)
        if isinstance(tree, Call) and tree.function == "where":
            return self._where(tree)
        if isinstance(tree, Call):
            return self._call(tree, [self.value(argument) for argument in tree.arguments])
        assert isinstance(tree, Binary | Comparison | Logic)
        return COUNT  # // and %

    def _where(self, tree: Call) -> Value:
        """The quantity that both branches have in common."""
        condition, *branches = tree.arguments
        self._compared(condition)
        one, other = map(self.value, branches)
        made = tuple(self._done(alternative, tree, *pair) for pair in zip(vector(one), vector(other)))
        return made if isinstance(one, tuple) else made[0]

    def _compared(self, condition: Tree) -> None:
        """Report values that cannot be compared."""
        if isinstance(condition, Logic):
            for operand in condition.operands:
                self._compared(operand)
        elif isinstance(condition, Comparison):
            values = [self.value(operand) for operand in condition.operands]
            for one, other in pairwise(values):
                self._done(compared, condition, one, other)

    def _call(self, tree: Call, arguments: list[Value]) -> Value:
        def called(*_: Value) -> Value:
            return call(tree, arguments, self.algebra)

        value = self._done(called, tree, *arguments)
        return value[0] if isinstance(value, tuple) and tree.function in ("dot", "norm") else value

    def _sum(self, tree: Sum) -> Value:
        counts, self.counts = self.counts, self.counts | {tree.index}
        value = self.value(tree.body)
        self.counts = counts
        return tuple(map(varying, value)) if isinstance(value, tuple) else varying(value)

    def _name(self, tree: Name) -> Value:
        if tree.identifier in self.counts and not tree.indices:
            return COUNT
        if tree.identifier == "pi":
            return Quantity(ONE, math.pi)
        base, _, component = tree.identifier.partition(".")
        if component == MULTIPLIER:
            return self.values.get(tree.identifier, UNKNOWN)
        value = self.values[base]
        if component in AXES_COMPONENTS:
            return Quantity(ONE, math.nan)
        if component in BODY_COMPONENTS:
            return self.velocity(Quantity(ONE, math.nan))
        if component in VELOCITY_COMPONENTS:
            return self.velocity(value[VELOCITY_COMPONENTS.index(component)])
        return value[COMPONENTS.index(component)] if component else value


def vector(value: Value) -> tuple[Quantity, ...]:
    """The components of a value; a scalar is one."""
    return value if isinstance(value, tuple) else (value,)
