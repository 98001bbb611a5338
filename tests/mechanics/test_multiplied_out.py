"""Energies multiplied out: what vanishes does not cancel, and masses add up."""

from __future__ import annotations

import math

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import terms_of
from lagrange_cli.expression.parse import parse
from lagrange_cli.mechanics.multiplied_out import folded, halved_squares
from lagrange_cli.mechanics.substitution import substituted
from tests.support.motion import each_formulation

TOP = """
parameters: {{m: 0.1, g: 9.81, l: 0.04, I1: 1.0e-4, I3: 5.0e-5}}
coordinates: {{phi: {{initial: 0}}, theta: {{initial: 0.5}}, psi: {{initial: 0, velocity: 200}}}}
bodies:
  top:
    mass: m
    {matter}
    position: [l*sin(theta)*sin(phi), -l*sin(theta)*cos(phi), l*cos(theta)]
    orientation: {{euler: [phi, theta, psi], sequence: zxz}}
potential: m*g*top.z
"""
NUMBERS = {"m": 0.1, "l": 0.04, "I1": 1.0e-4, "I3": 5.0e-5}


@pytest.mark.parametrize(
    ("matter", "across"),
    [
        ("inertia: [I1, I1, I3]", 1.0e-4),
        ("inertia: [1.1e-4, 1.1e-4, 1.7e-4]", 1.1e-4),
        ("solid: {disc: 0.05}", 0.1 * 0.05**2 / 4),
        ("solid: {cylinder: [0.05, 0.02]}", 0.1 * (0.05**2 / 4 + 0.02**2 / 12)),
    ],
)
def test_the_inertia_of_an_axis_about_the_vertical_has_all_its_digits(matter: str, across: float) -> None:
    """(I1 + m l^2) sin(theta)^2, where the spin has been eliminated."""
    entry = each_formulation(TOP.format(matter=matter))["Routh"].mass_matrix[0][0]
    graph = entry.graph
    theta = 1e-9
    known = {graph.symbol(name): graph.lift(x) for name, x in {**NUMBERS, "theta": theta}.items()}
    (found,) = substituted(graph, [entry], known)
    expected = (across + 0.1 * 0.04**2) * math.sin(theta) ** 2
    assert found.data == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("a - a*cos(x)**2", "a*sin(x)**2"),
        ("b*sin(x)**2*y - b*y", "-b*y*cos(x)**2"),
        ("0.3 - 0.3*cos(x)**2 + a*y", "0.3*sin(x)**2 + a*y"),
        ("a - 2*a*cos(x)**2", "a - 2*a*cos(x)**2"),
        ("a + a*cos(x)**2", "a + a*cos(x)**2"),
        ("a - a*cos(x)**3", "a - a*cos(x)**3"),
    ],
)
def test_differences_of_1_and_squares_are_squares(given: str, expected: str) -> None:
    algebra = GraphAlgebra()
    one, other = (build(parse(text), algebra.symbol, algebra) for text in (given, expected))
    assert folded(algebra.graph, one) is other


def test_masses_that_are_sums_are_multiplied_out_where_they_add_up() -> None:
    graph = GraphAlgebra().graph
    a, b, u, v = (graph.symbol(name) for name in "abuv")
    apart = halved_squares(graph, [(a + b, u), (a - b, u)])
    assert apart is not None and apart is a * u * u
    whole = halved_squares(graph, [(a + b, u), (a + b, v)])
    assert whole is not None and len(terms_of(whole)) == 2
