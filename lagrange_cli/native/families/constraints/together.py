"""The equations for accelerations and multipliers together, as totals, where M is constant but not diagonal
(see ``families.saddle_points``).

Where A is constant, too, their matrix is factored once; else in each step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.restraint import AlongMotion, Restraint
from lagrange_cli.native.families.lasting import Lasting


class Together(Restraint):
    """The totals: ``solution`` has the accelerations, or other changes of coordinates, and behind them the
    multipliers. If the matrix ``lasts``, it is that of ``lasting_entries``."""

    definite = False

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        assert system.saddle is not None
        self.saddle: SaddlePoint = system.saddle
        self.lasts = lasting.matrix
        self.solution = Array(Source.TOTAL, self.saddle.count)
        super().__init__(system, lasting)

    def all_columns(self) -> Sequence[Sequence[Array]]:
        return [() for _ in self.bounds] if self.lasts else super().all_columns()

    def _square(self) -> Total:
        """The entries of the matrix, and behind them 0, 1, and what pivots of constraints are compared with;
        nothing if they last."""
        if self.lasts:
            return Total(Source.TOTAL, 0)
        return self.lasting.arranged(entries(self.system, self.lasting, self.slope), kept=False)

    def placed(self, saddle: SolvingTables) -> Mapping[str, Places]:
        return saddle.placed(self.saddle.pairs, self.saddle.sizes)

    def whole(self, force: Array | None, make: Mapping[int, Node], more: Array | None = None) -> Total:
        """The right side: forces on coordinates, and c of each constraint, ``more`` of each besides."""
        first = self.size
        terms = [] if force is None else [Term(self.everyone, self.of_all(force), self.everyone.every)]
        for b, one in enumerate(self.bounds):
            if b in make and not make[b].is_zero:
                terms.append(Term(one.domain, make[b], first + one.numbers))
        if more is not None:
            domain = Domain(self.count)
            terms.append(Term(domain, self.slots.own(domain, more), first + domain.every))
        return self.total(self.saddle.count, terms)


def entries(system: FamilySystem, lasting: Lasting, slope: Callable[[int, int], Node]) -> Total:
    """The entries of the matrix, with the ``slope`` of each bound by each of its coordinates."""
    saddle, bonds, slots, graph = system.saddle, system.bonds, system.slots, system.slots.graph
    assert saddle is not None and bonds is not None
    masses = lasting.arranged(saddle.masses.entries)
    own, end = Domain(len(saddle.masses.pairs)), len(saddle.pairs)
    terms = [Term(own, slots.own(own, masses), own.every)]
    for (b, a), places in zip(bonds.pulls, saddle.places):
        one, value = bonds.bounds[b], slope(b, a)
        inverse = graph.absolute(slots.symbol(one.domain, lasting.inverses, one.rows[a]))
        terms.append(Term(one.domain, -value, places))
        terms.append(Term(one.domain, inverse * value * value, end + 2 + one.numbers))
    terms.append(Term(system.root, graph.one, np.array([end + 1])))
    return Total(Source.TOTAL, end + 2 + bonds.count, tuple(terms))


def lasting_entries(system: FamilySystem, lasting: Lasting) -> Total | None:
    """Those of a matrix that lasts; None where slopes of constraints change."""
    bonds = system.bonds
    assert bonds is not None
    if not system.straight_bonds:
        return None
    found = lasting.arranged(entries(system, lasting, lambda b, a: bonds.bounds[b].slopes[a]))
    return found if found in lasting.fixed else None


class TogetherAtAState(Together):
    """Those of the accelerations and multipliers at one state."""

    @property
    def found(self) -> Sequence[Array]:
        """What is solved for."""
        return self.system.accelerations, self.bonds.multipliers

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        forces = lasting.arranged(system.forces, kept=False)
        self.right = self.whole(forces, {b: self.rate(one.speed) for b, one in enumerate(self.bounds)})

    def column(self, bound: Bound, slope: Node) -> Array:
        return self.total(bound.domain.count, [Term(bound.domain, slope, bound.domain.every)])


class FreeAtAState:
    """The same without constraints: accelerations alone, by factors of M, which last."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        self.square = Total(Source.TOTAL, 0)
        self.right = lasting.arranged(system.forces, kept=False)
        self.solution = Array(Source.TOTAL, system.q.count)
        self.found = (system.accelerations,)


class TogetherAlongMotion(Together, AlongMotion):
    """Those of the equations of motion, of order k: A^T lambda without what is newest in it is added to the
    ``forces``."""

    def arrange(self) -> None:
        self.right = self.whole(self.forces, {}, more=self.rest)
        self.final = self.solution
        self.locals = [self._local(b, one) for b, one in enumerate(self.bounds) if one.rows]

    @property
    def arrays(self) -> Sequence[Array]:
        slopes = [one for some in self.slopes for one in some]
        return [self.rest, *slopes, self.square, self.right, self.solution]
