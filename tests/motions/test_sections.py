"""Crossings in lanes against closed forms: none is missed, none counted twice, each is where it belongs."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.lanes import LanesMethod
from lagrange_cli.integrate.ensemble.method import Section, Starts
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.ensemble.section import EVERY
from lagrange_cli.integrate.events import Crossings
from lagrange_cli.integrate.method import End, Start
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.spec import SURFACE
from lagrange_cli.spec.surface import with_surface
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import FULL, prepare, prepared, spec_of

FREE = "coordinates: {x: {initial: 0.0}}\nlagrangian: x_dot**2/2\n"
SPRING = "parameters: {w: 1.0}\ncoordinates: {x: {initial: 0.0}}\nlagrangian: x_dot**2/2 - w**2*x**2/2\n"
PLACED = "parameters: {a: 0.3}\ncoordinates: {x: {initial: 1.0}}\nlagrangian: x_dot**2/2 - x**2/2\n"
PENDULUM = "coordinates: {u: {initial: 1.0}}\nlagrangian: u_dot**2/2 + cos(u)\n"
THROWN = "coordinates: {y: {initial: 0.0}}\nlagrangian: y_dot**2/2 - y\n"
FALL = "coordinates: {r: {initial: 1.0}}\nlagrangian: r_dot**2/2 + 1/r\n"
ROUNDING = 4e-15


@dataclass
class Taken:
    """What each motion gave: times (m, n), states (m, 2 d, n), how many crossings, and how it ended."""

    t: np.ndarray
    states: np.ndarray
    reached: np.ndarray
    ending: list[Ending]
    end: np.ndarray

    def of(self, member: int = 0) -> np.ndarray:
        """The times of a motion's crossings."""
        return self.t[member, : self.reached[member]]


@cache
def ready(system: str, where: str, backward: bool = False) -> Prepared:
    """Compiled for crossings of a surface, or, without one, for periods."""
    spec = with_surface(spec_of(system), where) if where else spec_of(system)
    kind = "where" if where else "every"
    asked = Compilation("taylor", FULL, frozenset("qv"), ensemble=True, section=kind, backward=backward)
    return prepare(derive_system(spec), asked)


def unasked():
    """No motion of a section is followed alone."""
    raise AssertionError


def take(
    system: str,
    where: str,
    states: Sequence[Sequence[float]],
    count: int = 20,
    direction: int = 1,
    *,
    parameters: Sequence[Sequence[float]] | None = None,
    periods: Sequence[float] | None = None,
    start: float = 0.0,
    stop: float = math.inf,
    patience: int = 2000,
    threads: int = 1,
) -> Taken:
    """The section of the motions with these initial states."""
    one = ready(system, where, stop < start)
    assert one.machine.follow is not None
    given = np.array(states, dtype=float)
    given = np.pad(given, ((0, 0), (0, one.machine.program.rows - given.shape[1])))
    width = len(one.machine.program.parameters)
    numbers = np.ones((len(given), width)) if parameters is None else np.array(parameters, dtype=float)
    kept = Section(count, direction, None if periods is None else np.array(periods, float), patience)
    starts = Starts(numbers, given, Times(start, stop, 2, stop - start), False, kept)
    batches = []
    method = LanesMethod(one.machine, unasked, one.compilation.backward)
    assert method.follow(starts, batches.append, lambda done: False, threads)
    index = np.concatenate([batch.index for batch in batches])
    order, endings = np.argsort(index), [ending for batch in batches for ending in batch.ending]
    assert index[order].tolist() == [*range(len(given))]
    rows = {name: np.concatenate([getattr(b, name) for b in batches])[order] for name in
            ("times", "samples", "reached", "t")}  # fmt: skip
    degrees = 2 * one.machine.program.degrees
    return Taken(
        rows["times"], rows["samples"][:, :degrees], rows["reached"], [endings[i] for i in order], rows["t"]
    )


@pytest.mark.exhaustive(keep=0.7)
def test_an_oscillator_crosses_once_a_period_and_not_at_its_start():
    taken = take(SPRING, "x", [[0.0, 1.0]], 300)
    assert taken.ending == [Ending.COMPLETE]
    n = np.arange(1, 301)
    assert np.abs(taken.t[0] / (2 * math.pi * n) - 1).max() < ROUNDING
    assert np.abs(taken.states[0, 0]).max() < 1e-15
    assert np.abs(taken.states[0, 1] - 1).max() < 1e-12
    assert taken.end[0] == taken.t[0, -1]


