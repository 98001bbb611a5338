"""heyoka: Taylor series compiled by LLVM (F. Biscani and D. Izzo, MNRAS 504, 2021)."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, Literal

import heyoka as hy
import numpy as np

from benchmarks.harness.turns import timed
from benchmarks.motions.equations import Algebra, gravitation
from benchmarks.motions.motion import Motion
from benchmarks.motions.printed import TIME, Printed
from benchmarks.peers import Array, Course, Crossings, Cutter, Engine

Equations = list[tuple[Any, Any]]
"""[(variable, rate), ...], first of q, then of v."""
ALGEBRA = Algebra(hy.sin, hy.cos, lambda x: x**-0.5, hy.sum, 0.5)
STARTED = 1e-9
"""A zero before this time is the start of a motion on the section, and no crossing."""
Form = Literal["derived", "by hand", "model"]
"""Forms of its equations: what its ``lagrangian()`` derives, accelerations by hand, its ``model.nbody``."""


def engine(
    motion: Motion,
    *,
    form: Form,
    tolerance: float | None = None,
    quadruple: bool = False,
    dense: bool = False,
    **mode: bool,
) -> Engine:
    """Its Taylor method at its default tolerance, or another one, its caches of compiled code off.

    Preparing is to write the equations and to construct ``taylor_adaptive`` with the options of ``mode``.
    Samples are taken by integrating up to each of them, which for long motions is faster than the
    interpolation of ``propagate_grid`` (``dense``).
    """
    forget()
    number = hy.real128 if quadruple else float
    if tolerance is not None:
        mode = {**mode, "tol": tolerance}  # type: ignore[dict-item]

    def make() -> Any:
        return hy.taylor_adaptive(
            equations(motion, form), [number(x) for x in motion.initial], fp_type=number, **mode
        )

    seconds, integrator = timed(make)
    return Engine(seconds, follower(integrator, motion.grid, number, dense=dense))


def forget() -> None:
    """Compile anew."""
    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()


def equations(motion: Motion, form: Form) -> Equations:
    """The motion as a user of heyoka writes it, in one of the forms."""
    q, v = ([hy.expression(f"{letter}{i}") for i in range(motion.degrees)] for letter in "qv")
    if form == "derived":
        kinetic, potential = motion.energies(motion.parameters, q, v, ALGEBRA)
        derived: Equations = hy.lagrangian(kinetic - potential, q, v)
        return derived
    if form == "by hand":
        assert motion.by_hand is not None
        return [*zip(q, v), *zip(v, motion.by_hand(motion.parameters, q, v, ALGEBRA))]
    constant, masses = gravitation(motion.parameters)
    model = hy.model.nbody(len(masses), constant, masses)
    rates = {str(variable): (variable, rate) for variable, rate in model}
    order = [f"{kind}{axis}_{i}" for kind in ("", "v") for axis in "xyz" for i in range(len(masses))]
    return [rates[name] for name in order]


def follower(integrator: Any, times: Array, number: Any, *, dense: bool = False) -> Callable[[Array], Course]:
    """What follows a motion from the first of ``times`` to the others with an integrator."""
    kind = np.float64 if number is float else object

    def follow(initial: Array) -> Course:
        integrator.time = number(times[0])
        integrator.state[:] = [number(x) for x in initial]
        if dense:
            *_, steps, _, states = integrator.propagate_grid(times)
            return Course(np.array(states.T), steps)
        states = np.full((len(initial), len(times)), np.nan, dtype=kind)
        states[:, 0], steps = integrator.state, 0
        for k, t in enumerate(times[1:], 1):
            outcome, _, _, taken, *_ = integrator.propagate_until(number(t))
            steps += taken
            if outcome != hy.taylor_outcome.time_limit:
                break
            states[:, k] = integrator.state
        return Course(states, steps)

    return follow


def printed(equations: Printed, times: Array, *, quadruple: bool = False) -> Engine:
    """Its Taylor method in compact mode on printed equations."""
    number = hy.real128 if quadruple else float
    count = len(equations.q)

    def make() -> Any:
        state = [hy.expression(str(each)) for each in (*equations.q, *equations.v)]
        named = dict(zip((*equations.q, *equations.v), state))
        used = set().union(*(each.free_symbols for each in equations.accelerations))
        parameters = {symbol: value for symbol, value in equations.values.items() if symbol in used}
        named |= {symbol: hy.par[k] for k, symbol in enumerate(parameters)}
        named[TIME] = hy.time
        rates = [*state[count:], *(converted(each, named, number) for each in equations.accelerations)]
        return hy.taylor_adaptive(
            list(zip(state, rates)),
            [number(x) for x in equations.initial],
            time=number(times[0]),
            pars=[number(x) for x in parameters.values()],
            fp_type=number,
            compact_mode=True,
        )

    seconds, integrator = timed(make)
    return Engine(seconds, follower(integrator, times, number))


def converted(expression: Any, named: dict[Any, Any], number: Any) -> Any:
    """An expression of sympy in heyoka, its fractions to as many digits as ``number`` has."""
    import sympy

    kept = dict(named)
    for each in expression.atoms(sympy.Rational):
        if each.q & (each.q - 1):
            symbol = sympy.Dummy()
            kept[symbol] = hy.expression(number(int(each.p)) / number(int(each.q)))
            expression = expression.xreplace({each: symbol})
    return hy.from_sympy(expression, kept)


def ensemble(motion: Motion, *, form: Form, batch: int, threads: int | None = None) -> Engine:
    """Batches in the lanes of a vector, one after the other or, with ``threads``, by its
    ``ensemble_propagate_until_batch``; the number of members must be a multiple of ``batch``."""
    forget()
    system, zeros = equations(motion, form), np.zeros((2 * motion.degrees, batch))
    seconds, integrator = timed(lambda: hy.taylor_adaptive_batch(system, zeros, force_avx512=batch == 8))

    def load(one: Any, states: Array, first: int) -> Any:
        one.set_time(0.0)
        one.state[:] = states[:, first : first + batch]
        return one

    def follow(states: Array) -> Course:
        ends, steps, starts = np.empty_like(states), [], range(0, states.shape[1], batch)
        if threads is None:
            for first in starts:
                load(integrator, states, first).propagate_until(motion.stop)
                ends[:, first : first + batch] = integrator.state
                steps += [result[3] for result in integrator.propagate_res]
        else:
            followed = hy.ensemble_propagate_until_batch(
                integrator,
                motion.stop,
                len(starts),
                lambda one, i: load(one, states, batch * i),
                max_workers=threads,
            )
            for first, (one, *_) in zip(starts, followed):
                ends[:, first : first + batch] = one.state
                steps += [result[3] for result in one.propagate_res]
        return Course(ends, float(np.mean(steps)))

    return Engine(seconds, follow)


def section(motion: Motion, *, crossings: int, batch: int, threads: int = 1, period: float) -> Cutter:
    """Batches in the lanes of a vector, and an event whose callback stores the time and the state; with
    several ``threads``, an integrator in each. A crossing is expected once a ``period``."""
    forget()
    seconds, cutters = timed(lambda: [cutter(motion, crossings, batch) for _ in range(threads)])

    def follow(states: Array) -> Crossings:
        count = states.shape[1]
        found = Crossings(np.empty((count, crossings)), np.empty((len(states), count, crossings)), 0.0)
        waiting, steps = iter(range(0, count, batch)), list[float]()

        def work(cut: Any) -> None:
            for first in waiting:
                steps.extend(cut(states[:, first : first + batch], found, first, period))

        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(work, cutters))
        return replace(found, steps=float(np.mean(steps)))

    return Cutter(seconds, follow)


def cutter(motion: Motion, crossings: int, batch: int) -> Callable[..., list[int]]:
    """What finds the crossings of a batch."""
    done, found, first = [0] * batch, [np.empty(0)] * 2, 0

    def store(integrator: Any, time: float, sign: int, lane: int) -> None:
        k = done[lane]
        if k < crossings and time > STARTED:
            integrator.update_d_output(np.full(batch, time))
            found[0][first + lane, k] = time
            found[1][:, first + lane, k] = integrator.d_output[:, lane]
            done[lane] = k + 1

    event = hy.nt_event_batch(hy.expression("q0"), store, direction=hy.event_direction.positive)
    zeros = np.zeros((2 * motion.degrees, batch))
    integrator = hy.taylor_adaptive_batch(
        equations(motion, "by hand"), zeros, nt_events=[event], force_avx512=batch == 8
    )

    def cut(states: Array, into: Crossings, begin: int, period: float) -> list[int]:
        nonlocal first
        first, done[:], found[:] = begin, [0] * batch, [into.times, into.states]
        integrator.set_time(0.0)
        integrator.state[:] = states
        steps, stop = np.zeros(batch, dtype=int), 0.0
        while min(done) < crossings:
            stop += max(1, crossings - min(done)) * period
            integrator.propagate_until(stop)
            steps += [result[3] for result in integrator.propagate_res]
        return [*steps.tolist()]

    return cut
