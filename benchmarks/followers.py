"""Engines for one system at one tolerance: functions that integrate the motion, ready to be timed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.motions import Functions, System
from lagrange_cli import GraphAlgebra, build_model, derive, prepare, read_spec, resolve_values
from lagrange_cli.cli.shipped import text
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.run.settings import DEFAULT_OUTPUTS
from lagrange_cli.work_precision.reference import TOLERANCES, Reference, find_reference
from lagrange_cli.work_precision.trajectory import Followed, follow

Array = NDArray[np.float64]
SAMPLES = 101
"""Number of times at which the energy is evaluated, for engines that do not choose the times themselves."""
WELL_KNOWN = 1e-10
"""The largest error of the reference."""


@dataclass(frozen=True)
class Course:
    """States q and v, one above the other, of shape (2 n, times), from the start to the end."""

    states: Array

    @property
    def end(self) -> Array:
        """q (n,) where the motion ends."""
        return np.array(self.states[: len(self.states) // 2, -1])


Run = Callable[[], Course]


class Ours:
    """This project on a shipped system, as ``lagrange solve`` follows it."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._spec = read_spec(text(system.name), system.name)
        self._residual = derive(build_model(self._spec, GraphAlgebra()))
        self._values = resolve_values(self._spec, {})
        self.initial = np.array([*self._values.q, *self._values.v])

    def _prepared(self, tolerance: float) -> Any:
        """The system compiled for a tolerance, with the default outputs."""
        return prepare(
            self._residual,
            Compilation(method="taylor", tolerance=tolerance, outputs=frozenset(DEFAULT_OUTPUTS)),
        )

    def at(self, tolerance: float) -> Run:
        """The run at a tolerance: its samples and diagnostics are part of it."""
        prepared, stop = self._prepared(tolerance), self._system.stop
        times = Times(0.0, stop, SAMPLES, stop / (SAMPLES - 1))
        names = [dataset.path for dataset in prepared.recording.states]

        def run() -> Course:
            kept: list[Array] = []

            def emit(chunk: dict[str, Array]) -> None:
                kept.append(
                    np.concatenate([chunk[name].reshape(len(chunk["t"]), -1) for name in names], axis=1)
                )

            integrate(prepared, self._values, times, emit, lambda: False)
            return Course(np.concatenate(kept).T)

        return run

    def reference(self) -> Reference:
        """The motion that errors are held against; it must be known to the end.

        Raises ``RuntimeError`` where it is not.
        """

        def runner(tolerance: float) -> Callable[[Times], Followed]:
            prepared = self._prepared(tolerance)
            return lambda times: follow(prepared, self._values, times, 60.0, lambda: False)

        labels = [coordinate.name for coordinate in self._spec.coordinates]
        found = find_reference([*map(runner, TOLERANCES)], 0.0, self._system.stop, WELL_KNOWN, labels)
        if found.reason:
            raise RuntimeError(f"{self._system.name}: {found.reason}")
        return found


class Heyoka:
    """heyoka's Taylor method, every order written out: its fastest mode for systems as small as these."""

    def __init__(self, system: System, initial: Array, *, by_hand: bool) -> None:
        import heyoka as hy

        n = len(initial) // 2
        q, v = ([hy.expression(f"{letter}{i}") for i in range(n)] for letter in "qv")
        functions = Functions(hy.sin, hy.cos, hy.sqrt)
        if by_hand:
            self._equations = [*zip(q, v), *zip(v, system.by_hand(q, v, functions))]
        else:
            kinetic, potential = system.energies(q, v, functions)
            self._equations = hy.lagrangian(kinetic - potential, q, v)
        self._initial, self._grid = initial, np.linspace(0.0, system.stop, SAMPLES)

    def at(self, tolerance: float) -> Run:
        """The run at a tolerance."""
        import heyoka as hy

        integrator = hy.taylor_adaptive(self._equations, list(self._initial), tol=tolerance)

        def run() -> Course:
            integrator.time, integrator.state[:] = 0.0, self._initial
            return Course(integrator.propagate_grid(self._grid)[-1].T)

        return run


class Scipy:
    """scipy's DOP853 or LSODA on what sympy derives, simplifies and writes as Python with ``lambdify``."""

    def __init__(self, system: System, initial: Array) -> None:
        import sympy
        from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

        n = len(initial) // 2
        q, v, t = dynamicsymbols(f"q:{n}"), dynamicsymbols(f"q:{n}", 1), dynamicsymbols._t
        kinetic, potential = system.energies(q, v, algebra_of_sympy())
        method = LagrangesMethod(kinetic - potential, q)
        method.form_lagranges_equations()
        state = sympy.symbols(f"s:{2 * n}")
        named = dict(zip([*v, *q], [*state[n:], *state]))
        rates = [sympy.simplify(rate).subs(named) for rate in method.rhs()]
        self._rates = sympy.lambdify([t, state], rates, "math", cse=True)
        self._initial, self._stop = initial, system.stop

    def dop853(self, tolerance: float) -> Run:
        """DOP853, its energy looked at after every step, where nothing is interpolated."""
        from scipy.integrate import solve_ivp

        def run() -> Course:
            return Course(
                solve_ivp(
                    self._rates,
                    (0.0, self._stop),
                    self._initial,
                    method="DOP853",
                    rtol=tolerance,
                    atol=tolerance,
                ).y
            )

        return run

    def lsoda(self, tolerance: float) -> Run:
        """LSODA by ``odeint``, twice as fast as by ``solve_ivp``."""
        from scipy.integrate import odeint

        grid = np.linspace(0.0, self._stop, SAMPLES)

        def run() -> Course:
            found = odeint(
                self._rates, self._initial, grid, tfirst=True, rtol=tolerance, atol=tolerance, mxstep=10**6
            )
            return Course(np.asarray(found).T)

        return run


class Rebound:
    """rebound's IAS15 on bodies of mass 1 in a plane."""

    def __init__(self, system: System, initial: Array) -> None:
        self._stop, self._initial = system.stop, initial

    def at(self, epsilon: float) -> Run:
        """The run with IAS15's ``epsilon``; the energy is looked at after the steps that pass the samples."""
        import rebound

        x, y, vx, vy = self._initial.reshape(4, -1)

        def run() -> Course:
            simulation = rebound.Simulation()
            simulation.integrator = "ias15"
            simulation.integrator.epsilon = epsilon
            for each in zip(x, y, vx, vy):
                simulation.add(m=1.0, **dict(zip(("x", "y", "vx", "vy"), each)))
            states = [self._initial]
            for t in np.linspace(0.0, self._stop, SAMPLES)[1:]:
                simulation.integrate(t, exact_finish_time=int(t == self._stop))
                states.append(state_of(simulation.particles))
            return Course(np.array(states).T)

        return run


def state_of(particles: Sequence[Any]) -> Array:
    """x of each, then y, then their velocities."""
    return np.array([getattr(one, name) for name in ("x", "y", "vx", "vy") for one in particles])


def algebra_of_sympy() -> Functions:
    """sympy's functions."""
    import sympy

    return Functions(sympy.sin, sympy.cos, sympy.sqrt)


def energy_of(system: System, degrees: int) -> Callable[[Array], Array]:
    """T + U as a function of states (2 n, times)."""
    import sympy

    symbols = sympy.symbols(f"s:{2 * degrees}")
    kinetic, potential = system.energies(symbols[:degrees], symbols[degrees:], algebra_of_sympy())
    made = sympy.lambdify(symbols, kinetic + potential, "numpy")
    return lambda states: np.asarray(made(*states))
