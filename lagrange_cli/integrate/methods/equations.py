"""The equations of motion as y' = f(t, y) on compiled code, for methods that ask for rates.

The right-hand side is the compiled series' first stage; implicit methods get the compiled Jacobian.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.integrate.arrays import Array, aligned, at_one_state
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.records import dataclass


class Singular(ArithmeticError):
    """The mass matrix cannot be inverted here."""


class NotFinite(ArithmeticError):
    """The equations have no finite value here. (Some of scipy's solvers would never end.)"""


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
        values = at_one_state(evaluate, self.constants, np.array([t]), states, count)
        by_q, by_v, mass = values[: 3 * n * n].reshape(3, n, n)
        result = np.zeros((layout.rows, layout.rows))
        result[layout.q, layout.v] = np.eye(n)
        try:
            result[layout.v, layout.motion] = -np.linalg.solve(mass, np.concatenate([by_q, by_v], axis=1))
        except np.linalg.LinAlgError as error:
            raise Singular from error
        result[layout.integrals, layout.motion] = values[3 * n * n :].reshape(-1, 2 * n)
        return result
