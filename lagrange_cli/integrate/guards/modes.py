"""Modes of guards in the memory of a motion's state, and the series of arguments where the motion is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.latest import Latest
from lagrange_cli.integrate.workspace import Accelerated
from lagrange_cli.native.guards import FOUND, SMALLEST
from lagrange_cli.native.state import BEGINNING, Clock

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

DERIVATIVES = FOUND - 2
"""The number of derivatives of arguments that are examined."""
ORDERS = np.arange(1, DERIVATIVES + 2)
SEEN = 2
"""So many series are kept: the present ones, and those of an attempt at other modes."""
ROUNDING = 2.0**-44
"""A derivative that is so small beside the terms of the others is a rounding error."""


class Modes:
    """The modes and marks of switches, then those of events and contacts.

    ``constants``, ``memory`` and ``work`` are the arrays that compiled code works on.
    """

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        self.machine = machine
        program = machine.program
        self.constants, self.memory, self._work = constants, memory, work
        self._layout, self._rows = program.inner, program.rows_of_guards
        first, count = self._rows.mode(self._layout), self._rows.count
        self.modes = memory[first : first + count]
        marks = self._rows.fresh(self._layout)
        self.marks = memory[marks : marks + count]
        self.count = len(program.guards)
        self._accelerated = Accelerated(machine, constants, memory, work)
        self._seen, self._key = Latest["Array"](SEEN), b""
        self._given = self._views()
        """What series depend on."""
        settings = memory[self._layout.settings]
        self._at = settings.ctypes.data, constants.ctypes.data
        """Where parameters, modes and constants are."""
        self.last_step = np.zeros(1)
        """The length of the last step, from when steps begin anew."""
        first, step, term = program.series_at
        start = first + step * self._layout.v.start + term
        shape, strides = (self._layout.rows - self._layout.v.start, len(ORDERS)), (8 * step, 8 * term)
        self._integrals = np.ndarray(shape, np.float64, work, 8 * start, strides)
        """Where the first coefficients of the rows behind the coordinates are (rows, orders)."""
        self._beginning = np.array([self._layout.at(one) for one in BEGINNING])

    def _views(self) -> list[Array]:
        """The parts of the memory on which series depend: coordinates and velocities, t, parameters, and all
        modes but those of events."""
        layout, rows, parts = self._layout, self._rows, self.machine.program.parts
        starts = (0, layout.width, layout.third)[: 1 + parts]
        places = [slice(start, start + layout.motion.stop) for start in starts]
        if layout.cyclic:
            momenta = layout.cyclic_momenta
            places += [slice(start + momenta.start, start + momenta.stop) for start in starts]
        places.append(slice(layout.at(Clock.TIME), layout.at(Clock.TIME_LOW) + 1))
        first, width = layout.settings.start, rows.parameters + rows.count
        for part in range(self.machine.program.given):
            places.append(slice(first + part * width, first + part * width + rows.parameters))
        modes = rows.mode(layout)
        resting = modes + self.count + len(self.machine.program.events)
        places += [slice(modes, modes + self.count), slice(resting, modes + rows.count)]
        return [self.memory[one] for one in places if one.stop > one.start]

    def given(self) -> bytes:
        """What series depend on now, to the last bit."""
        return b"".join([one.tobytes() for one in self._given])

    def set_parameters(self, parameters: Array) -> None:
        """Put the parameters of the run (all high parts, then all low ones) beside the modes."""
        parts = self.machine.program.given
        settings = self.memory[self._layout.settings]
        width = self._rows.parameters + self._rows.count
        for part, given in enumerate(parameters.reshape(parts, -1)):
            settings[part * width : part * width + self._rows.parameters] = given

    def mark(self, guards: Sequence[int]) -> None:
        """The arguments of these are 0 now."""
        self.marks[list(guards)] = max(self.memory[self._layout.at(Clock.LENGTH)], SMALLEST)

    def length(self) -> float:
        """The length of the last step, also where others begin: if compiled code has begun them, as far as
        that led."""
        now, led = (float(self.memory[self._layout.at(one)]) for one in (Clock.STEP, Clock.LENGTH))
        return now or float(self.last_step[0]) or led

    def begin_steps(self) -> None:
        """Forget what steps before tell of the next one."""
        self.last_step[0] = self.length()
        self.memory[self._beginning] = 0.0

    def prepare(self) -> None:
        """Compute the constants of the equations from parameters and modes."""
        self.machine.prepare(*self._at)

    def _series(self) -> Array:
        """The series from here on; the rates of velocities and integrals."""
        key = self.given()
        if key != self._key:
            self.prepare()
            self._here, self._key = self._seen.of(key, self._see), key  # an attempt at other modes, and back
        return self._here[:, 0]

    def _see(self) -> Array:
        """The first coefficients of the integrands of the rows behind the coordinates (rows, orders)."""
        self._accelerated.rates(self.machine)
        found: Array = self._integrals * ORDERS
        return found

    def _arguments(self) -> Array:
        """The values of all guards' arguments."""
        self._series()
        found: Array = self._coefficients_of_arguments()[:, 0]
        return found

    def _coefficients(self, row: int) -> Array:
        """The first Taylor coefficients of the integrand of a row, beginning with its value."""
        found: Array = self._coefficients_of(row, row + 1)[0]
        return found

    def _coefficients_of(self, start: int, stop: int) -> Array:
        """Those of some rows behind the coordinates (rows, coefficients), where ``_series`` was called
        last."""
        first = self._layout.v.start
        return self._here[start - first : stop - first]

    def _coefficients_of_arguments(self) -> Array:
        """Those of the arguments of switches."""
        return self._coefficients_of(self._rows.first, self._rows.first + self.count)

    def coefficients_of(self, *rows: int) -> list[Array]:
        """The coefficients of rows at the present place of the motion."""
        self._series()
        return [self._coefficients(row) for row in rows]

    def values_of(self, rows: NDArray[np.intp]) -> Array:
        """The rates of some rows."""
        self._series()
        found: Array = self._here[rows - self._layout.v.start, 0]
        return found

    def coefficients_between(self, start: int, stop: int) -> Array:
        """The same of the rows from one to before another (rows, coefficients)."""
        self._series()
        return self._coefficients_of(start, stop)

    def accelerations(self) -> Array:
        """Those of the coordinates."""
        return self._series()[: self.machine.program.degrees]

    def scale(self) -> Array:
        """The largest coefficients of each order among velocities: the scale for rounding errors of a
        derivative."""
        found = np.zeros(len(ORDERS) + 1)
        velocities = self._coefficients_of(self._layout.v.start, self._layout.v.stop)
        np.abs(velocities).max(axis=0, out=found[1:])
        return found
