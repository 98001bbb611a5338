"""The same bits, however many samples are asked for, in whatever pieces, and wherever it is interrupted."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.checkpoint import Checkpointing, Progress, Schedule
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods import stepper, taylor
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.run.derive import derive_system
from tests.support.draws import examples
from tests.support.motion import FULL, prepared, spec_of, values_of

SYSTEMS = {
    "double_pendulum": 12.0,
    "driven_damped_pendulum": 40.0,
    "spherical_pendulum": 30.0,
    "central_force": 40.0,
    "n_pendulum": 2.0,
    "charged_particle": 25.0,
}
LINKAGE = """
coordinates: {x0: {initial: 0}, y0: {initial: 1}, x1: {initial: 1, velocity: 1}, y1: {initial: 1}}
masses: {a: 1, b: 1}
positions: {a: [x0, y0], b: [x1, y1]}
potential: 9.81*(y0 + y1)
constraints:
  left: x0**2 + y0**2 - 1
  right: (x1 - 1)**2 + y1**2 - 1
  bar: (x1 - x0)**2 + (y1 - y0)**2 - 1
"""
SYSTEMS[LINKAGE] = 3.0  # it passes the horizontal twice
KICKED = (
    LINKAGE
    + """
events:
  level: {when: x0 - 1/5}
  low:
    when: y0 + 1/2
    action: {set: {x0_dot: 0.99*x0_dot, y0_dot: 0.99*y0_dot, x1_dot: 0.99*x1_dot, y1_dot: 0.99*y1_dot}}
"""
)
SYSTEMS[KICKED] = 3.0
"""What is followed, and for how long; cyclic coordinates, explicit time and a family among them."""
BOUNCING = """
sizes: {N: 12}
parameters: {"e[i in range(N)]": "0.4 + 0.1*cos(i)"}
coordinates: {"y[i in range(N)]": {initial: "1 + 0.3*sin(i)", velocity: "0.3*cos(i*i)"}}
masses: {"ball[i in range(N)]": 1}
embedding: {"ball[i in range(N)]": "y[i]"}
potential: sum(9.81*y[i] for i in range(N))
events:
  floor[i in range(N)]: {when: "y[i]", direction: falling, action: {set: {"y_dot[i]": "-e[i]*y_dot[i]"}}}
"""
DRAWN = [*SYSTEMS]
SYSTEMS[BOUNCING] = 1.2
BACKWARD = SYSTEMS | {"driven_damped_pendulum": 3.0}  # what damping takes grows by exp(1.6 t) backward
OUTPUTS = ("q", "v", "p", "h", "ledger", "action")


class Run:
    """A motion that is followed bit by bit: each time until it has been asked ``looks`` times to stop."""

    def __init__(self, system: str, samples: int, looks: int, size: int = 65536, sense: int = 1) -> None:
        values, stop = values_of(system), SYSTEMS[system] if sense > 0 else -BACKWARD[system]
        if system is BOUNCING:
            asked = Compilation("taylor", FULL, frozenset(["q", "v", "h"]))
            ready = prepare_system(spec_of(system), partial(derive_system, resting=True), None, asked)
        else:
            ready = prepared(system, outputs=OUTPUTS, backward=sense < 0)
        emit_events = self.emit if system is BOUNCING else self.leave_out
        times = Times(0.0, stop, samples, stop / (samples - 1))
        self.series: dict[str, list[np.ndarray]] = {}
        self.pieces = 0
        begin: Progress | None = None
        with (
            mock.patch.object(taylor, "chunk_size", lambda width: size),
            mock.patch.object(stepper, "POLL_SECONDS", 0.0),
            mock.patch.object(stepper, "FIRST", 1 if looks else 256),
        ):
            while True:
                checkpointing = Checkpointing(begin, Schedule(1e9, 1e9), self.refuse)
                left = iter(range(looks))
                interrupted = (lambda left=left: next(left, None) is None) if looks else (lambda: False)
                self.outcome: Outcome = integrate(
                    ready, values, times, self.emit, interrupted,
                    checkpointing=checkpointing, emit_events=emit_events,
                )  # fmt: skip
                self.pieces += 1
                if self.outcome.ending is not Ending.INTERRUPTED:
                    break
                progress = self.outcome.progress
                assert progress is not None
                data, arrays = json.loads(json.dumps(progress.as_data())), progress.snapshot.arrays
                kept = ready.machine.program, ready.recording.conserved, times
                begin = Progress.from_data(data, arrays, *kept)

    def emit(self, chunk: Mapping[str, np.ndarray]) -> None:
        for path, samples in chunk.items():
            self.series.setdefault(path, []).append(np.array(samples))

    def leave_out(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Crossings of events are no samples."""

    def refuse(self, progress: Progress) -> None:
        raise AssertionError("no checkpoint is due")

    def __getitem__(self, path: str) -> bytes:
        return np.concatenate(self.series[path]).tobytes()