@pytest.mark.parametrize(("direction", "first", "step"), [(-1, 1, 2), (1, 2, 2), (0, 1, 1)])
def test_the_direction_is_that_of_the_expression(direction, first, step):
    taken = take(SPRING, "x", [[0.0, 1.0]], 40, direction)
    expected = math.pi * (first + step * np.arange(40))
    assert np.abs(taken.t[0] / expected - 1).max() < ROUNDING


@pytest.mark.exhaustive(keep=0.7)
def test_the_period_of_a_pendulum_is_an_elliptic_integral():
    amplitudes = [0.1, 1.0, 2.0, 3.0]
    taken = take(PENDULUM, "u_dot", [[a, 0.0] for a in amplitudes], 25, -1)
    for row, amplitude in zip(taken.t, amplitudes):
        period = 4 * float(mpmath.ellipk(mpmath.sin(mpmath.mpf(amplitude) / 2) ** 2))
        assert np.abs(row / (period * np.arange(1, 26)) - 1).max() < 1e-12


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("seed", range(60))
def test_roots_of_any_pattern_within_one_step(seed):
    """A free motion x = t takes steps without end, so that all roots of a polynomial in x lie in one."""
    source = random.Random(seed)
    count = source.randint(2, 5)
    roots = [source.uniform(0.2, 3.0) for _ in range(count)]
    if source.random() < 0.5:  # a close pair
        roots.append(roots[0] + source.choice([1e-2, 1e-3]) * source.uniform(1, 2))
    roots = sorted(roots)
    where = "*".join(f"(x - {one!r})" for one in roots)
    taken = take(FREE, where, [[0.0, 1.0]], 20, 0, stop=4.0)
    assert taken.ending == [Ending.COMPLETE]
    found = taken.of()
    assert len(found) == len(roots)
    size = math.prod(4 + one for one in roots)  # of the polynomial's terms at the end of the step
    for one, at in zip(found, roots):
        slope = math.prod(abs(at - other) for other in roots if other != at)
        assert abs(one - at) < 2.0**-50 * size / slope
    rising = take(FREE, where, [[0.0, 1.0]], 20, 1, stop=4.0).of()
    assert rising.tolist() == found[(len(roots) + 1) % 2 :: 2].tolist()


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-10])
def test_two_crossings_around_a_summit_that_hardly_passes_the_surface(depth):
    """y = t - t^2/2 has its summit 1/2 at t = 1."""
    taken = take(THROWN, f"y - {0.5 - depth!r}", [[0.0, 1.0]], 2, 0, stop=10.0)
    width = math.sqrt(2 * (0.5 - (0.5 - depth)))
    assert np.abs(taken.of() - [1 - width, 1 + width]).max() < 1e-15 / width


@pytest.mark.exhaustive(keep=0.8)
def test_what_touches_the_surface_does_not_cross_it():
    for direction in (-1, 0, 1):
        taken = take(THROWN, "y - 1/2", [[0.0, 1.0]], 2, direction, stop=1.7)
        assert taken.reached.tolist() == [0] and taken.ending == [Ending.COMPLETE]


@pytest.mark.exhaustive(keep=0.7)
def test_a_series_that_converges_more_slowly_than_the_motion():
    """sin(40 x) on x = t has 200 zeros in what would be one step."""
    taken = take(FREE, "sin(40*x)", [[0.0, 1.0]], 200, 0)
    assert np.abs(taken.t[0] - math.pi / 40 * np.arange(1, 201)).max() < 1e-13


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize(
    ("surface", "bound"),
    [
        ("sin(x - a) - (x - a)", 3e-14),
        ("(1 - cos(x - a))*(x - a)", 3e-14),
        ("x - a - sin(x - a)*cos(x - a)", 3e-14),
        ("(sin(x - a) - (x - a))*(1 - cos(x - a))", 1e-11),  # of order 5
    ],
)
def test_a_multiple_zero_is_as_accurate_as_a_simple_one(surface, bound):
    """Where g is (x - a)^3 but for rounding, rounding moves its zero by 1e-5, but not that of g''."""
    places = np.random.default_rng(7).uniform(-0.95, 0.95, 64)
    taken = take(PLACED, surface, [[1.0, 0.0]] * 64, 10, 0, parameters=[[a] for a in places])
    assert taken.reached.tolist() == [10] * 64
    assert np.abs(taken.states[:, 0] - places[:, None]).max() < bound


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("apart", [1e-3, 1e-4])
def test_zeros_that_are_near_each_other_are_not_taken_for_one(apart):
    taken = take(
        PLACED, f"(x - a)*(x - a - {apart})*(x - a + {apart})", [[1.0, 0.0]], 3, 0, parameters=[[0.3]]
    )
    expected = 0.3 + apart * np.array([1, 0, -1])
    assert np.abs(taken.states[0, 0] - expected).max() < 1e-16 / apart**2


