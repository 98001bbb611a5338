"""Indices that are looked up: ``x[a[n]]``, where ``a`` is a list or a family of whole numbers.

Such a family of ``parameters`` or ``definitions`` becomes a ``NumberTable``, and its members that stand in
indices, ranges and conditions become ``Lookup`` trees. Elsewhere they remain what they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from lagrange_cli.expression.number_table import NumberTable
from lagrange_cli.expression.rebuilding import with_children
from lagrange_cli.expression.syntax import (
    WHOLE,
    Axis,
    Binary,
    ExpressionError,
    Lookup,
    Loop,
    Name,
    Sum,
    Tree,
    children,
)
from lagrange_cli.limits import whole
from lagrange_cli.records import fields_of, replace
from lagrange_cli.spec.draft import LOOKED_UP, Declared, Draft, Written
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Passage, Place
from lagrange_cli.spec.spec import Expression

Find = Callable[[Name], "NumberTable | None"]
T = TypeVar("T")


def with_lookups(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Draft:
    """The draft with what is looked up, and the tables."""
    declared = declarations(draft)
    if not declared or not any(looks_up(*one) for one in trees_of(draft.sections)):
        return draft
    tables = Tables(declared, sizes, problems)
    return replace(draft, sections=changed(draft.sections, tables.find, problems), tables=tables.known)


def declarations(draft: Draft) -> dict[str, list[Written]]:
    """What declares each family of these sections."""
    found: dict[str, list[Written]] = {}
    for section in LOOKED_UP:
        for one in draft.written(section):
            if one.key.axes or one.is_list:
                found.setdefault(one.name, []).append(one)
    return found


class Tables:
    """The tables of families that are ``declared``, made where they are asked for."""

    def __init__(
        self, declared: Mapping[str, list[Written]], sizes: Mapping[str, int], problems: Problems
    ) -> None:
        self.declared, self.sizes, self.problems = declared, sizes, problems
        self.known: dict[str, NumberTable] = {}
        self._under_way: list[str] = []

    def find(self, name: Name) -> NumberTable | None:
        """The table of this name, if it is one of whole numbers.

        Raises:
            ExpressionError: where it is a family of other numbers, or needs itself.
        """
        base = name.identifier
        if base not in self.declared or base in self.problems.broken:
            return None
        if base in self._under_way:
            message = f"'{base}' is looked up in itself"
            raise ExpressionError(name.span, message, f"write numbers for '{base}'")
        if base not in self.known:
            self._under_way.append(base)
            try:
                self.known[base] = self._made(name)
            finally:
                self._under_way.pop()
        return self.known[base]

    def _made(self, name: Name) -> NumberTable:
        import numpy as np

        pieces = [*self._pieces(name)]
        axes = len(name.indices)
        if any(places.shape[1] != axes for places, _ in pieces):
            found = pieces[0][0].shape[1]
            message = f"'{name.identifier}' has {found} {'index' if found == 1 else 'indices'}, not {axes}"
            raise ExpressionError(name.span, message, "give it as many as in its declaration")
        places = np.concatenate([one for one, _ in pieces])
        shape = tuple(int(one) + 1 for one in places.max(axis=0, initial=0))
        if np.any(places < 0) or np.prod(shape, dtype=np.float64) > whole("pairs"):
            raise self._unsuited(name)
        numbers, given = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.bool_)
        where = tuple(places.T)
        numbers[where] = np.concatenate([one for _, one in pieces])
        given[where] = True
        return NumberTable(name.identifier, numbers, given)

    def _pieces(self, name: Name) -> Iterator[tuple[Any, Any]]:
        """The places (members, axes) of each piece of a family, and the numbers there."""
        import numpy as np

        from lagrange_cli.expression.index_arrays import integers
        from lagrange_cli.expression.index_loops import places
        from lagrange_cli.expression.indices import Unsuited, integer

        for piece in self.declared[name.identifier]:
            values = [with_found(one.tree, self.find, True) for one in values_of(piece)]
            if not values:
                raise self._unsuited(name)
            try:
                if isinstance(piece, Declared) and piece.is_list:
                    found = np.asarray([integer(one, self.sizes) for one in values], dtype=np.int64)
                    yield np.arange(len(found))[:, None], found
                    continue
                axes = changed(piece.key.axes, self.find, self.problems)
                rows = places(axes, self.sizes)
                own = {axis.index: rows[:, k] for k, axis in enumerate(axes) if axis.index}
                (value,) = values
                found = np.asarray(integers(value, {**self.sizes, **own}), dtype=np.int64)
                yield rows, np.broadcast_to(found, len(rows))
            except (ExpressionError, Unsuited) as error:
                raise self._unsuited(name) from error

    def _unsuited(self, name: Name) -> ExpressionError:
        message = f"'{name.identifier}' cannot be an index: it is not a family of whole numbers"
        return ExpressionError(name.span, message, "write them as 0, 1, 2, or with sizes and indices")


def values_of(piece: Written) -> tuple[Expression, ...]:
    """The expressions of a piece of a family; none where it has a unit."""
    if not isinstance(piece, Declared):
        return piece.expressions
    value = piece.fields.get("value")
    if value is None or piece.fields.get("unit"):
        return ()
    return value if isinstance(value, tuple) else (value,)


def trees_of(given: Any) -> Iterator[tuple[Tree, bool]]:
    """Every tree in what has been read of a file, and whether it is a whole number or a condition."""
    if isinstance(given, Expression):
        yield given.tree, False
    elif isinstance(given, Axis | Loop):
        yield from ((one, True) for one in (*given.bounds, *given.conditions))
    else:
        for _, one in inside(given):
            yield from trees_of(one)


def inside(given: Any) -> Iterator[tuple[Any, Any]]:
    """What a mapping, a sequence or a record is made of, with its keys."""
    if isinstance(given, Mapping):
        yield from given.items()
    elif isinstance(given, tuple | list):
        yield from enumerate(given)
    elif hasattr(given, "__record_fields__") and not isinstance(given, Place | Passage):
        yield from ((name, getattr(given, name)) for name in fields_of(given))


def looks_up(tree: Tree, is_index: bool) -> bool:
    """Whether a name with an index stands where a whole number does; the tree itself may be one."""
    pending = [(tree, is_index)]
    while pending:
        node, is_index = pending.pop()
        if isinstance(node, Name) and node.indices and is_index:
            return True
        pending += zip(children(node), indices_among(node, is_index))
    return False


def indices_among(node: Tree, is_index: bool) -> list[bool]:
    """Which of the ``children`` of a node are whole numbers."""
    if isinstance(node, Name):
        return [True] * len(node.indices)
    if isinstance(node, Sum):
        return [is_index, *[True] * (len(node.bounds) + len(node.conditions))]
    return [is_index or (isinstance(node, Binary) and node.operator in WHOLE)] * len(children(node))


def changed(given: T, find: Find, problems: Problems) -> T:
    """What has been read of a file with lookups; where a table cannot be found, that is a problem.

    Raises ``ExpressionError`` where the place of the problem is not known here.
    """
    one: Any = given
    if isinstance(one, Expression):
        if not looks_up(one.tree, False):
            return given
        try:
            one = replace(one, tree=with_found(one.tree, find, False))
        except ExpressionError as error:
            problems.add_expression(one, error)
            return given
        if not problems.trusts(given.tree):  # type: ignore[attr-defined]
            problems.distrust(one.tree)
        return one  # type: ignore[no-any-return]
    if isinstance(one, Axis | Loop):
        bounds, conditions = (
            tuple(with_found(tree, find, True) for tree in trees) for trees in (one.bounds, one.conditions)
        )
        return replace(one, bounds=bounds, conditions=conditions)  # type: ignore[return-value]
    try:
        parts = [(key, part, changed(part, find, problems)) for key, part in inside(one)]
    except ExpressionError as error:
        place = one.at(error.span) if isinstance(one, Written) else getattr(one, "place", None)
        if place is None:
            raise
        problems.add(place, error.message, error.hint)
        return given
    if all(old is new for _, old, new in parts):
        return given
    made = {key: new for key, _, new in parts}
    if isinstance(one, tuple | list):
        return type(one)(made.values())  # type: ignore[return-value]
    return made if isinstance(one, Mapping) else replace(one, **made)  # type: ignore[return-value]


def with_found(tree: Tree, find: Find, is_index: bool) -> Tree:
    """A tree with lookups in place of names, if it is an index or has some within. Raises ExpressionError."""
    spine = list[tuple[Binary, bool]]()
    while isinstance(tree, Binary):
        is_index = is_index or tree.operator in WHOLE
        spine.append((tree, is_index))
        tree = tree.left
    made = _with_found(tree, find, is_index)
    for binary, is_whole in reversed(spine):
        made = replace(binary, left=made, right=with_found(binary.right, find, is_whole))
    return made


def _with_found(tree: Tree, find: Find, is_index: bool) -> Tree:
    """The same of a tree that no operator joins."""
    among = zip(children(tree), indices_among(tree, is_index))
    parts = tuple(with_found(one, find, one_is_index) for one, one_is_index in among)
    table = find(tree) if isinstance(tree, Name) and tree.indices and is_index else None
    return with_children(tree, parts) if table is None else Lookup(table, tree.span, parts)
