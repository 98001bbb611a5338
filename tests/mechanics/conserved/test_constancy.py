"""Functions of the state that keep their values along every motion, and those that do not."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.mechanics.conserved.constancy import is_constant
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.model.build import build_model
from lagrange_cli.spec.surface import with_surface
from tests.support.motion import spec_of

CONSTANT = {
    "pendulum": ["m*l**2*theta_dot**2/2 - m*g*l*cos(theta) - 1", "sin(l*theta_dot**2/2 - g*cos(theta))"],
    "central_force": ["r**2*theta_dot - 1/2", "r_dot**2 + r**2*theta_dot**2 - 2*mu/r"],
    "central_force_cartesian": ["x*y_dot - y*x_dot"],
    "spherical_pendulum": ["sin(theta)**2*phi_dot - 1"],
    "double_pendulum": [
        "(m1 + m2)*l1**2*theta1_dot**2/2 + m2*l2**2*theta2_dot**2/2 - (m1 + m2)*g*l1*cos(theta1)"
        " + m2*l1*l2*cos(theta1 - theta2)*theta1_dot*theta2_dot - m2*g*l2*cos(theta2)"
    ],
    "rotating_rod": ["(r_dot + omega*r)*exp(-omega*t)"],
}
CHANGING = {
    "pendulum": ["theta", "theta_dot", "theta_dot**2 - cos(theta)", "t"],
    "central_force": ["theta_dot", "r*theta_dot - 1"],
    "spherical_pendulum": ["sin(theta)*phi_dot"],
    "double_pendulum": ["theta1_dot + theta2_dot"],
    "driven_damped_pendulum": ["theta_dot**2/2 - g/l*cos(theta)"],
    "rotating_rod": ["(r_dot + omega*r)*exp(omega*t)"],
}


@pytest.mark.parametrize("system", {**CONSTANT, **CHANGING})
def test_what_is_constant(system: str) -> None:
    for expressions, expected in ((CONSTANT, True), (CHANGING, False)):
        for text in expressions.get(system, []):
            residual = derive(build_model(with_surface(spec_of(system), text), GraphAlgebra()))
            assert is_constant(residual, residual.model.events[-1].argument) is expected, text
