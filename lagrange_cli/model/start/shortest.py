"""The smallest correction of a state, in the metric of the masses.

Corrections are computed in doubles, whatever the numbers that they are added to: each round of corrections
gives as many digits again as a double has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from lagrange_cli.model.indefinite import saddle_solved
from lagrange_cli.model.start.equations import Matter, Row, Solver
from lagrange_cli.model.start.linear import DENSE, Array, of_products, solved
from lagrange_cli.records import dataclass

LARGEST_BLOCK = 64
"""Coordinates that may move each other's masses for these to be divided by block by block."""


@dataclass(frozen=True)
class Blocks:
    """A large mass matrix that consists of small blocks: ``members`` are the coordinates of each one, by any
    of them, ``matrices`` its masses where it has several; of one alone they are in ``diagonal``."""

    members: Mapping[int, Sequence[int]]
    matrices: Mapping[int, Array]
    diagonal: Mapping[int, float]

    @classmethod
    def of(cls, matter: Mapping[int, Mapping[int, float]]) -> Blocks | None:
        """The blocks; None where one is too large (or all of the matrix is small), or masses are not
        positive."""
        members: dict[int, list[int]] = {}
        matrices, diagonal = {}, {j: row.get(j, 0.0) for j, row in matter.items()}
        alone = all(len(row) == 1 for row in matter.values())
        if not all(m > 0 for m in diagonal.values()) or (len(matter) <= LARGEST_BLOCK and not alone):
            return None
        for first in matter:
            if first in members:
                continue
            block, seen = [first], {first}
            for j in block:
                block += (new := [k for k in matter[j] if k not in seen])
                seen.update(new)
                if len(block) > LARGEST_BLOCK:
                    return None
            members |= dict.fromkeys(block, block)
            if len(block) > 1:
                whole = np.array([[matter[j].get(k, 0.0) for k in block] for j in block])
                try:
                    np.linalg.cholesky(whole)
                except np.linalg.LinAlgError:
                    return None
                matrices[first] = whole
        return cls(members, matrices, diagonal)

    def divided(self, row: Mapping[int, float]) -> dict[int, float]:
        """The inverse of the masses times a vector; both by coordinate."""
        found: dict[int, float] = {}
        for k, x in row.items():
            block = self.members[k]
            if len(block) == 1:
                found[k] = x / self.diagonal[k]
            elif k not in found:
                right = np.array([row.get(j, 0.0) for j in block])
                found.update(zip(block, np.linalg.solve(self.matrices[block[0]], right).tolist()))
        return found


@dataclass(frozen=True)
class Shortest:
    """Solves M dx - A^T mu = g, A dx = r for the ``unknown`` coordinates, and ``rows`` A that are
    independent."""

    masses: Matter
    rows: Sequence[Row]
    unknown: Sequence[int]

    def solve(self, g: Mapping[int, float], r: Sequence[float]) -> tuple[dict[int, float], list[float]]:
        """dx by coordinate, and mu; ``g`` is by coordinate, too."""
        inner = set(self.unknown)
        rows = [{k: float(a) for k, a in row.items() if k in inner} for row in self.rows]
        sizes = [math.hypot(*row.values()) or 1.0 for row in rows]
        rows = [{k: a / size for k, a in row.items()} for row, size in zip(rows, sizes)]
        found, mu = self._of_unit_rows(rows, g, [x / size for x, size in zip(r, sizes)])
        return found, [x / size for x, size in zip(mu, sizes)]

    def _of_unit_rows(
        self, rows: Sequence[Mapping[int, float]], g: Mapping[int, float], r: Sequence[float]
    ) -> tuple[dict[int, float], list[float]]:
        """The same for rows whose norm is 1."""
        solver = self.masses.solver(self.unknown)
        if solver is not None:
            return self._bordered(solver, rows, g, r)
        inner = set(self.unknown)
        matter = {
            j: {k: float(m) for k, m in self.masses.rows.get(j, {}).items() if k in inner}
            for j in self.unknown
        }
        blocks = Blocks.of(matter)
        if blocks is not None:
            weighted = [blocks.divided(row) for row in rows]
            alone = blocks.divided(dict.fromkeys(matter, 0.0) | {k: x for k, x in g.items() if k in inner})
            rest = [x - sum(a * alone[k] for k, a in row.items()) for row, x in zip(rows, r)]
            mu = of_products(rows, weighted, rest)
            for row, x in zip(weighted, mu):
                for k, a in row.items():
                    alone[k] += a * x
            return alone, mu
        return self._together(rows, matter, g, r)

    def _bordered(
        self, solver: Solver, rows: Sequence[Row], g: Mapping[int, float], r: Sequence[float]
    ) -> tuple[dict[int, float], list[float]]:
        """By M^-1 of each row: A M^-1 A^T mu = r - A M^-1 g."""
        places = {k: place for place, k in enumerate(self.unknown)}
        columns = np.zeros((len(places), len(rows) + 1))
        for i, row in enumerate(rows):
            columns[[places[k] for k in row], i] = [*row.values()]
        columns[:, -1] = [g.get(k, 0.0) for k in places]
        found, bound = solver(columns), columns[:, :-1]
        alone, replies = found[:, -1], found[:, :-1]
        mu = solved(bound.T @ replies, np.array(r) - bound.T @ alone)
        return dict(zip(places, (alone + replies @ np.array(mu)).tolist())), mu

    def _together(
        self,
        rows: Sequence[Row],
        matter: Mapping[int, Mapping[int, float]],
        g: Mapping[int, float],
        r: Sequence[float],
    ) -> tuple[dict[int, float], list[float]]:
        """By the whole saddle-point matrix; where masses are unknown, each coordinate has the mass 1."""
        places = {k: place for place, k in enumerate(self.unknown)}
        n = len(places)
        right = np.array([*(g.get(k, 0.0) for k in places), *r])
        if n > DENSE:
            own, others = (
                [{places[k]: x for k, x in row.items()} for row in some]
                for some in ([matter[k] for k in places], rows)
            )
            sparse = saddle_solved(own, others, right)
            if sparse is not None:
                return dict(zip(places, sparse[:n].tolist())), (-sparse[n:]).tolist()
        whole = np.zeros((n + len(rows), n + len(rows)))
        for j, row in matter.items():
            for k, m in row.items():
                whole[places[j], places[k]] = m
        if not whole.any():
            whole[range(n), range(n)] = 1.0
        for i, bound in enumerate(rows):
            for k, a in bound.items():
                whole[n + i, places[k]], whole[places[k], n + i] = a, -a
        found = solved(whole, right)
        return dict(zip(places, found[:n])), found[n:]
