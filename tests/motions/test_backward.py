"""Motions followed backward in time: against closed forms, and back to where they came from."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import CheckpointSink, Observer, Start
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from tests.support.motion import (
    FULL,
    each_formulation,
    error,
    follow,
    prepare,
    prepared,
    run,
    samples_of,
    values_of,
)

DRIVEN = """
parameters: {m: 1.25, k: 2.5, c: 0.375, F: 0.75, w: 1.875}
coordinates:
  x: {initial: 0.5, velocity: -0.25}
masses: {p: m}
embedding: {p: [x]}
potential: k*x**2/2 - F*x*cos(w*t)
dissipation: c*x_dot**2/2
"""
EVERYTHING = ("q", "v", "p", "h", "T", "U", "energy", "positions", "ledger", "action")
THERE_AND_BACK = {
    "central_force": 9.0, "charged_particle": 5.0, "double_pendulum": 1.0, "driven_damped_pendulum": 3.0,
    "figure_eight": 3.0, "gauge_oscillator": 5.0, "incline": 2.0, "n_pendulum": 0.5, "rotating_hoop": 1.0,
    "spherical_pendulum": 3.0,
}  # fmt: skip
"""For how long the motions of shipped systems are followed."""


def driven(t: mpmath.mpf) -> tuple[mpmath.mpf, mpmath.mpf]:
    """x and x' where m x'' = -k x - c x' + F cos(w t): the forced motion and a free one, damped in time."""
    m, k, c, F, w = (mpmath.mpf(x) for x in ("1.25", "2.5", "0.375", "0.75", "1.875"))
    forced = F / (k - m * w**2 + 1j * c * w)
    rate = -c / (2 * m) + 1j * mpmath.sqrt(k / m - (c / (2 * m)) ** 2)
    real = 0.5 - forced.real
    free = mpmath.mpc(real, (rate.real * real + 0.25 - w * forced.imag) / rate.imag)
    steady, fading = forced * mpmath.expj(w * t), free * mpmath.exp(rate * t)
    return (steady + fading).real, (1j * w * steady + rate * fading).real


def lagrangian(t: mpmath.mpf) -> mpmath.mpf:
    x, v = driven(t)
    return 0.625 * v**2 - 1.25 * x**2 + 0.75 * x * mpmath.cos(1.875 * t)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize(
    ("method", "tolerance", "wrong"),
    [("taylor", FULL, 2e-15), ("DOP853", 1e-12, 1e-10), ("LSODA", 1e-10, 1e-7), ("Radau", 1e-9, 1e-7)],
)
def test_a_driven_damped_oscillator_before_its_start(method, tolerance, wrong):
    motion = follow(DRIVEN, -12.0, 25, start=0.0, outputs=EVERYTHING, method=method, tolerance=tolerance)
    t, x, v = motion.t, motion["q/x"], motion["v/x"]
    assert motion.outcome.ending is Ending.COMPLETE and motion.outcome.t == -12.0
    assert np.array_equal(t, -0.5 * np.arange(25)) and not np.signbit(t[0])
    assert error(x, samples_of(lambda t: driven(t)[0], t)) < wrong
    assert error(v, samples_of(lambda t: driven(t)[1], t)) < wrong
    with mpmath.workdps(20):
        action = [mpmath.quad(lagrangian, [0, end], method="gauss-legendre") for end in t[:9:4].tolist()]
    assert error(motion["diagnostics/action"][:9:4], action) < wrong
    assert np.array_equal(motion["diagnostics/p/x"], 1.25 * v)
    assert np.allclose(motion["diagnostics/T"], 0.625 * v**2, rtol=1e-15)
    assert np.allclose(motion["diagnostics/U"], 1.25 * x**2 - 0.75 * x * np.cos(1.875 * t), atol=1e-14)
    assert np.array_equal(motion["positions/p"][:, 0], x)
    size = np.max(motion["diagnostics/T"])
    for ledger in ("h", "p/x"):
        assert np.max(np.abs(motion[f"diagnostics/ledger/{ledger}"])) < 10 * wrong * size


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("name", "stop"), THERE_AND_BACK.items())
def test_there_and_back(name, stop):
    """Every quantity of the way back is that of the way there, and S changes its sign and its start."""
    there = follow(name, stop, 9, outputs=EVERYTHING)
    state = {path: x[-1] for path, x in there.data.items() if path[:2] in ("q/", "v/")}
    values = values_of(name)
    q, v = (
        tuple(float(x) for path in state if path[0] == kind for x in np.ravel(state[path])) for kind in "qv"
    )
    back = run(prepared(name, outputs=EVERYTHING, backward=True), replace(values, q=q, v=v), stop, 0.0, 9)
    assert back.outcome.ending is Ending.COMPLETE
    assert back.t.tolist() == there.t[::-1].tolist()
    for path, series in there.data.items():
        if path == "t":
            continue
        expected = series[::-1] - (series[-1] if path == "diagnostics/action" else 0.0)
        if "ledger" in path:
            expected = np.zeros_like(series)
        size = max(1.0, np.max(np.abs(series)), np.max(np.abs(there[path.replace("ledger/", "")])))
        assert np.max(np.abs(back[path] - expected)) <= 1e-13 * size, path


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", ["central_force", "charged_particle", "rotating_hoop"])
def test_every_formulation_leads_backward(name):
    """Routh's, with momenta in place of velocities; gyroscopic forces; the embedding's."""
    forms = each_formulation(name)
    assert len(forms) > 1
    found = []
    for form in forms.values():
        ready = prepare(
            form,
            Compilation(
                method="taylor", tolerance=FULL, outputs=frozenset(("q", "v", "h", "ledger")), backward=True
            ),
        )
        found.append(run(ready, values_of(name), 0.25, -1.75, 9))
    for other in found[1:]:
        for path in (path for path in other.data if path[:2] in ("q/", "v/")):
            size = np.max(np.abs(found[0][path]))
            assert np.max(np.abs(other[path] - found[0][path])) <= 1e-13 * size


def test_what_is_equal_backward_is_so_to_the_last_bit():
    """A motion from rest in a potential is its own mirror image."""
    there, back = (follow("pendulum", stop, 33, sets={"theta_dot": 0}) for stop in (4.0, -4.0))
    assert there["q/theta"].tobytes() == back["q/theta"].tobytes()
    assert np.array_equal(there["v/theta"], -back["v/theta"])


@pytest.mark.exhaustive(keep=0.45)
def test_a_wedge_and_a_narrow_wall_are_met_backward():
    wedge = """
    coordinates: {x: {initial: 1}}
    lagrangian: x_dot**2/2 - sqrt((x - t/4)**2)
    """
    there = follow(wedge, 20.0, 81)
    back = follow(wedge, 0.0, 81, start=20.0, sets={"x": there["q/x"][-1], "x_dot": there["v/x"][-1]})
    assert np.max(np.abs(back["q/x"] - there["q/x"][::-1])) < 1e-11
    wall = """
    coordinates: {x: {initial: -1, velocity: -1}}
    lagrangian: x_dot**2/2 - 3/10*exp(-((x + t/2)/1e-5)**2)
    """
    motion = follow(wall, -4.0, 9)
    known = follow(wall.replace("t/2", "-t/2"), 4.0, 9, sets={"x_dot": 1})
    assert np.max(np.abs(motion["q/x"] - known["q/x"])) < 1e-12
    assert np.max(np.abs(motion["q/x"] + 1 + motion.t)) > 1e-4  # it has met the wall


def test_a_singularity_in_the_past_is_said_with_its_time():
    fall = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 + 1/x\n"
    motion = follow(fall, -2.0, 21)
    assert motion.outcome.ending is Ending.STEP_UNDERFLOW
    assert abs(motion.outcome.t + np.pi / np.sqrt(8)) < 1e-6
    assert "at t = -1.11" in motion.outcome.message and "x_dot = " in motion.outcome.message
    assert motion["v/x"][-1] > 0  # it comes out of the centre


@pytest.mark.exhaustive(keep=0.65)
def test_a_motion_backward_is_asked_about_at_the_same_steps_as_one_forward():
    """A section ends at a multiple of so many steps, however fast the machine is."""
    system = "coordinates: {x: {initial: 1, velocity: 0.3}}\nlagrangian: x_dot**2/2 - x**2/2 - abs(x)\n"
    asked = []
    for stop in (40.0, -40.0):
        steps: list[int] = []
        checkpoints = CheckpointSink(None, steps.append, lambda snapshot: None, every=16)
        method = prepared(system, "taylor", FULL, ("q",), backward=stop < 0).follower
        state = np.array([1.0, np.copysign(0.3, stop)])
        start = Start(np.empty(0), state, Times(0.0, stop, 2, stop))
        method.follow(start, Observer(checkpoints=checkpoints))
        asked.append([number for number in steps if number % 16 == 0])
    assert asked[0] == asked[1] and len(asked[0]) > 2
