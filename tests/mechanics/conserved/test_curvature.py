"""The curvature of a metric, beside the closed forms of well-known spaces."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.expression.residues import SMALL
from lagrange_cli.mechanics.conserved.curvature import curvatures, may_be_flat, may_be_uniform
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.run.derive import graph_model, read_run

FLAT, UNIFORM, OTHER = (True, True), (False, True), (False, False)
SPACES = {
    "polar coordinates": ("m*(r_dot**2 + r**2*phi_dot**2)/2", FLAT),
    "elliptic coordinates": ("a*m*(u_dot**2 + v_dot**2)*(sinh(u)**2 + sin(v)**2)/2", FLAT),
    "parabolic coordinates": ("(u_dot**2 + v_dot**2)*(u**2 + v**2)", FLAT),
    "Atwood's swinging machine": ("2*m*r_dot**2 + m*r**2*phi_dot**2/2", FLAT),
    "spherical coordinates": ("r_dot**2 + r**2*u_dot**2 + r**2*sin(u)**2*phi_dot**2", FLAT),
    "Minkowski's space": ("x_dot**2 - y_dot**2 - a*z_dot**2", FLAT),
    "sphere": ("m*a**2*(u_dot**2 + sin(u)**2*phi_dot**2)/2", UNIFORM),
    "hyperbolic plane": ("m*(x_dot**2 + y_dot**2)/y**2", UNIFORM),
    "sphere of three dimensions": ("m*(chi_dot**2 + sin(chi)**2*(u_dot**2 + sin(u)**2*phi_dot**2))", UNIFORM),
    "spherical top": ("m*(u_dot**2 + phi_dot**2 + psi_dot**2 + 2*cos(u)*phi_dot*psi_dot)/2", UNIFORM),
    "symmetric top": ("(u_dot**2 + sin(u)**2*phi_dot**2)/2 + a*(psi_dot + cos(u)*phi_dot)**2", OTHER),
    "torus": ("m*(b**2*u_dot**2 + (a + b*cos(u))**2*phi_dot**2)/2", OTHER),
    "sphere times a line": ("z_dot**2 + u_dot**2 + sin(u)**2*phi_dot**2", OTHER),
    "double pendulum": ("u_dot**2 + v_dot**2/2 + cos(u - v)*u_dot*v_dot", OTHER),
}
"""Kinetic energies, and whether the space may be flat and its curvature the same everywhere."""


def states(kinetic: str) -> States:
    """Those of a free motion."""
    names = [name for name in ("r", "u", "v", "x", "y", "z", "chi", "phi", "psi") if f"{name}_dot" in kinetic]
    text = "".join(f"  {name}: {{initial: 0.5}}\n" for name in names)
    text = f"coordinates:\n{text}parameters: {{m: 1, a: 2, b: 3}}\nlagrangian: {kinetic}\n"
    spec, _ = read_run(text.encode(), "free.yaml", None, lambda *_: None)
    model = graph_model(spec, ExactGraphAlgebra())
    return States(model, Noether(model))


@pytest.mark.parametrize("space", SPACES)
def test_spaces_are_told_apart(space: str):
    kinetic, expected = SPACES[space]
    found = states(kinetic)
    assert (may_be_flat(found), may_be_uniform(found)) == expected


@pytest.mark.parametrize(
    ("kinetic", "number"),
    [("9*(u_dot**2 + sin(u)**2*phi_dot**2)/2", 9), ("4*(u_dot**2 + sinh(u)**2*phi_dot**2)/2", -4)],
)
def test_the_curvature_is_that_of_a_sphere_or_a_hyperbolic_plane(kinetic: str, number: int):
    """K = 1/R^2 and -1/R^2 of the metric R^2 (du^2 + ...)."""
    ((curvature, area),) = curvatures(states(kinetic), 1)
    assert area and (number * curvature - area) % SMALL == 0


@pytest.mark.parametrize("kinetic", ["-sqrt(1 - x_dot**2 - y_dot**2)", "t*x_dot**2 + y_dot**2"])
def test_nothing_is_said_where_the_masses_depend_on_more_than_the_place(kinetic: str):
    assert not [*curvatures(states(kinetic), 2)]
