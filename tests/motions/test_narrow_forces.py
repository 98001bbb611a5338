"""Forces that are nothing, to the last bit, where a step begins and ends, and not in between."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.mechanics.defect import may_hide
from lagrange_cli.native.followed import followed
from tests.support.motion import NAMES, SYSTEMS, follow, prepared, residual_of

LINE = """
coordinates:
  x: {{initial: {initial}, velocity: {velocity}}}
lagrangian: x_dot**2/2 - ({potential})
"""
POTENTIALS = {
    "3/10*exp(-(x/1e-3)**2)": (1e-3, lambda u: 0.3 * mpmath.exp(-(u**2))),
    "-3/10*exp(-(x/1e-5)**2)": (1e-5, lambda u: -0.3 * mpmath.exp(-(u**2))),
    "3/10/cosh(50*x)**2": (2e-2, lambda u: 0.3 / mpmath.cosh(u) ** 2),
    "3/10*2**(-(x/1e-3)**2)": (1e-3, lambda u: 0.3 * mpmath.mpf(2) ** (-(u**2))),
    "3/10/(1 + (x/1e-6)**4)": (1e-6, lambda u: 0.3 / (1 + u**4)),
    "3/10/(1 + (100*x)**40)": (1e-2, lambda u: 0.3 / (1 + u**40)),
    "1/10*(1 + tanh(x/1e-3))": (1e-3, lambda u: 0.1 * (1 + mpmath.tanh(u))),
    "1/10*(1 + tanh((x/1e-6)**11))": (1e-6, lambda u: 0.1 * (1 + mpmath.tanh(u**11))),
    "3/10/(1 + (x/1e-6)**12)": (1e-6, lambda u: 0.3 / (1 + u**12)),
    "3/10/(1 + (x/1e-3)**30)": (1e-3, lambda u: 0.3 / (1 + u**30)),
    "3/10*exp(-(x/1e-6)**12)": (1e-6, lambda u: 0.3 * mpmath.exp(-(u**12))),
    "3/10*exp(-(x/1e-9)**2)": (1e-9, lambda u: 0.3 * mpmath.exp(-(u**2))),
    "3/10*1e-60/(x**2 + 1e-20)**3": (1e-10, lambda u: 0.3 / (1 + u**2) ** 3),
    "3/10*1e-24/(x**2 + 1e-16)**(3/2)": (1e-8, lambda u: 0.3 / (1 + u**2) ** 1.5),
}
"""Each with its width and as a function of x over that."""


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize("potential", POTENTIALS)
@pytest.mark.parametrize("initial", [-1.0, -2.9])
def test_a_particle_that_runs_over_a_narrow_potential(potential, initial):
    """x' = sqrt(1 - 2 U): how long it takes to where it is found, by quadrature."""
    motion = follow(LINE.format(initial=initial, velocity=1, potential=potential), 5.0, 6)
    assert motion.outcome.ending is Ending.COMPLETE

    width, shape = POTENTIALS[potential]
    place, start = float(motion["q/x"][-1]) / width, initial / width

    def slowness(u):
        return 1 / mpmath.sqrt(1 - 2 * shape(u))

    near = [k / 10 for k in range(-9, 10)]
    ways = [start, *(-(10.0**n) for n in range(10, -1, -1)), *near, *(10.0**n for n in range(11)), place]
    time = width * mpmath.quad(slowness, [u for u in ways if start <= u <= place])
    assert abs(time - 5) <= 1e-12
    assert motion.outcome.h_drift <= 1e-13


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize(
    "potential",
    ["3/10/(1 + ((x**2 + y**2)/1e-12)**6)", "3/10*1e-72/(x**2 + y**2)**6", "3/10*exp(-(x**2 + y**2)/1e-12)"],
)
def test_where_a_particle_comes_from_does_not_change_how_it_is_scattered(potential):
    """By what is 1e-6 wide, at an impact parameter of 7e-7."""
    found = []
    for way in (0.5, 2.9, 4.4):
        text = f"""
            coordinates: {{x: {{initial: -{way}, velocity: 1}}, y: {{initial: 7e-7}}}}
            lagrangian: (x_dot**2 + y_dot**2)/2 - ({potential})
            """
        found.append(follow(text, way + 3, 2)["v/y"][-1])
    assert abs(found[0]) > 0.1
    np.testing.assert_allclose(found, found[0], rtol=0, atol=1e-14)


def test_members_of_a_sweep_do_not_leap_over_narrow_forces():
    text = LINE.format(initial=-1, velocity=1, potential="0.8*exp(-(x/1e-3)**2)")
    assert prepared(text, ensemble=True).machine.program.lanes == 0


