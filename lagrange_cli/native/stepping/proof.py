"""``@proven``: whether the series of a step satisfy the equations of motion throughout the step.

The series of q are polynomials of t, and those of v and of the accelerations their derivatives. Put into the
equations they leave a *defect*, an analytic function of t whose coefficients are 0 up to the order n of the
accelerations. Where a term of it differs from its start by at most D for all complex times within r,
coefficient m of it is at most D / r^m (Cauchy's estimate), so that for h = r / k what is beyond order n is at
most D k^-(n + 1) / (1 - 1/k) up to time h. D is found by enclosing q, v, a and t in disks, and evaluating the
term over these (``recurrences.disk``). No term of the equations is passed over, however narrow. This is done
for several k at once, and each term takes the k that suits it best: a small one if it is negligible all
around, a large one if it is large. (Enclosures of Taylor series over a step: G. F. Corliss and R. Rihm,
Validating an a priori enclosure using high-order Taylor series, 1996; N. S. Nedialkov, K. R. Jackson and G.
F. Corliss, Appl. Math. Comput. 105, 21, 1999.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log
from typing import TypeAlias

from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.mechanics.cancellation import squared_tanh
from lagrange_cli.mechanics.defect import Defect
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.steps import Now
from lagrange_cli.records import dataclass

RATIOS = 1.125, 1.4, 1.8, 2.4, 3.2, 4.0, 5.5, 8.0
"""The radii of the disks of time, as multiples of the step."""
SHORTER, REGAINED, LEAST = 0.7, 1.5, 2.0**-60
"""A step that is not proven is tried again so many times as long, or as the step before; down to this part of
what the series suggests, below which there is none."""
WIDER = 1 + 2.0**-40
"""A margin larger than the rounding error of radii."""


Proving: TypeAlias = "tuple[Residual, Defect, Constants]"
"""Equations, what is left of them, and where their constants are."""


@dataclass(frozen=True)
class Proof:
    """What ``@proven`` is written from.

    What rests may be moved by ``nothing``; low parts of the state are ``low`` doubles behind. A number has
    ``parts`` doubles, of which the first is looked at. A defect cannot be distinguished from rounding up to
    the fraction ``small`` of the accelerations, their change, and what changes the velocity within a step.
    """

    residual: Residual
    defect: Defect
    constants: Constants
    lengths: Lengths
    low: int
    nothing: float
    small: float
    parts: int = 1
    integrals: tuple[int, int] = (0, 0)
    """The first row and the number of integrals whose integrands the terms are, if it is not the equations
    that are looked at."""
    multipliers: tuple[int, int] = (0, 0)
    """The first row and the number of the integrals of constraints' multipliers."""
    name: str = "proven"
    """The name of the function."""

    def function(self) -> Function:
        """``@proven(constants, t, state, work, h, unit, beyond)``, in the ``unit`` of time that the series
        have; ``beyond`` is the first order of the accelerations that they do not reach."""
        places = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work"
        given = f"{places}, double %h, double %unit, double %beyond"
        f = Function(f"define internal i1 @{self.name}({given}) #0")
        emitter = Emitter(f)
        disks = Disks(f, emitter, LANES)
        emitter.parts = disks.parts = self.parts  # constants have as many
        self._extents(f)
        moving = self._leaves(f, disks)
        rows = [one for row in self.defect.terms for one in row]
        self._without_cancelling(disks, rows, moving)
        emit_values(disks, rows, moving, self.constants)
        allowed = self._allowed(f, emitter, moving)
        logarithms, sums = f.vector([-log(k) for k in RATIOS]), f.vector([k / (k - 1) for k in RATIOS])
        weights = disks.exp(logarithms * f.splat(Real(f, "%beyond"), LANES)) * sums
        unlimited = disks.all(float("inf"))
        for row, most in zip(self.defect.terms, allowed):
            total = f.constant(0.0)
            for term in row:
                radius = disks.radius(moving[term] or disks.constant(0)) * weights
                # what is not a number is not known
                total = total + f.reduce("fmin", f.select(radius < unlimited, radius, unlimited))
            sure = total * WIDER <= most
            if self.name == "arguments_proven":  # a series whose coefficients overflow is one at a pole
                sure = sure & (most < f.constant(float("inf")))
            with f.when(~sure):
                f.give(Bit(f, "false"))
        f.give(Bit(f, "true"))
        return f

    def _extents(self, f: Function) -> None:
        """By how much q, v, the accelerations and multipliers change within the disks, vectors at
        ``%extents``; and what each acceleration and multiplier may be off, doubles at ``%scales``."""
        lengths, n = self.lengths, self.lengths.degrees
        first_multiplier, multipliers = self.multipliers
        f.line(f"  %extents = alloca <{LANES} x double>, i64 {3 * n + multipliers}, align {8 * LANES}")
        first_rate, rates = self.integrals if self.integrals[1] else (n, n)
        f.line(f"  %scales = alloca double, i64 {rates + multipliers}, align 8")
        h, inverse = Real(f, "%h"), 1.0 / Real(f, "%unit")
        scaled = h * inverse
        r = f.splat(scaled, LANES) * f.vector([k * WIDER for k in RATIOS])

        def sum_of(row: Pointer, last: Integer, first: int, x: Real) -> Real:
            """sum_{m >= 1} |c[m]| x^m, or that of the slopes sum_{m >= 2} m |c[m]| x^(m - 1)."""
            total, m = f.variable(f.splat(f.constant(0.0), x.lanes)), f.variable(last)
            with f.forever() as rounds:
                c = f.magnitude(f.load(row, m.get() * lengths.term))
                c = c * m.get().to_real() if first > 1 else c
                total.set((total.get() + f.splat(c, x.lanes)) * x)
                m.set(m.get() - 1)
                rounds.repeat(m.get() >= first)
            return total.get()

        def row_of(i: Integer) -> Pointer:
            return f.place("%work", i * lengths.row + lengths.first)

        with f.loop(0, 2 * n, tested=False) as i:
            low = f.splat(f.magnitude(f.load("%state", i + self.low)), LANES)
            last = f.select(i < n, f.count(lengths.order), f.count(lengths.top))
            f.store_row(sum_of(row_of(i), last, 1, r) + low, "%extents", i * LANES, aligned=True)
        nothing = self.nothing / (h * f.function("maxnum", h, 1.0))
        top = f.count(lengths.top)

        def slopes(i: Integer, place: Integer) -> None:
            extent = sum_of(row_of(i), top, 2, r) * f.splat(inverse, LANES)
            f.store_row(extent, "%extents", place * LANES, aligned=True)

        def size(i: Integer) -> Real:
            row = row_of(i)
            return (sum_of(row, top, 2, scaled) + f.magnitude(f.load(row, lengths.term))) * inverse

        with f.loop(first_rate, first_rate + rates, tested=False) as i:
            if not self.integrals[1]:
                slopes(i, i + n)
            speed = f.magnitude(f.load("%state", i)) / h
            f.store(f.fused(size(i) + speed, self.small, nothing), "%scales", i - first_rate)
        if multipliers:
            with f.loop(0, multipliers, tested=False) as i:
                slopes(i + first_multiplier, i + 3 * n)
                f.store(size(i + first_multiplier) * self.small, "%scales", i + rates)

    def _leaves(self, f: Function, disks: Disks) -> dict[Node, Disk | None]:
        """The disks of the symbols that the terms contain."""
        model, n, emitter, lengths = self.residual.model, self.lengths.degrees, disks.centres, self.lengths
        symbols = 0
        for row in self.defect.terms:
            for term in row:
                symbols |= term.symbols
        for one in self.residual.cyclic_momenta:
            symbols |= one.momentum.symbols
        for entries in self.residual.entries:
            for entry in entries.values():
                symbols |= entry.symbols
        radius = f.splat(Real(f, "%h"), LANES) * f.vector([k * WIDER for k in RATIOS])
        known: dict[Node, Disk | None] = {model.time: Disk("%t", radius)}
        residual = self.residual
        rows = [*range(n, 2 * n), *range(self.multipliers[0], sum(self.multipliers))]
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

    def _without_cancelling(self, disks: Disks, terms: list[Node], known: dict[Node, Disk | None]) -> None:
        """Another form of terms that cancel: 1 - tanh^2, the derivative of tanh, is 1 / cosh^2. A difference
        of disks does not make use of what they have in common."""
        for node in reachable(terms):
            u = squared_tanh(node)
            if u is not None and u.symbols & self.residual.variables:
                emit_values(disks, [u], known, self.constants)
                inverse = disks.div(disks.one, disks.function("cosh", known[u]))
                scale = disks.number(node.data[0])
                known[node] = disks.mul(scale, disks.mul(inverse, inverse))

    def _allowed(self, f: Function, emitter: Emitter, moving: dict[Node, Disk | None]) -> list[Real]:
        """How large the defect of each row may be: by the masses, as an error of the accelerations."""
        if self.integrals[1]:
            return [f.load("%scales", i) for i in range(self.integrals[1])]
        known = centres(moving)
        matrix, n = self.residual.entries, self.lengths.degrees
        places = [*self.residual.unknown, *range(n, n + len(self.residual.multipliers))]
        emit_values(emitter, [one for row in matrix for one in row.values()], known, self.constants)
        found = []
        for row in matrix:
            total: Value = None
            for j, entry in row.items():
                mass = emitter.magnitude(known[entry])
                total = emitter.fma(mass, emitter.load("%scales", places[j]), total)
            found.append(Real(f, emitter.written(total), 1))
        return found


