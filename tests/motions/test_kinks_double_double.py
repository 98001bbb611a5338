"""Kinks and singularities with ``--precision double-double``: as in doubles, to twice the digits."""

from __future__ import annotations

import itertools
import json
import random

import h5py
import numpy as np
import pytest

from lagrange_cli.spec.values import resolve_long_values
from tests.motions.test_double_double import LONG, MP, largest, solved
from tests.motions.test_kinks import LINE
from tests.support.command import lagrange
from tests.support.motion import prepared, run, spec_of

FRICTION = """
coordinates: {x: {initial: 1.7, velocity: 0.3}}
masses: {p: 1}
embedding: {p: [x]}
potential: 0.01*p.x**2
generalized_forces: {x: -0.2*x_dot/sqrt(x_dot**2)}
"""


def line(potential, initial="1", velocity="0"):
    return LINE.format(initial=initial, velocity=velocity, potential=potential)


def bouncing(t):
    """x'' = -sign(x) from rest at x = 1: parabolas, a quarter period of sqrt(2) each."""
    quarter = MP.sqrt(2)
    phase = t - 4 * quarter * MP.floor(t / (4 * quarter))
    fall = min(phase, 4 * quarter - phase)
    return 1 - fall**2 / 2 if fall <= quarter else (2 * quarter - fall) ** 2 / 2 - 1


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("place", ["0", "0.7", "-3"])
def test_the_motion_in_a_wedge_is_made_of_parabolas(tmp_path, place):
    """17 kinks; each is passed within 2^-102 of the time, and the error grows with the time from there."""
    system = line(f"sqrt((p.x - ({place}))**2)", f"1 + ({place})")
    attributes, found = solved(tmp_path, system, *LONG, "--stop", "50", "--samples", "101")
    known = [bouncing(t) + MP.mpf(place) for t in found["t"]]
    assert largest(found["q/x"], known) < 1e-26
    assert attributes["h_drift"] < 1e-27


@pytest.mark.exhaustive(keep=0.75)
def test_a_jump_in_a_higher_derivative_is_found_as_well(tmp_path):
    """U = |x|^3: after ten periods of 4 int dx / sqrt(2 (1 - x^3)) it is where it was."""
    quarter = MP.quad(lambda s: 2 / MP.sqrt(2 * (3 - 3 * s**2 + s**4)), [0, 1])  # x = 1 - s^2
    stop = f"{MP.nstr(40 * quarter, 40)}"
    attributes, found = solved(
        tmp_path, line("((p.x)**2)**1.5"), *LONG, "--stop", stop, "--samples", "3", "--outputs", "q,v,h"
    )
    late = found["t"][-1] - 40 * quarter  # the end is a double
    assert abs(found["q/x"][-1] - (1 - 3 * late**2 / 2)) < 1e-26
    assert attributes["h_drift"] < 1e-28


@pytest.mark.exhaustive(keep=0.35)
def test_two_kinks_in_a_plane(tmp_path):
    system = """
        coordinates: {x: {initial: 1.7, velocity: 0.3}, y: {initial: 0.2, velocity: 0.1}}
        masses: {p: 1}
        embedding: {p: [x, y]}
        potential: sqrt((x - 1)**2) + sqrt((y + x)**2) + 0.1*y**2
        """
    attributes, _ = solved(tmp_path, system, *LONG, "--stop", "50")
    assert attributes["h_drift"] < 1e-26


@pytest.mark.exhaustive(keep=0)
def test_what_is_sampled_changes_nothing(tmp_path):
    """More samples than are handed over at once, and few: the same motion through the same kinks."""
    system = line("sqrt((p.x - 0.5)**2) + x**4/4", "1.3", "0.1")
    few, many = (
        solved(tmp_path, system, *LONG, "--stop", "16", "--samples", str(samples), "--outputs", "q,v")
        for samples in (17, 2**16 + 1)
    )
    assert few[0]["steps"] == many[0]["steps"]
    for path in ("q/x", "v/x"):
        assert few[1][path] == many[1][path][::4096]


