"""Bodies in space under their mutual gravity, 10 to 1000 of them: integration alone, and energy errors."""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, timed_by_both

Array = NDArray[np.float64]
Follow = Callable[[Array, Array], tuple[Array, Array, int, float]]
"""From places and velocities (3, bodies) to those at ``STOP``, the number of steps, and processor seconds."""
SHARED, THREADS, FASTER = 300, (1, 2), 1.6
"""From so many bodies on, threads share the work; how much faster two of them have to be with a thousand."""
READY = 0.5
"""How many seconds preparation may take."""
SPEED = 0.4
ROUNDING = 2.0**-52
"""Energy errors smaller than this are not compared: those of the state as it is rounded are as large."""
IAS15, TAYLOR = "lagrange --method ias15", "lagrange"
REBOUND, HEYOKA = "rebound IAS15", "heyoka, its model.nbody, compact mode"


@dataclass(frozen=True)
class Case:
    """So many bodies: until when they are followed, from how many starts, and how near to each other any two
    may be at the beginning. Some peers are left out where they would take minutes to prepare."""

    count: int
    stop: float
    starts: int
    apart: float
    left_out: tuple[str, ...] = ()


CASES = (
    Case(10, 10.0, 5, 0.3),
    Case(30, 10.0, 5, 0.3),
    Case(100, 1.0, 3, 0.1),
    Case(300, 0.25, 2, 0.03, (TAYLOR,)),
    Case(1000, 0.05, 1, 0.01, (TAYLOR, HEYOKA)),
)

TEXT = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: 0}}
  y[i in range(N)]: {{initial: 0}}
  z[i in range(N)]: {{initial: 0}}
masses: {{body[i in range(N)]: 1/N}}
embedding: {{body[i in range(N)]: [x[i], y[i], z[i]]}}
potential: -sum(1/N**2/norm(body[i] - body[j]) for i in range(N) for j in range(i))
"""


@dataclass(frozen=True)
class Figures:
    """What an engine takes: processor seconds until it is ready, the median of those of a motion, the mean
    number of steps, and the root mean square of the energy's relative errors."""

    prepare: float
    run: float
    steps: float
    error: float


def start(case: Case, seed: int) -> tuple[Array, Array]:
    """A cluster at rest as a whole: places and velocities, drawn until no two bodies are too near."""
    count, chance = case.count, np.random.default_rng(seed)
    while True:
        x = chance.normal(size=(3, count))
        distances = np.linalg.norm(x[:, :, None] - x[:, None, :], axis=0)
        if np.min(distances + case.apart * np.eye(count)) >= case.apart:
            break
    v = SPEED * chance.normal(size=(3, count))
    return x - x.mean(axis=1, keepdims=True), v - v.mean(axis=1, keepdims=True)


def energy(x: Array, v: Array) -> np.longdouble:
    """Kinetic and potential energy, in extended precision."""
    mass = np.longdouble(1) / x.shape[1]
    one, other = np.triu_indices(x.shape[1], 1)
    apart = x.astype(np.longdouble)[:, one] - x[:, other]
    potential = mass**2 / np.sqrt((apart**2).sum(axis=0))
    found: np.longdouble = mass * (v.astype(np.longdouble) ** 2).sum() / 2 - potential.sum()
    return found


