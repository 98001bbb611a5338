"""The Gauss-Radau method: its nodes, its order, its accuracy, and what it hands over."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.native.rates.gauss_radau_nodes import NODES, TERMS, inverse, products
from tests.support.motion import FULL, Motion, follow, prepared

ELLIPSE = """
coordinates: {x: {initial: 0.7}, y: {initial: 0, velocity: 1.36}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 1/sqrt(x**2 + y**2)
"""
MAGNETIC = """
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 0.3}, z: {initial: 0.2}}
lagrangian: (x_dot**2 + y_dot**2 + z_dot**2)/2 + 2*(x*y_dot - y*x_dot) - x**2/2 - z**4
dissipation: 0.05*(x_dot**2 + z_dot**2)
"""
CLUSTER = """
sizes: {N: 6}
coordinates:
  x[i in range(N)]: {initial: cos(2.4*i)*sqrt(i + 1)}
  y[i in range(N)]: {initial: sin(2.4*i)*sqrt(i + 1), velocity: 0.1*cos(i)}
  z[i in range(N)]: {initial: cos(1.7*i)}
masses: {body[i in range(N)]: 1/N}
embedding: {body[i in range(N)]: [x[i], y[i], z[i]]}
potential: -sum(1/N**2/norm(body[i] - body[j]) for i in range(N) for j in range(i))
"""


def energy(motion: Motion, times: list[int]) -> NDArray[np.longdouble]:
    """That of the ellipse, in extended precision, at two of the samples."""
    x, y, u, v = (motion[path][times].astype(np.longdouble) for path in ("q/x", "q/y", "v/x", "v/y"))
    return (u * u + v * v) / 2 - 1 / np.sqrt(x * x + y * y)


def test_the_nodes_are_those_of_radaus_quadrature() -> None:
    """They integrate polynomials of degree 14 exactly, which determines them."""
    nodes = [Fraction(0), *map(Fraction, NODES)]

    def weight(i: int) -> Fraction:
        others, product = [one for j, one in enumerate(nodes) if j != i], [Fraction(1)]
        for other in others:
            product = [
                (a - other * b) / (nodes[i] - other) for a, b in zip([Fraction(0), *product], [*product, 0])
            ]
        return sum((c / (k + 1) for k, c in enumerate(product)), Fraction(0))

    weights = [weight(i) for i in range(len(nodes))]
    for degree in range(15):
        total = sum(w * node**degree for w, node in zip(weights, nodes))
        assert abs(total * (degree + 1) - 1) < 1e-15
    assert abs(sum(w * node**15 for w, node in zip(weights, nodes)) * 16 - 1) > 1e-9


@pytest.mark.parametrize("node", NODES)
def test_every_node_is_the_double_nearest_to_a_zero(node: float) -> None:
    """P_7 + P_8 of 2 s - 1 changes its sign within half a unit of the last place."""

    def value(s: Fraction) -> Fraction:
        x, before, now = 2 * s - 1, Fraction(1), 2 * s - 1
        for n in range(1, 8):
            before, now = now, ((2 * n + 1) * x * now - n * before) / (n + 1)
        return before + now

    half = Fraction(math.ulp(node)) / 2
    assert value(Fraction(node) - half) * value(Fraction(node) + half) < 0


def test_both_forms_of_the_polynomials_are_the_same() -> None:
    rows, back = products(), inverse(products())
    for n, k in itertools.product(range(TERMS), repeat=2):
        product = sum((back[n][m] * rows[j][m] for j in [k] for m in range(k + 1)), Fraction(0))
        assert product == (n == k)


@pytest.mark.exhaustive(keep=0.6)
def test_errors_at_the_end_fall_with_a_high_power_of_the_steps() -> None:
    """The 15th at the nodes' limit; here of so few steps that rounding is not seen."""
    errors, steps = [], []
    for tolerance in (0.1, 1e-4):
        total, count = 0.0, 0
        for k in range(4):
            sets = {"y_dot": 1.3 + 0.02 * k}
            known = follow(ELLIPSE, 20.0, 2, sets=sets)
            motion = follow(ELLIPSE, 20.0, 2, method="ias15", tolerance=tolerance, sets=sets)
            total += math.hypot(*(motion[f"q/{x}"][-1] - known[f"q/{x}"][-1] for x in "xy"))
            count += motion.outcome.steps
        errors.append(total)
        steps.append(count)
    assert math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0]) > 10
    assert errors[1] < 1e-11


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("system", "stop"),
    [("pendulum", 5.0), ("rotating_hoop", 3.0), ("lagrange_top", 2.0), ("fpu_chain", 30.0), (MAGNETIC, 10.0),
     (CLUSTER, 3.0)],
    ids=["pendulum", "hoop", "top", "chain", "magnetic", "cluster"],
)  # fmt: skip
def test_it_agrees_with_the_taylor_method_within_steps_too(system: str, stop: float) -> None:
    """Velocity-dependent forces, integrals, time, masses that are no numbers, and series in batches."""
    outputs = ("q", "v", "h", "ledger", "action")
    one, other = (follow(system, stop, 301, method=name, outputs=outputs) for name in ("ias15", "taylor"))
    assert one.outcome.ending is Ending.COMPLETE
    assert set(one.data) == set(other.data)
    for path, series in other.data.items():
        size = max(1.0, float(np.max(np.abs(series))))
        assert np.max(np.abs(one[path] - series)) < 1e-13 * size, path


def test_errors_of_the_energy_stay_as_small_as_rounding() -> None:
    """Brouwer's law (D. Brouwer, AJ 46, 1937): 7000 steps, each rounded once, add up to the root of that."""
    errors, motion = list[float](), None
    for k in range(4):
        motion = follow(ELLIPSE, 200 * math.pi, 2, method="ias15", sets={"y_dot": 1.36 + 0.001 * k})
        first, last = energy(motion, [0, -1])
        errors.append(float(last / first - 1))
    assert motion.outcome.steps > 5000
    assert max(map(abs, errors)) < 4 * math.sqrt(motion.outcome.steps) * 2.0**-53


def test_it_takes_two_rounds_of_evaluations_a_step() -> None:
    """The polynomials of the step before are where the iteration begins: the second round confirms them."""
    outcome = follow(ELLIPSE, 20.0, 2, method="ias15").outcome
    assert 15 <= outcome.evaluations / outcome.steps < 17


@pytest.mark.exhaustive(keep=0.6)
def test_a_kink_is_approached_and_passed() -> None:
    """|x| as a root: a fall from 1 takes sqrt(2) to the kink, and as long beyond it."""
    text = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - sqrt(x**2)\n"
    motion = follow(text, 3 * math.sqrt(2), 3, method="ias15")
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(0, abs=1e-12)
    assert motion["v/x"][-1] == pytest.approx(math.sqrt(2), abs=1e-12)


@pytest.mark.exhaustive(keep=0.65)
def test_one_program_serves_one_tolerance() -> None:
    assert prepared("pendulum", "ias15").machine.program.carried > 0
    assert prepared("pendulum").machine.program.carried == 0
    loose, full = (
        follow("pendulum", 5.0, 3, method="ias15", tolerance=x).outcome.steps for x in (1e-6, FULL)
    )
    assert 2 * loose < full