def ended(folder, system, stop):
    """What is said of a run that does not come to its end, and the attributes of its file."""
    (folder / "system.yaml").write_text(system, encoding="utf-8")
    run = lagrange("solve", "system.yaml", *LONG, "--stop", stop, "--json", "-o", "out.h5", cwd=folder)
    assert run.returncode == 4
    with h5py.File(folder / "out.h5") as file:
        assert file.attrs["status"] == "failed"
        assert np.all(file["t"][:] <= json.loads(run.stdout)["t"])
    return json.loads(run.stdout)


@pytest.mark.exhaustive(keep=0.7)
def test_dry_friction_brings_a_body_to_rest_and_holds_it(tmp_path):
    """x'' = -0.2 - 0.02 x until x' = 0: the amplitude about x = -10."""
    _, found = solved(tmp_path, FRICTION, *LONG, "--stop", "50", "--samples", "6")
    numbers = [MP.mpf(one) for one in ("1.7", "0.2", "0.3", "0.02")]
    x, friction, v, stiffness = numbers
    at_rest = MP.sqrt((x + friction / stiffness) ** 2 + v**2 / stiffness) - friction / stiffness
    assert abs(found["q/x"][-1] - at_rest) < 1e-28
    assert abs(found["v/x"][-1]) < 1e-28


@pytest.mark.exhaustive(keep=0.5)
def test_a_puck_that_is_pulled_begins_to_slide_at_a_limit(tmp_path):
    """From t = 1/10 on its acceleration is 5 t - 1/2 along (3, 4)/5."""
    system = """
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {p: 1}
embedding: {p: [x, y]}
forces: {p: "(3*t, 4*t) - 0.5*(x_dot, y_dot)/norm((x_dot, y_dot))"}
"""
    _, found = solved(tmp_path, system, *LONG, "--stop", "1", "--samples", "6")
    past = [max(t - MP.mpf(1) / 10, 0) for t in found["t"]]
    assert largest(found["q/x"], [t**3 / 2 for t in past]) < 1e-23
    assert largest(found["q/y"], [2 * t**3 / 3 for t in past]) < 1e-23


def test_a_collision_is_no_kink_and_is_met_in_time(tmp_path):
    """x'' = -1/x^2 from rest at 1: x = 0 at pi / sqrt(8), to the last digit of a double."""
    found = ended(tmp_path, "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 + 1/x\n", "5")
    assert "the denominator x reaches 0 in 1/x" in found["message"]
    assert found["t"] == float(MP.pi / MP.sqrt(8))


def test_a_pole_between_two_steps_is_no_kink(tmp_path):
    """1/x^2 so weak that it moves nothing until it is met head-on: x^2 = (t - t0)^2 (v^2 + c) + ..."""
    system = line("1e-12/p.x**2", "1", "-1")
    attributes, found = solved(tmp_path, system, *LONG, "--stop", "3", "--samples", "31")
    weak = MP.mpf("1e-12")  # h = 1/2 + weak; x^2 = 1 - 2 t + 2 h t^2, since (x^2)'' = 4 h
    known = [MP.sqrt(1 - 2 * t + (1 + 2 * weak) * t**2) for t in found["t"]]
    assert largest(found["q/x"], known) < 1e-22  # near the pole errors are multiplied by 1e6
    assert attributes["h_drift"] < 1e-24


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("exponent", [40, -40])
def test_any_unit_of_time_will_do(tmp_path, exponent):
    """Coefficients of order 56 in units of 1e12 periods, or of 1e-12, do not fit into doubles."""
    system = "coordinates: {{x: {{initial: 1}}}}\nlagrangian: x_dot**2/2 - 4**({})*(x**2/2 + x**4/4)\n"
    last = []
    for power in (0, exponent):
        stop = repr(10 * 2.0**-power)
        _, found = solved(tmp_path, system.format(power), *LONG, "--stop", stop, "--samples", "2")
        last.append(found["q/x"][-1])
    assert abs(last[1] - last[0]) < 1e-29


