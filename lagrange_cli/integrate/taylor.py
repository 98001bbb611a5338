"""The Taylor method: compiled code steps and samples, this module hands it buffers."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.motion import Accept, Array, End, Interrupted, aligned, chunk_size
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.layout import LANES
from lagrange_cli.native.machine import Machine
from lagrange_cli.native.stepper import Stop

ENDINGS = {
    Stop.END: Ending.COMPLETE,
    Stop.SINGULAR: Ending.SINGULAR_MASS_MATRIX,
    Stop.NOT_FINITE: Ending.NOT_A_NUMBER,
    Stop.UNDERFLOW: Ending.STEP_UNDERFLOW,
}
BREATH = 0.05
"""Seconds of machine code between two looks at the interrupt flag, about."""


@dataclass(frozen=True)
class TaylorMethod:
    """Follows a motion by its Taylor series (``native.stepper``); the steps do not depend on the sample
    times."""

    machine: Machine

    def follow(
        self, parameters: Array, state: Array, times: Times, accept: Accept, interrupted: Interrupted
    ) -> End:
        """See ``motion.Method``; ``evaluations`` counts series, one a step."""
        program, advance = self.machine.program, self.machine.advance
        assert advance is not None
        rows = program.rows
        constants = aligned(max(1, program.constants))
        self.machine.prepare(np.ascontiguousarray(parameters).ctypes.data, constants.ctypes.data)
        memory, work, trial = aligned(2 * rows + 3), aligned(program.work), aligned(program.trial)
        memory[:rows], memory[2 * rows] = state, times.start
        info = np.zeros(2, dtype=np.int64)
        size = min(chunk_size(rows + len(program.observed)), times.count)
        samples = np.empty((rows, size + LANES))
        first, steps, pause = 0, 0, 256
        while True:
            wanted = times.chunk(first, size)
            padded = np.concatenate([wanted, np.full(LANES, np.nan)])
            last = first + len(wanted) == times.count
            done = 0
            while True:
                began = time.perf_counter()
                stop = Stop(
                    advance(
                        constants.ctypes.data, memory.ctypes.data, work.ctypes.data, trial.ctypes.data,
                        times.stop,
                        padded.ctypes.data + 8 * done, len(wanted) - done, samples.ctypes.data + 8 * done,
                        samples.shape[1], last, pause, info.ctypes.data,
                    )
                )  # fmt: skip
                done, steps = done + int(info[0]), steps + int(info[1])
                if stop is not Stop.PAUSE:
                    break
                if interrupted():
                    accept(wanted[:done], samples[:, :done])
                    return End(
                        Ending.INTERRUPTED, float(memory[2 * rows]), memory[:rows].copy(), steps, steps
                    )
                spent = time.perf_counter() - began
                pause = int(max(64, min(4 * pause, pause * BREATH / max(spent, 1e-6))))
            accept(wanted[:done], samples[:, :done])
            if stop is not Stop.SAMPLES:
                return End(ENDINGS[stop], float(memory[2 * rows]), memory[:rows].copy(), steps, steps)
            if interrupted():  # the step that holds the last sample began before it
                return End(Ending.INTERRUPTED, float(wanted[-1]), samples[:, done - 1].copy(), steps, steps)
            first += len(wanted)
