"""How the terms of a loop add up: each member's at a place of its own, or those of a row at one place.

Where a member adds something to its own place and to the next one, as a spring does to the masses at its
ends, vectors of eight overlap. To load what has just been stored in part takes a processor as long as twenty
other instructions. So what goes to the next place waits in a register until that place is stored anyway.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from functools import reduce
from operator import add
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.families.arrays import Array, Term
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import Numbers, Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer

if TYPE_CHECKING:
    from lagrange_cli.native.families.loops import Loop

LookedUp: TypeAlias = "Callable[[int, Integer], Pointer]"
"""Where eight places of a table are, from one on."""
Key: TypeAlias = "tuple[Array, int]"
"""An array, and the number of the table of places where something is added to it."""


def keys(loop: Loop) -> dict[Key, None]:
    """Where something is added."""
    targets = loop.numbered[1][len(loop.used) :]
    return {(total, i): None for (_, total), i in zip(loop.terms, targets)}


def behind(loop: Loop, keys: Iterable[Key]) -> dict[Key, tuple[Key, int]]:
    """What is added a few places behind something else, in most rows, with that and the distance."""
    tables, _ = loop.numbered
    starts, lengths = loop.rows.starts, loop.rows.lengths
    beside: dict[Array, dict[int, int]] = {}
    for total, i in keys:
        if loop.rows.strides[i] == 1:
            places = beside.setdefault(total, {})
            first = next(iter(places), i)
            distances, which = np.unique(tables[i][starts] - tables[first][starts], return_inverse=True)
            places[i] = int(distances[np.argmax(np.bincount(which, lengths))])
    found: dict[Key, tuple[Key, int]] = {}
    for total, places in beside.items():
        leader, *others = sorted(places, key=places.__getitem__)
        for i in others:
            distance = places[i] - places[leader]
            if 0 < distance < LANES:
                found[total, i] = (total, leader), distance
            else:
                leader = i
    return found


class Additions:
    """The code that adds up ``terms``, the first ones of ``loop``, in numbers of a kind. ``where`` gives the
    pointers to arrays."""

    def __init__(
        self,
        vectors: Vectors,
        loop: Loop,
        terms: Sequence[tuple[Term, Array]],
        where: Callable[[Array], Pointer],
    ) -> None:
        self.vectors, self.f = vectors, vectors.f
        self.where, self.strides, self.alone = where, loop.rows.strides, loop.put
        self.terms: dict[Key, list[int]] = {}
        for k, ((_, total), i) in enumerate(zip(terms, loop.numbered[1][len(loop.used) :])):
            self.terms.setdefault((total, i), []).append(k)
        self.behind, self.single = behind(loop, self.terms), len(loop.rows.starts) == 1
        self.together = {*self.behind, *(leader for leader, _ in self.behind.values())}

    def begin(self, bases: Sequence[Integer]) -> None:
        """A row whose tables begin with these places."""
        vectors = self.vectors
        zero = vectors.zero(LANES)
        self.bases = bases
        self.sums = {key: vectors.variable(zero) for key in self.terms if self.strides[key[1]] == 0}
        self.waiting = {key: vectors.variable(zero) for key in self.behind}
        self.carried: list[Any] = [*self.sums.values(), *self.waiting.values()]
        self.beside = {
            key: (bases[key[1]] - bases[leader[1]]).equals(distance)
            for key, (leader, distance) in self.behind.items()
            if not self.single
        }

    def add(self, values: Sequence[Operands], inside: Bit, j: Integer, looked_up: LookedUp) -> None:
        """Terms of the eight members from ``j`` on, of which those count that are ``inside``."""
        vectors, zero = self.vectors, self.vectors.zero(LANES)
        found: dict[Key, Numbers] = {}
        for key, terms in self.terms.items():
            given = [vectors.number(values[k]) for k in terms if values[k] is not None]
            if given:
                found[key] = vectors.select(inside, reduce(add, given), zero)
            elif key[0] in self.alone or key in self.together:
                found[key] = zero
        for key, (leader, distance) in self.behind.items():
            value, before = found.pop(key), self.waiting[key].get()
            shifted = vectors.shuffle(before, late(distance), value)
            self.waiting[key].set(value)
            if self.single:
                found[leader] = found[leader] + shifted
                continue
            beside = self.beside[key]
            found[leader] = found[leader] + vectors.select(beside, shifted, zero)
            with self.f.when(~beside):
                self.put(value, key, self.bases[key[1]] + j)
        for key, value in found.items():
            stride = self.strides[key[1]]
            if stride == 0:
                self.sums[key].set(self.sums[key].get() + value)
            elif stride == 1:
                self.put(value, key, self.bases[key[1]] + j)
            else:
                self.scatter(value, self.where(key[0]), looked_up(key[1], j))

    def resume(self, place: Pointer) -> None:
        """Go on in a row where ``pause`` left it."""
        for i, one in enumerate(self.carried):
            one.set(self.vectors.load_row(place, i * LANES, LANES))

    def pause(self, place: Pointer) -> None:
        """Leave a row before its end: what is in registers."""
        for i, one in enumerate(self.carried):
            self.vectors.store_row(one.get(), place, i * LANES)

    def end(self, length: Integer) -> None:
        """The rest of a row of so many members."""
        vectors = self.vectors
        for key, total in self.sums.items():
            base, at = self.where(key[0]), self.bases[key[1]]
            vectors.store(vectors.total(total.get(), vectors.load(base, at)), base, at)
        beyond = (length + (LANES - 1)) & -LANES
        for key, (leader, distance) in self.behind.items():
            with nullcontext() if self.single else self.f.when(self.beside[key]):
                rest = vectors.shuffle(self.waiting[key].get(), late(distance), vectors.zero(LANES))
                self.put(rest, leader, self.bases[leader[1]] + beyond)

    def put(self, value: Numbers, key: Key, at: Integer) -> None:
        """Add eight numbers side by side, unless nothing else is there."""
        base = self.where(key[0])
        if key[0] not in self.alone:
            value = self.vectors.load_row(base, at, LANES) + value
        self.vectors.store_row(value, base, at)

    def scatter(self, values: Numbers, base: Pointer, places: Pointer) -> None:
        """Add eight numbers at eight places, one after the other: some may be the same."""
        f, vectors = self.f, self.vectors
        for lane in range(LANES):
            at = place_at(f, lane, places)
            vectors.store(vectors.load(base, at) + vectors.lane(values, lane), base, at)


def late(distance: int) -> range:
    """The lanes of two vectors in a row that begin ``distance`` before the second."""
    return range(LANES - distance, 2 * LANES - distance)