def lagrange(case: Case, method: str, *, threads: int = 1, processor: bool = True) -> Follow:
    """This project, without samples between; it tells seconds of the ``processor``, or of the clock."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.method import Start
    from lagrange_cli.integrate.precision import FULL_PRECISION
    from lagrange_cli.integrate.prepare import prepare_system
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.derive import derive_system
    from lagrange_cli.spec.read import read_spec

    count = case.count
    spec = read_spec(TEXT.format(count=count), "bodies")
    prepared = prepare_system(spec, derive_system, None, Compilation(method, FULL_PRECISION, frozenset()))

    def follow(x: Array, v: Array) -> tuple[Array, Array, int, float]:
        state = np.concatenate([x.ravel(), v.ravel()])
        start = Start(np.empty(0), state, Times(0.0, case.stop, 2, case.stop))
        run = partial(prepared.follower.follow, start, threads=threads)
        clock, spent, end = timed_by_both(run)
        if end.ending.status != "complete":
            raise RuntimeError(end.ending.name)
        reached, speed = end.state.reshape(2, 3, count)
        return reached, speed, end.steps, spent if processor else clock

    return follow


def rebound(case: Case) -> Follow:
    """Its IAS15, as it is by default."""
    import rebound

    def follow(x: Array, v: Array) -> tuple[Array, Array, int, float]:
        simulation = rebound.Simulation()
        simulation.integrator = "ias15"
        for place, speed in zip(x.T, v.T):
            simulation.add(m=1 / case.count, **dict(zip(("x", "y", "z", "vx", "vy", "vz"), (*place, *speed))))
        _, seconds, _ = timed_by_both(lambda: simulation.integrate(case.stop))
        ends = simulation.particles
        reached = np.array([[getattr(one, name) for one in ends] for name in ("x", "y", "z")])
        speeds = np.array([[getattr(one, name) for one in ends] for name in ("vx", "vy", "vz")])
        return reached, speeds, simulation.steps_done, seconds

    return follow


def heyoka(case: Case) -> Follow:
    """Its Taylor method at its default tolerance."""
    import heyoka as hy

    count = case.count
    equations = hy.model.nbody(count, masses=[1 / count] * count)
    integrator = hy.taylor_adaptive(equations, [0.0] * (6 * count), compact_mode=True)
    names = [str(variable).split("_") for variable, _ in equations]
    rows = [("xyz".index(kind[-1]) + 3 * (kind[0] == "v")) * count + int(i) for kind, i in names]

    def follow(x: Array, v: Array) -> tuple[Array, Array, int, float]:
        integrator.time = 0.0
        integrator.state[:] = np.concatenate([x.ravel(), v.ravel()])[rows]
        _, seconds, outcome = timed_by_both(lambda: integrator.propagate_until(case.stop))
        ends = np.empty(6 * count)
        ends[rows] = integrator.state
        reached, speeds = ends.reshape(2, 3, count)
        return reached, speeds, outcome[3], seconds

    return follow


ENGINES: dict[str, Callable[[Case], Follow]] = {
    IAS15: partial(lagrange, method="ias15"),
    TAYLOR: partial(lagrange, method="taylor"),
    REBOUND: rebound,
    HEYOKA: heyoka,
}


def figures(name: str, case: Case, runs: int) -> Figures:
    """Those of an engine; of each motion the fastest run counts."""
    _, ready, follow = timed_by_both(lambda: ENGINES[name](case))
    seconds, steps, errors = list[float](), list[int](), list[float]()
    for seed in range(case.starts):
        x, v = start(case, seed)
        results = [follow(x, v) for _ in range(runs)]
        reached, speeds, taken, _ = results[0]
        seconds.append(min(result[-1] for result in results))
        steps.append(taken)
        errors.append(float(energy(reached, speeds) / energy(x, v) - 1))
    return Figures(ready, median(seconds), float(np.mean(steps)), float(np.sqrt(np.mean(np.square(errors)))))


def by_threads(case: Case, runs: int) -> dict[int, float]:
    """Seconds of the clock for each number of threads: the medians of motions in turns."""
    follow = {n: lagrange(case, "ias15", threads=n, processor=False) for n in THREADS}
    tasks = {n: partial(one, *start(case, 0)) for n, one in follow.items()}
    return {n: median(one[-1] for one in found) for n, found in in_turns(tasks, runs).items()}


def measure(options: Namespace) -> Report:
    """A table for each number of bodies; every engine in a process of its own."""
    parts, requirements = list[str](), list[Requirement]()
    for case in CASES[:1] if options.quick else CASES:
        count, names = case.count, [name for name in ENGINES if name not in case.left_out]
        found = {name: in_own_process(figures, name, case, options.runs) for name in names}
        parts += [f"**{count} bodies**, {case.stop:g} units of time:", table(found)]
        if count >= SHARED:
            clock = in_own_process(by_threads, case, 2 * options.runs)
            rows = [(str(n), f"{1e3 * one:.2f}", f"{clock[1] / one:.2f}") for n, one in clock.items()]
            parts.append(markdown_table(("threads of ias15", "clock, ms", "speed"), rows))
        ready = max(found[name].prepare for name in (IAS15, TAYLOR) if name in found)
        requirements.append(Requirement(f"{count} bodies: seconds to prepare", ready, "<=", READY))
        if count >= CASES[-1].count:
            faster = f"{count} bodies: time with one thread, relative to two"
            requirements.append(Requirement(faster, clock[1] / clock[2], ">=", FASTER))
        requirements += [
            Requirement(
                f"{count} bodies: time of {peer}, relative to lagrange", found[peer].run / ours, ">=", least
            )
            for peer, least in ((REBOUND, 1), (HEYOKA, 2))
            if peer in found
            for ours in [fastest(found, found[peer].error)]
        ]
    return Report(tuple(parts), tuple(requirements))


def fastest(found: dict[str, Figures], error: float) -> float:
    """The time of the faster of our methods whose energy error is not larger than that of another program."""
    ours = [found[name] for name in (IAS15, TAYLOR) if name in found]
    return min((one.run for one in ours if one.error <= max(error, ROUNDING)), default=math.inf)


def table(found: dict[str, Figures]) -> str:
    """All figures of the engines."""
    header: Sequence[str] = ("", "prepare, s", "run, ms", "steps", "energy error")
    rows = [
        (name, f"{one.prepare:.2f}", f"{1e3 * one.run:.2f}", f"{one.steps:.0f}", f"{one.error:.1e}")
        for name, one in found.items()
    ]
    return markdown_table(header, rows)


SUITE = Suite(
    "bodies", measure, packages=("llvmlite", "numpy", "rebound", "heyoka"), runs=5, quick="ten bodies only"
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
