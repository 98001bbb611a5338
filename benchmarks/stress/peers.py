"""Other programs on a scene, and the reference: ``python -m benchmarks.stress.peers SCENE ENGINE OUT.npz``.

Each starts from the same doubles as lagrange and has the equations that sympy derives.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.stress.equations import TIME, Equations, equations_of, values_of
from benchmarks.stress.scene import QUADRUPLE, Scene
from benchmarks.stress.scenes import SCENES

Array = NDArray[np.float64]
Followed = tuple[Any, int]
"""States (2 n, samples), nan beyond where the motion ended, and steps."""
DIGITS = 60
CLOSED = 201
"""At how many samples, spread evenly, closed forms are computed."""


def follow_heyoka(scene: Scene, equations: Equations, times: Array) -> Followed:
    """Its Taylor method at its default tolerance."""
    return with_heyoka(equations, times, equations.initial, float)


def with_heyoka(equations: Equations, times: Array, initial: Any, number: Any) -> Followed:
    """heyoka's Taylor method, with numbers of type ``number``."""
    import heyoka as hy

    state = [hy.expression(str(each)) for each in (*equations.q, *equations.v)]
    named = dict(zip((*equations.q, *equations.v), state))
    used = set().union(*(each.free_symbols for each in equations.accelerations))
    parameters = {symbol: value for symbol, value in equations.parameters.items() if symbol in used}
    named |= {symbol: hy.par[k] for k, symbol in enumerate(parameters)}
    named[TIME] = hy.time
    rates = [
        *state[len(equations.q) :],
        *(in_heyoka(each, named, number) for each in equations.accelerations),
    ]
    integrator = hy.taylor_adaptive(
        list(zip(state, rates)),
        [number(each) for each in initial],
        time=number(times[0]),
        pars=[number(each) for each in parameters.values()],
        fp_type=number,
        compact_mode=True,
    )
    states = np.full((len(state), len(times)), np.nan, dtype=object)
    states[:, 0] = integrator.state
    steps = 0
    for k, t in enumerate(times[1:], 1):
        outcome, _, _, taken, *_ = integrator.propagate_until(number(t))
        steps += taken
        if outcome != hy.taylor_outcome.time_limit or not all(map(np.isfinite, map(float, integrator.state))):
            break
        states[:, k] = integrator.state
    return states, steps


def in_heyoka(expression: Any, named: dict[Any, Any], number: Any) -> Any:
    """An expression of sympy in heyoka, its fractions and pi to as many digits as ``number`` has."""
    import heyoka as hy
    import sympy

    kept = dict(named)
    for each in expression.atoms(sympy.Rational):
        if each.q & (each.q - 1):
            symbol = sympy.Dummy()
            kept[symbol] = hy.expression(number(int(each.p)) / number(int(each.q)))
            expression = expression.xreplace({each: symbol})
    return hy.from_sympy(expression, kept)


def rates_of(equations: Equations) -> Callable[[float, Array], Array]:
    """dy/dt for scipy, in plain Python."""
    import sympy

    made = sympy.lambdify(
        [TIME, [*equations.q, *equations.v]],
        [*equations.v, *(each.subs(equations.parameters) for each in equations.accelerations)],
        "math",
        cse=True,
    )
    return lambda t, y: np.array(made(t, y), dtype=np.float64)


def with_scipy(method: str, tolerance: float) -> Callable[[Scene, Equations, Array], Followed]:
    """A method of ``solve_ivp``."""

    def follow(scene: Scene, equations: Equations, times: Array) -> Followed:
        from scipy import integrate

        size = np.abs(equations.initial).max() or 1.0
        solve: Any = integrate.solve_ivp  # its types leave no room for a method by name
        solution = solve(
            rates_of(equations), (times[0], times[-1]), equations.initial, method=method,
            t_eval=times, rtol=tolerance, atol=tolerance * size,
        )  # fmt: skip
        states = np.full((len(equations.initial), len(times)), np.nan)
        states[:, : solution.y.shape[1]] = solution.y
        return states, solution.nfev

    return follow