def test_a_row_of_narrow_bumps():
    """Ten of them, all alike: the argument itself has to be known along the whole step."""
    motion = follow(LINE.format(initial=0.5, velocity=1, potential="0.3*exp(-1e4*sin(pi*x)**2)"), 10.0, 2)
    crossing = mpmath.quad(
        lambda u: (
            1 / mpmath.sqrt(1 - mpmath.mpf(6) / 10 * mpmath.exp(-(10**4) * mpmath.sin(mpmath.pi * u) ** 2))
        ),
        [-0.5, -0.05, -0.01, 0, 0.01, 0.05, 0.5],
    )
    way = float(motion["q/x"][-1]) - 0.5
    assert abs(way + round(way) * (crossing - 1) - 10) <= 1e-11
    assert motion.outcome.h_drift <= 1e-12


def test_a_particle_is_turned_back_by_a_narrow_bump():
    motion = follow(LINE.format(initial=-1, velocity=1, potential="0.8*exp(-(x/1e-3)**2)"), 5.0, 6)
    assert abs(motion["v/x"][-1] + 1) <= 1e-13


@pytest.mark.parametrize("velocity", [0.0, 1.0])
def test_a_particle_is_hit_by_a_short_pulse(velocity):
    """exp(-(t - 50)^2 / w^2) of impulse 1, nothing at t = 0 even to denormal numbers."""
    text = f"""
        parameters: {{w: 1e-3}}
        coordinates: {{x: {{initial: 0, velocity: {velocity}}}}}
        lagrangian: x_dot**2/2
        generalized_forces: {{x: exp(-(t - 50)**2/w**2)/(w*sqrt(pi))}}
        """
    motion = follow(text, 100.0, 11)
    assert abs(motion["v/x"][-1] - velocity - 1) <= 1e-11
    assert abs(motion["q/x"][-1] - 100 * velocity - 50) <= 1e-9
    assert np.all(motion["v/x"][:5] == velocity)


def test_a_barrier_between_two_walls_is_met_every_time():
    motion = follow(LINE.format(initial=1, velocity=0, potential="x**2/2 + 0.1*exp(-1e8*x**2)"), 50.0, 501)
    assert motion.outcome.h_drift <= 1e-13
    assert np.min(motion.t[1:][np.diff(np.sign(motion["q/x"])) != 0]) < math.pi


def test_powers_that_no_series_has_terms_of_are_detected():
    """U = sin(pi x)^64 begins with 64 derivatives that are 0."""
    motion = follow(LINE.format(initial=0, velocity=1, potential="0.3*sin(pi*x)**64"), 10.0, 2)

    def slowness(x):
        return 1 / mpmath.sqrt(1 - mpmath.mpf(6) / 10 * mpmath.sin(mpmath.pi * x) ** 64)

    way = mpmath.mpf(float(motion["q/x"][-1]))
    passed, rest = mpmath.floor(way), way - mpmath.floor(way)
    crossing = mpmath.quad(slowness, [0, 0.4, 0.5, 0.6, 1])
    assert abs(passed * crossing + mpmath.quad(slowness, [0, 0.4, rest]) - 10) <= 1e-11


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("power", [50, 57, 62])
def test_a_force_with_a_high_power_of_a_sine_begins_from_rest(power):
    """sin(1.3 t + 0.2)^power: its integral is a sum of few cosines."""
    text = f"""
        coordinates: {{x: {{initial: 0, velocity: 0}}}}
        lagrangian: x_dot**2/2
        generalized_forces: {{x: sin(1.3*t + 0.2)**{power}}}
        """
    motion = follow(text, 100.0, 2)
    with mpmath.workdps(40):
        rate, phase = mpmath.mpf(1.3), mpmath.mpf(0.2)
        beats = [phase + rate * 100 * k / 40 for k in range(41)]
        impulse = mpmath.quad(lambda u: mpmath.sin(u) ** power, beats) / rate
    assert abs(motion["v/x"][-1] - impulse) <= 1e-13


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("width", [1e-2, 1e-5, 1e-9])
@pytest.mark.parametrize(
    "form", ["0.3/cosh(x/{w})**2", "0.6*exp(x/{w})/(1 + exp(x/{w}))**2", "0.5/(exp(x/{w}) + exp(-x/{w}))"]
)
def test_exponentials_that_overflow_where_nothing_else_does(form, width):
    """cosh(x/w) is infinite at the start, and the force 0."""
    motion = follow(LINE.format(initial=-10, velocity=1, potential=form.format(w=width)), 15.0, 2)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift <= 1e-14
    assert abs(motion["v/x"][-1] - 1) <= 1e-14
    assert 0 < 5 - motion["q/x"][-1] < 3 * width


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("power", range(24, 66, 8))
def test_a_well_of_a_high_power_confines(power):
    motion = follow(LINE.format(initial=0, velocity=1, potential=f"0.6*sin(x)**{power}"), 60.0, 601)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(motion["q/x"])) < math.pi / 2
    assert motion.outcome.h_drift <= 1e-14


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "potential",
    [
        "0.5*cos(atan(1e6*(x - 0.3)))**6",
        "0.5*cos(atan2(1e6*x - 3e5, 1))**6",
        "2*((1 + ((x - 0.3)/1e-5)**4)**0.5 - ((x - 0.3)/1e-5)**2)**4",
        "atan(exp(-(x/1e-4)**2))",
        "log(1 + exp(1e3*x))/10",
    ],
)
def test_a_barrier_of_any_form_turns_a_particle_back(potential):
    motion = follow(LINE.format(initial=-1, velocity=0.9, potential=potential), 3.0, 2)
    assert motion["v/x"][-1] < -0.8
    assert motion.outcome.h_drift <= 1e-13
    assert motion.outcome.steps <= 1000


