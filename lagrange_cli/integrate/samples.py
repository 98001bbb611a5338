"""Samples of double-double numbers: every dataset twice: the nearest doubles, and the remainders under
``low/``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.integrate.run import Samples
from lagrange_cli.native.interface import low
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import Array

LOW = "low/"


@dataclass(frozen=True)
class DoubleDouble:
    """Numbers, each the sum of two doubles (c,) or of two for all."""

    high: Array
    low: Array

    def __add__(self, other: DoubleDouble) -> DoubleDouble:
        high, error = two_sum(self.high, other.high)
        low, rest = two_sum(self.low, other.low)
        high, error = two_sum(high, error + low)
        return DoubleDouble(*two_sum(high, error + rest))

    def __sub__(self, other: DoubleDouble) -> DoubleDouble:
        return self + DoubleDouble(-other.high, -other.low)


def two_sum(a: Array, b: Array) -> tuple[Array, Array]:
    """a + b and its rounding error (Knuth, TAOCP 2, sec. 4.2.2)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


class DoubleDoubleSamples(Samples):
    """What ``Samples`` does, for states (2 rows, c) whose low parts follow all high ones."""

    def accept(self, times: Array, states: Array) -> None:
        if not len(times):
            return
        program, recording = self._prepared.machine.program, self._prepared.recording
        flat = self._observe(times, states)
        if not self._first:
            self._first = {name: float(row[0]) for name, row in flat.items()}
        observed = {name: DoubleDouble(flat[name], flat[low(name)]) for name in program.observed}
        first = {
            name: DoubleDouble(np.array(self._first[name]), np.array(self._first[low(name)]))
            for name in observed
        }
        with np.errstate(invalid="ignore"):
            for name, drift in self._drift.items():
                self._drift[name] = max(drift, float(np.max(np.abs((observed[name] - first[name]).high))))
        self._measure(flat, states)
        high, beyond = np.split(states, [program.rows])
        begin = 2 * program.degrees
        quadratures = {
            name: DoubleDouble(high[begin + i], beyond[begin + i]) for i, name in enumerate(program.integrals)
        }
        chunk: dict[str, Any] = {"t": times}
        for prefix, part in (("", high), (LOW, beyond)):
            chunk |= {prefix + path: row for path, row in recording.state_series(part).items()}
        for made in recording.made:
            rows = made.parts(observed, quadratures, first)
            chunk[made.path] = made.shaped([row.high for row in rows])
            chunk[LOW + made.path] = made.shaped([row.low for row in rows])
        self._emit(chunk)
