"""DOP853 in machine code: its coefficients, its steps beside scipy's, samples, resume, and tails of waves."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import DOP853

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.native.rates.dop853 import ALL, DEGREE, powers
from lagrange_cli.native.rates.dop853_stages import FIFTH, INSIDE, NODES, STAGE, STAGES, THIRD
from tests.support.motion import follow

KEPLER = """
coordinates: {x: {initial: 0.7}, y: {initial: 0, velocity: 1.36}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 1/sqrt(x**2 + y**2)
"""
DRIVEN = """
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 0.3}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 2*(x*y_dot - y*x_dot) - x**2/2 - y**4 + x*cos(3*t)
dissipation: 0.05*(x_dot**2 + y_dot**2)
"""


def moment(weights: dict[int, float], k: int) -> float:
    """sum_i w_i c_i^k, exactly but for the rounding of what is given."""
    return float(sum(Fraction(w) * Fraction(NODES[i]) ** k for i, w in weights.items()))


def test_stages_and_the_end_integrate_polynomials() -> None:
    """The conditions of order 8 that quadratures give; every stage is of order 1 at least."""
    assert len(STAGE) == len(NODES) == ALL
    for i, weights in enumerate(STAGE):
        assert moment(weights, 0) == pytest.approx(NODES[i], abs=1e-14)
        assert all(j < i for j in weights)
    for k in range(8):
        assert moment(STAGE[STAGES], k) == pytest.approx(1 / (k + 1), abs=2e-15)
    assert abs(moment(STAGE[STAGES], 8) - 1 / 9) > 1e-9
    for k in range(6):  # a quadrature of a quadrature
        inner = {i: w * moment(STAGE[i], k) for i, w in STAGE[STAGES].items()}
        assert moment(inner, 0) == pytest.approx(1 / ((k + 1) * (k + 2)), abs=1e-14)


@pytest.mark.parametrize(("weights", "order"), [(FIFTH, 5), (THIRD, 3)])
def test_error_estimates_have_their_orders(weights: dict[int, float], order: int) -> None:
    """Neither shows what a method of its order integrates exactly."""
    assert all(abs(moment(weights, k)) < 1e-14 for k in range(order))
    assert abs(moment(weights, order + 1)) > 1e-9


def test_the_polynomial_within_a_step_is_exact_for_rates_of_degree_6() -> None:
    for k in range(7):
        slopes = [node**k for node in NODES]
        change = sum(w * slopes[i] for i, w in STAGE[STAGES].items())
        begin, end = slopes[0], slopes[STAGES]
        parts = [change, begin - change, 2 * change - begin - end]
        parts += [sum(w * slopes[i] for i, w in weights.items()) for weights in INSIDE]
        for s in (0.1, 0.5, 0.77, 1.0):
            value = sum(
                c * part * s ** (m + 1) for row, part in zip(powers(), parts) for m, c in enumerate(row)
            )
            assert value == pytest.approx(s ** (k + 1) / (k + 1), abs=1e-13)
    assert all(len(row) == DEGREE for row in powers())


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-10, 1e-13])
def test_it_takes_the_steps_that_scipy_takes(tolerance: float) -> None:
    """Errors are measured alike; the first steps differ."""

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        x, y, u, v = state
        a = np.array([u, v, x, y])
        a[2:] /= -(math.hypot(x, y) ** 3)
        return a

    solver, steps = DOP853(rates, 0.0, np.array([0.7, 0, 0, 1.36]), 20.0, rtol=tolerance, atol=tolerance), 0
    while solver.status == "running":
        solver.step()
        steps += 1
    exact, motion = (
        follow(KEPLER, 20.0, 2, method=method, tolerance=size)
        for method, size in (("taylor", 2.0**-52), ("DOP853", tolerance))
    )
    assert abs(motion.outcome.steps - steps) <= 0.03 * steps + 2
    # the rates at the end of a step are computed again, and steps are tried for the first one
    assert motion.outcome.evaluations - motion.outcome.steps <= 1.1 * solver.nfev + 100
    errors = [
        math.hypot(x - exact["q/x"][-1], y - exact["q/y"][-1])
        for x, y in (solver.y[:2], (motion["q/x"][-1], motion["q/y"][-1]))
    ]
    assert errors[1] < 3 * errors[0]


@pytest.mark.exhaustive(keep=0.25)
def test_samples_change_nothing_and_are_as_accurate() -> None:
    outputs = ("q", "v", "h", "ledger", "action")
    few, many = (follow(DRIVEN, 6.0, n, method="DOP853", tolerance=1e-9, outputs=outputs) for n in (4, 301))
    exact = follow(DRIVEN, 6.0, 301, outputs=outputs)
    assert few.outcome.steps == many.outcome.steps
    assert set(many.data) == set(exact.data)
    for path, series in exact.data.items():
        assert np.max(np.abs(many[path] - series)) < 1e-6 * max(1.0, np.max(np.abs(series))), path
        if path.startswith(("q/", "v/")):
            assert np.array_equal(few[path], many[path][::100]), path


def test_a_sample_in_a_step_takes_three_more_evaluations() -> None:
    ends, inside = (follow(KEPLER, 20.0, n, method="DOP853", tolerance=1e-9).outcome for n in (2, 3001))
    assert ends.steps == inside.steps
    assert 3 * inside.steps - 6 <= inside.evaluations - ends.evaluations <= 3 * inside.steps


def test_a_kink_is_passed() -> None:
    """|x| as a root: a fall from 1 takes sqrt(2) to the kink, and as long beyond it."""
    text = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - sqrt(x**2)\n"
    motion = follow(text, 3 * math.sqrt(2), 3, method="DOP853", tolerance=1e-9)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"][-1] == pytest.approx(math.sqrt(2), abs=1e-6)
