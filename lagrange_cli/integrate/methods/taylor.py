"""The Taylor method: a motion in chunks of samples, with checkpoints, to its end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lagrange_cli.integrate.arrays import Array, chunk_size
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import UNOBSERVED, End, Observer, Snapshot, Start
from lagrange_cli.integrate.methods.compiled import CompiledEquations, Recompilation
from lagrange_cli.integrate.methods.stepper import Stepper
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import Stop
from lagrange_cli.records import dataclass, replace

ENDINGS = {
    Stop.END: Ending.COMPLETE,
    Stop.SINGULAR: Ending.SINGULAR_MASS_MATRIX,
    Stop.NOT_FINITE: Ending.NOT_A_NUMBER,
    Stop.UNDERFLOW: Ending.STEP_UNDERFLOW,
    Stop.GUARD: Ending.STEP_UNDERFLOW,
    Stop.CRAWL: Ending.CRAWLING,
    Stop.STUCK: Ending.STUCK,
}
GREAT = 1e280
"""If coordinates or velocities are as large as this, coefficients of their series overflow."""


@dataclass(frozen=True)
class TaylorMethod(CompiledEquations):
    """Follows a motion by its Taylor series (``native.stepping``); steps do not depend on sample times."""

    def follow(self, start: Start, observer: Observer = UNOBSERVED, threads: int | None = 1) -> End:
        """See ``integrate.method.Method``; ``evaluations`` counts series, one a step."""
        program, times = self.machine.program, start.times
        size = min(chunk_size(program.parts * (program.rows + len(program.observed))), times.count)
        stepper = Stepper(self, start, size, observer)
        with stepper.heard(), stepper.helped(threads):
            return self._follow(stepper, size, times, observer)

    def _follow(self, stepper: Stepper, size: int, times: Times, observer: Observer) -> End:
        program, checkpoints, first = self.machine.program, observer.checkpoints, 0
        if checkpoints.begin is not None:
            first = checkpoints.begin.samples
            stepper.restore(checkpoints.begin)
        halted = False

        def end(ending: Ending, t: float, state: Array, detail: str = "", at: Snapshot | None = None) -> End:
            found = End(ending, t, state, stepper.steps, stepper.evaluations, detail, at)
            done = {"projections": stepper.projections, "singular": stepper.singular}
            return replace(found, **done, threads=stepper.threads)

        def halt(t: float) -> bool:
            nonlocal halted
            halted = halted or observer.interrupt(t)
            return halted

        def pause(t: float) -> bool:
            due = checkpoints.due(stepper.steps)
            return halt(t) or due

        while True:
            # chunks end at the same samples wherever the motion has paused, or a run continues an earlier one
            wanted = times.chunk(first, size - first % size)
            last = first + len(wanted) == times.count
            before_end = last and checkpoints.ends is not None and program.parts == 1 and len(wanted) > 0
            stop, done = stepper.fill(wanted, first, last and not before_end, pause, halt)
            first += done
            samples = stepper.space.taken(done)
            if before_end and stop is Stop.SAMPLES:
                kept = int(np.count_nonzero(stepper.space.passed(wanted)))
                observer.samples(wanted[:kept], samples[:, :kept])
                begin = first - done
                known = kept > 0 or begin == 0 or bool(stepper.space.passed(times.chunk(begin - 1, 1))[0])
                snapshot = stepper.snapshot(begin + kept)
                if checkpoints.ends is not None and known and not stepper.limited:
                    checkpoints.ends(snapshot)
                wanted, samples, done = wanted[kept:], samples[:, kept:], done - kept
                stop, _ = stepper.fill(wanted[done:], first, True, pause, halt)
                while stop is Stop.PAUSE:  # the end is near; a run that goes on has to come by here, too
                    if halted and stepper.at(snapshot):
                        return end(Ending.INTERRUPTED, snapshot.t, stepper.space.state, at=snapshot)
                    stop, _ = stepper.fill(wanted[done:], first, True, pause, halt)
            observer.samples(wanted[:done], samples)
            if stepper.finished is not None:
                ending, detail = stepper.finished.ending, stepper.finished.detail
                ended = end(ending, stepper.space.t, stepper.space.state, detail)
                return stopped(ended, stepper.accelerations()) if ending is Ending.EDGE else ended
            if stop is Stop.NOT_FINITE and stepper.finite():
                stop = (
                    Stop.UNDERFLOW
                )  # the equations are, but a singularity is so near that the series is not
            if stop in ENDINGS:
                ending = ENDINGS[stop]
                if ending is Ending.STEP_UNDERFLOW and stepper.touching():
                    ending = Ending.TOUCHING
                ended = end(ending, stepper.space.t, stepper.space.state)
                return ended if stop is Stop.END else stopped(ended, stepper.accelerations())
            if stop is Stop.PAUSE or pause(stepper.space.t):
                snapshot = stepper.snapshot(first)
                if halted:
                    t, state = stepper.space.t, stepper.space.state
                    if stop is not Stop.PAUSE:  # the step that holds the last sample began before it
                        t, state = float(wanted[-1]), samples[:, -1].copy()
                    return end(Ending.INTERRUPTED, t, state, at=snapshot)
                checkpoints.keep(snapshot)
            stepper.space.swap()


def stopped(end: End, accelerations: Array) -> End:
    """The end of a motion that could not go on."""
    largest = np.fmax.reduce(np.abs(end.state))
    if end.ending in (Ending.STEP_UNDERFLOW, Ending.NOT_A_NUMBER, Ending.STUCK) and largest > GREAT:
        return replace(end, ending=Ending.OVERFLOW)
    return replace(end, accelerations=accelerations)


def follower(
    machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None
) -> TaylorMethod:
    """The method on a compiled program; ``improve`` makes better code for a long run, if any."""
    return TaylorMethod(machine, compilation.tolerance, None if improve is None else Recompilation(improve))
