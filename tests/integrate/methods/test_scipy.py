"""scipy's methods on the compiled equations: their Jacobian, agreement with the Taylor method, tolerances."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods import table
from lagrange_cli.integrate.methods.equations import Equations
from lagrange_cli.integrate.precision import PRECISIONS
from tests.support.motion import NAMES, follow, prepared, spec_of, values_of

METHODS = ("DOP853", "Radau", "BDF", "LSODA")
"""The first two are no longer scipy's, and do the same."""
LEDGER = ("q", "v", "p", "h", "ledger", "action")
SMOOTH = [name for name in NAMES if not spec_of(name).events and name != "newtons_cradle"]
"""Systems without events, which these methods do not follow."""
WILD = """
parameters: {a: 1.5, b: 0.7, m: 2, k: 3}
coordinates: {u: {initial: 0.4, velocity: 0.3}, w: {initial: 0.9, velocity: -0.2}}
masses: {p: m, q: 1}
embedding:
  p: [a*cos(u)*cosh(w)/2, b*sin(u)*sin(w + t), exp(-w)/(2 + u**2)]
  q: [tanh(u*w), (1 + w**2)**0.7, atan2(u, 2 + w)]
potential: k*p.x**2/2 + log(2 + sin(u)) - 1/norm(p - q + (0, 0, 3)) + 0.1*u_dot*w
forces: {q: [0, -q.vy*q.vx, t]}
dissipation: 0.01*(u_dot**2 + w_dot**2)
"""


def equations(system: str, method: str = "BDF") -> tuple[Equations, np.ndarray]:
    """The compiled y' = f(t, y), with all quadratures, and a y a little off the initial state."""
    machine, values = prepared(system, method, 1e-8, LEDGER).machine, values_of(system)
    parameters = np.array([values.parameters[name] for name in machine.program.parameters])
    y = np.array([*values.q, *values.v, *np.zeros(len(machine.program.integrals))])
    return Equations.of(machine, parameters), y + 0.1 + 0.05 * np.sin(np.arange(len(y)))


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("system", [*SMOOTH, WILD], ids=[*SMOOTH, "wild"])
def test_the_jacobian_is_the_slope_of_the_rates(system: str) -> None:
    """Against Richardson's extrapolation of central differences, quadratures included."""
    compiled, y = equations(system)
    jacobian = compiled.jacobian(0.7, y)
    assert jacobian.shape == (len(y), len(y))
    rounding = 2e-15 * abs(compiled.rates(0.7, y)).max()  # where masses are large, work is, too

    def slope(k: int, step: float) -> np.ndarray:
        away = np.zeros_like(y)
        away[k] = step
        return (compiled.rates(0.7, y + away) - compiled.rates(0.7, y - away)) / (2 * step)

    for k in range(len(y)):
        expected = (4 * slope(k, 5e-4) - slope(k, 1e-3)) / 3
        allowed = 1e-8 * max(1.0, abs(expected).max()) + rounding / 5e-4
        assert abs(jacobian[:, k] - expected).max() < allowed


@pytest.mark.exhaustive(keep=0.2)
def test_rates_are_what_the_taylor_method_starts_with() -> None:
    compiled, _ = equations(WILD)
    values = values_of(WILD)
    y = np.array([*values.q, *values.v, *np.zeros(len(compiled.machine.program.integrals))])
    motion = follow(WILD, 1e-5, 2, outputs=("q", "v", "ledger"))
    change = (motion["v/u"][1] - motion["v/u"][0]) / 1e-5
    assert compiled.rates(0.0, y)[2] == pytest.approx(change, rel=1e-4)
    assert list(compiled.rates(0.0, y)[:2]) == list(values.v)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "system", ["double_pendulum", "driven_damped_pendulum", "gauge_oscillator", "charged_particle"]
)
def test_methods_agree_within_their_tolerance(system: str, method: str) -> None:
    exact = follow(system, 3.0, 31, outputs=LEDGER)
    tolerance = 1e-8
    motion = follow(system, 3.0, 31, method=method, tolerance=tolerance, outputs=LEDGER)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.evaluations > motion.outcome.steps > 5
    assert set(motion.data) == set(exact.data)
    for path, series in exact.data.items():
        allowed = 3e3 * tolerance * max(1.0, abs(series).max())
        assert abs(motion[path] - series).max() < allowed, path


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("method", METHODS)
def test_a_smaller_tolerance_gives_a_smaller_error(method: str) -> None:
    exact = follow("pendulum", 5.0, 26)
    errors, steps = [], []
    for tolerance in (1e-4, 1e-6, 1e-8):
        motion = follow("pendulum", 5.0, 26, method=method, tolerance=tolerance)
        errors.append(abs(motion["q/theta"] - exact["q/theta"]).max())
        steps.append(motion.outcome.steps)
    assert errors[0] > 5 * errors[1] > 25 * errors[2] > 0
    assert steps[0] < steps[1] < steps[2]


def test_stiff_systems_are_for_the_implicit_methods() -> None:
    stiff = {"c": 1e5, "A": 0.0}
    implicit = follow("driven_damped_pendulum", 20.0, 5, sets=stiff, method="Radau", tolerance=1e-6)
    explicit = follow("driven_damped_pendulum", 0.2, 5, sets=stiff)
    assert implicit.outcome.ending is Ending.COMPLETE
    assert implicit.outcome.steps < 100
    assert explicit.outcome.steps > 1000


def test_samples_do_not_depend_on_their_spacing() -> None:
    few, many = (follow("pendulum", 6.0, n, method="DOP853", tolerance=1e-6) for n in (4, 301))
    assert np.array_equal(few["q/theta"], many["q/theta"][::100])
    assert few.outcome.steps == many.outcome.steps


def test_explicit_methods_carry_no_jacobian() -> None:
    assert prepared("pendulum", "DOP853", 1e-8).machine.linearize is None
    assert prepared("pendulum", "BDF", 1e-8).machine.linearize is not None
    assert prepared("pendulum", "BDF", 1e-8).machine.advance is None
    assert aligned(3).ctypes.data % 64 == 0


def test_every_method_has_a_module_that_follows_motions():
    for row in table.METHODS.values():
        assert callable(import_module(f"lagrange_cli.integrate.methods.{row.module}").follower)
        assert all(tightest <= default <= 0.1 for tightest, default in row.tolerances.values())
        assert set(row.tolerances) <= set(PRECISIONS)