@pytest.mark.exhaustive(keep=0.15)
@given(
    system=st.sampled_from(DRAWN),
    samples=st.integers(2, 700),
    looks=st.integers(1, 40),
    size=st.integers(1, 300),
    sense=st.sampled_from([1, -1]),
)
@examples(4)
def test_interruptions_and_pieces_change_no_bit(system, samples, looks, size, sense):
    """Forward and backward."""
    whole, pieces = Run(system, samples, 0, sense=sense), Run(system, samples, looks, size, sense)
    assert whole.series.keys() == pieces.series.keys()
    for path in whole.series:
        assert whole[path] == pieces[path], path
    for name in ("steps", "t", "ending", "message", "h_drift", "p_drift"):
        assert getattr(whole.outcome, name) == getattr(pieces.outcome, name), name


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("linkage", [LINKAGE, KICKED])
@pytest.mark.parametrize("looks", [1, 10])
def test_a_singular_configuration_is_passed_alike_wherever_the_motion_was_interrupted(looks, linkage):
    whole, pieces = Run(linkage, 31, 0), Run(linkage, 31, looks, 5)
    heights = np.frombuffer(whole["q/y0"])
    assert len(whole.outcome.singular) == np.count_nonzero(heights[1:] * heights[:-1] < 0) >= 2
    assert pieces.outcome.singular == whole.outcome.singular
    assert pieces.pieces > 3
    for path in whole.series:
        assert whole[path] == pieces[path], path


@pytest.mark.exhaustive(keep=0.45)
def test_impacts_in_loops_are_the_same_wherever_the_motion_was_interrupted(monkeypatch):
    monkeypatch.setattr(systems, "FEWEST", 0)
    monkeypatch.setattr(systems, "FEWEST_SWITCHED", 0)
    assert systems.family_system(spec_of(BOUNCING)) is not None
    whole, pieces = Run(BOUNCING, 31, 0), Run(BOUNCING, 31, 3, 5)
    assert pieces.pieces > 20 and len(np.concatenate(whole.series["events/floor/t"])) > 50
    assert whole.series.keys() == pieces.series.keys()
    for path in whole.series:
        assert whole[path] == pieces[path], path


@pytest.mark.exhaustive(keep=0.45)
def test_a_run_is_really_taken_to_pieces():
    assert Run("double_pendulum", 100, 1).pieces > 50


@pytest.mark.exhaustive(keep=0.25)
@given(system=st.sampled_from(DRAWN), samples=st.integers(2, 200), finer=st.integers(1, 5))
@examples(5)
def test_the_samples_asked_for_change_neither_steps_nor_samples(system, samples, finer):
    """At the instants that both have; a power of two makes them the same to the last bit."""
    coarse, fine = Run(system, samples, 0), Run(system, (samples - 1) * 2**finer + 1, 0)
    assert (coarse.outcome.steps, coarse.outcome.t) == (fine.outcome.steps, fine.outcome.t)
    for path, parts in coarse.series.items():
        every = np.concatenate(fine.series[path])[:: 2**finer]
        assert np.concatenate(parts).tobytes() == np.ascontiguousarray(every).tobytes(), path
