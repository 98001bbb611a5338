"""Motions taken to pieces: ``python -m tests.fuzzing.restoring [--runs 200] [--seed 1] [--kind wall]``.

The compiled loop is left and entered again at any step and at any sample, each time with the memory of a
checkpoint and nothing else (scratch arrays are filled with NaN), in code of any level. Every piece must end
with the memory that an undisturbed motion has after so many steps, bit by bit, and give its samples.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.method import Snapshot, Start
from lagrange_cli.integrate.methods.compiled import CompiledEquations
from lagrange_cli.integrate.methods.stepper import Stepper
from lagrange_cli.integrate.program import write_run
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import FULL, QUICK, Machine, compile_program
from lagrange_cli.native.interface import LANES, Stop
from lagrange_cli.outputs.catalog import OUTPUTS, PARTICLE_OUTPUTS
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.values import Values, resolve_long_values, resolve_portable_values, resolve_values
from tests.support.motion import NAMES, spec_of

WEDGES = """
coordinates: {{x: {{initial: {x}, velocity: {v}}}, y: {{initial: 0.2, velocity: 0.1}}}}
masses: {{p: 1}}
embedding: {{p: [x, y]}}
potential: sqrt((x - {a})**2) + sqrt((y + x)**2) + 0.1*y**2
dissipation: {c}*x_dot**2
"""
"""Kinks, which steps approach by halves and pass unseen."""
WALL = """
coordinates: {{x: {{initial: {x}, velocity: {v}}}}}
masses: {{p: 1}}
embedding: {{p: [x]}}
potential: exp(-{a}*(x + 3)) + 0.3*x + ((x)**2)**1.5
generalized_forces: {{x: -{c}*tanh(50*x_dot)}}
"""
"""Narrow forces, which are detected, and a kink of a higher derivative."""
DRIVEN = """
coordinates: {{x: {{initial: {x}, velocity: {v}}}}}
masses: {{p: 1}}
embedding: {{p: [sin(x), -cos(x)]}}
potential: 9.81*p.y
generalized_forces: {{x: 11.8*cos(2.1*t + {a})}}
dissipation: {c}*x_dot**2
"""
"""Now and then a step is refused for nothing but rounding."""
RANDOM = {"wedges": (WEDGES, 20.0), "wall": (WALL, 8.0), "driven": (DRIVEN, 400.0)}
"""Texts with numbers to be drawn, and for how long they are followed."""
NUMBERS = {"x": 1.3, "v": 0.3, "a": 0.5, "c": 0.2}
"""What is drawn from, give or take a third."""

NOT_ALWAYS = "reactions", "multipliers"
"""Outputs that are not defined for all systems."""


@dataclass(frozen=True)
class Case:
    """A motion: a shipped system or the text of one, for how long, in how many samples, with what outputs."""

    system: str
    stop: float
    samples: int
    outputs: tuple[str, ...]
    precision: str = "double"
    portable: bool = False

    def times(self) -> Times:
        return Times(0.0, self.stop, self.samples, self.stop / (self.samples - 1))


@cache
def machines(case: Case) -> tuple[Machine, Machine]:
    """Its program, compiled at every level."""
    spec, double_double = spec_of(case.system), case.precision != "double"
    program, _ = write_run(
        derive_system(spec, exact=double_double, portable=case.portable),
        Compilation(
            method="taylor",
            tolerance=2.0**-104 if double_double else 2.0**-52,
            outputs=frozenset(case.outputs),
            precision=case.precision,
            portable=case.portable,
        ),
    )
    return compile_program(program, QUICK), compile_program(program, FULL)


def values_of(case: Case) -> Values:
    """Its numbers."""
    resolve = resolve_portable_values if case.portable else resolve_values
    if case.precision != "double":
        resolve = resolve_long_values
    return resolve(spec_of(case.system), {})


def stepper(case: Case, machine: Machine, size: int) -> Stepper:
    """What goes through it, with scratch of which nothing may be used."""
    start = Start.of(machine.program, values_of(case), case.times())
    made = Stepper(CompiledEquations(machine), start, size)
    made.space.work[:] = made.space.trial[:] = np.nan
    return made


@dataclass(frozen=True)
class Piece:
    """What a call gives: why it returned, with how many steps and samples in all, its samples, the memory."""

    stop: Stop
    steps: int
    reached: int
    samples: np.ndarray
    memory: bytes


def advance(stepper: Stepper, case: Case, steps: int, first: int, size: int, pause: int) -> Piece:
    """One call for up to ``size`` samples from the one numbered ``first``, pausing after so many steps."""
    times = case.times()
    wanted = times.chunk(first, size)
    padded, last = np.concatenate([wanted, np.full(LANES, np.nan)]), first + len(wanted) == times.count
    stop = stepper.space.advance(times.stop, padded, 0, len(wanted), last, pause)
    done, taken = map(int, stepper.space.info[:2])
    return Piece(
        stop,
        steps + taken,
        first + done,
        stepper.space.samples[:, :done].copy(),
        stepper.space.memory.tobytes(),
    )


def whole(case: Case, machine: Machine, pause: int = 10**9) -> Iterator[Piece]:
    """The motion in one go, but for pauses after so many steps."""
    made, steps, first = stepper(case, machine, case.samples), 0, 0
    while True:
        piece = advance(made, case, steps, first, case.samples - first, pause)
        yield piece
        if piece.stop is not Stop.PAUSE:
            return
        steps, first = piece.steps, piece.reached


def pieces(case: Case, chance: random.Random, most: int) -> Iterator[Piece]:
    """The motion in pieces of up to ``most`` samples and steps, each from the memory of the one before."""
    quick_full = machines(case)
    made: Stepper | None = None
    memory, steps, first = None, 0, 0
    while True:
        if made is None or chance.random() < 0.5:
            made = stepper(case, chance.choice(quick_full), most)
            if memory is not None:
                made.restore(Snapshot(np.frombuffer(memory), 0.0, steps, first))
        piece = advance(made, case, steps, first, chance.randint(1, most), chance.randint(1, most))
        yield piece
        if piece.stop not in (Stop.PAUSE, Stop.SAMPLES):
            return
        memory, steps, first = piece.memory, piece.steps, piece.reached


def compare(case: Case, chance: random.Random, most: int) -> int:
    """Take the motion to pieces and assert that nothing shows it; into how many."""
    (undisturbed,) = whole(case, machines(case)[1])
    stepwise = list(whole(case, machines(case)[0], pause=1))
    memories = {piece.steps: piece.memory for piece in stepwise if piece.stop is Stop.PAUSE}
    count = 0
    for found in (stepwise, pieces(case, chance, most)):
        samples = []
        for piece in found:
            samples.append(piece.samples)
            count += 1
            if piece.stop is Stop.PAUSE:  # else there may be doubts about the next step in it
                assert piece.memory == memories[piece.steps], f"step {piece.steps} of {case}"
        assert np.concatenate(samples, axis=1).tobytes() == undisturbed.samples.tobytes(), case
        end = (undisturbed.stop, undisturbed.steps, undisturbed.memory)
        assert (piece.stop, piece.steps, piece.memory) == end, case
    return count


def random_case(chance: random.Random, kind: str | None = None) -> Case:
    """Any system (one of ``RANDOM``, or ``shipped``), outputs and precision.

    What happens at events is not all in the memory: see ``tests/cli/test_event_outputs.py``.
    """
    name = kind if kind is not None else chance.choice(["shipped", "shipped", "shipped", *RANDOM])
    precision = chance.choice(["double"] * 4 + ["double-double"])
    if name in RANDOM:
        drawn = {key: round(value * chance.uniform(0.7, 1.3), 6) for key, value in NUMBERS.items()}
        text, stop = RANDOM[name]
        text = text.format(**drawn)
    else:
        text = chance.choice([name for name in NAMES if not spec_of(name).events])
        stop = float(spec_of(text).solve.stop) * chance.uniform(0.2, 1.0)
    if precision != "double":
        stop *= 0.1
    allowed = [one for one in OUTPUTS if spec_of(text).lagrangian is None or one not in PARTICLE_OUTPUTS]
    allowed = [one for one in allowed if one not in NOT_ALWAYS]
    outputs = allowed if chance.random() < 0.3 else ["q", *chance.sample(allowed, chance.randint(0, 4))]
    samples, portable = int(10 ** chance.uniform(0.5, 3.3)), chance.random() < 0.2
    return Case(text, stop, samples, tuple(dict.fromkeys(outputs)), precision, portable)


def attempt(seed: int, kind: str | None = None) -> int:
    """Take the motion of that number to pieces (see ``compare``); what is asserted names it."""
    chance = random.Random(seed)
    case = random_case(chance, kind)
    try:
        return compare(case, chance, chance.choice((1, 2, 10, 100)))
    except AssertionError as error:
        raise AssertionError(f"--seed {seed} --kind {kind}: {error}") from error
    finally:
        machines.cache_clear()


def main(runs: int, seed: int, kind: str | None) -> int:
    """Take so many random motions to pieces; 1 if any shows it."""
    lost = cuts = 0
    for number in range(seed, seed + runs):
        case = random_case(random.Random(number), kind)
        shown = f"seed {number}: {case.system.strip().splitlines()[0]} {case.precision}"
        try:
            count = attempt(number, kind)
            cuts += count
            print(f"{shown}: {count} pieces", flush=True)
        except AssertionError as error:
            lost += 1
            print(f"{shown}: {error}", flush=True)
    print(f"{runs - lost} of {runs} motions came out the same, bit by bit, in {cuts} pieces")
    return int(lost > 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=["shipped", *RANDOM])
    options = parser.parse_args()
    sys.exit(main(options.runs, options.seed, options.kind))