@pytest.mark.exhaustive(keep=0.65)
def test_through_the_pole_of_a_sphere(tmp_path):
    """At some 1e-9 from it; otherwise as a pendulum in a plane, with an error of the momentum's square."""
    sphere = """
coordinates: {th: {initial: 1.2}, ph: {initial: 0, velocity: 1e-8}}
lagrangian: (th_dot**2 + ph_dot**2*sin(th)**2)/2 + 9.81*cos(th)
"""
    attributes, found = solved(
        tmp_path, sphere, *LONG, "--stop", "5", "--samples", "51", "--outputs", "q,v,h"
    )
    k = MP.sin(MP.mpf("0.6"))
    plane = [1 - 2 * (k * MP.ellipfun("cd", MP.sqrt(MP.mpf("9.81")) * t, k=k)) ** 2 for t in found["t"]]
    assert largest([MP.cos(th) for th in found["q/th"]], plane) < 1e-14
    assert attributes["h_drift"] < 1e-29


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("power", ["0.25", "0.5", "1.5", "2.5"])
def test_a_contact_force_that_has_no_series_where_it_begins(tmp_path, power):
    """x'' = -7 u^p, u = max(0, x - 0.7): how long it stays is an integral over u."""
    system = f"""
        coordinates: {{x: {{initial: 0, velocity: 1.2}}}}
        lagrangian: x_dot**2/2
        generalized_forces: {{x: "-7*max(0, x - 0.7)**{power}"}}
        """
    _, found = solved(tmp_path, system, *LONG, "--stop", "4", "--samples", "3")
    v, n = MP.mpf("1.2"), MP.mpf(power) + 1
    deepest = (v**2 * n / 14) ** (1 / n)
    inside = 2 * deepest / v * MP.quad(lambda s: 1 / MP.sqrt(1 - s**n), [0, 0.5, 1])
    known = MP.mpf("0.7") - v * (found["t"][-1] - MP.mpf("0.7") / v - inside)
    assert abs(found["q/x"][-1] - known) < 1e-26
    assert abs(found["v/x"][-1] + v) < 1e-27


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("power", ["1.25", "pi/2"])
def test_the_energy_of_a_spring_that_is_not_touched_is_known(tmp_path, power):
    """A fractional power of 0 is 0."""
    system = f"""
        coordinates: {{x: {{initial: 0, velocity: 1.2}}}}
        lagrangian: x_dot**2/2 - 7*(-min(0, 0.7 - x))**({power})
        """
    attributes, found = solved(tmp_path, system, *LONG, "--stop", "2", "--samples", "5", "--outputs", "q,v,h")
    assert attributes["h_drift"] < 1e-29
    assert abs(found["v/x"][-1] + MP.mpf("1.2")) < 1e-28


def test_the_last_sample_is_reached_from_a_time_with_a_low_part():
    """The time that is left, rounded, was less than that until the sample: the motion stood still there."""
    text = """
    name: a force from a place or a time on
    coordinates: {x: {initial: -0.77, velocity: 2.3383}}
    masses: {p: 1}
    embedding: {p: [x]}
    potential: 0
    generalized_forces: {x: "where(x > 2.5828 or t > 0.6857, 0.8660, 0)"}
    """
    resolved = resolve_long_values(spec_of(text), {})
    ready = prepared(text, "taylor", 2.0**-100, ("q", "v"), precision="double-double")
    motion = run(ready, resolved, 0.0, 4.0, 5)
    assert motion.t[-1] == 4.0
    assert motion["v/x"][-1] == pytest.approx(2.3383 + 0.8660 * (4.0 - 0.6857), rel=1e-15)


