"""Velocities that are nothing but rounding: what they are measured by.

Where forces cancel by symmetry, a velocity is 0 but for rounding. It may be 1e-100 while the high coefficients
of its series, where forces cancel to fewer digits, are 1e-10: no step is short enough for these to be small
beside it, and in such steps it does not grow. But rounding changes its rate by far more. How much is measured
as for integrands (``rounding_errors``): by changes of coordinates and velocities in proportion to themselves,
so that what is small beside nothing but itself keeps all its digits. Rates are known to that only, and
velocities are measured by what it changes them in a step.
"""

from __future__ import annotations

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.state import LANES, StateLayout
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.rounding_errors import WAYS, share
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.records import dataclass

FAINT = 2.0**-52
"""Velocities below this part of the fastest one may be rounding."""
SMOOTH = 0.8
"""Twice half a change may differ from the whole one by this part of it where it is smooth, a cubic even; not
across a jump, or close to a pole."""
LASTS = 32.0
"""For so many steps what was found holds."""


@dataclass(frozen=True)
class Noise:
    """Writes ``@noise(constants, t, state, work, trial)``, which writes down how much of each rate is rounding
    (as a term of the velocity's series), where velocities have third parts; 0 where none of them is faint.
    The first third part of the state counts the steps until it is ``due`` again.

    Coordinates and velocities change by the part ``size`` of them. Returns whether the series in ``%work`` are
    those of another state.
    """

    lengths: Lengths
    state: StateLayout
    size: float

    @property
    def place(self) -> int:
        """So many rows behind velocities."""
        return self.state.third

    @property
    def rounding(self) -> tuple[int, float]:
        """The same, and how often it is to be counted in what velocities are measured by: so that they are
        measured by all that terms of their rates, which may cancel, change in a step."""
        return self.place, 0.5 / self.size

    def function(self) -> Function:
        """The function."""
        names = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial"
        f = Function(f"define internal i1 @noise({names}) #0")
        suspicious = self._faint(f)
        with f.when(suspicious):
            self._measure(f)
        with f.when(~suspicious):
            self._clear(f)
        f.store(f.constant(LASTS), "%state", self.place)
        f.give(suspicious)
        return f

    def due(self, f: Function) -> Bit:
        """Whether it is to be called at the beginning of a step."""
        return f.load("%state", self.place) <= 0.0

    def count(self, f: Function) -> None:
        """Count a step that was taken."""
        f.store(f.load("%state", self.place) - 1.0, "%state", self.place)

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

    def _measure(self, f: Function) -> None:
        """The measurement."""
        lengths, width = self.lengths, self.state.width
        first = LANES * -(-(self.state.memory + 3 * width) // LANES)
        base, half, saved = (f.place("%trial", first + array * width) for array in range(3))
        with lengths.each(f) as row:
            row.put(row.at("%state"), saved)
        self._clear(f)
        self._expand(f)
        with lengths.velocities(f) as row:
            row.put(row.series()[1], base)
        with f.loop(0, WAYS, tested=False) as way:
            for size in (0.5 * self.size, self.size):
                with lengths.each(f) as row:
                    old = row.at(saved)
                    new = old + old * share(f, row, way) * size
                    row.put(f.select(row.among(0, 2 * lengths.degrees), new, old), "%state")
                self._expand(f)
                with lengths.velocities(f) as row:
                    change = row.series()[1] - row.at(base)
                    if size < self.size:
                        row.put(change, half)
                    else:
                        self._keep(row, row.at(half), change)
        with lengths.each(f) as row:
            row.put(row.at(saved), "%state")

    def _keep(self, row: Row, half: Real, whole: Real) -> None:
        """Keep the larger change, where rates are smooth."""
        f, change = row.f, row.f.magnitude(whole)
        steady = (f.magnitude((whole - half) - half) <= change * SMOOTH) & (change < ENDLESS)
        before = row.at("%state", self.place)
        counts = row.moving(steady) if self.lengths.together > 1 else steady
        row.put(f.select(counts, f.larger(change, before), before), "%state", self.place)

    def _clear(self, f: Function) -> None:
        with self.lengths.velocities(f) as row:
            before = row.at("%state", self.place)
            every = row.moving(f.splat(Bit(f, "true", 1), self.lengths.lanes))
            row.put(f.select(every, f.zero(self.lengths.lanes), before), "%state", self.place)

    def _expand(self, f: Function) -> None:
        given = (f.pointer(f"%{name}") for name in ("state", "work"))
        f.call(Bit, "jet", f.pointer("%constants"), Real(f, "%t"), *given)