@pytest.mark.exhaustive(keep=0.6)
def test_surfaces_may_depend_on_velocities_time_and_parameters():
    frequencies = [0.5, 1.0, 3.0]
    states = [[0.0, 1.0]] * 3
    taken = take(SPRING, "w*x*cos(t) - x_dot*sin(t)", states[:1], 10, 0, parameters=[[3.0]])
    n = np.arange(1, 11)  # sin(3 t - t)
    assert np.abs(taken.t[0] / (math.pi / 2 * n) - 1).max() < ROUNDING
    taken = take(SPRING, "x_dot", states, 10, -1, parameters=[[w] for w in frequencies])
    for row, w in zip(taken.t, frequencies):
        assert np.abs(row / ((0.5 * math.pi + 2 * math.pi * np.arange(10)) / w) - 1).max() < ROUNDING


@pytest.mark.exhaustive(keep=0.65)
def test_a_motion_is_the_same_whatever_runs_beside_it():
    source = np.random.default_rng(3)
    states = np.column_stack([source.uniform(-2, 2, 200), source.uniform(-1, 1, 200)])
    where = "(u - 0.1)*(u + 0.3)*(u_dot - u/3)"
    together = take(PENDULUM, where, states, 30)
    threaded = take(PENDULUM, where, states, 30, threads=3)
    assert together.t.tobytes() == threaded.t.tobytes()
    assert together.states.tobytes() == threaded.states.tobytes()
    order = source.permutation(200)
    shuffled = take(PENDULUM, where, states[order], 30)
    assert shuffled.t.tobytes() == together.t[order].tobytes()
    for member in (0, 7, 39):
        alone = take(PENDULUM, where, states[member : member + 1], 30)
        assert alone.t[0].tobytes() == together.t[member].tobytes()


@pytest.mark.exhaustive(keep=0.45)
def test_crossings_lie_on_the_motion_that_solve_follows():
    taken = take("henon_heiles", "x + y/2", [[0.0, 0.1, 0.49, 0.05]], 40)
    alone = prepared("henon_heiles").follower
    program = prepared("henon_heiles").machine.program
    state = np.pad([0.0, 0.1, 0.49, 0.05], (0, program.rows - 4))
    for k in (0, 12, 39):
        t = taken.t[0, k]
        end = alone.follow(Start(np.ones(len(program.parameters)), state, Times(0.0, t, 2, t)))
        assert np.abs(end.state[:4] - taken.states[0, :, k]).max() < 1e-11
        assert abs(taken.states[0, 0, k] + taken.states[0, 1, k] / 2) < 1e-15


SURFACES = {
    "henon_heiles": (["x", "y", "x_dot", "y_dot"], [(-0.3, 0.3)] * 4),
    "double_pendulum": (["theta1", "theta2_dot", "sin(theta1)", "cos(theta2)"], [(-2, 2)] * 4),
    "central_force": (["r - 1", "r_dot", "sin(theta)"], [(0.5, 1.5), (0, 6), (-0.3, 0.3), (0.7, 1.1)]),
    "spherical_pendulum": (
        ["theta - 1", "sin(phi)", "phi_dot - 2"],
        [(0.5, 1.5), (0, 6), (-0.3, 0.3), (1, 2)],
    ),
}
"""What surfaces are made of, and between which numbers states are drawn."""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("seed", range(24))
def test_random_surfaces_have_the_crossings_that_events_have(seed):
    """Events are found by other code, in steps of another length."""
    source = random.Random(seed)
    system = source.choice(sorted(SURFACES))
    pieces, bounds = SURFACES[system]

    def term() -> str:
        factors = [f"({source.choice(pieces)})" for _ in range(source.choice([1, 1, 2]))]
        return "*".join([f"{source.uniform(-1, 1):.3f}", *factors])

    terms = [term() for _ in range(source.choice([1, 2, 3]))]
    where, direction = " + ".join([*terms, source.choice(["0", "0.2"])]), source.choice([-1, 0, 1])
    states = [[source.uniform(*each) for each in bounds] for _ in range(9)]
    spec = spec_of(system)
    values = resolve_values(spec).parameters
    numbers = [[values[name] for name in ready(system, where).machine.program.parameters]] * len(states)
    taken = take(system, where, states, 40, direction, stop=8.0, parameters=numbers)
    residual = derive_system(with_surface(spec, where, direction), resting=True)
    alone = prepare(residual, Compilation("taylor", FULL, frozenset("qv")))
    method = OneByOne(alone.follower, True, (SURFACE,))
    rows = alone.machine.program.rows - len(states[0])
    starts = Starts(
        np.array(numbers, float).reshape(9, -1), np.pad(states, ((0, 0), (0, rows))), Times(0.0, 8.0, 2, 8.0),
        False, section=Section(40, direction, None, 10**5),
    )  # fmt: skip
    batches = []
    assert method.follow(starts, batches.append, lambda done: False, 1)
    for member, batch in enumerate(batches):
        expected = batch.times[0, : batch.reached[0]]
        assert len(taken.of(member)) == len(expected), (where, states[member])
        assert np.allclose(taken.of(member), expected, rtol=0, atol=1e-8), (where, states[member])


