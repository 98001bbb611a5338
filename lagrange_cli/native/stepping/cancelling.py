"""Disks of what cancels, closer than those of its terms.

A difference of disks makes no use of what they have in common. The relative velocity of two bodies that move
fast side by side changes little within a step, but the radii of both velocities are added up. Three forms of
such sums are enclosed closely:

- A combination of q and v is a polynomial, as they are: its coefficients are those of its terms, combined.
- A sum u that is no combination, and in which something is singular, has a row of the state, as an integral
  has: its coefficients are known up to order n. What is beyond is at most D K^-(n + 1) / (1 - 1/K) within r,
  if u differs from its start by at most D within K r (Cauchy's estimate). There its terms may be enclosed
  loosely. (A Taylor model in one variable: M. Berz and K. Makino, Reliable Computing 4, 361, 1998.)
- 1 - tanh^2, the derivative of tanh, is 1 / cosh^2.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from math import inf, log
from typing import cast

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.approach import fixed_factors, linear_in
from lagrange_cli.mechanics.cancellation import squared_tanh
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Index, Integer, Real
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import ROUNDING, Disk
from lagrange_cli.native.recurrences.evaluation import Constants, add_scaled, emit_values
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.proof import RATIOS, WIDER, radii
from lagrange_cli.records import dataclass

SEVERAL = 2
"""Terms of a sum that can cancel."""
FARTHER = 1.4, 1.8, 2.4, 3.2, 4.8, 8.0, 16.0
"""How much farther than the largest disks of time those reach within which sums are enclosed loosely. One
more has the radius 0: what is left are the rounding errors at the start of a step."""
OPERATIONS = 32
"""Rounding errors of the coefficients of a sum, in those of a disk of its terms."""


class StateSeries(ABC):
    """The series of symbols, whose ``places`` and ``speeds`` are rows of the state, and of ``sums`` that are
    the integrands of rows. All that moves is made of ``variables``, of which one is ``time``; q's series have
    the order that ``lengths`` say."""

    lengths: Lengths
    variables: int
    time: Node
    places: Mapping[Node, Index]
    speeds: Mapping[Node, Index]
    sums: Mapping[Node, int]

    @abstractmethod
    def coefficient(self, node: Node, m: Integer) -> Real:
        """Coefficient ``m`` of a symbol, or of the integral of a sum."""

    @abstractmethod
    def late(self, symbol: Node) -> Real:
        """The low part of a symbol's number in the state."""


@dataclass(frozen=True)
class Combination:
    """A sum of ``symbols`` with constant ``weights``, and of the ``rest``: other terms, and what these are
    multiplied by. It may be one of the ``rates`` of symbols instead."""

    symbols: Sequence[Node]
    weights: Sequence[Real]
    rest: Sequence[tuple[Node, float]] = ()
    rates: bool = False


