"""Hamilton's form is Lagrange's, written in p."""

import numpy as np
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.symbolic.data import as_data
from lagrange_cli.symbolic.hamilton import hamilton_form
from lagrange_cli.symbolic.layouts import as_text
from lagrange_cli.symbolic.source import as_python
from tests.support.systems import NAMES, agree_at_random, derived, equations_of, same


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("name", NAMES)
def test_canonical_equations_give_the_same_motion(name):
    equations = equations_of(name)
    form = hamilton_form(equations)
    known = dict(zip(form.p, equations.momenta, strict=True))
    assert agree_at_random(form.H.subs(known), equations.h)
    for own, slope, velocity, v in zip(
        form.velocities, (form.H.diff(p) for p in form.p), equations.v, equations.v, strict=True
    ):
        assert agree_at_random(own, slope)
        assert agree_at_random(own.subs(known), velocity) and velocity == v
    for rate, momentum in zip(form.rates, equations.momenta, strict=True):
        assert equations.accelerations is not None
        moving = momentum.diff(equations.time)
        for symbols, values in ((equations.q, equations.v), (equations.v, equations.accelerations)):
            moving += sum(momentum.diff(s) * value for s, value in zip(symbols, values, strict=True))
        assert agree_at_random(rate.subs(known), moving)


def test_kepler():
    form = hamilton_form(equations_of("central_force"))
    assert same(form.H, "p_r**2/(2*m) + p_theta**2/(2*m*r**2) - m*mu/r")
    assert form.rates[1] == 0


def test_momenta_that_are_not_linear_in_the_velocities():
    """Of a charge in a field B with m = 2, c = 3: H = c sqrt(m^2 c^2 + (p - A)^2) - x (Landau II, 16)."""
    text = """
coordinates: {x: {initial: 0}, y: {initial: 0}}
lagrangian: -18*sqrt(1 - (x_dot**2 + y_dot**2)/9) + x + 0.5*x*y_dot
"""
    written = as_text(derived(text), "hamilton")
    assert "Momenta, which determine the velocities" in written and "p_y_dot = 0" in written
    module = {}
    exec(as_python(derived(text), "hamilton", {}), module)
    for p in ((0.0, 0.0), (3.0, -4.0), (10.0, 200.0)):
        q, kinetic = (0.7, 0.1), (p[0], p[1] - 0.35)
        energy = 3 * np.hypot(6, np.hypot(*kinetic))
        assert module["velocities"](0.0, q, p) == pytest.approx([9 * x / energy for x in kinetic], rel=1e-11)
        assert module["hamiltonian"](0.0, q, p) == pytest.approx(energy - 0.7, rel=1e-9)
        rate = 1 + 0.5 * 9 * kinetic[1] / energy
        assert module["momentum_rates"](0.0, q, p) == pytest.approx([rate, 0.0], rel=1e-11)


def test_momenta_that_no_velocities_have():
    module = {}
    text = "coordinates: {x: {initial: 0}}\nlagrangian: sqrt(1 + x_dot**2)\n"
    exec(as_python(derived(text), "hamilton", {}), module)
    assert module["velocities"](0.0, [0.0], [0.6]) == pytest.approx([0.75], rel=1e-12)
    with pytest.raises(ArithmeticError):
        module["velocities"](0.0, [0.0], [2.0])


def test_a_name_that_a_momentum_needs():
    clash = derived("parameters: {p_x: 1}\ncoordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - p_x*x\n")
    with pytest.raises(UsageError, match="p_x"):
        hamilton_form(clash)


@pytest.mark.exhaustive(keep=0)
def test_what_is_too_long_is_written_in_steps():
    """Of a quaternion's momenta: they determine the velocities, and change as the equations of motion say."""
    module = {}
    parameters = {"m": 0.1, "g": 9.81, "l": 0.2, "I1": 0.3, "I3": 0.2, "spin": 1.0}
    exec(as_python(equations_of("gyroscope"), "hamilton", parameters), module)
    q, v, step = (0.5, -0.3, 0.7, 0.4), (0.2, 0.9, -0.4, 0.3), 1e-5
    p, a = module["momenta"](0.0, q, v), module["accelerations"](0.0, q, v)
    assert module["velocities"](0.0, q, p) == pytest.approx(v, rel=1e-13)
    assert module["hamiltonian"](0.0, q, p) == pytest.approx(module["energy_function"](0.0, q, v), rel=1e-13)

    def later(e):
        there = [x + e * y + e**2 / 2 * z for x, y, z in zip(q, v, a)]
        return np.array(module["momenta"](0.0, there, [y + e * z for y, z in zip(v, a)]))

    rates = (later(step) - later(-step)) / (2 * step)
    assert module["momentum_rates"](0.0, q, p) == pytest.approx(list(rates), abs=1e-7)
    written = as_text(equations_of("gyroscope"), "hamilton")
    assert "Momenta, which determine the velocities" in written and "p_w_dot = " in written
    data = as_data(equations_of("gyroscope"), "hamilton", parameters)
    assert data["hamiltonian"] and data["canonical_equations"]["velocities"] is None