def proven(
    f: Function,
    proofs: Sequence[Proof],
    now: Now,
    h: Real,
    left: Real,
    free: Bit,
    places: tuple[Pointer, Pointer],
    beyond: Real,
) -> Real:
    """The step ``h``, of which no more than what is ``left`` is needed, or as much of it as is proven by all
    ``proofs``; 0 if nothing is. In front of a critical point (not ``free``) steps are parts of one that was
    proven."""
    length = f.variable(h)
    before = f.select(now.previous > 0.0, now.previous * REGAINED, h)
    with f.when(free), f.section() as sound, f.forever():
        needed = f.smaller(length.get(), left)
        given = f.pointer("%constants"), now.t + now.low, *places, needed, now.unit, beyond
        sure = Bit(f, "true")
        for one in proofs:
            sure = sure & f.call(Bit, one.name, *given)
        with f.when(sure):
            sound.leave()
        length.set(f.smaller(needed * SHORTER, before))
        with f.when(~(length.get() > f.smaller(h, left) * LEAST)):
            length.set(f.constant(0.0))
            sound.leave()
    return length.get()


def centres(disks: Mapping[Node, Disk | None]) -> dict[Node, Value]:
    """The values where the step begins."""
    return {node: None if disk is None else disk.centre for node, disk in disks.items()}
