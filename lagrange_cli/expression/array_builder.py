"""``Builder`` for all members of a family, or all terms of a sum, at once: indices are arrays of numpy.

Where members differ in kind, as a chain's ends do from its middle, each kind is built by itself.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.conditions import is_index
from lagrange_cli.expression.index_arrays import (
    MOST,
    Differ,
    Places,
    Whole,
    distinct,
    holding,
    integers,
    of_each_kind,
    one_if_equal,
    taken,
)
from lagrange_cli.expression.index_loops import inner, visited
from lagrange_cli.expression.indices import Indices, Unsuited
from lagrange_cli.expression.syntax import Call, Comparison, Logic, Name, Sum, Tree, is_whole, plain_names
from lagrange_cli.expression.vocabulary import TIME


class Members(dict[str, Any]):
    """The sizes, and the indices of the members of a ``domain``, of which there are ``count``."""

    def __init__(self, domain: Any, count: int, indices: Mapping[str, Whole]) -> None:
        super().__init__(indices)
        self.domain, self.count = domain, count
        self.alike: Mapping[str, Whole] | None = None
        """The indices of all members that are written as these are, where that is known."""


class ArrayBuilder(Builder):
    """Raises ``Unsuited`` where members have to be treated one by one, and where all sums together have
    more than ``most`` terms, of which so many have been ``used``."""

    most, used = MOST, 0

    def domain(self, count: int) -> Any:
        """The shared values of members that are built together."""

    @abstractmethod
    def number(self, value: Whole, members: Members) -> Value:
        """Whole numbers as the values of an expression."""

    @abstractmethod
    def named(self, identifier: str, places: list[Whole], members: Members) -> Value:
        """The value of a (dotted) name, with indices if it is that of a family."""

    @abstractmethod
    def summed(self, tree: Sum, members: Members) -> Value:
        """A sum."""

    def value(self, tree: Tree, members: Members) -> Value:
        """The value of ``tree`` for these members."""
        return self._value(tree, members)

    def _name(self, tree: Name, indices: Indices) -> Value:
        assert isinstance(indices, Members)
        if not tree.indices and tree.identifier in indices:
            return self.number(indices[tree.identifier], indices)
        if tree.identifier == "pi":
            return self.algebra.pi()
        if tree.identifier == TIME:
            return self.algebra.symbol(TIME)
        return self.named(tree.identifier, [integers(index, indices) for index in tree.indices], indices)

    def _whole(self, tree: Tree, indices: Indices) -> Value:
        assert isinstance(indices, Members)
        return self.number(integers(tree, indices), indices)

    def _where(self, tree: Call, indices: Indices) -> Value:
        """One branch for all members where indices decide, else a switch."""
        assert isinstance(indices, Members)
        condition, *branches = tree.arguments
        for one in comparisons(condition):
            compared = one.operands if isinstance(one, Comparison) else ()
            if not all(is_whole(part, lambda name: is_index(name, indices)) for part in compared):
                return super()._where(tree, indices)
        return self._value(branches[0 if self._holds(condition, indices) else 1], indices)

    def _holds(self, condition: Tree, indices: Indices) -> bool:
        """The same for all members; raises ``Differ`` where they differ."""
        assert isinstance(indices, Members)
        known = holding(condition, indices)
        found = distinct(np.asarray(known))
        if len(found) > 1:
            raise Differ(np.asarray(known, dtype=np.int64))
        return bool(found[0])

    def _sum(self, tree: Sum, indices: Indices) -> Value:
        assert isinstance(indices, Members)
        return self.summed(tree, indices)

    def terms(self, tree: Sum, members: Members) -> Iterator[tuple[Members, Value, Places]]:
        """The terms of a sum, of each kind by itself: their indices, values, and whose terms they are."""
        found, owners = inner(tree, members, members.count)
        for mine, value, which in self.each(tree.body, found, len(owners)):
            yield mine, value, owners[which]

    def shared(self, tree: Sum, members: Members) -> tuple[dict[str, Whole], Places] | None:
        """The indices of all terms of a sum, each once, and the values of its own index among them; None
        where terms differ from member to member."""
        varying = {name for name, one in members.items() if not isinstance(one, int)}
        if any(varying & plain_names(one) for one in (tree.body, *tree.conditions)):
            return None
        found: dict[str, Whole] = {name: one for name, one in members.items() if isinstance(one, int)}
        own = found[tree.index] = visited(tree, members, members.count)
        for condition in tree.conditions:
            own = found[tree.index] = own[np.broadcast_to(holding(condition, found), len(own))]
        return found, own

    def each(
        self, body: Tree, found: Mapping[str, Whole], count: int, alike: Mapping[str, Whole] | None = None
    ) -> Iterator[tuple[Members, Value, Places]]:
        """The values of ``body`` for ``count`` members with the indices ``found``, of each kind by itself:
        their indices, values, and which they are. ``alike`` are the indices of all that are written so."""
        self.used += count
        if self.used > self.most:
            raise Unsuited

        def made(which: Places) -> tuple[Members, Value, Places]:
            some = found if len(which) == count else taken(found, which)
            here = {name: one if isinstance(one, int) else one_if_equal(one) for name, one in some.items()}
            mine = Members(self.domain(len(which)), len(which), here)
            mine.alike = alike
            return mine, self._value(body, mine), which

        if count:
            yield from of_each_kind(np.arange(count), made)

    def _key(self, tree: Tree, indices: Indices) -> tuple[int, ...]:
        raise Unsuited


def comparisons(condition: Tree) -> Iterator[Tree]:
    """The comparisons that a condition is made of."""
    if isinstance(condition, Logic):
        for one in condition.operands:
            yield from comparisons(one)
    else:
        yield condition
