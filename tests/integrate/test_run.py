"""How a run samples, pauses, ends and skips."""

from itertools import pairwise

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import chunk_size
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods import stepper, taylor
from lagrange_cli.native.orders import order_for
from lagrange_cli.native.program import Steps, write_program
from lagrange_cli.series.program import Op
from tests.support.motion import FULL, follow, program_of, residual_of

OF_STEPS = pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
"""The methods whose steps are compiled."""
FINEST = {"taylor": FULL, "ias15": FULL, "DOP853": 1e-12}


@pytest.mark.exhaustive(keep=2)
@OF_STEPS
def test_samples_do_not_change_the_steps(method):
    coarse, fine = (
        follow("double_pendulum", 20.0, n, method=method, tolerance=FINEST[method]) for n in (5, 4001)
    )
    assert coarse.outcome.steps == fine.outcome.steps
    assert np.array_equal(coarse["q/theta1"], fine["q/theta1"][::1000])


@pytest.mark.exhaustive(keep=0.5)
@OF_STEPS
def test_chunks_and_pauses_change_nothing(monkeypatch, method):
    asked = {"outputs": ("q", "v", "h", "ledger"), "method": method, "tolerance": FINEST[method]}
    whole = follow("double_pendulum", 20.0, 1001, **asked)
    monkeypatch.setattr(taylor, "chunk_size", lambda width: 7)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(stepper, "FIRST", 1)
    pieces = follow("double_pendulum", 20.0, 1001, **asked)
    assert pieces.outcome.steps == whole.outcome.steps
    for path, series in whole.data.items():
        assert np.array_equal(series, pieces[path]), path


def test_chunks_are_bounded_whatever_the_system():
    assert chunk_size(1) == 65536
    assert chunk_size(10**6) == 256


def test_an_interrupted_run_keeps_the_beginning(monkeypatch):
    whole = follow("double_pendulum", 20.0, 1001)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(stepper, "FIRST", 1)
    asked = iter(range(10**6))
    part = follow("double_pendulum", 20.0, 1001, interrupted=lambda: next(asked) >= 5)
    assert part.outcome.ending is Ending.INTERRUPTED
    assert part.outcome.ending.status == "interrupted"
    count = len(part["t"])
    assert 0 < count < 1001
    final = part.outcome.final
    assert part.outcome.t == final.t >= part["t"][-1]
    assert final.q["theta2"] == pytest.approx(follow("double_pendulum", final.t, 2)["q/theta2"][-1], abs=1e-9)
    assert np.array_equal(part["q/theta2"], whole["q/theta2"][:count])


def test_times_end_exactly_at_the_stop():
    motion = follow("pendulum", 0.7, 8, start=-0.7)
    assert motion["t"][0] == -0.7
    assert motion["t"][-1] == motion.outcome.t == 0.7


LINE = (
    "coordinates: {{x: {{initial: {x}, velocity: {v}}}}}\n"
    "masses: {{p: 1}}\nembedding: {{p: x}}\npotential: {potential}\n"
)
ENDINGS = {
    "collision": (LINE.format(x=1, v=0, potential="-1/x"), Ending.STEP_UNDERFLOW),
    "hard collision": (LINE.format(x=1, v=0, potential="-1/x**4"), Ending.STEP_UNDERFLOW),
    "root of a negative number": (LINE.format(x=1, v=-1, potential="0*x + 2*(x)**2.5"), None),
    "logarithm of zero": (LINE.format(x=0, v=1, potential="log(x)"), Ending.NOT_A_NUMBER),
    "arc sine out of its domain": (LINE.format(x=2, v=1, potential="asin(x)"), Ending.NOT_A_NUMBER),
    "pole": (
        "coordinates: {th: {initial: 0, velocity: 1}, ph: {initial: 0}}\nmasses: {p: 1}\n"
        "embedding: {p: [sin(th)*cos(ph), sin(th)*sin(ph), cos(th)]}\n",
        Ending.SINGULAR_MASS_MATRIX,
    ),
}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("name", ENDINGS)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
def test_a_motion_that_cannot_go_on_says_so(name, method):
    text, ending = ENDINGS[name]
    motion = follow(
        text, 10.0, 1001, method=method, tolerance=FULL if method in ("taylor", "ias15") else 1e-8
    )
    outcome = motion.outcome
    if method in ("taylor", "ias15") and ending is not None:
        assert outcome.ending is ending
    assert outcome.ending is not Ending.COMPLETE
    assert outcome.ending.status == "failed"
    assert f"t = {outcome.t:.9g}" in outcome.message
    assert " = " in outcome.message.partition("where")[2]
    for series in motion.data.values():
        assert np.all(np.isfinite(series[1:]))
        assert len(series) == len(motion["t"])


