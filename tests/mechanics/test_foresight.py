"""Convolutions that are known before the equations are: never more than the equations take."""

from __future__ import annotations

from functools import partial

import pytest
from hypothesis import given

from lagrange_cli.errors import SpecError
from lagrange_cli.integrate.convolutions import foresee_convolutions
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.mechanics.foresight import least_convolutions
from lagrange_cli.run import derive
from tests.mechanics.test_random_systems import systems
from tests.support.draws import examples
from tests.support.motion import SYSTEMS, residual_of, spec_of

ANYWAY = -1
"""No system is so small that it is not looked at."""
BODIES = """
sizes: {N: 12}
parameters: {eps: 0.1}
coordinates:
  x[i in range(N)]: {initial: cos(i)}
  y[i in range(N)]: {initial: sin(2*i)}
  z[i in range(N)]: {initial: cos(3*i + 1)}
masses:
  b[i in range(N)]: 1/N
embedding:
  b[i in range(N)]: [x[i], y[i], z[i]]
potential: -sum(1/N/N/sqrt(dot(b[i] - b[j], b[i] - b[j]) + eps**2) for i in range(N) for j in range(i))
"""
FORCES = BODIES.replace("potential:", "observables:\n  u:") + (
    "forces:\n  b[i in range(N)]: sum((b[j] - b[i])/N/N/norm(b[i] - b[j])**3 for j in range(N) if j != i)\n"
)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("text", "each"), [(BODIES, 8), (FORCES, 11)], ids=["potential", "forces"])
def test_what_bodies_take_is_known_exactly(text, each):
    """A pair takes three squares, a power (two convolutions), and three products, or six: each way."""
    residual = residual_of(text)
    pairs = 12 * 11 // 2
    assert least_convolutions(residual.model, ANYWAY) == min(residual.costs.values()) == each * pairs
    assert least_convolutions(residual.model, 100 * pairs) == 0


@pytest.mark.exhaustive(keep=8)
@pytest.mark.parametrize("path", sorted(SYSTEMS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_formulation_of_a_known_system_takes_less(path):
    residual = residual_of(path.read_text())
    assert least_convolutions(residual.model, ANYWAY) <= min(residual.costs.values())


@pytest.mark.exhaustive(keep=0.2)
@examples(15)
@given(systems())
def test_no_formulation_of_a_random_system_takes_less(text):
    residual = residual_of(text)
    assert least_convolutions(residual.model, ANYWAY) <= min(residual.costs.values())


def test_a_total_derivative_that_cancels_is_not_counted():
    lagrangian = "x_dot**2/2 + t*x**3*sin(x)*x_dot + x**4*sin(x)/4 + x_dot*t*cos(x)"
    residual = residual_of(f"coordinates: {{x: {{initial: 1}}}}\nlagrangian: {lagrangian}\n")
    assert least_convolutions(residual.model, ANYWAY) == 0


@pytest.mark.exhaustive(keep=0.7)
def test_too_many_are_refused_before_anything_is_derived(monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "convolutions=527")
    spec = spec_of(BODIES)
    derived = []
    monkeypatch.setattr("lagrange_cli.mechanics.derive.derive", derived.append)

    def derive_for(method: str, precision: str = DOUBLE) -> None:
        foresee = partial(foresee_convolutions, method=method, precision=precision)
        derive.derive_system(spec, foresee=foresee)

    with pytest.raises(SpecError, match="take at least 528 convolutions per order; at most 527 are compiled"):
        derive_for("taylor")
    monkeypatch.setenv("LAGRANGE_LIMITS", "convolutions=528")
    with pytest.raises(SpecError, match="at most 132 are compiled"):
        derive_for("taylor", DOUBLE_DOUBLE)
    assert not derived
    derive_for("taylor")
    monkeypatch.setenv("LAGRANGE_LIMITS", "convolutions=1")
    derive_for("DOP853")
    assert len(derived) == 2
