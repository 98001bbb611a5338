"""scipy's BDF and LSODA on the compiled equations, whose Jacobian is compiled, too."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import scipy.integrate

from lagrange_cli.integrate.arrays import Array, chunk_size
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import UNOBSERVED, Accept, End, Observer, Start
from lagrange_cli.integrate.methods.equations import Equations, Singular
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.records import dataclass

STILL = 100
"""The number of consecutive steps without a change of t after which a method counts as stuck. (LSODA would go
on for ever.)"""


CREEPS, PACE = 2_000, 1e-6
"""A method that advances by less than this part of the whole time in so many steps does not get through."""


class Collector:
    """Gathers samples into chunks for ``accept``."""

    def __init__(self, times: Times, rows: int, accept: Accept) -> None:
        self._times, self._accept = times, accept
        self._size = min(chunk_size(rows), times.count)
        self._buffer = np.empty((rows, self._size))
        self._first, self._filled = 0, 0
        self._wanted = times.chunk(0, self._size)

    def take(self, until: float, interpolate: Callable[[Array], Array]) -> None:
        """Add the samples up to ``until``; ``interpolate(times (c,))`` gives states (rows, c)."""
        while len(self._wanted):
            stop = int(np.searchsorted(self._wanted, until, side="right"))
            if stop > self._filled:
                chosen = slice(self._filled, stop)
                self._buffer[:, chosen] = interpolate(self._wanted[chosen])
                self._filled = stop
            if self._filled < len(self._wanted):
                return
            self.flush()

    def flush(self) -> None:
        """Hand over the present chunk and begin the next one."""
        self._accept(self._wanted[: self._filled], self._buffer[:, : self._filled])
        self._first += self._filled
        self._filled = 0
        self._wanted = self._times.chunk(self._first, self._size)
        self._buffer = np.empty_like(self._buffer)  # the one handed over may still be in use


@dataclass(frozen=True)
class ScipyMethod:
    """Integrates a motion with one of scipy's step-by-step solvers and its dense output."""

    machine: Machine
    name: str
    tolerance: float

    def follow(self, start: Start, observer: Observer = UNOBSERVED, threads: int | None = 1) -> End:
        """See ``integrate.method.Method``; ``evaluations`` counts accelerations."""
        equations = Equations.of(self.machine, start.parameters)
        state, times = start.state, start.times
        collector = Collector(times, len(state), observer.samples)
        t, y, steps, evaluations, still = times.start, state, 0, 0, 0
        mark, least = t, PACE * abs(times.stop - times.start)
        ending, detail = Ending.COMPLETE, ""
        collector.take(t, lambda when: np.tile(state[:, None], len(when)))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # LSODA's; what went wrong is in its status
                solver = self._solver(equations, times, state)
                while solver.status == "running":
                    if observer.interrupt(t):
                        ending = Ending.INTERRUPTED
                        break
                    message = solver.step()
                    steps, evaluations = steps + 1, solver.nfev
                    if message is not None:
                        ending, detail = Ending.METHOD_FAILED, message.rstrip(".")
                        break
                    still = still + 1 if solver.t == t else 0
                    if still > STILL:
                        ending, detail = Ending.METHOD_FAILED, "its steps are below the resolution of time"
                        break
                    if steps % CREEPS == 0:
                        if abs(solver.t - mark) < least:
                            ending, detail = Ending.METHOD_FAILED, "its steps become too short"
                            break
                        mark = solver.t
                    if not np.all(np.isfinite(solver.y)):
                        ending = Ending.NOT_A_NUMBER
                        break
                    t, y = float(solver.t), solver.y
                    collector.take(t, solver.dense_output())
        except Singular:
            ending = Ending.SINGULAR_MASS_MATRIX
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
            ending, detail = Ending.NOT_A_NUMBER, str(error)
        collector.flush()
        return End(ending, t, np.array(y), steps, evaluations, detail)

    def _solver(self, equations: Equations, times: Times, state: Array) -> scipy.integrate.OdeSolver:
        solver: Callable[..., scipy.integrate.OdeSolver] = getattr(scipy.integrate, self.name)
        options = {} if self.machine.linearize is None else {"jac": equations.jacobian}
        return solver(
            equations.rates,
            times.start,
            state,
            times.stop,
            rtol=self.tolerance,
            atol=self.tolerance,
            **options,
        )


def follower(
    machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None
) -> ScipyMethod:
    """The solver of scipy that has the method's name; better code than this would make no difference."""
    return ScipyMethod(machine, compilation.method, compilation.tolerance)