def follow_ias15(scene: Scene, equations: Equations, times: Array) -> Followed:
    """rebound's IAS15, of point masses in a plane."""
    import rebound

    parameters = values_of(scene).parameters
    masses = [value for name, value in parameters.items() if name.startswith("m[")]
    count, start = len(masses), np.reshape(equations.initial, (4, -1))
    simulation = rebound.Simulation()
    simulation.G, simulation.integrator = parameters["G"], "ias15"
    for k in range(count):
        x, y, u, v = start[:, k]
        simulation.add(m=masses[k], x=x, y=y, vx=u, vy=v)
    states = np.full((4 * count, len(times)), np.nan)
    for k, t in enumerate(times):
        simulation.integrate(t)
        found = [[p.x, p.y, p.vx, p.vy] for p in simulation.particles]
        states[:, k] = np.array(found).T.ravel()
    return states, simulation.steps_done


ENGINES: dict[str, Callable[[Scene, Equations, Array], Followed]] = {
    "heyoka": follow_heyoka,
    "DOP853": with_scipy("DOP853", 1e-12),
    "Radau": with_scipy("Radau", 1e-9),
    "IAS15": follow_ias15,
}


def times_of(scene: Scene) -> Array:
    """The sample times, as `lagrange solve` makes them."""
    from lagrange_cli.integrate.times import Times

    step = (scene.stop - scene.start) / (scene.samples - 1)
    return np.asarray(Times(scene.start, scene.stop, scene.samples, step).chunk(0, scene.samples))


def write_peer(scene: Scene, engine: str, path: str) -> None:
    """States, steps, seconds, and the values of h where it is conserved."""
    equations, times = equations_of(scene), times_of(scene)
    began = time.perf_counter()
    states, steps = ENGINES[engine](scene, equations, times)
    seconds = time.perf_counter() - began
    np.savez(path, states=states.astype(np.float64), steps=steps, seconds=seconds)


def write_reference(scene: Scene, path: str) -> None:
    """q (n, samples) at ``which`` of the samples, and how far one rounding of the start moves it."""
    times = times_of(scene)
    which = np.unique(np.linspace(0, len(times) - 1, min(CLOSED, len(times))).astype(int))
    if scene.reference == QUADRUPLE:
        import heyoka as hy

        equations, which = equations_of(scene), np.arange(len(times))
        initial = [hy.real128(each) for each in equations.initial]
        moved = [each * hy.real128(1 + (-1) ** k * 2.0**-52) for k, each in enumerate(initial)]
        runs = [with_heyoka(equations, times, start, hy.real128)[0] for start in (initial, moved)]
        count = len(equations.q)
        q, other = (run[:count] for run in runs)
    else:
        import mpmath as mp

        mp.mp.dps = DIGITS
        exact = scene.reference
        assert callable(exact)
        values = values_of(scene)
        parameters = {name: mp.mpf(value) for name, value in values.parameters.items()}

        def at(scale: Any) -> Any:
            start = [
                tuple(mp.mpf(x) * (1 + (-1) ** k * scale) for k, x in enumerate(each))
                for each in (values.q, values.v)
            ]
            found = [exact(parameters, start[0], start[1], mp.mpf(t)) for t in times[which]]
            return np.array(found, dtype=object).T

        q, other = at(0), at(mp.mpf(2) ** -52)
    np.savez(path, which=which, q=q.astype(np.float64), rounding=np.abs(other - q).astype(np.float64))


def main() -> None:
    """One engine, or ``reference``, on one scene."""
    name, engine, path = sys.argv[1:]
    scene = next(each for each in SCENES if each.name == name)
    if engine == "reference":
        write_reference(scene, path)
    else:
        write_peer(scene, engine, path)


if __name__ == "__main__":
    main()
