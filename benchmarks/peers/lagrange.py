"""This project, as its commands use it, without reading and writing files and with nothing cached."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import lagrange_cli.integrate.methods.taylor
import lagrange_cli.integrate.program
import lagrange_cli.native.compilation.llvm  # noqa: F401 - what prepare would import
from benchmarks.harness.turns import timed, timed_by_both
from benchmarks.motions.lattices import Lattice
from benchmarks.motions.motion import Motion, shipped
from benchmarks.motions.stiff import Stiff
from benchmarks.peers import Array, Course, Crossings, Cutter, Engine
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ensemble.follow import ensemble_method
from lagrange_cli.integrate.ensemble.lanes import LanesMethod
from lagrange_cli.integrate.ensemble.method import EndedMembers, Section, Starts
from lagrange_cli.integrate.method import Start
from lagrange_cli.integrate.precision import DOUBLE, FULL_DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.integrate.prepare import prepare, prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.members import SECTION
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.surface import with_surface
from lagrange_cli.spec.values import Values, resolve_long_values, resolve_portable_values, resolve_values


def engine(motion: Motion, *, tolerance: float = FULL_PRECISION) -> Engine:
    """``lagrange solve``: default outputs, and the default tolerance if none is given.

    Preparing reads the system file, derives and compiles; a run is all of ``integrate``, its samples
    and diagnostics included.
    """
    text, parameters = motion.text, motion.values.parameters
    seconds, prepared = timed(lambda: compiled(motion, text, tolerance))
    times = Times(0.0, motion.stop, motion.samples, motion.stop / (motion.samples - 1))
    paths = [dataset.path for dataset in prepared.recording.states]

    def follow(initial: Array) -> Course:
        states: list[Array] = []

        def keep(chunk: dict[str, Array]) -> None:
            count = len(chunk["t"])
            states.append(np.concatenate([chunk[path].reshape(count, -1) for path in paths], axis=1))

        q, v = np.split(initial, 2)
        outcome = integrate(prepared, Values(parameters, tuple(q), tuple(v)), times, keep, lambda: False)
        if outcome.ending.status != "complete":
            raise RuntimeError(outcome.message)
        return Course(np.concatenate(states).T, outcome.steps)

    return Engine(seconds, follow)


def compiled(motion: Motion, text: str, tolerance: float) -> Prepared:
    """The motion for a tolerance, with the default outputs."""
    spec = read_spec(text, motion.system, motion.sizes)
    compilation = Compilation("taylor", tolerance, frozenset(DEFAULT_OUTPUTS))
    return prepare_system(spec, derive_system, None, compilation)


def ensemble(motion: Motion, *, threads: int) -> Engine:
    """``lagrange sweep``, which writes the end of each motion."""
    residual = derive_system(read_spec(motion.text, motion.system, motion.sizes))
    asked = Compilation("taylor", FULL_PRECISION, frozenset({"p", "h"}), ensemble=True)
    seconds, prepared = timed(lambda: prepare(residual, asked))
    method = ensemble_method(prepared, lambda: prepared.follower)
    values, times = [*motion.values.parameters.values()], Times(0.0, motion.stop, 2, motion.stop)

    def follow(states: Array) -> Course:
        ends, steps = np.empty_like(states), np.empty(states.shape[1])

        def accept(batch: EndedMembers) -> None:
            ends[:, batch.index], steps[batch.index] = batch.state.T, batch.steps

        parameters = np.tile(values, (states.shape[1], 1))
        method.follow(Starts(parameters, states.T, times, False), accept, lambda done: False, threads)
        return Course(ends, float(steps.mean()))

    return Engine(seconds, follow)


def section(motion: Motion, *, crossings: int, threads: int) -> Cutter:
    """``lagrange section``, without its file."""
    spec = read_spec(motion.text, motion.system, motion.sizes)
    residual = derive_system(with_surface(spec, spec.coordinates[0].name))
    asked = Compilation("taylor", FULL_PRECISION, frozenset({"q", "v"}), ensemble=True, section=SECTION)
    seconds, prepared = timed(lambda: prepare(residual, asked))
    values, rows = [*motion.values.parameters.values()], prepared.machine.program.rows
    kept = Section(crossings, direction=1, patience=10**6)
    method = LanesMethod(prepared.machine, lambda: prepared.follower)

    def follow(states: Array) -> Crossings:
        count = states.shape[1]
        found = Crossings(np.empty((count, crossings)), np.empty((len(states), count, crossings)), 0.0)
        steps = np.empty(count)

        def accept(batch: EndedMembers) -> None:
            assert batch.samples is not None and batch.times is not None
            found.times[batch.index] = batch.times
            found.states[:, batch.index] = batch.samples[:, : len(states)].transpose(1, 0, 2)
            steps[batch.index] = batch.steps

        begin = np.zeros((count, rows))
        begin[:, : len(states)] = states.T
        starts = Starts(np.tile(values, (count, 1)), begin, Times(0.0, math.inf, 2, 1.0), False, section=kept)
        method.follow(starts, accept, lambda done: False, threads)
        return replace(found, steps=float(steps.mean()))

    return Cutter(seconds, follow)


def steps_of(
    system: str, stop: float, *, precision: str = DOUBLE, portable: bool = False
) -> Callable[[], int]:
    """The integration alone of a shipped system at full precision, compiled before; it returns the steps."""
    spec = read_spec(shipped(system), system)
    double = precision == DOUBLE
    prepared = prepare(
        derive_system(spec, exact=not double, portable=portable),
        Compilation(
            "taylor", FULL_PRECISION if double else FULL_DOUBLE_DOUBLE, frozenset(), precision=precision,
            portable=portable,
        ),
    )  # fmt: skip
    resolve = resolve_portable_values if portable else resolve_values if double else resolve_long_values
    start = Start.of(prepared.machine.program, resolve(spec), Times(0.0, stop, 2, stop))

    def run() -> int:
        return prepared.follower.follow(start).steps

    return run


def large(lattice: Lattice, *, tolerance: float = FULL_PRECISION) -> Engine:
    """``lagrange solve`` of a large system, without samples between and without a file."""
    few = {name: min(size, "4", key=int) for name, size in lattice.sizes.items()}
    values = resolve_values(read_spec(lattice.text, lattice.system, few)).parameters

    def prepared() -> Prepared:
        spec = read_spec(lattice.text, lattice.system, lattice.sizes)
        return prepare_system(spec, derive_system, None, Compilation("taylor", tolerance, frozenset()))

    _, seconds, made = timed_by_both(prepared)
    program = made.machine.program
    doubles = program.work + program.trial + program.inner.memory + program.constants
    given = np.array([values[name] for name in program.parameters])

    def follow(initial: Array) -> Course:
        times = Times(0.0, lattice.stop, 2, lattice.stop)
        end = made.follower.follow(Start(given, initial, times))
        if end.ending.status != "complete":
            raise RuntimeError(end.ending.name)
        return Course(end.state[:, None], end.steps)

    return Engine(seconds, follow, 8 * doubles / (lattice.count * program.order))


def stiff(motion: Stiff, *, method: str, tolerance: float) -> Engine:
    """``lagrange solve --method`` of a stiff system, without samples between and without a file."""
    compilation = Compilation(method, tolerance, frozenset())
    _, seconds, made = timed_by_both(
        lambda: prepare_system(read_spec(motion.text, motion.name), derive_system, None, compilation)
    )

    def follow(initial: Array) -> Course:
        times = Times(0.0, motion.stop, 2, motion.stop)
        end = made.follower.follow(Start(np.empty(0), initial, times))
        if end.ending.status != "complete":
            raise RuntimeError(end.ending.name)
        return Course(end.state[:, None], end.steps)

    return Engine(seconds, follow)
