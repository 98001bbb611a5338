"""Sweeps along trees: from the tips to the roots and back (see ``balance``).

What goes to a parent stays in registers where every node is the parent of the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.families.arrays import NONE, Array, Tree
from lagrange_cli.native.families.evaluation import climb
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import Numbers, Vectors
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.numbers.error_free import two_sum

Where = Callable[[Array], Pointer]


class Sweeps:
    """The sweeps of one tree; behind the last node, arrays have one of what does not move."""

    def __init__(self, vectors: Vectors, tables: Tables, tree: Tree, where: Where) -> None:
        self.vectors, self.f = vectors, vectors.f
        self.tables, self.tree, self.where = tables, tree, where
        self.count = len(tree.parents)
        self.straight = bool(np.array_equal(tree.parents, np.arange(NONE, self.count + NONE)))

    def load(self, array: Array, i: Integer) -> Numbers:
        return self.vectors.load(self.where(array), i)

    def store(self, value: Numbers, array: Array, i: Integer) -> None:
        self.vectors.store(value, self.where(array), i)

    def eliminate(self, balance: Balance) -> Bit:
        """Masses from the tips on, and what each order needs of them; whether they are regular."""
        f, vectors, axes, size = self.f, self.vectors, balance.axes, balance.size
        masses, bends = balance.masses, range(size)
        good = f.variable(Bit(f, "true", 1))
        handed = {key: vectors.variable(vectors.constant(0.0)) for key in masses}
        with climb(f, self.tables, self.tree, back=True) as (i, parent, _):
            mass: dict[tuple[int, int], Numbers] = {}
            for (c, e), array in masses.items():
                value = self.load(array, i)
                if self.straight:
                    value = value + handed[c, e].get()
                if c == e and c in balance.places:
                    value = value + self.load(balance.inertia[c], i)
                self.store(value, array, i)
                mass[c, e] = mass[e, c] = value
            slope = {key: self.load(array, i) for key, array in balance.node_slopes.items()}
            for b, array in enumerate(balance.node_gates):
                open_ = self.load(array, i)
                slope |= {(c, b): slope[c, b] * open_ for c in balance.places}
                slope |= {(c, b): open_ for c in balance.turns if c - balance.turns.start == b}
            turned = {key: self.load(array, i) for key, array in balance.turned.items() if array.terms}
            met = {
                (c, b): dotted(vectors, [(mass[c, e], slope[e, b]) for e in axes if (e, b) in slope])
                for c in axes
                for b in bends
            }
            met_before = {
                (c, b): met[c, b]
                if c in balance.places
                else dotted(vectors, [(turned[e, c], met[e, b]) for e in axes if (e, c) in turned])
                for c in axes
                for b in bends
            }
            both = {key: value + self.load(balance.own[key], i) for key, value in met_before.items()}
            matrix = {
                (b, d): dotted(
                    vectors,
                    [(slope[c, b], met[c, d]) for c in axes if (c, b) in slope],
                    self.load(balance.corners[b, d], i),
                )
                for b in bends
                for d in bends[b:]
            }
            found, positive = inverted(vectors, matrix, size)
            spins = {key: self.load(array, i) for key, array in balance.spins.items()}
            found = with_spins(vectors, found, spins, size) if spins else found
            for one in positive:
                good.set(good.get() & one)
            for key, value in found.items():
                self.store(value, balance.inverse[key], i)
            gain = {
                (c, b): dotted(vectors, [(both[c, d], found[min(b, d), max(b, d)]) for d in bends])
                for c in axes
                for b in bends
            }
            for key, value in gain.items():
                self.store(value, balance.gains[key], i)
            for c in axes:
                for e in axes:
                    start = vectors.constant(1.0 if c == e else 0.0)
                    if c in balance.turns:
                        start = turned.get((e, c), vectors.constant(0.0))
                    terms = [(-gain[c, b], slope[e, b]) for b in bends if (e, b) in slope]
                    self.store(dotted(vectors, terms, start), balance.passed[c, e], i)
            mass |= moved_back(vectors, balance, mass, turned)
            for (c, e), array in masses.items():
                start = mass[c, e]
                if (c, e) in balance.weights:
                    start = start + self.load(balance.weights[c, e], i)
                value = dotted(vectors, [(-gain[c, b], both[e, b]) for b in bends], start)
                if self.straight:
                    handed[c, e].set(value)
                else:
                    self.store(self.load(array, parent) + value, array, parent)
        return good.get()

    def to_roots(self, balance: Balance) -> None:
        """What goes on to the parent from each node: ``push``, and what is ``passed`` of the node's
        ``pull``, to which it is added."""
        f, vectors, axes, pull = self.f, self.vectors, balance.axes, balance.pull
        bare = not any(one.terms for one in pull)  # nothing is there before
        handed = [vectors.variable(vectors.constant(0.0)) for _ in axes]
        with climb(f, self.tables, self.tree, back=True) as (i, parent, _):
            mine = [self.load(one, i) for one in pull] if not self.straight or not bare else []
            if self.straight:
                mine = [one.get() + own for one, own in zip(handed, mine)] or [one.get() for one in handed]
                for one, array in zip(mine, pull):
                    self.store(one, array, i)
            for c in axes:
                terms = [(self.load(balance.passed[c, e], i), mine[e]) for e in axes]
                value = dotted(vectors, terms, self.load(balance.push[c], i))
                if self.straight:
                    handed[c].set(value)
                else:
                    self.store(self.load(pull[c], parent) + value, pull[c], parent)

    def add_up(self, steps: Array, low: Array, sums: Array, lost: Array) -> None:
        """The ``sums`` of steps from the roots on, and what is ``lost`` in them, ``low`` parts included."""
        f, vectors = self.f, self.vectors
        for one in (sums, lost):
            vectors.store(vectors.constant(0.0), self.where(one), self.count)
        with climb(f, self.tables, self.tree, back=False) as (i, parent, _):
            total, error = two_sum(self.load(sums, parent), self.load(steps, i))
            self.store(total, sums, i)
            self.store(self.load(lost, parent) + (error + self.load(low, i)), lost, i)

    def to_tips(self, balance: Balance) -> None:
        """The accelerations of each node: its ``drift``, and what is ``passed`` of its parent's. What does
        not move is before the first node, and behind the last one."""
        f, vectors, axes, moved = self.f, self.vectors, balance.axes, balance.accelerations
        handed = [vectors.variable(vectors.constant(0.0)) for _ in axes]
        for array in moved:
            for place in (0, self.count + 1):
                vectors.store(vectors.constant(0.0), self.where(array), place)
        with climb(f, self.tables, self.tree, back=False) as (i, parent, _):
            up = (
                [one.get() for one in handed]
                if self.straight
                else [self.load(one, parent + 1) for one in moved]
            )
            values = [
                dotted(
                    vectors,
                    [(self.load(balance.passed[c, e], i), up[c]) for c in axes],
                    self.load(balance.drift[e], i),
                )
                for e in axes
            ]
            for one, array, value in zip(handed, moved, values):
                self.store(value, array, i + 1)
                if self.straight:
                    one.set(value)

    def carry(self, steps: Sequence[Array], moved: Sequence[Array | None]) -> None:
        """Add ``steps`` up from the roots on, and to accelerations of nodes, if these are ``moved``."""
        for step in steps:
            self.store(self.vectors.constant(0.0), step, self.f.count(self.count))
        with climb(self.f, self.tables, self.tree, back=False) as (i, parent, _):
            for step, to in zip(steps, moved):
                value = self.load(step, parent) + self.load(step, i)
                self.store(value, step, i)
                if to is not None:
                    self.store(self.load(to, i + 1) + value, to, i + 1)


def moved_back(
    vectors: Vectors,
    balance: Balance,
    mass: Mapping[tuple[int, int], Numbers],
    turned: Mapping[tuple[int, int], Numbers],
) -> dict[tuple[int, int], Numbers]:
    """The masses of a node as the parent feels them where coordinates stick to those of the parent."""
    axes, turns = balance.axes, balance.turns

    def along(c: int, e: int) -> Numbers:
        return dotted(vectors, [(mass[c, d], turned[d, e]) for d in axes if (d, e) in turned])

    half = {(c, e): along(c, e) for c in axes for e in turns}
    found = {(c, e): half[c, e] for c in balance.places for e in turns}
    for c in turns:
        for e in turns:
            found[c, e] = dotted(vectors, [(turned[d, c], half[d, e]) for d in axes if (d, c) in turned])
    return found


def dotted(
    vectors: Vectors, terms: Sequence[tuple[Numbers, Numbers]], start: Numbers | None = None
) -> Numbers:
    """A sum of products."""
    total = start
    for a, b in terms:
        total = a * b if total is None else vectors.fused(a, b, total)
    return vectors.constant(0.0) if total is None else total


def with_spins(
    vectors: Vectors,
    inverse: Mapping[tuple[int, int], Numbers],
    spins: Mapping[tuple[int, int], Numbers],
    size: int,
) -> dict[tuple[int, int], Numbers]:
    """The inverse of all masses, from that beside spins: (1 - E) M^-1 (1 - E)^T, with E of the ``spins``."""

    every = [(b, d) for b in range(size) for d in range(size)]
    whole = {(b, d): inverse[min(b, d), max(b, d)] for b, d in every}
    half = {
        (b, c): dotted(vectors, [(-x, whole[b, d]) for (a, d), x in spins.items() if a == c], whole[b, c])
        for b, c in every
    }
    return {
        (b, c): dotted(vectors, [(-x, half[d, c]) for (a, d), x in spins.items() if a == b], half[b, c])
        for b, c in every
        if b <= c
    }


def inverted(
    vectors: Vectors, matrix: Mapping[tuple[int, int], Numbers], size: int
) -> tuple[dict[tuple[int, int], Numbers], list[Bit]]:
    """The inverse of a small positive definite matrix, and whether it is: A = L D L^T."""
    lower: dict[tuple[int, int], Numbers] = {}
    pivots: list[Numbers] = []
    for j in range(size):
        pivot = matrix[j, j]
        for k in range(j):
            pivot = pivot - lower[j, k] * lower[j, k] * pivots[k]
        pivots.append(pivot)
        for i in range(j + 1, size):
            value = matrix[j, i]
            for k in range(j):
                value = value - lower[i, k] * lower[j, k] * pivots[k]
            lower[i, j] = value / pivot
    one = vectors.constant(1.0)
    unit = {(j, j): one for j in range(size)}
    for j in range(size):
        for i in range(j + 1, size):
            value = -lower[i, j]
            for k in range(j + 1, i):
                value = value - lower[i, k] * unit[k, j]
            unit[i, j] = value
    inverses = [one / pivot for pivot in pivots]
    made = {
        (i, j): dotted(vectors, [(unit[k, i] * inverses[k], unit[k, j]) for k in range(j, size)])
        for i in range(size)
        for j in range(i, size)
    }
    return made, [vectors.high(pivot) > 0.0 for pivot in pivots]