def test_a_logarithm_without_bound_turns_a_particle_back():
    motion = follow(LINE.format(initial=1, velocity=-1, potential="-log(3 + 1.7*x)/4"), 20.0, 2)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"][-1] > 0
    assert motion.outcome.h_drift <= 1e-13


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("potential", ["log(3 + 1.7*x)/4", "-1e-6/(3 + 1.7*x)", "-1e-20/(3 + 1.7*x)**2"])
def test_a_motion_ends_at_a_pole(potential):
    """However weak it is. As a function of the way s to it: x' = sqrt(1 - 2 (U(s) - U(3/1.7)))."""
    shape = {"log": lambda s: mpmath.log(1.7 * s) / 4, "-1e-6": lambda s: -1e-6 / (1.7 * s)}
    energy = shape.get(potential.partition("(")[0].rstrip("/"), lambda s: -1e-20 / (1.7 * s) ** 2)
    way = mpmath.mpf(3) / mpmath.mpf(1.7)

    def slowness(s):
        return 1 / mpmath.sqrt(1 - 2 * (energy(s) - energy(way)))

    time = mpmath.quad(slowness, [0, *(way * mpmath.mpf(10) ** -n for n in range(20, 0, -1)), way])
    motion = follow(LINE.format(initial=0, velocity=-1, potential=potential), 10.0, 2)
    assert motion.outcome.ending is Ending.STEP_UNDERFLOW
    assert abs(motion.outcome.t - float(time)) <= 1e-12


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("name", NAMES)
def test_the_systems_shipped_hide_no_forces(name):
    """It costs a row of the state."""
    assert not may_hide(residual_of((SYSTEMS / f"{name}.yaml").read_text()))


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("depth", "hides"),
    [
        ("x - 1", False),
        ("3 - sqrt(x**2 + (y - 1)**2)", False),
        ("x + cos(y)", False),
        ("x**2 - y**2 + 1e-12", True),
        ("x + sqrt(x**2 + y**2)", True),
        ("2 - x_dot", True),
    ],
)
def test_a_depth_hides_no_force_unless_it_is_softened(depth, hides):
    """It is a coordinate of another frame; |v| may be 0 all along, and x + |r| is 0 on a line."""
    text = f"""
        coordinates: {{x: {{initial: 2}}, y: {{initial: 0}}}}
        lagrangian: (x_dot**2 + y_dot**2)/2
        generalized_forces: {{x: "-max(0, {depth})**1.5"}}
    """
    given = {"stepping": True, "store_momenta": False, "proven": False, "unproven": False}
    assert followed(residual_of(text), {}, **given).hiding == hides


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(
    "form", ["(x - 0.3247)/1.382e-6", "x/1.382e-6 - 0.3247/1.382e-6", "(0.3247 - x)*723589"]
)
def test_numbers_in_a_narrow_well_are_rounded_once(form):
    """x/w - a/w in the well and x/w**2 - a/w**2 in its slope, each rounded, would be 0 at different places:
    the energy behind the well would be off by 1e-10."""
    well = f"1.643*(1 + ({form})**2)**(-1.5)"
    start = "name: a well\ncoordinates: {x: {initial: -0.9693, velocity: 1.646}}\n"
    for text in (
        f"lagrangian: x_dot**2/2 + {well}",
        f"masses: {{p: 1}}\nembedding: {{p: [x]}}\npotential: -{well}",
    ):
        motion = lagrange_cli.solve(start + text, stop=1.6, samples=3)
        assert motion.v["x"][-1] == pytest.approx(1.646, rel=1e-15)