def test_the_fall_into_a_centre_is_followed_to_the_end():
    """x'' = -1/x^2 from rest at 1 collides at t = pi/2/sqrt(2)."""
    motion = follow(ENDINGS["collision"][0], 10.0, 1001)
    assert abs(motion.outcome.t - np.pi / 2 / np.sqrt(2)) <= 1e-12
    assert motion.outcome.steps <= 1000


def observed(system, outputs):
    return program_of(system, tuple(outputs.split(",")))


@pytest.mark.exhaustive(keep=0.5)
def test_only_what_is_asked_for_is_in_the_program():
    assert observed("double_pendulum", "q,v").observed == ()
    assert observed("double_pendulum", "q,v").operations["observe"] == 0
    assert observed("double_pendulum", "h").observed == ("h",)
    assert observed("double_pendulum", "q,v,p,h").integrals == ()
    everything = observed("double_pendulum", "q,v,p,h,T,U,energy,positions,ledger,action")
    assert len(everything.integrals) == 3  # h is conserved by structure: its ledger needs no quadrature
    alone = observed("double_pendulum", "q,v")
    assert everything.operations["jet"] > alone.operations["jet"]
    assert everything.series.convolutions == alone.series.convolutions  # those of the motion


def program(system):
    return write_program(residual_of(system), Steps(order_for(FULL)), {}, {})


def test_time_is_absent_where_the_equations_do_not_contain_it():
    assert all(one.op is not Op.TIME for one in program("rotating_hoop").series.series)  # it cancels
    assert any(one.op is Op.TIME for one in program("driven_damped_pendulum").series.series)


def test_structure_of_the_mass_matrix():
    assert residual_of("free_particles").constant_mass_matrix
    assert residual_of("free_particles").blocks == tuple((k,) for k in range(9))
    assert residual_of("spherical_pendulum").blocks == ((0,), (1,))
    assert not residual_of("spherical_pendulum").constant_mass_matrix
    assert residual_of("double_pendulum").blocks == ((0, 1),)


def test_parameters_stay_inputs():
    """One program serves every value: parameter-only expressions are computed once a run, from slots."""
    text = program("double_pendulum").text
    changed = residual_of("double_pendulum")
    assert write_program(changed, Steps(order_for(FULL)), {}, {}).text == text
    assert program("double_pendulum").constants >= 3
    light = follow("double_pendulum", 5.0, sets={"m2": 1e-9})
    plain = follow("pendulum", 5.0, sets={"theta": 2.0, "theta_dot": 0, "m": 1, "l": 1, "g": 9.81})
    assert np.max(np.abs(light["q/theta1"] - plain["q/theta"])) <= 1e-6


@pytest.mark.exhaustive(keep=0.45)
def test_large_systems_grow_with_their_terms_not_their_squares():
    """A line of springs: operations per step in proportion to its length."""

    def springs(size):
        names = [f"x{k}" for k in range(size)]
        energies = [f"({a} - {b})**2 + ({a} - {b})**4" for a, b in pairwise(names)]
        return (
            f"coordinates: {{{', '.join(f'{n}: {{initial: 0.1}}' for n in names)}}}\n"
            f"masses: {{{', '.join(f'p{n}: 1' for n in names)}}}\n"
            f"embedding: {{{', '.join(f'p{n}: {n}' for n in names)}}}\npotential: {' + '.join(energies)}\n"
        )

    small, large = (program(springs(size)) for size in (10, 40))
    assert large.operations["jet"] <= 5 * small.operations["jet"]
    assert large.series.convolutions == 4.333333333333333 * small.series.convolutions


def test_what_goes_wrong_at_the_start_is_not_to_be_avoided_by_an_earlier_end():
    at_start = follow("pendulum", 1.0, sets={"l": 0.0}).outcome
    assert at_start.t == 0.0 and at_start.ending is not Ending.COMPLETE
    assert "--stop" not in at_start.message and "start from another state" in at_start.message
    later = follow(
        "coordinates: {x: {initial: 1, velocity: -1}}\nlagrangian: x_dot**2/2 + 1/x**2\n", 9.0
    ).outcome
    assert later.t > 0 and "end the run before it with --stop" in later.message
