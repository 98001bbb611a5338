"""Velocities that are nothing but rounding: what they are measured by.

Where forces cancel by symmetry, a velocity is 0 but for rounding. It may be 1e-100 while the high
coefficients of its series, where forces cancel to fewer digits, are 1e-10: no step is short enough for these
to be small beside it, and in such steps it does not grow. But rounding changes its rate by far more. How much
is measured as for integrands (``rounding_errors``): by changes of coordinates and velocities in proportion to
themselves, so that what is small beside nothing but itself keeps all its digits. Rates are known to that
only, and velocities are measured by what it changes them in a step. They are not measured by more, such as
all that the terms which cancel change them: steps could be so long that the rounding errors of these terms,
which grow with the exponential of their frequency times the step, are no longer small.

Where a step is not accepted, accelerations may differ by what rounding changes them, too: relative angles of
a chain are moved by forces on all links behind them, and Euler angles are so fast near their pole that hardly
a digit of their difference is known. Where forces cancel, as in a chain that is dropped, or entries of M do,
as at such a pole, nothing but rounding is left: it does not change smoothly, and all that is tiny beside the
largest acceleration counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Pointer, Real
from lagrange_cli.native.state import LANES
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.rounding_errors import WAYS, share
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.sums import HighLow
from lagrange_cli.records import dataclass

FAINT = 2.0**-52
"""Velocities below this part of the fastest one may be rounding."""
SMOOTH = 0.8
"""Twice half a change may differ from the whole one by this part of it where it is smooth, a cubic even; not
across a jump, or close to a pole."""
TINY = 2.0**-26
"""Changes below this part of the largest acceleration are rounding, smooth or not."""
SCATTER = 64.0
"""Others may be so many times as large: what functions of small coordinates are rounded by is the same in
all of these."""
LASTS = 32.0
"""For so many steps what was found holds."""


def keep_larger(
    row: Row, place: int, half: Real, whole: Real, counts: Callable[[Bit], Bit], most: Real | None = None
) -> None:
    """Keep the larger change, so many rows behind its own, where rates are smooth and it ``counts``; ``half``
    is what half the change makes of them. It counts up to ``most``."""
    f, change = row.f, row.f.magnitude(whole)
    steady = (f.magnitude((whole - half) - half) <= change * SMOOTH) & (change < ENDLESS)
    change = change if most is None else f.smaller(change, most)
    before = row.at("%state", place)
    row.put(f.select(counts(steady), f.larger(change, before), before), "%state", place)


@dataclass(frozen=True)
class Noise:
    """Writes ``@noise(constants, state, work, arrays, t, low, unit, which)``, which writes down how much of
    each rate is rounding, ``place`` rows behind its velocity; 0 where no velocity is faint. The first of
    these numbers counts the steps until it is ``due`` again. Only those of the motions ``which`` are due
    change.

    Coordinates and velocities change by the part ``size`` of them, in parts that are ``last`` rows behind.
    ``expand`` is to compute the series of a state. ``@noise`` returns whether those in ``%work`` are of
    another one. It uses three arrays of the ``width`` of a state, from row ``first`` of ``%arrays`` on, and
    one more where low parts of coefficients are so far ``beyond`` these. If it may be ``asked``, it is
    measured where no velocity is faint, too, once it is.
    """

    lengths: Lengths
    width: int
    place: int
    first: int
    size: float
    last: int
    expand: Callable[[Function, HighLow, Real], object]
    asked: bool = False
    beyond: int = 0

    def function(self) -> Function:
        """The function."""
        motions = self.lengths.motions
        places = "ptr noalias %constants, ptr noalias %state, ptr noalias %work, ptr noalias %arrays"
        times = "REAL %t, REAL %low, REAL %unit, BIT %which"
        f = Function(f"define internal i1 @noise({places}, {times}) #0", motions)
        which = Bit(f, "%which", motions)
        suspicious, asked = self._faint(f), None
        if self.asked:
            asked = f.load("%state", self.place) < 0.0
            suspicious = suspicious | asked
        suspicious = suspicious & which
        self._clear(f, which)
        measured = f.any(suspicious)
        with f.when(measured):
            self._measure(f, suspicious, asked)
        left = f.load("%state", self.place)
        f.store(f.select(which, LASTS, left), "%state", self.place)
        f.give(measured)
        return f

    def call(self, f: Function, places: Sequence[Pointer], times: Sequence[Real], which: Bit) -> Bit:
        """Call it at ``places`` for the motions ``which``: whether the series in ``%work`` are of another
        state now."""
        return f.call(Bit, "noise", *places, *times, which, lanes=1)

    def due(self, f: Function) -> Bit:
        """Whether it is to be called at the beginning of a step."""
        return f.load("%state", self.place) <= 0.0

    def ask(self, f: Function) -> None:
        """Let it be measured with the next series."""
        f.store(f.constant(-1.0), "%state", self.place)

    def allow(self, f: Function, allowed: Pointer, before: Pointer) -> None:
        """Let the errors of accelerations that are ``allowed`` be so much larger, and let it be known at the
        state ``before``, too, for as many steps."""
        with self.lengths.velocities(f) as row:
            row.put(row.at(allowed) + row.at("%state", self.place), allowed)
        source, target = ("%state", self.place), (before, self.place)
        f.copy_rows(source, target, self.width, LANES)

    def count(self, f: Function, steps: Real | float = 1.0) -> None:
        """Count a step that was taken, or what ``steps`` there were of each motion."""
        f.store(f.load("%state", self.place) - steps, "%state", self.place)

    def _faint(self, f: Function) -> Bit:
        """Whether there are velocities that may be rounding."""
        lengths = self.lengths
        zero, endless = f.zero(lengths.lanes), lengths.wide(f, f.constant(ENDLESS))
        fastest, slowest = f.variable(zero), f.variable(endless)
        with lengths.velocities(f) as row:
            speed = row.only_velocities(f.magnitude(row.at("%state")))
            fastest.set(f.larger(fastest.get(), speed))
            slowest.set(f.smaller(slowest.get(), f.select(speed > 0.0, speed, endless)))
        most, least = lengths.gather(f, "fmax", fastest.get()), lengths.gather(f, "fmin", slowest.get())
        return least < most * FAINT

    def _measure(self, f: Function, which: Bit, asked: Bit | None) -> None:
        """The measurement; where it was ``asked`` for, of changes that are not smooth, too."""
        lengths = self.lengths
        arrays = (f.place("%arrays", self.first + array * self.width) for array in range(4))
        base, half, saved, base_low = arrays
        with lengths.each(f) as row:
            row.put(row.at("%state", self.last), saved)
        t, low, unit = f.reals("t", "low", "unit")
        self.expand(f, (t, low), unit)
        inverse = lengths.wide(f, 1.0 / unit)
        with lengths.velocities(f) as row:
            row.put(row.series()[1] * inverse, base)
            if self.beyond:
                row.put(row.series()[1 + self.beyond] * inverse, base_low)
        tiny = lengths.wide(f, f.select(asked, self._largest(f, base) * TINY, 0.0)) if asked else None
        with f.loop(0, WAYS, tested=False) as way:
            for size in (0.5 * self.size, self.size):
                with lengths.each(f) as row:
                    old = row.at(saved)
                    most = (row.at("%state") if self.last else old) * size
                    new = f.select(
                        row.among(0, 2 * lengths.degrees),
                        old + lengths.wide(f, share(f, row, way)) * most,
                        old,
                    )
                    row.put(new, "%state", self.last)
                self.expand(f, (t, low), unit)
                with lengths.velocities(f) as row:
                    change = row.series()[1] * inverse - row.at(base)
                    if self.beyond:
                        change = change + (row.series()[1 + self.beyond] * inverse - row.at(base_low))
                    if size < self.size:
                        row.put(change, half)
                    else:
                        counts = partial(self._counts, row, which)
                        keep_larger(row, self.place, row.at(half), change, counts)
                        if tiny:
                            self._keep_tiny(row, which, f.magnitude(change), tiny)
        with lengths.each(f) as row:
            row.put(row.at(saved), "%state", self.last)

    def _largest(self, f: Function, rates: Pointer) -> Real:
        """The largest rate of a velocity."""
        found = f.variable(f.zero(self.lengths.lanes))
        with self.lengths.velocities(f) as row:
            found.set(f.larger(found.get(), row.only_velocities(f.magnitude(row.at(rates)))))
        return self.lengths.gather(f, "fmax", found.get())

    def _keep_tiny(self, row: Row, which: Bit, change: Real, tiny: Real) -> None:
        """Keep a change that is nothing but rounding, of which few are seen."""
        f, before = row.f, row.at("%state", self.place)
        counts = row.moving((change <= tiny) & f.splat(which, self.lengths.lanes))
        row.put(f.select(counts, f.larger(change * SCATTER, before), before), "%state", self.place)

    def _counts(self, row: Row, which: Bit, steady: Bit) -> Bit:
        return row.moving(steady & row.f.splat(which, self.lengths.lanes))

    def _clear(self, f: Function, which: Bit) -> None:
        with self.lengths.velocities(f) as row:
            before = row.at("%state", self.place)
            every = row.moving(f.splat(which, self.lengths.lanes))
            row.put(f.select(every, f.zero(self.lengths.lanes), before), "%state", self.place)

    def floors(self, f: Function, h: Real) -> None:
        """What velocities are measured by over ``h``, where ``Lengths.floor`` is."""
        lengths = self.lengths
        with lengths.velocities(f) as row:
            row.put(row.at("%state", self.place) * lengths.wide(f, h), "%work", lengths.floor)
