"""``Tree`` to a value over any algebra; sums over the indices of families share what they have in common."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from lagrange_cli.expression import conditions
from lagrange_cli.expression.algebra import Algebra, Value
from lagrange_cli.expression.indices import Indices, counted, holds, integer, known_indices
from lagrange_cli.expression.operations import OPERATIONS, arithmetic, call, component, joined
from lagrange_cli.expression.syntax import (
    WHOLE,
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Logic,
    Lookup,
    Name,
    Negative,
    Number,
    Sum,
    Tree,
    Vector,
    plain_names,
)
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.limits import way_out, whole

Scope = Callable[[str], Value]

MANY = 64
"""Terms of a sum from which on those that satisfy its conditions are found together."""
MAX_TERMS = whole("terms")
"""Terms of all the sums that one builder writes out."""


class NoMember(LookupError):
    """Raised by a scope: the family has no such member; its text is a way out."""


def build(tree: Tree, scope: Scope, algebra: Algebra[Any], indices: Indices | None = None) -> Value:
    """The value of ``tree`` alone; see ``Builder``."""
    return Builder(scope, algebra).build(tree, indices or {})


class Builder:
    """Builds the trees of one file over ``algebra``.

    ``scope`` gives the value of each (possibly dotted) name, or member of a family by a name such as
    ``bob[2].x``; ``pi`` is asked of the algebra, ``sizes`` are whole numbers. Terms and partial sums that
    come again are built once, so the scope must always give the same value for a name.
    """

    def __init__(
        self, scope: Scope, algebra: Algebra[Any], sizes: Indices | None = None, *, fades: bool = False
    ) -> None:
        self.scope = scope
        self.fades = fades
        self.algebra = algebra
        self.sizes = sizes or {}
        self._terms = 0
        self._names: dict[int, tuple[Tree, frozenset[str]]] = {}
        self._bodies: dict[tuple[int, ...], Value] = {}
        self._sums: dict[tuple[int, ...], tuple[int, Value]] = {}

    def build(self, tree: Tree, indices: Indices | None = None) -> Value:
        """The value of ``tree``: an element of the algebra, or a tuple of 1 to 3 elements for a vector.

        ``indices`` are the values of the indices that the tree is within.

        Raises:
            ExpressionError: where a vector meets a scalar, lengths differ, a member does not exist, or the
                algebra raises ``ArithmeticError`` (a division by zero among constants, say).
        """
        return self._value(tree, {**self.sizes, **indices} if indices else self.sizes)

    def _value(self, tree: Tree, indices: Indices) -> Value:
        # Sums and products lean to the left, so the long way down is a loop and the recursion stays short.
        spine: list[Binary] = []
        while isinstance(tree, Binary) and tree.operator not in WHOLE:
            spine.append(tree)
            tree = tree.left
        value = self._operand(tree, indices)
        for binary in reversed(spine):
            right = self._value(binary.right, indices)
            try:
                value = OPERATIONS[binary.operator](value, right, binary)
            except ArithmeticError as error:
                raise arithmetic(binary, error, indices) from error
        return value

    def _operand(self, tree: Tree, indices: Indices) -> Value:
        if isinstance(tree, Number):
            return self.algebra.number(tree.text)
        if isinstance(tree, Name):
            return self._name(tree, indices)
        if isinstance(tree, Negative):
            operand = self._value(tree.operand, indices)
            return tuple(-item for item in operand) if isinstance(operand, tuple) else -operand
        if isinstance(tree, Vector):
            return tuple(component(item, self._value(item, indices)) for item in tree.items)
        if isinstance(tree, Sum):
            return self._sum(tree, indices)
        if isinstance(tree, Comparison | Logic):
            raise ExpressionError(
                tree.span, "expected a number, found a condition", "write where(CONDITION, 1, 0)"
            )
        if isinstance(tree, Binary | Lookup):  # // and %
            return self._whole(tree, indices)
        if tree.function == "where":
            return self._where(tree, indices)
        arguments = [self._value(argument, indices) for argument in tree.arguments]
        try:
            return call(tree, arguments, self.algebra, fades=self.fades)
        except ArithmeticError as error:
            raise arithmetic(tree, error, indices) from error

    def _holds(self, condition: Tree, indices: Indices) -> bool:
        """Whether a condition on indices holds."""
        return holds(condition, indices)

    def _where(self, tree: Call, indices: Indices) -> Value:
        """One branch or the other; a branch that is known not to apply is not computed."""
        condition, *branches = tree.arguments
        algebra = self.algebra
        try:
            value = partial(self._value, indices=indices)
            met = conditions.met(condition, indices, value, algebra, self._holds)
            if isinstance(met, bool):
                return self._value(branches[0 if met else 1], indices)
            chosen = met.select(algebra, algebra.number("1"), algebra.number("0"))
            above, below = algebra.both(chosen, *(partial(self._value, one, indices) for one in branches))
            return joined(tree, above, below, partial(met.select, algebra))
        except ArithmeticError as error:
            raise arithmetic(tree, error, indices) from error

    def _name(self, tree: Name, indices: Indices) -> Value:
        if not tree.indices:
            if tree.identifier in indices:
                return self.algebra.number(str(indices[tree.identifier]))
            return self.algebra.pi() if tree.identifier == "pi" else self.scope(tree.identifier)
        identifier = member_name(tree.identifier, [integer(index, indices) for index in tree.indices])
        try:
            return self.scope(identifier)
        except NoMember as error:
            message = f"no member '{identifier}'{known_indices(tree, indices)}"
            raise ExpressionError(tree.span, message, str(error)) from error

    def _whole(self, tree: Tree, indices: Indices) -> Value:
        try:
            return self.algebra.number(str(integer(tree, indices)))
        except ExpressionError as error:
            hint = "// and % are for whole numbers: indices and sizes; a comment begins with #"
            raise ExpressionError(error.span, error.message, hint) from error

    def _sum(self, tree: Sum, indices: Indices) -> Value:
        """A sum; one that begins as an earlier one did goes on from there."""
        loop = counted(tree, indices)
        key = (loop.start, loop.step, *self._key(tree, indices))
        done, total = self._sums.get(key, (0, None))
        if done > len(loop):
            done, total = 0, None
        left: Sequence[int] = loop[done:]
        if len(left) >= MANY:
            from lagrange_cli.expression.loops import narrowed  # for long sums only

            chosen = narrowed(tree, indices)
            left = left if chosen == loop else [index for index in chosen if index in left]
        self._terms += len(left)
        if self._terms > MAX_TERMS:
            raise ExpressionError(
                tree.span,
                f"more than {MAX_TERMS} terms in all sums together",
                f"make the sizes smaller, {way_out('terms')}",
            )
        terms = [] if total is None else [total]
        for index in left:
            inner = {**indices, tree.index: index}
            if all(holds(condition, inner) for condition in tree.conditions):
                terms.append(self._term(tree.body, inner))
        if len(terms) > 1:
            total = self._total(tree, terms, indices)
        elif terms:
            total = terms[0]
        self._sums[key] = len(loop), total
        return self.algebra.number("0") if total is None else total

    def _term(self, body: Tree, indices: Indices) -> Value:
        key = self._key(body, indices)
        if isinstance(body, Sum) or len(key) == 1 + len(indices) - len(self.sizes):  # will not come again
            return self._value(body, indices)
        if key not in self._bodies:
            self._bodies[key] = self._value(body, indices)
        return self._bodies[key]

    def _key(self, tree: Tree, indices: Indices) -> tuple[int, ...]:
        """The names that the value of ``tree`` depends on; of a sum, without the bounds of its range."""
        known = self._names.get(id(tree))
        if known is None:
            parts = (tree.body, *tree.conditions) if isinstance(tree, Sum) else (tree,)
            names = frozenset[str]().union(*map(plain_names, parts)) - self.sizes.keys()
            known = self._names[id(tree)] = tree, names  # the tree too, so that its id stays its own
        return (id(tree), *(value for name, value in indices.items() if name in known[1]))

    def _total(self, tree: Sum, terms: list[Value], indices: Indices) -> Value:
        try:
            if not any(isinstance(term, tuple) for term in terms):
                return self.algebra.total(terms)
            if len({len(term) if isinstance(term, tuple) else 0 for term in terms}) == 1:
                return tuple(self.algebra.total(components) for components in zip(*terms))
        except ArithmeticError as error:
            raise arithmetic(tree, error, indices) from error
        raise ExpressionError(
            tree.body.span,
            "the terms of the sum differ in kind",
            "give all terms the same number of components",
        )
