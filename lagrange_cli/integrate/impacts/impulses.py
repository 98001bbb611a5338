"""Impulses of the forces of constraint: a state that an action has set is moved back to the constraints.

The values that the action has set stay; the others change as little as possible in the metric of the masses.
For velocities these are the impulses of the forces of constraint (E. T. Whittaker, Analytical Dynamics, 4th
ed. 1937, ch. IX): M dv = A^T lambda in all directions that the action has left free. Where the constraints
do not allow all velocities that were set, impulses change these, too; coordinates do not jump elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import at_one_state, largest_of
from lagrange_cli.integrate.impacts.refinement import added, chosen, refined
from lagrange_cli.integrate.impacts.sparse_impulses import ENOUGH
from lagrange_cli.native.guards import DONE
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.guards.settling import Settling

MOST = 60
"""The largest number of steps of Newton's method that move a state to the constraints."""
NEAR = 2.0**-40
"""Deviations up to this fraction of the state are left to ``@project``."""
FEW = 64
"""Constraints up to which the matrix is a dense one."""
PATIENCE = 4
"""Where the state is not found to the last digit after so many steps, rounding may change it for ever: then
changes do not become smaller."""
EXACT = 2.0**-44
"""What elimination leaves is rounding if it is this part of what constraints are off by."""
MET = 2.0**-20
"""The part that is left at most of what constraints were off by, where a state is moved far to them."""
SLIGHTLY = 1e-6
"""Coordinates that were set are moved by this fraction of the state at most, as initial values are."""


def least_change(masses: Array, slopes: Array, off: Array, free: Sequence[int]) -> Array | None:
    """The least change of what is ``free``, in the metric of the ``masses``, by which constraints with these
    ``slopes`` get the values that they are ``off`` by; None where elimination does not find it to the last
    digits."""
    own, diagonal = slopes[:, free], np.diagonal(masses)
    alone = np.count_nonzero(masses) == np.count_nonzero(diagonal) == len(masses)
    try:
        along = own.T / diagonal[free, None] if alone else np.linalg.solve(masses[np.ix_(free, free)], own.T)
        found: Array = along @ np.linalg.solve(own @ along, off)
    except np.linalg.LinAlgError:
        return None
    left = largest_of(off - own @ found)
    return found if left <= EXACT * largest_of(off) else None


