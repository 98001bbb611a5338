"""``@proven`` of equations that are written out: a term for each of their terms (see ``stepping.proof``)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import chain
from math import inf

from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.defect import Defect
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.stepping.cancelling import Sums, Tail
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.proof import (
    HEAD,
    WIDER,
    Margins,
    Proof,
    exceeded,
    expected,
    least,
    radii,
    weights_of,
)
from lagrange_cli.native.stepping.state_series import StateSeries
from lagrange_cli.records import dataclass

TOGETHER = 4
"""Rows whose extents are computed side by side: each sum waits for its last term."""


@dataclass(frozen=True)
class EquationsProof(Proof):
    """The proof of equations, of which the ``defect`` is left and whose constants are known. The integrals of
    ``sums`` are behind those of multipliers."""

    residual: Residual
    defect: Defect
    constants: Constants
    sums: Sequence[Node]
    margins: Margins

    @property
    def lengths(self) -> Lengths:
        """Where the series are."""
        return self.margins.lengths

    def function(self) -> Function:
        f = Function(HEAD.format(self.name))
        emitter = Emitter(f)
        disks = Disks(f, emitter, LANES)
        emitter.parts = disks.parts = self.margins.parts  # constants have as many
        self._extents(f)
        moving = self._leaves(f, disks)
        rows = [one for row in self.defect.terms for one in row]
        variables = self.residual.variables | union(self.defect.accelerations)
        series = WrittenSeries(f, self, variables, set(moving))
        tail = Tail(f) if self.sums else None
        Sums(disks, rows, series, moving, self.constants, tail).enclose()
        emit_values(disks, rows, moving, self.constants)
        allowed = self._allowed(f, emitter, moving)
        weights, excess = weights_of(disks), f.constant(0.0)
        for row, most in zip(self.defect.terms, allowed):
            total = f.constant(0.0)
            for term in row:
                total = total + least(disks, disks.radius(moving[term] or disks.constant(0)), weights)
            excess = exceeded(f, excess, total * WIDER, most)
            if self.name == "arguments_proven":  # a series whose coefficients overflow is one at a pole
                excess = f.select(most < inf, excess, f.constant(inf))
        f.give(expected(f, excess, self.lengths.order))
        return f

    def _extents(self, f: Function) -> None:
        """By how much q, v, the accelerations and multipliers change within the disks, vectors at
        ``%extents``; and what each acceleration and multiplier may be off, doubles at ``%scales``."""
        lengths, n = self.lengths, self.lengths.degrees
        first_multiplier, multipliers = self.margins.multipliers
        f.line(f"  %extents = alloca <{LANES} x double>, i64 {3 * n + multipliers}, align {8 * LANES}")
        first_rate, rate_count = self.margins.integrals if self.margins.integrals[1] else (n, n)
        f.line(f"  %scales = alloca double, i64 {rate_count + multipliers}, align 8")
        h, inverse = Real(f, "%h"), 1.0 / Real(f, "%unit")
        scaled = h * inverse
        r = radii(f, scaled)

        def sums_of(rows: Sequence[Pointer], last: Sequence[Integer], first: int, x: Real) -> list[Real]:
            """sum_{m >= 1} |c[m]| x^m, or that of the slopes sum_{m >= 2} m |c[m]| x^(m - 1)."""
            totals = [f.variable(f.splat(f.constant(0.0), x.lanes)) for _ in rows]
            m = f.variable(last[0])
            with f.forever() as rounds:
                for total, row, most in zip(totals, rows, last):
                    c = f.magnitude(f.load(row, m.get() * lengths.term))
                    c = f.select(m.get() <= most, c, f.constant(0.0))
                    c = c * m.get().to_real() if first > 1 else c
                    total.set((total.get() + f.splat(c, x.lanes)) * x)
                m.set(m.get() - 1)
                rounds.repeat(m.get() >= first)
            return [total.get() for total in totals]

        def rows_of(listed: Sequence[Integer]) -> list[Pointer]:
            return [f.place("%work", i * lengths.row + lengths.first) for i in listed]

        def several(first: Index, i: Integer, count: int) -> list[Integer]:
            """Rows from one on, the last one of ``count`` again where there are no more."""
            return [f.select(i + j < count, i + j, f.count(count - 1)) + first for j in range(TOGETHER)]

        top = f.count(lengths.top)
        with f.loop(0, 2 * n, TOGETHER, tested=False) as i:
            listed = several(0, i, 2 * n)
            last = [f.select(one < n, f.count(lengths.order), top) for one in listed]
            for one, extent in zip(listed, sums_of(rows_of(listed), last, 1, r)):
                low = f.splat(f.magnitude(f.load("%state", one + self.margins.low)), LANES)
                f.store_row(extent + low, "%extents", one * LANES, aligned=True)
        nothing = self.margins.negligible(f, h)

        def rates(first: int, count: int, extents: int | None, scales: int | None, *, speeds: bool) -> None:
            """The extents of rates of rows, and what each rate may be off, from such places on."""
            with f.loop(0, count, TOGETHER, tested=False) as i:
                listed = several(first, i, count)
                rows, last = rows_of(listed), [top] * TOGETHER
                if extents is not None:
                    for one, extent in zip(listed, sums_of(rows, last, 2, r)):
                        place = (one + (extents - first)) * LANES
                        f.store_row(extent * f.splat(inverse, LANES), "%extents", place, aligned=True)
                if scales is None:
                    return
                for one, row, size in zip(listed, rows, sums_of(rows, last, 2, scaled)):
                    off = (size + f.magnitude(f.load(row, lengths.term))) * inverse
                    if speeds:
                        speed = f.magnitude(f.load("%state", one)) / h
                        off = f.fused(off + speed, self.margins.small, nothing)
                    else:
                        off = off * self.margins.small
                    f.store(off, "%scales", one + (scales - first))

        if self.margins.integrals[1]:
            rates(first_rate, rate_count, None, 0, speeds=True)
            if union(self.defect.accelerations) & self._symbols:
                rates(n, n, 2 * n, None, speeds=True)
        else:
            rates(n, n, 2 * n, 0, speeds=True)
        if multipliers:
            rates(first_multiplier, multipliers, 3 * n, rate_count, speeds=False)

    @property
    def _symbols(self) -> int:
        """Those that the terms contain, momenta and entries of the equations included."""
        inside = [term for row in self.defect.terms for term in row]
        inside += [one.momentum for one in self.residual.cyclic_momenta]
        return union([*inside, *(entry for row in self.residual.entries for entry in row.values())])

    def _leaves(self, f: Function, disks: Disks) -> dict[Node, Disk | None]:
        """The disks of the symbols that the terms contain."""
        model, n, emitter, lengths = self.residual.model, self.lengths.degrees, disks.centres, self.lengths
        symbols = self._symbols
        known: dict[Node, Disk | None] = {model.time: Disk("%t", radii(f, Real(f, "%h")))}
        residual = self.residual
        rows = [*range(n, 2 * n), *range(self.margins.multipliers[0], sum(self.margins.multipliers))]
        leaves = [*enumerate((*residual.state_q, *residual.state_v))]
        leaves += zip((2 * n + k for k in residual.unknown), self.defect.accelerations)
        leaves += enumerate(residual.multipliers, 3 * n)
        for i, symbol in leaves:
            if symbol.symbols & symbols:
                if i < 2 * n:
                    centre = emitter.load("%state", i)
                else:
                    place = rows[i - 2 * n] * lengths.row + lengths.first + lengths.term
                    centre = emitter.define(f"fdiv double {emitter.load('%work', place)}, %unit")
                extent = f.load_row("%extents", i * LANES, LANES, aligned=True)
                known[symbol] = Disk(centre, extent)
        # momenta are constants: those of the velocities
        points = centres(known)
        emit_values(emitter, [one.momentum for one in self.residual.cyclic_momenta], points, self.constants)
        known.update((one.symbol, Disk(points[one.momentum])) for one in self.residual.cyclic_momenta)
        return known

    def _allowed(self, f: Function, emitter: Emitter, moving: dict[Node, Disk | None]) -> list[Real]:
        """How large the defect of each row may be: by the masses, as an error of the accelerations. The
        multipliers that remain in the row of a coordinate without mass may be 0: there its terms count."""
        if self.margins.integrals[1]:
            return [f.load("%scales", i) for i in range(self.margins.integrals[1])]
        known = centres(moving)
        matrix, n = self.residual.entries, self.lengths.degrees
        places = [*self.residual.unknown, *range(n, n + len(self.residual.multipliers))]
        light = [self.defect.terms[i] if i in self.residual.weightless else () for i in range(len(matrix))]
        entries = [one for row in matrix for one in row.values()]
        emit_values(emitter, [*entries, *chain(*light)], known, self.constants)
        found = []
        for row, terms in zip(matrix, light):
            total: Value = None
            for j, entry in row.items():
                mass = emitter.magnitude(known[entry])
                total = emitter.fma(mass, emitter.load("%scales", places[j]), total)
            most = Real(f, emitter.written(total), 1)
            for term in terms:
                size = Real(f, emitter.written(emitter.magnitude(known[term])), 1)
                most = f.fused(size, self.margins.small, most)
            found.append(most)
        return found


class WrittenSeries(StateSeries):
    """The series of rows of the state, of symbols that are ``used``."""

    sums: Mapping[Node, int]

    def __init__(self, f: Function, proof: EquationsProof, variables: int, used: Collection[Node]) -> None:
        self.f, self.lengths, self.variables, self.low = f, proof.lengths, variables, proof.margins.low
        self.time, self.inverse = proof.residual.model.time, 1.0 / Real(f, "%unit")
        degrees, first = proof.lengths.degrees, sum(proof.margins.multipliers)
        places = {symbol: i for i, symbol in enumerate(proof.residual.state_q) if symbol in used}
        speeds = enumerate(proof.residual.state_v, degrees)
        self.rows = {**places, **{symbol: i for i, symbol in speeds if symbol in used}}
        self.places, self.speeds = [*places], [*self.rows][len(places) :]
        self.sums = {node: i for i, node in enumerate(proof.sums, first)}
        """The rows of their integrals."""

    def coefficient(self, node: Node, m: Integer) -> Real:
        if node in self.rows:
            return self._of_row(self.rows[node], m)
        return self._of_row(self.sums[node], m + 1) * (m + 1).to_real() * self.inverse

    def _of_row(self, row: int, m: Integer) -> Real:
        lengths = self.lengths
        return self.f.load("%work", m * lengths.term + (row * lengths.row + lengths.first))

    def late(self, symbol: Node) -> Real:
        return self.f.load("%state", self.rows[symbol] + self.low)


def centres(disks: Mapping[Node, Disk | None]) -> dict[Node, Value]:
    """The values where the step begins."""
    return {node: None if disk is None else disk.centre for node, disk in disks.items()}
