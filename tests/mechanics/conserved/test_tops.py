"""Kovalevskaya's integral: found in any orientation's form, kept by motions, and claimed of no other top."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.conserved.tops import goryachev_chaplygin
from tests.support.command import lagrange
from tests.support.motion import follow, residual_of
from tests.support.rates import rates

TOP = """
parameters: {{m: 1.0, g: 9.81, l: 0.1, C: 0.05}}
coordinates: {{{coordinates}}}
definitions: {{i: [{first}], j: [{second}], k: [{third}]}}
bodies: {{top: {{mass: m, inertia: {inertia}, position: {centre}, orientation: {{{orientation}}}}}}}
potential: {potential}
"""
ANGLES = "a: {initial: 0.4, velocity: 1}, b: {initial: 1, velocity: 2}, c: {initial: 0.3, velocity: 5}"
EULER = {
    "coordinates": ANGLES,
    "orientation": "euler: [a, b, c], sequence: zxz",
    "first": "cos(a)*cos(c) - sin(a)*cos(b)*sin(c), sin(a)*cos(c) + cos(a)*cos(b)*sin(c), sin(b)*sin(c)",
    "second": "-cos(a)*sin(c) - sin(a)*cos(b)*cos(c), cos(a)*cos(b)*cos(c) - sin(a)*sin(c), sin(b)*cos(c)",
    "third": "sin(a)*sin(b), -cos(a)*sin(b), cos(b)",
}
TAIT_BRYAN = {
    "coordinates": ANGLES,
    "orientation": "euler: [a, b, c], sequence: xyz",
    "first": "cos(b)*cos(c), cos(a)*sin(c)+sin(a)*sin(b)*cos(c), sin(a)*sin(c)-cos(a)*sin(b)*cos(c)",
    "second": "-cos(b)*sin(c), cos(a)*cos(c)-sin(a)*sin(b)*sin(c), sin(a)*cos(c)+cos(a)*sin(b)*sin(c)",
    "third": "sin(b), -sin(a)*cos(b), cos(a)*cos(b)",
}
QUATERNION = {
    "coordinates": "w: {initial: 1}, x: {initial: 0, velocity: 0.5}, y: {initial: 0, velocity: 1.2}, "
    "z: {initial: 0, velocity: -2}",
    "orientation": "quaternion: [w, x, y, z]",
    "first": "w**2 + x**2 - y**2 - z**2, 2*(x*y + w*z), 2*(x*z - w*y)",
    "second": "2*(x*y - w*z), w**2 - x**2 + y**2 - z**2, 2*(y*z + w*x)",
    "third": "2*(x*z + w*y), 2*(y*z - w*x), w**2 - x**2 - y**2 + z**2",
}
ALONG, WEIGHT = "[2*C, 2*C - m*l**2, C - m*l**2]", "m*g*top.z"
CASES = {
    "Euler's angles": (EULER, ALONG, "l*i", WEIGHT),
    "a quaternion": (QUATERNION, ALONG, "l*i", WEIGHT),
    "U in coordinates": (EULER, ALONG, "l*i", "m*g*l*sin(b)*sin(c)"),
    "another direction": (TAIT_BRYAN, ALONG, "l*i", "-m*g*top.x"),
    "another axis": (EULER, "[C - m*l**2, 2*C - m*l**2, 2*C]", "l*k", WEIGHT),
    "between two axes": (
        EULER,
        "[[2*C - m*l**2, m*l**2/2, 0], [m*l**2/2, 2*C - m*l**2/4, 0], [0, 0, C - 5*m*l**2/4]]",
        "l*i/2 + l*j",
        WEIGHT,
    ),
    "numbers": (EULER, "[0.08, 0.07, 0.03]", "0.1*i", "g*top.z"),
}
OTHERS = {
    "Lagrange's top": (EULER, "[2*C - m*l**2, 2*C - m*l**2, C]", "l*k", WEIGHT),
    "a ratio of 3": (EULER, "[4*C, 4*C - m*l**2, 4*C/3 - m*l**2]", "l*i", WEIGHT),
    "a spring besides": (EULER, ALONG, "l*i", "m*g*top.z + top.R31**2"),
    "a rotor inside": (EULER, ALONG, "l*i", "m*g*top.z - C*top.w3"),
    "a magnetic moment that grows with the spin": (EULER, ALONG, "l*i", "m*g*top.z - C*top.w1*top.R31"),
    "a velocity in U": (EULER, ALONG, "l*i", "m*g*top.z - m*top.vx"),
    "another point": (EULER, ALONG, "l*i + (0, 0, l*a)", WEIGHT),
    "a moving frame": (EULER, ALONG, "l*i", "m*g*(top.z*cos(t) + top.x*sin(t))"),
}


def text_of(case):
    form, inertia, centre, potential = case
    text = TOP.format(**form, inertia=inertia, centre=centre, potential=potential)
    return text.replace("mass: m", "mass: 1") if centre.startswith("0.1") else text


def found_in(case):
    residual = residual_of(text_of(case))
    found = symmetries(residual.model, residual.conserved)
    return [each.conserved.quantity for each in found if "Kovalevskaya" in each.conserved.because]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", CASES)
def test_it_is_found(name):
    assert found_in(CASES[name]) == ["K"]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", ["a quaternion", "another axis", "between two axes"])
def test_motions_keep_it(name):
    found = follow(text_of(CASES[name]), 2.0, 21, outputs=("conserved",))["diagnostics/conserved/K"]
    assert np.ptp(found) < 1e-12 * found.max()


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", OTHERS)
def test_it_is_not_claimed_of_others(name):
    assert not found_in(OTHERS[name])


FOUR = "[4*C, 4*C - m*l**2, C - m*l**2]"
GORYACHEV = {
    "Euler's angles": (EULER, FOUR, "l*i", WEIGHT),
    "another direction": (TAIT_BRYAN, FOUR, "l*i", "-m*g*top.x"),
    "another axis": (EULER, "[C - m*l**2, 4*C - m*l**2, 4*C]", "l*k", WEIGHT),
    "between two axes": (
        EULER,
        "[[4*C - m*l**2, m*l**2/2, 0], [m*l**2/2, 4*C - m*l**2/4, 0], [0, 0, C - 5*m*l**2/4]]",
        "l*i/2 + l*j",
        WEIGHT,
    ),
}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", GORYACHEV)
def test_goryachevs_and_chaplygins_integral(name):
    """It is constant where there is no angular momentum about the direction of the field, not elsewhere."""
    model = residual_of(text_of(GORYACHEV[name])).model
    one = goryachev_chaplygin(model, Noether(model))
    for (rate, kept), (size, whole) in rates(model, [one.node, one.level], level=one.level):
        assert abs(rate) < 1e-12 * size and abs(kept) < 1e-12 * whole
    assert max(abs(rate) / size for (rate,), (size,) in rates(model, [one.node])) > 1e-3
    assert "K" not in {each.conserved.quantity for each in symmetries(model)}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("name", [*CASES, *OTHERS])
def test_it_is_no_other_top(name):
    case = CASES[name] if name in CASES else OTHERS[name]
    model = residual_of(text_of(case)).model
    assert goryachev_chaplygin(model, Noether(model)) is None


@pytest.mark.exhaustive(keep=0.15)
def test_check_names_it_for_motions_that_keep_it(tmp_path):
    """With b = pi/2 and no spin of a, the angular momentum about z is 0, and the formula stays constant."""
    text = text_of((EULER, FOUR, "l*i", WEIGHT))
    still = text.replace("initial: 0.4, velocity: 1", "initial: 0.4").replace("initial: 1,", "initial: pi/2,")
    for name, given in (("moving", text), ("still", still)):
        (tmp_path / f"{name}.yaml").write_text(given)
    found = {}
    for name in ("moving", "still"):
        said = json.loads(lagrange("check", f"{name}.yaml", "--json", cwd=tmp_path).stdout)
        found[name] = {one["quantity"]: one for one in said["conserved"]}
    assert found["still"].keys() - found["moving"].keys() == {"G"}
    formula = found["still"]["G"]["expression"]
    series = follow(f"{still}observables: {{G: {formula}}}", 2.0, 21, outputs=("observables",))[
        "observables/G"
    ]
    assert np.ptp(series) < 1e-12 * (5**3 + np.abs(series).max())


@pytest.mark.exhaustive(keep=0.5)
def test_the_axis_of_a_symmetric_top_has_a_momentum_in_a_quaternion_too():
    inertia = "[2*C - m*l**2, 2*C - m*l**2, C]"
    residual = residual_of(text_of((QUATERNION, inertia, "l*k", WEIGHT)))
    found = {each.conserved.quantity for each in symmetries(residual.model, residual.conserved)}
    assert found == {"L_z", "L_3"}
