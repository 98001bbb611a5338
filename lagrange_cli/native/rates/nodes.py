"""Rates at the nodes of a step: where states are written, and what is computed there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.rates.places import EVALUATIONS, Places
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.acceptance import DOUBLE
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.motion import Steps
from lagrange_cli.native.stepping.sums import DoubleSums


class RatesAtNodes(DoubleSteps):
    """Steps that take rates at ``places`` of ``%work``. The rates are those of a function that leaves series
    side by side, order after order, in its own part of ``%work``. Steps can be taken again (``retried``)."""

    order: int
    """The degree of q's polynomials."""

    def __init__(self, given: Given, lengths: Lengths, places: Places) -> None:
        Steps.__init__(self, given, lengths, DOUBLE, DoubleSums(), 0.0)
        self.quadratures = None  # integrals are followed as velocities are
        self._places = places
        self._count = given.state.rows - given.state.degrees

    def _evaluate(self, f: Function, t: Real, state: Pointer, work: Pointer) -> tuple[Pointer, Bit]:
        """The rates of a state, and whether they are regular."""
        at = f.place(work, self._places.jet, "double")
        good = f.call(Bit, self.given.rates, f.pointer("%constants"), t, state, at)
        return self.rates(f), good

    def rates(self, f: Function) -> Pointer:
        """Where rates are that have been computed."""
        return f.place("%work", self._places.jet + self.state.width + self.state.degrees, "double")

    def called(self, f: Function, name: str, *arguments: Real) -> None:
        """A call of a function without a result."""
        f.call(None, name, *f.pointers("constants", "state", "work"), *arguments)

    @contextmanager
    def _each(self, f: Function, count: int) -> Iterator[Integer]:
        """Vectors of so many rows."""
        with f.loop(0, count, self.lengths.lanes, tested=False) as i:
            yield i

    def node(self, f: Function, t: Real) -> tuple[Pointer, Bit]:
        """The rates at the state that has been written, and whether they are regular."""
        at, width, work = self._places, self.state.width, f.pointer("%work")
        f.copy_rows((work, at.low), (work, at.state + width), width, self.lengths.lanes)
        return self._evaluate(f, t, f.place(work, at.state, "double"), work)

    def put_state(self, f: Function, row: Integer, change: Real, rest: Real) -> None:
        """Write some rows of the state at a node."""
        at, lanes = self._places, self.lengths.lanes
        high, error = two_sum(f.load_row("%state", row, lanes), change + rest)
        f.store_row(high, "%work", row + at.state)
        f.store_row(error, "%work", row + at.low)

    def retried(self, f: Function, exact: Real) -> Real:
        """The step once more, with that length; 0 if there is none (``@tried`` of ``rates.trials``)."""
        return f.call(Real, "tried", *f.pointers("constants", "state", "work"), exact)

    def now(self, f: Function) -> Real:
        """The time where the step begins."""
        t, low = (f.load("%state", self.state.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        return t + low

    def spend(self, f: Function, evaluations: Real) -> None:
        """Count evaluations of rates."""
        place = self._places.chosen + EVALUATIONS
        f.store(f.load("%work", place) + evaluations, "%work", place)

    def _among(self, f: Function, i: Integer, count: int) -> Bit:
        return Row(self.lengths, f, i).among(0, count)

    def _fastest(self, f: Function) -> Real:
        """The largest velocity, relative to 1 + the size of its coordinate."""
        degrees, lanes = self.lengths.degrees, self.lengths.lanes
        fastest = f.variable(f.zero(lanes))
        with self._each(f, degrees) as i:
            q, v = (f.magnitude(f.load_row("%state", i + shift, lanes)) for shift in (0, degrees))
            speed = f.select(self._among(f, i, degrees), v / (q + 1.0), f.zero(lanes))
            fastest.set(f.larger(speed, fastest.get()))
        return f.reduce("fmax", fastest.get())