def least_squares(matrix: Array, right: Array) -> Array:
    """The shortest solution of equations, some of which may depend on others."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], np.float64)


class Impulses:
    """Moves the state in the memory of ``settling`` to the constraints."""

    def __init__(self, settling: Settling) -> None:
        self._settling, self._memory = settling, settling.memory
        self._program, self._layout = settling.machine.program, settling.machine.program.inner

    def close(self, event: int, rows: NDArray[np.intp], sets: Sequence[tuple[int, int]]) -> bool:
        """Go on from the state at ``rows`` of the memory, where what the action of an ``event`` has set, the
        numbers and places ``sets``, is to stay as it is; whether that leads to the constraints."""
        changed = {place for _, place in sets}
        if self._settling.machine.project is None or self._untouched(changed):
            return True
        if self._pushed(self._memory, event, sets):
            return True
        program, degrees = self._program, self._program.degrees
        before = self._memory[[part * self._layout.width + rows for part in range(program.parts)]]
        state, once = before[:, : program.rows].copy(), program.parts == 1
        speeds = all(degrees <= row < 2 * degrees for row in changed)
        for part, first in ((1, degrees),) if speeds and changed else ((0, 0), (1, degrees)):
            own = slice(first, first + degrees)
            free = [row - first for row in range(first, first + degrees) if row not in changed]
            for _ in range(MOST):
                moved = self._step(state, part, free)
                state[:, own] = added(state[:, own], moved)
                if (part and once) or not largest_of(moved[0]) > NEAR**program.parts * largest_of(state[0]):
                    break  # of velocities, constraints are linear
            new = np.any(state[:, own] != before[:, own], axis=0)
            self._put(rows[own][new], state[:, own][:, new])
        coordinates = before[0, :degrees]
        return self._met(before[0], state[0]) and self._polished() and self._stay(coordinates, rows, changed)

    def impulse(self, state: Array, event: int, sets: Sequence[tuple[int, int]]) -> Array:
        """The changes of velocities by forces of constraint in a ``state`` in which some were set as by the
        action of an ``event``, but for rounding."""
        n, changed = self._program.degrees, {place for _, place in sets}
        if self._settling.machine.project is None or self._untouched(changed):
            return np.zeros(n)
        if self._settling.machine.push is not None:
            memory = self._memory.copy()
            memory[: 2 * n] = state[: 2 * n]
            if self._pushed(memory, event, sets):
                return np.asarray(memory[n : 2 * n] - state[n : 2 * n])
        free = [row - n for row in range(n, 2 * n) if row not in changed]
        return np.asarray(self._step(state[None, : self._program.rows], 1, free)[0])

    def _pushed(self, memory: Array, event: int, sets: Sequence[tuple[int, int]]) -> bool:
        """Whether compiled code gives a state its impulses after the action of an ``event``, to the last
        digit."""
        program, push = self._program, self._settling.machine.push
        if push is None or not all(program.degrees <= place < 2 * program.degrees for _, place in sets):
            return False
        values, speeds = np.empty(len(program.changed)), np.empty(len(program.bounces))
        for number, place in sets:
            values[number] = memory[place]
        arrays = self._settling.constants, memory, values, speeds
        return bool(push(*(one.ctypes.data for one in arrays), event) == DONE)

    def _met(self, state: Array, high: Array) -> bool:
        """Whether a state that was moved far satisfies constraints much better: Newton's method may end where
        their slopes are 0."""
        degrees = self._program.degrees
        far = np.max(np.abs(high - state[: len(high)])[:degrees], initial=0.0)
        if not far > SLIGHTLY * largest_of(state[:degrees]):
            return True
        return self._off(high) <= MET * self._off(state[: len(high)])

    def _off(self, high: Array) -> float:
        """By how much constraints are not satisfied."""
        return largest_of(self._evaluated(high[None, :])[0, : self._program.constraints])

    def _untouched(self, changed: Collection[int]) -> bool:
        """Whether the rows ``changed`` are velocities that none of many constraints contains."""
        n = self._program.degrees
        if self._program.constraints <= FEW or not all(n <= row < 2 * n for row in changed):
            return False
        rows, columns = self._program.places
        return not np.isin([row - n for row in changed], columns[rows >= n]).any()

    def _stay(self, coordinates: Array, rows: NDArray[np.intp], changed: Collection[int]) -> bool:
        """Whether the ``coordinates`` that were set are still where the action has put them."""
        scale = SLIGHTLY * largest_of(coordinates)
        own = [row for row in changed if row < len(coordinates)]
        return all(abs(self._memory[rows[row]] - coordinates[row]) <= scale for row in own)

    def _put(self, rows: NDArray[np.intp], values: Array) -> None:
        for start in (self._layout.width, self._layout.third):
            self._memory[start + rows] = 0.0
        for part, own in enumerate(values):
            self._memory[part * self._layout.width + rows] = own

    def _step(self, state: Array, part: int, free: list[int]) -> Array:
        """A step of Newton's method for the coordinates (part 0) or velocities (part 1): the change (parts,
        n) of those that are ``free``, or of all where that is not enough."""
        program = self._program
        count, degrees = program.constraints, program.degrees
        found = self._evaluated(state)
        off, entries = found[0, part * count : (part + 1) * count], found[:, 2 * count :]
        if count > FEW:
            from lagrange_cli.integrate.impacts.sparse_impulses import sparse_step

            change = sparse_step(program, entries, off, (free, range(degrees)))
            if change is not None:
                return change
        matrix = np.zeros((degrees + count,) * 2)
        matrix[tuple(program.places)] = entries[0]
        change = np.zeros((program.parts, degrees))
        if program.parts == 1:
            least = least_change(matrix[:degrees, :degrees], matrix[degrees:, :degrees], off, free)
            if least is not None:
                change[0, free] = least
                return change
        right = np.concatenate([np.zeros(degrees), off])
        for some in (free, range(degrees)):
            kept = [*some, *range(degrees, degrees + count)]
            solve = partial(least_squares, matrix[np.ix_(kept, kept)])
            if program.parts == 1:
                solution = solve(right[kept])[None, :]
            else:
                there, places = chosen(kept, program.places, len(right))
                solution = refined(solve, entries[:, there], places, right[kept])
            change[:] = 0.0
            change[:, [*some]] = solution[:, : len(some)]
            left = off - matrix[degrees:, :degrees] @ change[0]
            if not largest_of(left) > ENOUGH * largest_of(off):
                break
        return change

    def _evaluated(self, known: Array) -> Array:
        """Constraints, their rates, and the entries of the matrix of the equations, at a state (parts, rows),
        of which the high part alone may be known."""
        machine, program = self._settling.machine, self._program
        assert machine.constrain is not None
        count = program.parts * (2 * program.constraints + len(program.pattern))
        state = np.zeros((program.parts, program.rows))
        state[: len(known)] = known[:, : program.rows]
        when = self._memory[[self._layout.at(part) for part in (Clock.TIME, Clock.TIME_LOW)]]
        found = at_one_state(machine.constrain, self._settling.constants, when, state.ravel(), count)
        return found.reshape(program.parts, -1)

    def _polished(self) -> bool:
        """Newton's method to the last digit; whether it ends, but for rounding."""
        memory, place = self._memory, self._layout.at(Clock.PROJECTIONS)
        project, count = self._settling.machine.project, float(memory[place])
        assert project is not None
        n = self._program.degrees
        parts, last = (slice(0, n), slice(n, 2 * n)), [np.inf, np.inf]
        for k in range(MOST):
            before, state = float(memory[place]), memory[: 2 * n].copy()
            project(self._settling.constants.ctypes.data, memory.ctypes.data)
            changes = [largest_of(memory[one] - state[one]) for one in parts]
            sizes = [largest_of(state[one]) for one in parts]
            noise = k >= PATIENCE and all(
                change <= NEAR * size and not 0.0 < change < 0.5 * earlier
                for change, size, earlier in zip(changes, sizes, last)
            )
            if memory[place] == before or noise:
                memory[place] = count
                return True
            last = changes
        return False
