"""Loops over those members alone that act. The terms of others are 0 by the modes of their switches: so are
the forces between discs that do not touch, which are almost all pairs of many.

Those that act are listed once for all orders of a series, or for one evaluation of the forces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import product
from typing import TypeAlias

import numpy as np

from lagrange_cli.expression.node import Node, terms_of, union
from lagrange_cli.families.arrays import Array, Chain, Slots, Source, Term
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.native.families.evaluation import Evaluation, Writer
from lagrange_cli.native.families.loops import Loop, Rows
from lagrange_cli.native.families.member_lists import MemberList, each_of
from lagrange_cli.native.families.series import LoopSeries, begin_sums
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tables import Tables, before
from lagrange_cli.native.families.vectors import Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.records import dataclass, replace

Where: TypeAlias = "Callable[[Vectors], Pointer]"
"""Where numbers are, in a function."""
Spare: TypeAlias = "Callable[[int], Where]"
"""Finds room for so many doubles."""

FEWEST, CROWDED = 256, 2
"""From so many members on, and so many for each coordinate, most are expected not to act. (To look places up
takes longer than to go through them in rows.)"""
MOST_MODES = 3
"""Modes of a member that are looked at."""


@dataclass(frozen=True, eq=False)
class ActingLoop(Loop):
    """A loop over members that do not act while their ``modes`` have one of the ``idle`` signs."""

    modes: Sequence[Node] = ()
    idle: Sequence[tuple[float, ...]] = ()

    @cached_property
    def rows(self) -> Rows:
        """Whichever members act, all their places are looked up."""
        return Rows(np.zeros(1, np.int64), np.array([self.domain.count]), (None,) * len(self.numbered[0]))


def parted(loop: Loop, coordinates: int) -> list[Loop]:
    """A loop, or the terms of it that may be idle in one of their own, behind the others."""
    if loop.domain.count < max(FEWEST, CROWDED * coordinates):
        return [loop]
    modes = [one for one, slot in loop.used.items() if slot.array.source is Source.MODES]
    if not 0 < len(modes) <= MOST_MODES:
        return [loop]
    idle, others = list[tuple[Term, Array]](), list[tuple[Term, Array]]()
    for term, total in loop.terms:
        summands = [c * one for one, c in terms_of(term.node)]
        quiet = [one for one in summands if _signs(loop.slots, modes, [one])]
        rest = [one for one in summands if one not in quiet]
        for found, nodes in ((idle, quiet), (others, rest)):
            if nodes:
                node = loop.slots.graph.sum([(one, 1.0) for one in nodes])
                found.append((replace(term, node=node), total))
    nodes = [term.node for term, _ in idle]
    modes = [one for one in modes if one.symbols & union(nodes)]
    signs = _signs(loop.slots, modes, nodes)
    if not idle or not signs:
        return [loop]
    acting = ActingLoop(loop.domain, idle, loop.slots, modes=modes, idle=signs)
    return [*([replace(loop, terms=others)] if others else []), acting]


def _signs(slots: Slots, modes: Sequence[Node], nodes: Sequence[Node]) -> list[tuple[float, ...]]:
    """The signs of modes for which all of some expressions are 0."""
    found = []
    for signs in product((1.0, -1.0), repeat=len(modes)):
        known = {mode: sign * slots.graph.one for mode, sign in zip(modes, signs)}
        if all(one.is_zero for one in substituted(slots.graph, nodes, known)):
            found.append(signs)
    return found


class Scan(Writer):
    """The code that lists the members of a loop that act."""

    def __init__(self, evaluation: Evaluation, loop: ActingLoop, members: MemberList) -> None:
        slots = loop.used
        terms = [(Term(loop.domain, one, slots[one].table), slots[one].array) for one in loop.modes]
        super().__init__(evaluation, Loop(loop.domain, terms, loop.slots))
        self.acting, self.members = loop, members

    def write_all(self) -> None:
        """All members."""
        self.members.empty()
        self.write()
        self.members.finish()

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        f, fixed = self.f, self.fixed(bases)
        start = self.listed_at(self.rows.starts, r)
        with f.loop(0, length, LANES, tested=False) as j:
            acts = self._acts({**fixed, **self.changing(bases, j)}) & before(f, j, length)
            with each_of(f, acts) as lane:
                self.members.add(start + j + lane)

    def _acts(self, known: Mapping[Node, Operands]) -> Bit:
        """Which of eight members act."""
        vectors = self.vectors
        modes = [vectors.high(vectors.number(known[one])) for one in self.acting.modes]
        acts = ~self.f.never(LANES)
        for signs in self.acting.idle:
            idle = ~self.f.never(LANES)
            for mode, sign in zip(modes, signs):
                idle = idle & (mode > 0.0 if sign > 0.0 else mode < 0.0)
            acts = acts & ~idle
        return acts


class ActingWriter(Writer):
    """The code of a loop over the ``members`` that act."""

    members: MemberList

    def write_rows(self, first: Index, last: Index) -> None:
        count, zero = self.members.count, self.f.count(0)
        with self.f.when(count > 0):
            self.row([zero] * len(self.listed), count, zero)

    def looked_up(self, i: int, j: Integer) -> Pointer:
        return self.members.at(i, j)


class ActingSeries(ActingWriter, SeriesWriter):
    """Stage k of their series."""


class ActingLists:
    """The lists of a function, and the series of those that act, in a system of so many ``coordinates``:
    ``spare`` gives them room, which nobody has to clear."""

    def __init__(self, tables: Tables, coordinates: int, spare: Spare) -> None:
        self.tables, self.coordinates, self.spare, self.numbers = tables, coordinates, spare, 0
        self.lists: dict[Loop, Where] = {}
        self.series: dict[Loop, Where] = {}

    def take(self, doubles: int) -> Where:
        """Room for so many."""
        self.numbers += doubles
        return self.spare(doubles)

    def parted(self, listed: Sequence[Loop | Chain]) -> list[Loop | Chain]:
        """Loops, with lists for those that need them."""
        found = list[Loop | Chain]()
        for one in listed:
            parts = [one] if isinstance(one, Chain) else parted(one, self.coordinates)
            acting = [part for part in parts if isinstance(part, ActingLoop)]
            self.lists |= {part: self.take(MemberList.room(part)) for part in acting}
            found += parts
        return found

    def hold(self, series: LoopSeries) -> bool:
        """Find a place for the series of a loop, if it has a list."""
        if series.loop in self.lists:
            self.series[series.loop] = self.take(series.doubles)
        return series.loop in self.lists

    def members(self, vectors: Vectors, loop: Loop) -> MemberList:
        """The list of a loop."""
        return MemberList(vectors.f, self.tables, loop, self.lists[loop](vectors))

    def make(self, evaluation: Evaluation) -> None:
        """Find out who acts."""
        for loop in self.lists:
            self.find(evaluation, loop)

    def find(self, evaluation: Evaluation, loop: Loop) -> None:
        """Find out who acts in one loop."""
        assert isinstance(loop, ActingLoop)
        Scan(evaluation, loop, self.members(evaluation.vectors, loop)).write_all()

    def write(self, evaluation: Evaluation, loop: Loop) -> bool:
        """Write a loop, if it has a list, and find out who acts before."""
        if loop not in self.lists:
            return False
        self.find(evaluation, loop)
        writer = ActingWriter(evaluation, loop)
        writer.members = self.members(evaluation.vectors, loop)
        writer.write()
        return True

    def write_series(self, evaluation: Evaluation, series: LoopSeries, k: Index, phase: int | None) -> bool:
        """Write stage ``k`` of the series of a loop, if it has a list (see ``SeriesWriter``)."""
        if series.loop not in self.series:
            return False
        writer, vectors = ActingSeries(evaluation, series, 0, k, phase), evaluation.vectors
        writer.members, writer.base = self.members(vectors, series.loop), self.series[series.loop](vectors)
        writer.write()
        return True

    def begin_sums(self, vectors: Vectors, series: LoopSeries, k: Integer) -> bool:
        """Begin the dot products of a loop, if it has a list."""
        if series.loop not in self.series:
            return False
        blocks = (self.members(vectors, series.loop).count + (LANES - 1)).operation("lshr", 3)
        begin_sums(vectors.f, series, k, 0, 0, blocks, self.series[series.loop](vectors))
        return True
