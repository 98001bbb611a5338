"""Names that would look the same in LaTeX, Unicode or on pages are told apart."""

import pytest

from lagrange_cli.symbolic.latex import as_latex
from lagrange_cli.symbolic.layouts import as_text, as_unicode
from lagrange_cli.symbolic.mathml import as_mathml
from tests.support.systems import derived

SYSTEM = """
parameters: {x_1: 2, θ: 3, π: 0.5}
coordinates: {x1: {initial: 0.2}, theta: {initial: 0.1}}
lagrangian: x1_dot**2/2 + theta_dot**2/2 - x_1*x1 - θ*theta**2 - pi*π*theta
"""
TOGETHER = "coordinates: {x1: {initial: 1}, x_1: {initial: 2}}\nlagrangian: x1_dot**2 - x_1*x1 + x_1_dot**2\n"


@pytest.mark.parametrize(
    ("write", "shown"),
    [
        (as_text, ("x1_ddot = -x_1", "- 2*θ*theta", "pi*π")),
        (as_latex, (r"\ddot{x}_{1} &= -\mathrm{x\_1}", r"2 \mathrm{θ} \theta", r"\pi \mathrm{π}")),
        (as_unicode, (" = −x_1", "2 θ theta")),
    ],
)
def test_a_parameter_looks_unlike_a_coordinate(write, shown):
    text = write(derived(SYSTEM), "explicit")
    assert all(one in text for one in shown), text


@pytest.mark.parametrize("write", [as_latex, as_unicode])
def test_two_coordinates_look_different(write):
    lines = [line for line in write(derived(TOGETHER), "explicit").splitlines() if "=" in line]
    assert len({line.partition("=")[0] for line in lines}) == 2


def test_names_are_told_apart_on_a_page():
    text = as_mathml(derived(SYSTEM))
    assert "<mi>x_1</mi>" in text and "<msub><mi>x</mi>" in text


def test_other_names_look_as_they_would_alone():
    alone = SYSTEM.replace("x_1", "k").replace("θ", "a").replace("π", "b")
    assert r"\mathrm" not in as_latex(derived(alone), "explicit")


LENGTH = """
parameters: {L: 1}
coordinates: {x: {initial: 0}, h: {initial: 0}}
lagrangian: x_dot**2/2 + h_dot**2/2 - L*x - h*x
"""


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (as_text(derived(LENGTH), "lagrange"), "x*h   [h on the right is the coordinate]"),
        (as_latex(derived(LENGTH), "lagrange"), r"\text{($L$ on the right is the parameter)}"),
        (as_mathml(derived(LENGTH)), "on the right is the parameter"),
    ],
    ids=["text", "latex", "page"],
)
def test_a_length_named_like_the_lagrangian_is_told_apart_from_it(text, shown):
    assert shown in text
    assert text.count("on the right is the") == 2
