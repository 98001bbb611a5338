"""Disks of what cancels, closer than those of its terms.

A difference of disks makes no use of what they have in common. The relative velocity of two bodies that move
fast side by side changes little within a step, but the radii of both velocities are added up. Three forms of
such sums are enclosed closely:

- A combination of q and v is a polynomial, as they are: its coefficients are those of its terms, combined.
- A sum u that is no combination, and in which something is singular, has a series of its own, which is known
  up to order n. What is beyond is at most D K^-(n + 1) / (1 - 1/K) within r, if u differs from its start by
  at most D within K r (Cauchy's estimate). There its terms may be enclosed loosely. (A Taylor model in one
  variable: M. Berz and K. Makino, Reliable Computing 4, 361, 1998.)
- 1 - tanh^2, the derivative of tanh, is 1 / cosh^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, partial
from math import inf, log
from typing import cast

from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.mechanics.cancellation import squared_tanh
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import ROUNDING, Disk
from lagrange_cli.native.recurrences.evaluation import Constants, add_scaled, emit_values
from lagrange_cli.native.stepping.proof import RATIOS, WIDER, radii
from lagrange_cli.native.stepping.state_series import Combination, StateSeries, Weighted, combinations
from lagrange_cli.records import replace

FARTHER = 1.4, 1.8, 2.4, 3.2, 4.8, 8.0, 16.0
"""How much farther than the largest disks of time those reach within which sums are enclosed loosely. One
more has the radius 0: what is left are the rounding errors at the start of a step."""
OPERATIONS = 32
"""Rounding errors of the coefficients of a sum, in those of a disk of its terms."""


class Tail:
    """What is beyond the series of a sum, from how far it reaches on larger disks of time: those of
    ``times``."""

    def __init__(self, f: Function) -> None:
        self.f, far = f, Disks(f, Emitter(f), LANES)
        scales = f.vector([RATIOS[-1] * WIDER * x for x in (0.0, *FARTHER)])
        self.times = f.splat(Real(f, "%h"), LANES) * scales
        order = f.splat(Real(f, "%beyond"), LANES)
        weights = far.exp(f.vector([0.0, *(-log(x) for x in FARTHER)]) * order)
        self.weights = weights * f.vector([inf, *(x / (x - 1) for x in FARTHER)])
        self.nearer = far.exp(f.vector([log(k / RATIOS[-1]) for k in RATIOS]) * order)

    def of(self, radius: Real) -> Real:
        """Its bounds within the disks of ``radii``, given those within ``times``."""
        f, most = self.f, self.f.splat(self.f.constant(inf), LANES)
        bound = radius * self.weights
        bound = f.reduce("fmin", f.select(bound < most, bound, most))  # what is not a number is not known
        return f.fused(f.splat(bound, LANES), self.nearer, f.splat(f.lane(radius, 0), LANES))


class Sums:
    """Encloses the sums in ``terms`` whose own terms may cancel. ``known`` has the disks of symbols, and is
    given those of the sums. Terms that are ``reaching`` farther are enclosed loosely within larger disks of
    time, too."""

    def __init__(
        self,
        disks: Disks,
        terms: list[Node],
        series: StateSeries,
        known: dict[Node, Disk | None],
        constants: Constants,
        tail: Tail | None,
        reaching: Sequence[Node] = (),
    ) -> None:
        self.disks, self.f, self.series, self.known, self.constants = disks, disks.f, series, known, constants
        self.order, self.tail, self.reaching = reachable(terms), tail, reaching
        symbols = {*series.places, *series.speeds, *series.totals}
        self.combined = combinations(self.order, series.variables, symbols)
        self.weighted = {node: self._weighted(node, one) for node, one in self.combined.items()}
        self.own = [node for node in self.order if node in series.sums and node not in self.combined]

    def enclose(self) -> None:
        """Write them, arguments before their users."""
        f, one = self.f, self.f.constant(1.0)
        r = radii(f, Real(f, "%h") / Real(f, "%unit"))
        symbols, sums = self._reached()
        asked = [(combination, r) for combination in self.weighted.values()]
        if self.tail is not None:
            far = self.tail.times / f.splat(Real(f, "%unit"), LANES)
            alone = (Weighted(symbol, [(symbol, one)]) for symbol in symbols)
            asked += [(each, far) for each in (*alone, *(self.weighted[node] for node in sums))]
        found = iter(self._extents(asked, self.own, r))
        extent = {node: next(found) for node in self.weighted}
        self.farther = self._farther(
            {node: next(found) for node in symbols}, {node: next(found) for node in sums}
        )
        """Those of sums and of terms that are ``reaching``."""
        extent |= {node: next(found) for node in self.own}
        for node in self.order:
            u = squared_tanh(node)
            if node in self.combined:
                self.known[node] = self._combination(self.disks, node, extent[node], self.known)
            elif node in self.own:
                assert self.tail is not None
                beyond = self.tail.of(self.disks.radius(self.farther[node]))
                self.known[node] = self._closer(self._value(node), extent[node] + beyond)
            elif u is not None and u.symbols & self.series.variables:
                self.known[node] = self._over_cosh(node, self._value(u))

    def _value(self, node: Node) -> Disk | None:
        """The disk of an expression."""
        emit_values(self.disks, [node], self.known, self.constants)
        return self.known[node]

    def _weighted(self, node: Node, one: Combination) -> Weighted:
        """A combination, with the values of its weights."""
        emitter = self.disks.centres
        fixed = {node: disk.centre for node, disk in self.known.items() if disk and disk.radius is None}
        emit_values(emitter, [*one.factors], fixed, self.constants)
        values = (
            fixed[factor] if factor in fixed else self.constants.value(emitter, factor)
            for factor in one.factors
        )
        weights = (Real(self.f, emitter.written(value), 1) for value in values)
        return Weighted(node, [*zip(one.symbols, weights)])

    def _extents(
        self, combined: Sequence[tuple[Weighted, Real]], sums: Sequence[Node], r: Real
    ) -> list[Real]:
        """How much combinations change, each within an r, in the unit of the series: sum_m |c[m]| r^m; and
        how much ``sums`` do within ``r`` by the series that they have."""
        if not (combined or sums):
            return []
        f, series, spans = self.f, self.series, [span for _, span in combined]

        def sizes(m: Integer, *, places: bool = False) -> list[Real]:
            """|c[m]| of the combinations, of ``places`` alone."""
            coefficient, found = cache(partial(series.coefficient, m=m)), list[Real]()
            for one, _ in combined:
                if places:
                    one = replace(one, terms=[term for term in one.terms if term[0] in series.places])
                found.append(f.splat(series.size(one, m, coefficient), LANES))
            return found

        longer = sizes(f.count(series.lengths.order), places=True)  # by one order
        totals = [f.variable(one * span) for one, span in zip(longer, spans)]
        shorter = [f.variable(f.zero(LANES)) for _ in sums]
        m = f.variable(f.count(series.lengths.top))
        with f.forever() as rounds:
            for total, one, span in zip(totals, sizes(m.get()), spans):
                total.set((total.get() + one) * span)
            for total, node in zip(shorter, sums):
                size = f.magnitude(series.coefficient(node, m.get() - 1))
                total.set((total.get() + f.splat(size, LANES)) * r)
            m.set(m.get() - 1)
            rounds.repeat(m.get() > 1)
        first = sizes(f.count(1))
        changes = [(total.get() + last) * span for total, last, span in zip(totals, first, spans)]
        return [*changes, *(total.get() for total in shorter)]

    def _combination(
        self, disks: Disks, node: Node, extent: Real, known: dict[Node, Disk | None]
    ) -> Disk | None:
        """The disk of a sum whose combination changes by an ``extent``."""
        one, rest, centre = self.weighted[node], self.combined[node].rest, cast("Value", None)
        for symbol, weight in one.terms:
            centre = disks.centres.fma(weight.name, disks.centre(self.known[symbol]), centre)
        radius = self.series.widened(disks, one, known, extent)
        total = disks.add(Disk(centre, radius), disks.number(node.data[0]))
        moving = [term for term, _ in rest if term.symbols & self.series.variables]
        emit_values(disks, moving, known, self.constants)
        for term, scale in rest:
            value = known[term] if term in known else self.constants.value(disks, term)
            total = add_scaled(disks, total, value, scale)
        return total

    def _reached(self) -> tuple[list[Node], list[Node]]:
        """The symbols, and the sums with combinations, by which others are enclosed farther."""
        asked, series = [*self.own, *self.reaching], self.series
        inside = {*reachable(asked)}
        sums = [
            node
            for node, one in self.combined.items()
            if node in inside and not any(symbol in series.totals for symbol in one.symbols)
        ]  # totals are enclosed loosely there
        apart = [node for node in sums if node in series.combined]
        rests = [term for node in apart for term, _ in self.combined[node].rest]
        inside = {*reachable([*asked, *rests], lambda node: node not in apart)}
        return [one for one in (*series.places, *series.speeds) if one in inside], sums

    def _farther(self, symbols: Mapping[Node, Real], sums: Mapping[Node, Real]) -> dict[Node, Disk]:
        """The disks of sums that have series of their own, and of terms that are ``reaching``, within those
        of ``tail.times``, given the extents of what they are made of. The first ones tell rounding errors of
        where they start, with low parts."""
        if self.tail is None:
            return {}
        f, series, far = self.f, self.series, Disks(self.f, self.disks.centres, LANES)
        far.parts, asked = self.disks.parts, [*self.own, *self.reaching]
        known = {node: disk for node, disk in self.known.items() if disk is None or disk.radius is None}
        known |= dict.fromkeys((*series.places, *series.speeds), Disk(None, far.all(inf)))  # nothing asks
        for symbol, extent in symbols.items():
            late = f.splat(f.magnitude(series.late(symbol)), LANES)
            known[symbol] = Disk(far.centre(self.known[symbol]), extent + late)
        for symbol in series.totals:
            known[symbol] = Disk(far.centre(self.known[symbol]), series.farther(symbol))
        known[series.time] = Disk("%t", self.tail.times)
        for node, extent in sums.items():
            known[node] = self._combination(far, node, extent, known)
        emit_values(far, asked, known, self.constants)
        return {node: known[node] or far.constant(0) for node in asked}

    def _closer(self, disk: Disk | None, radius: Real) -> Disk | None:
        """The disk of a sum, or one of a ``radius`` of its series, whichever is smaller."""
        if disk is None or disk.radius is None:
            return disk
        radius = self.disks.lesser(disk.radius, radius + rounding(self.disks, disk))
        return Disk(disk.centre, radius, disk.bound)

    def _over_cosh(self, node: Node, u: Disk | None) -> Disk | None:
        """The disk of c (1 - tanh(u)^2)."""
        disks = self.disks
        inverse = disks.div(disks.one, disks.function("cosh", u))
        return disks.mul(disks.number(node.data[0]), disks.mul(inverse, inverse))


def rounding(disks: Disks, disk: Disk) -> Real:
    """The rounding errors of the coefficients of a sum, of which this is a disk of its terms."""
    return disks.most(disk) * (OPERATIONS * ROUNDING)