@pytest.mark.exhaustive(keep=0.8)
def test_no_zero_is_passed_over_where_another_argument_is_known_for_less_of_the_step():
    """A triangular well: its corner in the middle was missed."""
    text = """
    name: a triangle
    coordinates: {x: {initial: -0.826, velocity: 1.4256}}
    masses: {p: 1}
    embedding: {p: [x]}
    potential: -0.7083*max(0, 1 - abs(x - 0.5058)/0.04043)
    """
    resolved = resolve_long_values(spec_of(text), {})
    ready = prepared(text, "taylor", 2.0**-100, ("q", "v"), precision="double-double")
    assert run(ready, resolved, 0.0, 3.5, 5)["v/x"][-1] == pytest.approx(1.4256, rel=1e-15)


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("width", ["0.002158", "0.0031"])
def test_a_barrier_that_is_next_to_nothing_at_first(tmp_path, width):
    """Steps are proven by the right constants, where a force is smaller than any normal number, too."""
    text = f"parameters: {{a: 0.5148, w: {width}, B: 1.887}}\n"
    text += LINE.format(initial="-1.0652", velocity="1.7314", potential="B*exp(-abs(p.x - a)/w)")
    attributes, found = solved(tmp_path, text, *LONG, "--stop", "2.9375", "--samples", "3")
    assert abs(found["v/x"][-1] + MP.mpf("1.7314")) < 1e-28
    assert attributes["steps"] < 100


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("power", ["0.5", "1.5"])
def test_a_force_of_the_time_without_a_series_is_passed_to_all_digits(tmp_path, power, request):
    """Its root lies between two doubles; the low part of the time tells where."""
    source = random.Random(request.config.option.seed)
    w, b = (f"{source.uniform(*ends):.4f}" for ends in ((1, 2), (0.1, 3)))
    print("w, b =", w, b)
    system = f"""
coordinates: {{x: {{initial: 0, velocity: 0}}}}
lagrangian: x_dot**2/2
generalized_forces: {{x: "abs(sin({w}*t + {b}))**{power}"}}
"""
    _, found = solved(tmp_path, system, *LONG, "--stop", "4", "--samples", "5")
    places = [
        MP.mpf(0),
        *(t for k in range(1, 5) if 0 < (t := (k * MP.pi - MP.mpf(b)) / MP.mpf(w)) < 4),
        MP.mpf(4),
    ]
    v = MP.mpf(0)
    for start, end in itertools.pairwise(places):  # t = start + (end - start) s^2 (3 - 2 s)

        def rate(s, start=start, long=end - start):
            t = start + long * s * s * (3 - 2 * s)
            return abs(MP.sin(MP.mpf(w) * t + MP.mpf(b))) ** MP.mpf(power) * long * 6 * s * (1 - s)

        v += MP.quad(rate, [0, MP.mpf("0.25"), MP.mpf("0.5"), MP.mpf("0.75"), 1])
    assert abs(found["v/x"][-1] - v) <= 1e-28


@pytest.mark.exhaustive(keep=0.55)
def test_a_force_of_the_time_is_passed_where_the_motion_is(tmp_path):
    """At the root, x is 0.008 in one of two motions that differ by where they begin, 1.9 in the other."""
    system = """
coordinates: {{x: {{initial: {}, velocity: -0.0705}}}}
lagrangian: x_dot**2/2
generalized_forces: {{x: "0.6979*sqrt(abs(sin(1.0974*t - 1.9201)))"}}
"""
    (_, one), (_, other) = (
        solved(tmp_path, system.format(x), *LONG, "--stop", "4", "--samples", "5") for x in ("-0.8537", "1")
    )
    assert abs(one["v/x"][-1] - other["v/x"][-1]) <= 1e-28
    assert abs(other["q/x"][-1] - one["q/x"][-1] - MP.mpf("1.8537")) <= 1e-28
