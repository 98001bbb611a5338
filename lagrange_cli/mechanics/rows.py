"""``Row``: one of a matrix most of whose entries are 0, as those of large systems are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import overload

from lagrange_cli.expression.node import Node


class Row(Sequence[Node]):
    """A row of so many entries: those in ``given``, by place, and ``zero`` everywhere else.

    It takes memory for what is not 0 only; a matrix of 10,000 rows has 10^8 entries.
    """

    __slots__ = ("_entries", "_length", "_zero")

    def __init__(self, given: Mapping[int, Node], length: int, zero: Node) -> None:
        self._entries = {place: given[place] for place in sorted(given) if given[place] is not zero}
        self._length, self._zero = length, zero

    @property
    def places(self) -> list[int]:
        """The columns of the entries that are not 0, in order."""
        return [*self._entries]

    def mapped(self, function: Callable[[Sequence[Node]], Sequence[Node]]) -> Row:
        """The row with what ``function`` makes of all entries that are not 0; it leaves 0 as it is."""
        found = function([*self._entries.values()])
        return Row(dict(zip(self._entries, found, strict=True)), self._length, self._zero)

    def replaced(self, place: int, entry: Node) -> Row:
        """The row with another entry."""
        return Row({**self._entries, place: entry}, self._length, self._zero)

    def __len__(self) -> int:
        return self._length

    def __iter__(self) -> Iterator[Node]:
        return (self._entries.get(place, self._zero) for place in range(self._length))

    @overload
    def __getitem__(self, place: int) -> Node: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Node, ...]: ...
    def __getitem__(self, place: int | slice) -> Node | tuple[Node, ...]:
        places = range(self._length)[place]  # counts from the end, and knows where that is
        if isinstance(places, int):
            return self._entries.get(places, self._zero)
        return tuple(self._entries.get(each, self._zero) for each in places)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and [*self] == [*other]

    def __hash__(self) -> int:
        return hash(tuple(self))


Matrix = tuple[Sequence[Node], ...]
"""Rows of equal length."""


def mapped(row: Sequence[Node], function: Callable[[Sequence[Node]], Sequence[Node]]) -> Sequence[Node]:
    """The result of ``function`` for a row, in which 0 stays 0."""
    return row.mapped(function) if isinstance(row, Row) else function(row)
