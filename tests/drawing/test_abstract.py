"""Drawings of systems without positions: dials, axes, and the names beside them."""

import numpy as np
import pytest

from lagrange_cli.drawing.draw import draw
from lagrange_cli.drawing.drawing import Drawing
from lagrange_cli.drawing.evaluate import points
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values


def drawn(*names: str, lagrangian: str) -> Drawing:
    coordinates = "".join(f"  {name}: {{initial: 0.3}}\n" for name in names)
    text = f"parameters: {{k: 2}}\ncoordinates:\n{coordinates}lagrangian: {lagrangian}\n"
    spec = read_spec(text, "abstract.yaml")
    return draw(spec, resolve_values(spec))


def on_dials(drawing: Drawing) -> set[str]:
    """The coordinates that turn a hand: the tip of each is one unit from its middle, whatever its value."""
    q = np.linspace(-2, 2, 9)[:, None] * np.ones(len(drawing.coordinates))
    places = points(drawing, np.zeros(9), q, {"k": 2.0})
    tips = {one.name: places[one.point] for one in drawing.dots}
    middles = {one.point: places[one.point] for one in drawing.pivots}
    return {
        name
        for name, tip in tips.items()
        if any(np.allclose(np.hypot(*(tip - middle)), 1) for middle in middles.values())
    }


@pytest.mark.parametrize(
    ("lagrangian", "turning"),
    [
        ("a_dot**2 + b_dot**2 + c_dot**2 + k*cos(a)", {"a"}),
        ("a_dot**2 + b_dot**2 + c_dot**2*sin(b - a)**2", {"a", "b"}),
        ("a_dot**2 + b_dot**2 + c_dot**2 + cos(k*a)", set()),  # a potential that repeats itself
        ("a_dot**2 + b_dot**2 + c_dot**2 - a**2", set()),
    ],
)
def test_what_is_turned_by_is_an_angle(lagrangian, turning):
    assert on_dials(drawn("a", "b", "c", lagrangian=lagrangian)) == turning


def test_greek_letters_are_angles_as_their_names_are():
    kinetic = "{}_dot**2 + {}_dot**2 + x_dot**2 + cos(x)"
    assert on_dials(drawn("θ", "ψ", "x", lagrangian=kinetic.format("θ", "ψ"))) == {"θ", "ψ"}
    assert on_dials(drawn("theta", "psi", "x", lagrangian=kinetic.format("theta", "psi"))) == {"theta", "psi"}


def test_dials_and_axes_bear_names_and_a_place_has_a_scale():
    gauges = drawn("theta", "s", "r", lagrangian="theta_dot**2 + s_dot**2 + r_dot**2")
    assert [one.label for one in gauges.dots] == ["theta", "s", "r"]
    assert not gauges.data()["scaled"]
    place = drawn("x", "y", lagrangian="x_dot**2 + y_dot**2")
    assert [one.label for one in place.dots] == [""]
    assert place.data()["scaled"]
    plane = drawn("u", "s", lagrangian="u_dot**2 + s_dot**2")
    assert [one.label for one in plane.dots] == ["u, s"]
    assert plane.data()["scaled"]
