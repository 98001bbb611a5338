"""Eight motions at once: each is what it is alone, whatever runs beside it, and ends when it must."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble import members as shared
from lagrange_cli.integrate.ensemble.follow import ensemble_method
from lagrange_cli.integrate.ensemble.lanes import LanesMethod
from lagrange_cli.integrate.ensemble.method import Starts
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.times import Times
from tests.support.motion import NAMES, SYSTEMS, prepared, spec_of, values_of

LARGE = (SYSTEMS / "n_pendulum.yaml").read_text().replace("N: 5", "N: 20")
"""A system whose motions are followed one by one."""
SMOOTH = [name for name in NAMES if not spec_of(name).events and name != "newtons_cradle"]
"""Motions with events are followed one by one."""
STOP = {"solar_system": 100.0, "figure_eight": 3.0}
TWO_WAYS = """
parameters: {a: 0.0}
coordinates: {x: {initial: 1.0}, y: {initial: 0.0}}
lagrangian: a*x_dot**2/2 + x_dot*y_dot - x*y
"""
"""x'' = -x and y'' = -y + a x: the mass matrix [[a, 1], [1, 0]] is indefinite, and its pivot depends on a."""
FALL = """
parameters: {k: 1.0}
coordinates: {x: {initial: 1.0}}
lagrangian: x_dot**2/2 + k/x
"""
"""Where k > 0 it falls into the centre, from x = 1 after pi/sqrt(8 k)."""
STANDING = """
parameters: {m: 1.0}
coordinates: {x: {initial: 1.0, velocity: 1.0}, y: {initial: 0.0}}
lagrangian: m*x_dot**2/2 + x**2*y_dot**2/2
"""
"""The mass matrix is singular where x is 0; and there is none where m is."""
CHOSEN = """
parameters: {a: 1.0}
coordinates: {x: {initial: 1.0}, y: {initial: 0.5}}
potential: where(a > 0, x**2*y + sqrt(a), sqrt(1 - a) + x*y) + abs(a)*y**2
masses: {p: 1}
embedding: {p: [x, y*where(a > 0, 1, 2)]}
"""
"""Which potential a member has depends on the sign of its own parameter."""
STIFF = """
parameters: {w: 1.0}
coordinates: {x: {initial: 1.0}}
lagrangian: x_dot**2/2 - w**2*x**2/2
"""


@dataclass
class Kept:
    """What members gave, in their order."""

    going: bool
    ending: list[Ending]
    t: np.ndarray
    state: np.ndarray
    steps: np.ndarray
    samples: np.ndarray | None
    reached: np.ndarray


def members_of(system, count, sets=None, spread=0.02, seed=1):
    """Parameters and initial states near those of the file, other ones for each member."""
    values, program = values_of(system, sets), prepared(system).machine.program
    random = np.random.default_rng(seed)
    parameters = np.array([values.parameters[name] for name in program.parameters], dtype=float)
    state = np.array([*values.q, *values.v], dtype=float)
    some = [row * (1 + spread * random.standard_normal((count, len(row)))) for row in (parameters, state)]
    return some[0], np.hstack([some[1], np.zeros((count, len(program.integrals)))])


def unasked():
    """The method for single motions where none is needed."""
    raise AssertionError


def run(
    system, parameters, states, times, *, sampled=True, threads=1, single=False, watch=lambda done: False
):
    """All members by the engine for many, or one by one."""
    many = prepared(system, ensemble=True, backward=times.backward)
    alone = prepared(system, backward=times.backward).follower
    method = OneByOne(alone) if single else ensemble_method(many, lambda: alone)
    missing = many.machine.program.rows - states.shape[1]  # integrals, which begin with 0
    states = np.pad(states, ((0, 0), (0, missing)))
    batches = []
    going = method.follow(Starts(parameters, states, times, sampled), batches.append, watch, threads)
    index = np.concatenate([batch.index for batch in batches])
    endings = [ending for batch in batches for ending in batch.ending]
    order = np.argsort(index)
    assert len(set(index)) == len(index)
    if going:
        assert sorted(index) == [*range(len(states))]
    rest = {
        name: np.concatenate([getattr(batch, name) for batch in batches])[order]
        for name in ("t", "state", "steps", "reached", *(["samples"] if sampled else []))
    }
    return Kept(going=going, ending=[endings[i] for i in order], **({"samples": None} | rest))


def same(a: Kept, b: Kept, rows=slice(None), others=slice(None)) -> bool:
    """Whether they are the same to the last bit."""
    arrays = ("t", "state", "steps", "reached", "samples")
    return [a.ending[i] for i in np.arange(len(a.t))[rows]] == [
        b.ending[i] for i in np.arange(len(b.t))[others]
    ] and all(getattr(a, x)[rows].tobytes() == getattr(b, x)[others].tobytes() for x in arrays)


def times_of(stop, count=9, start=0.0):
    return Times(start, stop, count, (stop - start) / (count - 1))


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(
    ("name", "sense"),
    [*((name, 1) for name in SMOOTH), ("driven_damped_pendulum", -1), ("central_force", -1)],
)
def test_members_move_as_they_do_alone(name, sense):
    parameters, states = members_of(name, 11)
    times = times_of(0.5 + sense * STOP.get(name, 1.0), start=0.5)
    many = run(name, parameters, states, times)
    alone = run(name, parameters, states, times, single=True)
    assert isinstance(ensemble_method(prepared(name, ensemble=True), unasked), LanesMethod)
    assert many.ending == alone.ending == [Ending.COMPLETE] * len(states)
    assert np.all(many.reached == times.count) and np.all(many.t == times.stop)
    scale = np.abs(alone.samples).max(axis=(0, 2), keepdims=True) + 1e-300
    assert np.max(np.abs(many.samples - alone.samples) / scale) < 1e-12
    assert np.max(np.abs(many.state - many.samples[:, :, -1]) / scale[:, :, 0]) < 1e-13


@pytest.mark.exhaustive(keep=0.8)
def test_members_choose_their_own_branches():
    parameters, states = members_of(CHOSEN, 19)
    parameters[:, 0] = np.random.default_rng(1).uniform(-1, 1, 19)
    times = times_of(1.0)
    many, alone = (run(CHOSEN, parameters, states, times, single=single) for single in (False, True))
    assert many.ending == alone.ending == [Ending.COMPLETE] * 19
    assert np.max(np.abs(many.samples - alone.samples)) < 1e-13


@pytest.mark.exhaustive(keep=0.5)
def test_integrals_are_carried_along():
    program = prepared("driven_damped_pendulum", outputs=("ledger", "action"), ensemble=True).machine.program
    assert len(program.integrals) > 1 and program.lanes
    alone = prepared("driven_damped_pendulum", outputs=("ledger", "action"))
    parameters, states = members_of("driven_damped_pendulum", 9)
    states = np.hstack([states, np.zeros((9, len(program.integrals)))])
    found = []
    for method in (
        ensemble_method(
            prepared("driven_damped_pendulum", outputs=("ledger", "action"), ensemble=True), unasked
        ),
        OneByOne(alone.follower),
    ):
        batches = []
        method.follow(Starts(parameters, states, times_of(5.0), False), batches.append, lambda done: False, 1)
        order = np.argsort(np.concatenate([batch.index for batch in batches]))
        found.append(np.concatenate([batch.state for batch in batches])[order])
    assert np.abs(found[0] - found[1]).max() < 1e-12
    assert np.abs(found[0][:, 2:]).min() > 0


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", ["double_pendulum", "driven_damped_pendulum", "figure_eight"])
def test_a_member_is_the_same_in_any_lane_beside_any_others(name):
    parameters, states = members_of(name, 45)
    times = times_of(2.0)
    whole = run(name, parameters, states, times)
    assert same(whole, run(name, parameters[::-1], states[::-1], times), others=slice(None, None, -1))
    for part in (slice(3, 4), slice(5, 14), slice(20, 45)):
        assert same(whole, run(name, parameters[part], states[part], times), rows=part)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("threads", [2, 3, 7])
def test_the_number_of_threads_changes_nothing(threads):
    parameters, states = members_of("double_pendulum", 100)
    times = times_of(2.0)
    whole = run("double_pendulum", parameters, states, times)
    assert same(whole, run("double_pendulum", parameters, states, times, threads=threads))
    large, times = members_of(LARGE, 5), times_of(0.5)
    assert isinstance(ensemble_method(prepared(LARGE, ensemble=True), unasked), OneByOne)
    one = run(LARGE, *large, times)
    assert same(one, run(LARGE, *large, times, threads=threads))


def test_samples_change_no_step():
    parameters, states = members_of("double_pendulum", 20)
    few = run("double_pendulum", parameters, states, times_of(3.0), sampled=False)
    many = run("double_pendulum", parameters, states, times_of(3.0, 500))
    assert few.samples is None and few.state.tobytes() == many.state.tobytes()
    assert few.steps.tobytes() == many.steps.tobytes()


def test_little_room_for_samples_changes_nothing(monkeypatch):
    parameters, states = members_of("double_pendulum", 60)
    times = times_of(2.0)
    whole = run("double_pendulum", parameters, states, times)
    for members in (1, 5, 17):
        monkeypatch.setattr(shared, "MEMORY", members * 8 * 4 * times.count)
        monkeypatch.setattr(shared, "LARGEST", 0)
        assert same(whole, run("double_pendulum", parameters, states, times, threads=2))


def test_members_that_take_long_wait_for_nobody():
    frequency = 10.0 ** np.linspace(0, 3, 40)[np.random.default_rng(3).permutation(40)]
    states = np.tile([1.0, 0.0], (40, 1))
    many = run(STIFF, frequency[:, None], states, times_of(10.0))
    alone = run(STIFF, frequency[-1:, None], states[-1:], times_of(10.0))
    assert same(many, alone, rows=slice(-1, None))
    assert many.steps.max() > 300 * many.steps.min()
    when = np.linspace(0, 10, 9)
    error = np.abs(many.samples[:, 0] - np.cos(np.outer(frequency, when)))
    assert np.all(error.max(axis=1) < 1e-13 + 1e-15 * 10 * frequency)


def test_a_slow_motion_takes_few_steps():
    """One radian in 1e18 s: higher coefficients of its series have underflowed, and none limits a step."""
    starts = np.linspace(1, 2, 9)
    states = np.zeros((9, 2 + len(prepared(STIFF).machine.program.integrals)))
    states[:, 0] = starts
    many = run(STIFF, np.full((9, 1), 1e-18), states, times_of(1e19))
    assert max(many.steps) <= 30
    expected = starts[:, None] * np.cos(10 * np.linspace(0, 1, 9))
    np.testing.assert_allclose(many.samples[:, 0], expected, rtol=0, atol=1e-14)


def test_the_pivot_is_each_lanes_own():
    a = np.array([0.0, 5.0, -3.0, 0.2, 1.0, 1e-9, 1e9, 0.0, 2.0, -1.0])
    states = np.tile([1.0, 0.0, 0.0, 0.0], (10, 1))
    many = run(TWO_WAYS, a[:, None], states, times_of(6.0))
    t = np.linspace(0.0, 6.0, 9)
    assert np.abs(many.samples[:, 0] - np.cos(t)).max() < 1e-14
    error = np.abs(many.samples[:, 1] - a[:, None] / 2 * t * np.sin(t))
    assert np.all(error.max(axis=1) < 1e-14 * (1 + np.abs(a)))


def test_some_fall_into_the_centre_while_others_go_on():
    k = np.where(np.arange(30) % 3 == 1, 1.0, -1.0)
    k[4] = 2.0
    states = np.tile([1.0, 0.0], (30, 1))
    times = times_of(4.0, 41)
    many = run(FALL, k[:, None], states, times)
    for i, one in enumerate(k):
        if one < 0:
            assert many.ending[i] is Ending.COMPLETE and many.t[i] == 4.0 and many.reached[i] == 41
            continue
        end = np.pi / np.sqrt(8 * one)
        assert many.ending[i] is Ending.STEP_UNDERFLOW
        assert many.t[i] == pytest.approx(end, rel=1e-9)
        assert many.reached[i] == np.sum(times.chunk(0, 41) < end)
        assert np.all(np.isnan(many.samples[i, :, many.reached[i] :]))
        assert np.all(np.isfinite(many.samples[i, :, : many.reached[i]]))
    alone = run(FALL, k[:, None], states, times, single=True)
    assert many.ending == alone.ending and np.all(many.reached == alone.reached)
    assert many.t == pytest.approx(alone.t, rel=1e-9)
    well = k < 0
    healthy = run(FALL, k[well, None], states[well], times)
    assert same(many, healthy, rows=well)


def test_singular_ones_and_such_that_are_no_numbers_end_at_once():
    mass = np.ones(20)
    states = np.tile([1.0, 0.0, 1.0, 0.5], (20, 1))
    mass[3], states[7, 0], states[11, 2] = 0.0, 0.0, np.nan
    many = run(STANDING, mass[:, None], states, times_of(2.0))
    bad = {3: Ending.NOT_A_NUMBER, 7: Ending.SINGULAR_MASS_MATRIX, 11: Ending.NOT_A_NUMBER}
    for i, ending in enumerate(many.ending):
        assert ending is bad.get(i, Ending.COMPLETE)
        assert many.t[i] == (0.0 if i in bad else 2.0)
    alone = run(STANDING, mass[:, None], states, times_of(2.0), single=True)
    assert many.ending == alone.ending
    good = [i for i in range(20) if i not in bad]
    assert same(many, run(STANDING, mass[good, None], states[good], times_of(2.0)), rows=good)


def test_first_steps_are_looked_at_in_each_lane():
    states = np.array([[0.0, 0.0], [1e-300, 0.0], [np.pi, 0.0], [1.0, 0.0], [0.0, 30.0]] * 4)
    values = values_of("pendulum").parameters.values()
    parameters = np.tile([*values], (20, 1))
    many = run("pendulum", parameters, states, times_of(20.0))
    alone = run("pendulum", parameters, states, times_of(20.0), single=True)
    for start in range(0, 20, 5):
        assert same(many, many, rows=slice(0, 5), others=slice(start, start + 5))
    quiet = [0, 1, 3, 4]
    assert np.abs(many.samples - alone.samples)[quiet].max() < 1e-9
    assert many.steps[0] == 1 and np.all(many.steps < 4 * alone.steps + 8)


def test_energy_is_kept_as_well_as_by_one_motion():
    parameters, states = members_of("double_pendulum", 64, spread=0.05)
    drift = []
    for single in (False, True):
        kept = run("double_pendulum", parameters, states, times_of(10.0), single=single)
        drift.append(np.array([energies(p, s) for p, s in zip(parameters, kept.samples)]))
    many, alone = (np.sqrt(np.mean((each / each[:, :1] - 1) ** 2)) for each in drift)
    assert many < 2 * alone and many < 1e-13


def energies(parameters, states):
    """T + U of the double pendulum at each sample."""
    m1, m2, g, l1, l2 = parameters
    a, b, u, v = states
    kinetic = (m1 + m2) * (l1 * u) ** 2 / 2 + m2 * (l2 * v) ** 2 / 2 + m2 * l1 * l2 * u * v * np.cos(a - b)
    return kinetic - (m1 + m2) * g * l1 * np.cos(a) - m2 * g * l2 * np.cos(b)


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("name", ["double_pendulum", LARGE], ids=["lanes", "one by one"])
def test_it_stops_when_told_and_says_what_has_ended(name):
    parameters, states = members_of(name, 400 if name == "double_pendulum" else 12)
    seen = []

    def watch(done):
        seen.append(done)
        return done >= 1

    times = times_of(30.0 if name == "double_pendulum" else 2.0)
    many = run(name, parameters, states, times, threads=2, watch=watch)
    whole = run(name, parameters, states, times, threads=2)
    assert not many.going and whole.going
    complete = [ending is Ending.COMPLETE for ending in many.ending]
    assert 0 < sum(complete) < len(states) and seen == sorted(seen)
    known = {state.tobytes() for state in whole.state}
    assert all(state.tobytes() in known for state in many.state[complete])


@pytest.mark.exhaustive(keep=0.25)
def test_an_error_of_whoever_takes_members_stops_all():
    class Full(Exception):
        pass

    def refuse(batch):
        raise Full

    for name in ("double_pendulum", LARGE):
        parameters, states = members_of(name, 20)
        method = ensemble_method(prepared(name, ensemble=True), unasked)
        with pytest.raises(Full):
            method.follow(Starts(parameters, states, times_of(1.0), True), refuse, lambda done: False, 2)


def test_what_meets_a_kink_is_followed_alone():
    """A wedge: those that start near its bottom pass it, the others do not in so short a time."""
    wedge = """
        coordinates: {x: {initial: 1.0}}
        masses: {p: 1}
        embedding: {p: [x]}
        potential: sqrt((x - 0.25)**2)
        """
    places = np.array([0.3, 5.0, 0.4, 6.0, 7.0, 0.27, 8.0, 9.0, 0.5, 10.0, 0.29])
    states = np.stack([places, np.zeros_like(places)], axis=1)
    parameters, times = np.empty((len(places), 0)), times_of(2.0, 41)
    many = run(wedge, parameters, states, times)
    alone = run(wedge, parameters, states, times, single=True)
    near = places < 1
    assert many.ending == alone.ending == [Ending.COMPLETE] * len(places)
    assert same(many, alone, near, near)
    height, speed = abs(many.samples[:, 0] - 0.25), many.samples[:, 1]
    assert np.ptp(height + speed**2 / 2, axis=1).max() <= 1e-12
    assert np.all(many.steps[~near] <= 5)