class Sums:
    """Encloses the sums in ``terms`` whose own terms may cancel. ``known`` has the disks of symbols, and is
    given those of the sums."""

    def __init__(
        self,
        disks: Disks,
        terms: list[Node],
        series: StateSeries,
        known: dict[Node, Disk | None],
        constants: Constants,
    ) -> None:
        self.disks, self.f, self.series, self.known, self.constants = disks, disks.f, series, known, constants
        self.order = reachable(terms)
        self.combined = self._combinations()
        self.own = [node for node in self.order if node in series.sums]

    def enclose(self) -> None:
        """Write them, arguments before their users."""
        f, one = self.f, self.f.constant(1.0)
        integrands = [Combination([node], [one], rates=True) for node in self.own]
        r = radii(f, Real(f, "%h") / Real(f, "%unit"))
        extent = dict(
            zip([*self.combined, *self.own], self._extents([*self.combined.values(), *integrands], r))
        )
        beyond = self._beyond()
        for node in self.order:
            u = squared_tanh(node)
            if node in self.combined:
                self.known[node] = self._combination(self.disks, node, extent[node], self.known)
            elif node in self.own:
                disk = self._value(node)
                self.known[node] = self._closer(disk, extent[node] + beyond[node])
            elif u is not None and u.symbols & self.series.variables:
                self.known[node] = self._over_cosh(node, self._value(u))

    def _value(self, node: Node) -> Disk | None:
        """The disk of an expression."""
        emit_values(self.disks, [node], self.known, self.constants)
        return self.known[node]

    def _combinations(self) -> dict[Node, Combination]:
        """The sums in which several symbols may cancel."""
        found, emitter, series = dict[Node, Combination](), self.disks.centres, self.series
        for node in self.order:
            if node.kind is not Kind.SUM or not node.symbols & series.variables:
                continue
            symbols, factors, rest = list[Node](), list[Node](), list[tuple[Node, float]]()
            for argument, scale in zip(node.arguments, node.data[1]):
                symbol = linear_in(argument, series.variables)
                if symbol is not None and (symbol in series.places or symbol in series.speeds):
                    symbols.append(symbol)
                    factors.append(scale * node.graph.product(fixed_factors(argument, series.variables)))
                else:
                    rest.append((argument, scale))
            if len(symbols) >= SEVERAL:
                values = (emitter.written(self.constants.value(emitter, one)) for one in factors)
                found[node] = Combination(symbols, [Real(self.f, value, 1) for value in values], rest)
        return found

    def _extents(self, combinations: Sequence[Combination], r: Real) -> list[Real]:
        """How much they change within ``r``, in the unit of the series: sum_m |c[m]| r^m."""
        if not combinations:
            return []
        f, series = self.f, self.series
        used = dict.fromkeys(symbol for one in combinations for symbol in one.symbols)

        def sizes(m: Integer, symbols: Iterable[Node]) -> list[Real]:
            """|c[m]|, as far as it is made of some symbols; m |c[m]| for rates."""
            loaded, found = {symbol: series.coefficient(symbol, m) for symbol in symbols}, list[Real]()
            for one in combinations:
                total = f.constant(0.0)
                for symbol, weight in zip(one.symbols, one.weights):
                    total = f.fused(loaded[symbol], weight, total) if symbol in loaded else total
                size = f.magnitude(total)
                found.append(f.splat(size * m.to_real() if one.rates else size, LANES))
            return found

        longer = [symbol for symbol in used if symbol in series.places]  # by one order
        totals = [f.variable(one * r) for one in sizes(f.count(series.lengths.order), longer)]
        m = f.variable(f.count(series.lengths.top))
        with f.forever() as rounds:
            for total, one in zip(totals, sizes(m.get(), used)):
                total.set((total.get() + one) * r)
            m.set(m.get() - 1)
            rounds.repeat(m.get() > 1)
        inverse = f.splat(1.0 / Real(f, "%unit"), LANES)
        return [
            total.get() * inverse if one.rates else (total.get() + last) * r
            for one, total, last in zip(combinations, totals, sizes(f.count(1), used))
        ]

    def _combination(
        self, disks: Disks, node: Node, extent: Real, known: dict[Node, Disk | None]
    ) -> Disk | None:
        """The disk of a sum whose combination changes by an ``extent``."""
        f, one, centre = self.f, self.combined[node], cast("Value", None)
        spread, late = disks.all(0.0), f.constant(0.0)
        for symbol, weight in zip(one.symbols, one.weights):
            disk, size = known[symbol] or disks.constant(0), f.magnitude(weight)
            centre = disks.centres.fma(weight.name, disk.centre, centre)
            spread = f.fused(f.splat(size, disks.lanes), disks.most(disk), spread)
            late = f.fused(size, f.magnitude(self.series.late(symbol)), late)
        radius = f.fused(spread, disks.all(len(one.symbols) * ROUNDING), extent) + f.splat(late, disks.lanes)
        total = disks.add(Disk(centre, radius), disks.number(node.data[0]))
        moving = [term for term, _ in one.rest if term.symbols & self.series.variables]
        emit_values(disks, moving, known, self.constants)
        for term, scale in one.rest:
            value = known[term] if term in known else self.constants.value(disks, term)
            total = add_scaled(disks, total, value, scale)
        return total

    def _beyond(self) -> dict[Node, Real]:
        """What is beyond the series of sums that have some, at most, within each disk of time; and the
        rounding errors of where they start, with low parts."""
        if not self.own:
            return {}
        f, far = self.f, Disks(self.f, self.disks.centres, LANES)
        far.parts, h = self.disks.parts, f.splat(Real(f, "%h"), LANES)
        scales = f.vector([RATIOS[-1] * WIDER * x for x in (0.0, *FARTHER)])
        inside = set(reachable(self.own))
        symbols = [one for one in (*self.series.places, *self.series.speeds) if one in inside]
        sums = [node for node in self.combined if node in inside]
        alone = [Combination([one], [f.constant(1.0)]) for one in symbols]
        r = h * scales / f.splat(Real(f, "%unit"), LANES)
        found = self._extents([*alone, *(self.combined[node] for node in sums)], r)
        extent = dict(zip([*symbols, *sums], found))
        known = {node: disk for node, disk in self.known.items() if disk is None or disk.radius is None}
        known |= {one: self._farther(one, extent[one]) for one in symbols}
        known[self.series.time] = Disk("%t", h * scales)
        for node in sums:
            known[node] = self._combination(far, node, extent[node], known)
        emit_values(far, self.own, known, self.constants)
        order, most = f.splat(Real(f, "%beyond"), LANES), far.all(inf)
        weights = far.exp(f.vector([0.0, *(-log(x) for x in FARTHER)]) * order)
        weights = weights * f.vector([inf, *(x / (x - 1) for x in FARTHER)])
        nearer = far.exp(f.vector([log(k / RATIOS[-1]) for k in RATIOS]) * order)
        beyond = dict[Node, Real]()
        for node in self.own:
            radius = far.radius(known[node] or far.constant(0))
            bound = radius * weights
            bound = f.reduce("fmin", f.select(bound < most, bound, most))  # what is not a number is not known
            beyond[node] = f.fused(f.splat(bound, LANES), nearer, f.splat(f.lane(radius, 0), LANES))
        return beyond

    def _farther(self, symbol: Node, extent: Real) -> Disk:
        """The disk of a symbol that changes by an ``extent``."""
        disk, late = self.known[symbol], self.f.magnitude(self.series.late(symbol))
        return Disk(None if disk is None else disk.centre, extent + self.f.splat(late, LANES))

    def _closer(self, disk: Disk | None, radius: Real) -> Disk | None:
        """The disk of a sum, or one of a ``radius`` of its series, whichever is smaller."""
        if disk is None or disk.radius is None:
            return disk
        rounding = self.disks.most(disk) * (OPERATIONS * ROUNDING)
        return Disk(disk.centre, self.disks.lesser(disk.radius, radius + rounding), disk.bound)

    def _over_cosh(self, node: Node, u: Disk | None) -> Disk | None:
        """The disk of c (1 - tanh(u)^2)."""
        disks = self.disks
        inverse = disks.div(disks.one, disks.function("cosh", u))
        return disks.mul(disks.number(node.data[0]), disks.mul(inverse, inverse))