class Polled:
    """A method that finds a crossing in each step of length 1, and is polled after every one."""

    def follow(self, start, observer):
        for steps in range(1, 2 * EVERY):
            found = (
                np.array([0]),
                np.array([float(steps)]),
                np.zeros(1),
                start.state[None],
                np.array([False]),
                np.zeros(1),
            )
            observer.events.crossed(Crossings(*found))
            due = observer.checkpoints.due(steps)
            if due or observer.interrupt(float(steps)):
                return End(Ending.INTERRUPTED, float(steps), start.state, steps, steps)
        return End(Ending.COMPLETE, start.times.stop, start.state, steps, steps)


@pytest.mark.parametrize("polls", [3, 5, 6, EVERY - 1, EVERY])
def test_an_interrupted_motion_ends_where_it_does_otherwise_or_has_not_ended(polls):
    """It has enough crossings after 5 steps, and is only asked about them at some later step."""
    starts = Starts(
        np.zeros((1, 0)), np.zeros((1, 2)), Times(0.0, math.inf, 2, math.inf), False,
        section=Section(5, 1, None, 10**5),
    )  # fmt: skip
    left = iter([False] * (polls - 1) + [True] * EVERY)
    batches = []
    OneByOne(Polled(), False, (SURFACE,)).follow(starts, batches.append, lambda done: next(left), 1)
    if polls < EVERY:
        assert batches[0].ending == [Ending.INTERRUPTED]
    else:
        assert (batches[0].ending, batches[0].steps.tolist()) == ([Ending.COMPLETE], [EVERY])
        assert batches[0].times.tolist() == [[1.0, 2.0, 3.0, 4.0, 5.0]]


def test_members_differ_in_their_periods():
    periods = [1.0, 0.3, 40.0]
    taken = take(SPRING, "", [[1.0, 0.0]] * 3, 12, periods=periods)
    for row, states, period in zip(taken.t, taken.states, periods):
        assert np.abs(row - period * np.arange(1, 13)).max() <= 1e-13 * period
        assert np.abs(states[0] - np.cos(row)).max() < 1e-12
    assert taken.ending == [Ending.COMPLETE] * 3
    stopped = take(SPRING, "", [[1.0, 0.0]], 12, periods=[1.0], start=2.0, stop=6.5)
    assert stopped.of().tolist() == [3.0, 4.0, 5.0, 6.0]


def test_backward_in_time():
    taken = take(SPRING, "x", [[0.0, 1.0]], 9, stop=-100.0)
    assert np.abs(taken.of() / (-2 * math.pi * np.arange(1, 10)) - 1).max() < ROUNDING
    assert np.abs(taken.states[0, 1] - 1).max() < 1e-13  # and x rises with t there
    strobed = take(SPRING, "", [[0.0, 1.0]], 3, periods=[1.0], stop=-100.0)
    assert strobed.of().tolist() == [-1.0, -2.0, -3.0]


@pytest.mark.exhaustive(keep=0.55)
def test_how_motions_end():
    stopped = take(SPRING, "x", [[0.0, 1.0]], 9, stop=20.0)
    assert stopped.ending == [Ending.COMPLETE] and len(stopped.of()) == 3
    assert abs(stopped.end[0] - 20.0) < 1e-14
    assert np.isnan(stopped.t[0, 3:]).all()
    lost = take(SPRING, "x - 2", [[0.0, 1.0], [0.0, 3.0]], 2, patience=50)
    assert lost.ending == [Ending.NO_CROSSING, Ending.COMPLETE]
    fell = take(FALL, "r - 1/2", [[1.0, 0.0], [1.0, 2.0]], 1, -1, stop=10.0)
    assert fell.ending == [Ending.COMPLETE] * 2 and fell.reached.tolist() == [1, 0]
    time = (math.pi / 2 + 1) / 2 / math.sqrt(2)  # r = cos^2 a, t = (a + sin a cos a)/sqrt 2, a = pi/4
    assert abs(fell.t[0, 0] - time) < 1e-15
