"""Masses of systems whose M is constant but not diagonal: of finite elements with consistent masses, of
particles whose places are linear in several coordinates, of Ritz's method.

M is factored once, before the motion, in L D L^T.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slots, Source, Term, Total
from lagrange_cli.families.elimination import elimination_of
from lagrange_cli.model.sparse import SparseElimination
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class Product:
    """What L has of products of two velocities: ``node`` of each member of ``domain``, times those of the
    coordinates ``first`` and ``second``."""

    domain: Domain
    node: Node
    first: Places
    second: Places


@dataclass(frozen=True, eq=False)
class Spin:
    """Coordinates at ``rows``, and the ``ratios`` M_ds/M_ss of others, with their own rows, of each member of
    a ``domain`` (see ``families.spins``)."""

    domain: Domain
    rows: Places
    ratios: tuple[tuple[Node, Places], ...]


@dataclass(frozen=True, eq=False)
class Alone:
    """The products of a matrix in which ``spins`` stand alone, those that are no constants ``curved``."""

    products: tuple[Product, ...]
    curved: tuple[Product, ...]
    spins: tuple[Spin, ...]


@dataclass(frozen=True, eq=False)
class Factored:
    """The ``entries`` of the matrix that is factored, and what is no constant in them: M, or that in which
    ``spins`` stand alone."""

    entries: Total
    curved: tuple[Product, ...]
    spins: tuple[Spin, ...] = ()


@dataclass(frozen=True, eq=False)
class CoupledMasses:
    """The ``entries`` of M on its diagonal and below, at the places ``pairs`` (entries, 2); 0 and 1 are
    behind them."""

    count: int
    pairs: Places
    entries: Total
    sizes: Places | None = None
    """What pivots are compared with, if it is not the diagonal."""
    curved: tuple[Product, ...] = ()
    """What is no constant of the motion in them: the part of T."""
    alone: Factored | None = None

    @property
    def factored(self) -> Factored:
        """The matrix that is factored."""
        return self.alone or Factored(self.entries, self.curved)

    def places(self, one: Product) -> Sequence[Places]:
        """Where a product's coefficients go among the entries: those of squares, c v^2, go there twice."""
        keys = self.pairs[:, 0] * self.count + self.pairs[:, 1]
        return places_of(keys, self.count, one)

    @cached_property
    def elimination(self) -> SparseElimination | None:
        """How M is factored; None where it is taken as dense. Raises ``Unsuited`` where L has too many
        numbers."""
        return elimination_of(self.count, self.pairs)

    @cached_property
    def below(self) -> Places:
        """The entries below the diagonal."""
        return np.flatnonzero(self.pairs[:, 0] != self.pairs[:, 1])

    def diagonal(self, slots: Slots, everyone: Domain) -> Total:
        """The diagonal of M."""
        places = np.flatnonzero(self.pairs[:, 0] == self.pairs[:, 1])
        entry = slots.symbol(everyone, self.entries, places)
        return Total(Source.TOTAL, self.count, (Term(everyone, entry, everyone.every),))

    def momenta(self, slots: Slots, v: Array) -> Sequence[Term]:
        """M v, but for the diagonal."""
        i, j = self.pairs[self.below].T
        domain = Domain(len(i))
        entry = slots.symbol(domain, self.entries, self.below)
        return [Term(domain, entry * slots.symbol(domain, v, b), a) for a, b in ((i, j), (j, i))]

    def energy(self, slots: Slots, v: Array) -> Term:
        """The same of the kinetic energy."""
        domain = Domain(len(self.below))
        entry = slots.symbol(domain, self.entries, self.below)
        first, second = (slots.symbol(domain, v, one) for one in self.pairs[self.below].T)
        return Term(domain, entry * first * second, domain.together)

    def matrix(self, entries: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[dict[int, float]]:
        """M row by row, from the values of its entries."""
        made: list[dict[int, float]] = [{} for _ in range(self.count)]
        for (i, j), value in zip(self.pairs.tolist(), entries.tolist()):
            made[i][j] = made[j][i] = value
        return made


def coupled_masses(
    root: Domain, count: int, diagonal: Sequence[Term], products: Sequence[Product], one: Node,
    curved: Sequence[Product] = (), alone: Alone | None = None,
) -> CoupledMasses:  # fmt: skip
    """M of so many coordinates, from terms on its ``diagonal`` and products of velocities, those that are no
    constants ``curved``; the number ``one``; and what is ``alone``, if there are spins."""
    given = [*products, *curved, *(alone.products if alone else ())]
    keys = distinct(np.concatenate([np.arange(count) * (count + 1), *(key_of(count, p) for p in given)]))
    size = len(keys)

    def added(terms: Sequence[Term], own: Sequence[Product]) -> Total:
        """The entries, and 1 behind them."""
        found = [Term(t.domain, t.node, np.searchsorted(keys, t.targets * (count + 1))) for t in terms]
        for product in own:
            found += [Term(product.domain, product.node, at) for at in places_of(keys, count, product)]
        return Total(Source.TOTAL, size + 3, (*found, Term(root, one, np.array([size + 1]))))

    factored = None if alone is None else Factored(added((), alone.products), alone.curved, alone.spins)
    pairs, entries = np.stack(np.divmod(keys, count), axis=1), added(diagonal, [*products, *curved])
    return CoupledMasses(count, pairs, entries, curved=tuple(curved), alone=factored)


def key_of(count: int, one: Product) -> Places:
    """The numbers of entries, row by row."""
    found: Places = np.maximum(one.first, one.second) * count + np.minimum(one.first, one.second)
    return found


def places_of(keys: Places, count: int, one: Product) -> Sequence[Places]:
    """Where a product's coefficients go among entries with these keys (``CoupledMasses.places``)."""
    places, square = np.searchsorted(keys, key_of(count, one)), one.first == one.second
    return [places, *([np.where(square, places, len(keys) + 2)] if square.any() else [])]
