"""Radau in machine code: its order, stiff systems, scipy's steps beside it, samples, and matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import Radau

from lagrange_cli.errors import TooLarge
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.native.rates import implicit
from lagrange_cli.native.rates.radau_constants import (
    COMPLEX,
    ERROR,
    NODES,
    PARTS,
    POLYNOMIAL,
    REAL,
    VALUES,
    WEIGHTS,
)
from lagrange_cli.native.stepping import coupling
from tests.support.motion import Motion, follow, prepared

KEPLER = """
coordinates: {x: {initial: 0.7}, y: {initial: 0, velocity: 1.36}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 1/sqrt(x**2 + y**2)
"""
DRIVEN = """
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 0.3}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 2*(x*y_dot - y*x_dot) - x**2/2 - y**4 + x*cos(3*t)
dissipation: 0.05*(x_dot**2 + y_dot**2)
"""
DAMPED = """
parameters: {c: 1e6}
coordinates: {x: {initial: 1, velocity: 0.5}}
lagrangian: (x_dot**2 - x**2)/2
dissipation: c*x_dot**2/2
"""
VAN_DER_POL = """
parameters: {c: 1000}
coordinates: {x: {initial: 2}}
lagrangian: (x_dot**2 - x**2)/2
generalized_forces: {x: c*(1 - x**2)*x_dot}
"""
SPRING = """
parameters: {k: 1e8, c: 1e5}
coordinates: {x: {initial: 1}, y: {initial: 0}}
lagrangian: (x_dot**2 + y_dot**2)/2 - 9.81*y - k*(sqrt(x**2 + y**2) - 1)**2/2
dissipation: c*(x*x_dot + y*y_dot)**2/(x**2 + y**2)/2
"""
CHAIN = """
sizes: {N: 60}
coordinates: {x[i in range(N)]: {initial: 0.1*sin(i)}}
masses: {bead[i in range(N)]: 1}
embedding: {bead[i in range(N)]: x[i]}
potential: x[0]**2 + sum(5e3*(x[i + 1] - x[i])**2 + (x[i + 1] - x[i])**4 for i in range(N - 1))
dissipation: sum(5e4*(x_dot[i + 1] - x_dot[i])**2 for i in range(N - 1))
"""


def radau(text: str, stop: float, samples: int, tolerance: float, **more: object) -> Motion:
    return follow(text, stop, samples, method="Radau", tolerance=tolerance, **more)  # type: ignore[arg-type]


def test_the_numbers_are_those_of_a_method_of_order_5() -> None:
    a, c = np.array(WEIGHTS), np.array(NODES)
    for k in range(5):
        assert a[2] @ c**k == pytest.approx(1 / (k + 1), abs=1e-15)
    assert abs(a[2] @ c**5 - 1 / 6) > 1e-3
    for k in range(3):
        assert a @ c**k == pytest.approx(c ** (k + 1) / (k + 1), abs=1e-15)
    growth = np.array([[REAL, 0, 0], [0, COMPLEX.real, -COMPLEX.imag], [0, COMPLEX.imag, COMPLEX.real]])
    assert np.array(PARTS) @ np.linalg.inv(a) @ np.array(VALUES) == pytest.approx(growth, abs=1e-13)
    powers = np.array([c, c**2, c**3])
    assert np.array(POLYNOMIAL) @ powers.T == pytest.approx(np.eye(3), abs=1e-14)
    assert powers @ ERROR == pytest.approx([-1, 0, 0], abs=1e-14)


def test_errors_fall_with_the_fifth_power_of_the_steps_and_inside_with_the_fourth() -> None:
    """Where steps are of one length: the motion in a circle."""
    text = KEPLER.replace("0.7", "1").replace("1.36", "1")
    ends, inside, counts = list[float](), list[float](), list[int]()
    for tolerance in (1e-5, 1e-9):
        motion = radau(text, 10.0, 1001, tolerance)
        t = np.linspace(0, 10.0, 1001)
        errors = np.hypot(motion["q/x"] - np.cos(t), motion["q/y"] - np.sin(t))
        speeds = np.hypot(motion["v/x"] + np.sin(t), motion["v/y"] - np.cos(t))
        ends.append(errors[-1])
        inside.append(np.max(np.abs(np.diff(speeds, 2))))  # what is not smooth
        counts.append(motion.outcome.steps)
    ratio = math.log(counts[1] / counts[0])
    assert 4.7 < math.log(ends[0] / ends[1]) / ratio < 5.4
    assert math.log(inside[0] / inside[1]) / ratio > 3.5


@pytest.mark.exhaustive(keep=0.8)
def test_an_overdamped_oscillator_takes_few_steps() -> None:
    """exp(-t/c), but for a start that is over after some 1/c."""
    motion = radau(DAMPED, 1e6, 11, 1e-8)
    fast = (1e6 + math.sqrt(1e12 - 4)) / 2
    exact = (0.5 + fast) / (fast - 1 / fast) * np.exp(-np.linspace(0, 1e6, 11) / fast)
    assert np.max(np.abs(motion["q/x"][1:] - exact[1:])) < 1e-9
    assert motion.outcome.steps < 200
    explicit = follow(DAMPED, 1e-3, 2, method="DOP853", tolerance=1e-8)
    assert explicit.outcome.steps > 100  # for a 10^9th of it


@pytest.mark.exhaustive(keep=0.7)
def test_a_pendulum_on_a_stiff_spring_moves_as_one_on_a_rod() -> None:
    """Within what the spring gives way, 3 g/k; it oscillates 1600 times in each unit of time."""
    motion = radau(SPRING, 2.0, 21, 1e-6)
    rod = follow("coordinates: {a: {initial: pi/2}}\nlagrangian: a_dot**2/2 + 9.81*cos(a)\n", 2.0, 21)
    assert np.max(np.abs(motion["q/x"] - np.sin(rod["q/a"]))) < 1e-4
    assert motion.outcome.steps < 1500
    explicit = follow(SPRING, 0.01, 2, method="DOP853", tolerance=1e-6)
    assert 200 * explicit.outcome.steps > 20 * motion.outcome.steps


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize(
    ("text", "stop", "tolerance"), [(KEPLER, 20.0, 1e-4), (KEPLER, 20.0, 1e-8), (VAN_DER_POL, 2000.0, 1e-5)]
)
def test_it_takes_the_steps_that_scipy_takes(text: str, stop: float, tolerance: float) -> None:
    """Errors are measured alike, and the ends agree within them."""

    def kepler(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([*y[2:], *(-y[:2] / math.hypot(*y[:2]) ** 3)])

    def relaxing(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], 1000 * (1 - y[0] ** 2) * y[1] - y[0]])

    rates, start = (kepler, [0.7, 0, 0, 1.36]) if text == KEPLER else (relaxing, [2.0, 0])
    solver, steps = Radau(rates, 0.0, np.array(start), stop, rtol=tolerance, atol=tolerance), 0
    while solver.status == "running":
        solver.step()
        steps += 1
    motion = radau(text, stop, 2, tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert abs(motion.outcome.steps - steps) <= 0.1 * steps + 3
    assert motion.outcome.evaluations < 1.5 * (solver.nfev + 4 * solver.njev) + 100
    assert abs(motion["q/x"][-1] - solver.y[0]) < 100 * tolerance


def test_samples_change_nothing_and_are_as_accurate() -> None:
    outputs = ("q", "v", "h", "ledger", "action")
    few, many = (radau(DRIVEN, 6.0, n, 1e-9, outputs=outputs) for n in (4, 301))
    exact = follow(DRIVEN, 6.0, 301, outputs=outputs)
    assert few.outcome.steps == many.outcome.steps
    assert few.outcome.evaluations == many.outcome.evaluations
    assert set(many.data) == set(exact.data)
    for path, series in exact.data.items():
        assert np.max(np.abs(many[path] - series)) < 1e-6 * max(1.0, np.max(np.abs(series))), path
        if path.startswith(("q/", "v/")):
            assert np.array_equal(few[path], many[path][::100]), path


@pytest.mark.exhaustive(keep=0.55)
def test_derivatives_are_kept_where_newtons_method_converges() -> None:
    """Of 60 coordinates in a chain, differences take some evaluations, and most steps none."""
    outcome = radau(CHAIN, 10.0, 2, 1e-7).outcome
    assert outcome.steps > 40
    assert outcome.evaluations < 12 * outcome.steps + 100


@pytest.mark.exhaustive(keep=0.35)
def test_a_full_matrix_gives_the_motion_of_a_banded_one(monkeypatch: pytest.MonkeyPatch) -> None:
    banded = radau(CHAIN, 1.0, 5, 1e-7)
    banded_work = prepared(CHAIN, "Radau", 1e-7).machine.program.work
    monkeypatch.setattr(coupling, "FEW", 10**6)
    text = CHAIN.replace("{N: 60}", "{N:  60}")  # another file for what is kept
    full = radau(text, 1.0, 5, 1e-7)
    assert prepared(text, "Radau", 1e-7).machine.program.work > 2 * banded_work
    assert full.outcome.steps == banded.outcome.steps
    assert np.max(np.abs(full["q/x"] - banded["q/x"])) < 1e-11


@pytest.mark.parametrize("shape", ["chain", "ring", "lattice"])
def test_neighbours_are_put_near_each_other(shape: str) -> None:
    """Coordinates in any order: the band is as narrow as in the best one, or nearly."""
    if shape == "lattice":
        at = np.arange(12 * 30).reshape(12, 30)
        pairs = [*zip(at[1:].ravel(), at[:-1].ravel()), *zip(at[:, 1:].ravel(), at[:, :-1].ravel())]
    else:
        pairs = [(i, (i + 1) % 200) for i in range(199 + (shape == "ring"))]
    rows, columns = np.array(pairs).T
    mixed = np.random.default_rng(1).permutation(1 + max(pairs[-1] + pairs[-2]))
    found = coupling.coupling_of(len(mixed), mixed[rows], mixed[columns])
    assert sorted(found.places) == list(range(len(mixed)))
    at = np.argsort(found.places)
    assert np.max(np.abs(at[mixed[rows]] - at[mixed[columns]])) == found.band.reach
    assert found.band.reach <= {"chain": 1, "ring": 2, "lattice": 14}[shape]
    assert found.colours == 2 * found.band.reach + 1


def test_a_kink_is_passed() -> None:
    """|x| as a root: a fall from 1 takes sqrt(2) to the kink, and as long beyond it."""
    text = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - sqrt(x**2)\n"
    motion = radau(text, 3 * math.sqrt(2), 3, 1e-9)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"][-1] == pytest.approx(math.sqrt(2), abs=1e-6)


def test_matrices_that_are_too_large_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(implicit, "MOST_NUMBERS", 500)
    with pytest.raises(TooLarge, match=r"the matrices of implicit steps of this system are .* numbers"):
        prepared(DRIVEN.replace("0.05", "0.06"), "Radau", 1e-7)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("rate", [3.0, 1e2, 1e4])
@pytest.mark.parametrize("phase", [1e-12, 1e-9])
def test_an_oscillation_that_begins_after_a_rest_is_followed(rate: float, phase: float) -> None:
    """A free flight, then a spring that begins to act where it is relaxed, or nearly: the length of steps on
    the flight, or the velocity over an acceleration next to 0, says nothing about its oscillation."""
    begin, speed = 10.0, 0.5
    place = speed * begin - phase * speed / rate
    text = f"""
coordinates: {{x: {{initial: 0, velocity: {speed}}}}}
lagrangian: x_dot**2/2
generalized_forces: {{x: 'where(t < {begin}, 0, -{rate!r}**2*(x - {place!r}))'}}
"""
    after = 73.7 / rate
    motion = radau(text, begin + after, 3, 1e-7)
    amplitude, angle = speed * math.hypot(1.0, phase), math.atan(phase) + rate * after
    assert motion["v/x"][-1] == pytest.approx(amplitude * math.cos(angle), abs=1e-4)
    assert motion["q/x"][-1] == pytest.approx(place + amplitude * math.sin(angle) / rate, abs=1e-4)
