"""scipy's methods (Hairer, Norsett and Wanner's DOP853, Radau; BDF; LSODA) on the compiled equations.

The right-hand side is the compiled series' first stage; the implicit methods get the compiled Jacobian.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import scipy.integrate

from lagrange_cli.integrate.arrays import Array, aligned, chunk_size
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import NO_CHECKPOINTS, Accept, CheckpointSink, End, Interrupt
from lagrange_cli.integrate.methods.names import IMPLICIT
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.records import dataclass

STILL = 100
"""The number of consecutive steps without a change of t after which a method counts as stuck. (LSODA would go
on for ever.)"""


class Singular(ArithmeticError):
    """The mass matrix cannot be inverted here."""


class NotFinite(ArithmeticError):
    """The equations have no finite value here. (Some of scipy's solvers would go on for ever.)"""


@dataclass(frozen=True)
class Equations:
    """y' = f(t, y) for y = (q, v, integrals) of shape (rows,), on compiled code."""

    machine: Machine
    constants: Array
    work: Array

    @classmethod
    def of(cls, machine: Machine, parameters: Array) -> Equations:
        """The equations at the values ``parameters``."""
        constants = aligned(max(1, machine.program.constants))
        machine.prepare(np.ascontiguousarray(parameters).ctypes.data, constants.ctypes.data)
        return cls(machine, constants, aligned(machine.program.work))

    def rates(self, t: float, y: Array) -> Array:
        """y'; raises ``Singular`` or ``NotFinite``."""
        program, accelerate = self.machine.program, self.machine.accelerate
        layout = program.state
        state = np.zeros(layout.memory)
        state[: len(y)] = y
        result = np.empty(program.rows)
        result[layout.q] = y[layout.v]
        regular = accelerate(
            self.constants.ctypes.data,
            t,
            state.ctypes.data,
            self.work.ctypes.data,
            result[layout.rates].ctypes.data,
        )
        if not regular:
            raise Singular
        if not np.all(np.isfinite(result)):
            raise NotFinite
        return result

    def jacobian(self, t: float, y: Array) -> Array:
        """df/dy of shape (rows, rows); raises ``Singular``."""
        program, evaluate = self.machine.program, self.machine.linearize
        assert evaluate is not None
        n, layout = program.degrees, program.state
        states = np.concatenate([y[layout.motion], self.rates(t, y)[layout.v]])
        count = 3 * n * n + len(program.integrals) * 2 * n
        values, when = np.empty(count), np.array([t])
        evaluate(self.constants.ctypes.data, when.ctypes.data, states.ctypes.data, values.ctypes.data, 1, 1)
        by_q, by_v, mass = values[: 3 * n * n].reshape(3, n, n)
        result = np.zeros((layout.rows, layout.rows))
        result[layout.q, layout.v] = np.eye(n)
        try:
            result[layout.v, layout.motion] = -np.linalg.solve(mass, np.concatenate([by_q, by_v], axis=1))
        except np.linalg.LinAlgError as error:
            raise Singular from error
        result[layout.integrals, layout.motion] = values[3 * n * n :].reshape(-1, 2 * n)
        return result


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

    def follow(
        self,
        parameters: Array,
        state: Array,
        times: Times,
        accept: Accept,
        interrupt: Interrupt,
        checkpoints: CheckpointSink = NO_CHECKPOINTS,
    ) -> End:
        """See ``motion.Method``; ``evaluations`` counts accelerations."""
        equations = Equations.of(self.machine, parameters)
        collector = Collector(times, len(state), accept)
        t, y, steps, evaluations, still = times.start, state, 0, 0, 0
        ending, detail = Ending.COMPLETE, ""
        collector.take(t, lambda when: np.tile(state[:, None], len(when)))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # LSODA's; what went wrong is in its status
                solver = self._solver(equations, times, state)
                while solver.status == "running":
                    if interrupt(t):
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
        solvers: dict[str, Callable[..., scipy.integrate.OdeSolver]] = {
            "DOP853": scipy.integrate.DOP853,
            "Radau": scipy.integrate.Radau,
            "BDF": scipy.integrate.BDF,
            "LSODA": scipy.integrate.LSODA,
        }
        options = {"jac": equations.jacobian} if self.name in IMPLICIT else {}
        return solvers[self.name](
            equations.rates,
            times.start,
            state,
            times.stop,
            rtol=self.tolerance,
            atol=self.tolerance,
            **options,
        )
