"""Sums of series: a longer one begins with the longest of those before whose terms are among its own."""

from __future__ import annotations

from bisect import insort

from lagrange_cli.expression.node import Node
from lagrange_cli.records import dataclass, field

Terms = frozenset[tuple[int, Node]]
"""The terms of a sum: series and their coefficients."""


@dataclass
class Sums:
    """Series by the terms that they are the sums of."""

    known: dict[Terms, int] = field(default_factory=dict)
    parts: dict[tuple[int, Node], list[tuple[int, int, Terms]]] = field(default_factory=dict)
    """The same by the one of their terms that is first, from short to long, of one length the oldest last."""

    def enter(self, whole: Terms, series: int) -> None:
        """Keep a sum for later ones."""
        parts = self.parts.setdefault(min(whole, key=lambda term: term[0]), [])
        insort(parts, (len(whole), -len(self.known), whole))
        self.known[whole] = series

    def longest_part(self, whole: Terms) -> Terms | None:
        """The longest of the sums so far all of whose terms, but not all terms, are in ``whole``."""
        found: tuple[int, int, Terms] | None = None
        for term in whole:
            for one in reversed(self.parts.get(term, ())):
                if found is not None and one[:2] < found[:2]:
                    break
                if one[2] < whole:
                    found = one
                    break
        return found[2] if found is not None else None
