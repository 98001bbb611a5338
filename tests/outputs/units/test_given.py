"""Units by dimension: of what little a file gives."""

from __future__ import annotations

import pytest

from lagrange_cli.outputs.units import find_units
from lagrange_cli.spec.read import read_spec
from tests.support.units import ANGULAR, ENERGY, LINEAR, one, units


def test_a_file_without_units_has_none():
    assert units(one(m="1", k="4", x="{initial: 1}")) == {}


@pytest.mark.parametrize(
    "time", ["time: {unit: d}", "time: d", "solve: {unit: d}", "time: d\nsolve: {unit: d}"]
)
def test_the_file_says_the_unit_of_t(time):
    found = units(one(m="1", k="4", more=time))
    assert (found["t"], found["v/x"]) == ("d", "m/d")


@pytest.mark.parametrize(
    ("k", "unit"),
    [
        ("N/m", "s"),
        ("kg/d^2", "d"),
        ("kg/ms^2", "ms"),
        ("1/yr", "yr"),
        ("V", "s"),
        ("kN/m", None),  # kN, mm, ms and kg go together as well as kN, m, s and t
        ("kHz", None),
        ("m", None),
        ("rpm", None),
    ],
)
def test_the_unit_of_t_is_that_of_the_others(k, unit):
    found = units(one(m="1", k=f"{{value: 4, unit: {k}}}", potential="0*x"))
    assert found.get("t") == unit
    assert found.get("v/x") == (unit and f"m/{unit}")


def test_several_units_of_time_say_nothing_of_t():
    text = one(m="{value: 1, unit: kg}, w: {value: 1, unit: km/h}")
    found = find_units(read_spec(text, "a.yaml"))
    assert "t" not in found.texts and "v/x" not in found.texts
    (conflict,) = found.conflicts
    assert "h and s" in conflict.message and "time: {unit: h}" in conflict.hint
    assert units(text + "time: s")["v/x"] == "m/s"


def test_a_unit_of_t_that_only_seems_so_is_given_up():
    """g, mm, ms and N are one system of units; N alone would say s."""
    text = one(m="{value: 1, unit: g}", k="{value: 1, unit: N/mm}", x="{initial: 1, unit: mm}")
    found = find_units(read_spec(text, "a.yaml"))
    assert not found.texts.keys() & {"t", "v/x", "diagnostics/h"} and found.texts["q/x"] == "mm"
    (conflict,) = found.conflicts
    assert conflict.message == "the potential is in N*mm, other energies in g*mm^2/s^2"
    assert "time: {unit: ...}" in conflict.hint
    assert units(text + "time: ms")["diagnostics/h"] == "g*mm^2/ms^2"


@pytest.mark.parametrize(
    ("text", "energy"),
    [
        (one(), ENERGY),
        (one("9.81*x"), ENERGY),  # T tells
        (one("0"), ENERGY),
        (one(m="1"), ENERGY),  # U tells
        (one(mass="2"), ENERGY),
        (one("x**2/2", mass="2"), None),  # m^2 is no energy: the number is a stiffness
        (one("m*x", mass="2"), None),
        (one(m="1", k="4"), None),
        (one(x="{initial: 1}"), None),
        (one(x="{initial: 1}", more="time: s"), None),
        (one("k*x**2/2*m", m="1"), None),
        (one("k*(x - 1.25)**2/2", mass="2"), None),
        (one("k*(x - 1.25)**2/2"), ENERGY),
        (one(position="[cos(x/l)]", k="{value: 1, unit: N}", more="definitions: {l: 2}"), None),
    ],
)
def test_the_unit_of_energy(text, energy):
    found = units(text)
    assert {found.get(f"diagnostics/{name}") for name in ("h", "T", "U", "energy", "ledger/h")} == {energy}
    assert ("diagnostics/p/x" in found) == (energy is not None)


@pytest.mark.parametrize(
    ("formula", "unit"),
    [
        ("x", "m"),
        ("2*x", "m"),
        ("x/2 + 0.25*x", "m"),
        ("x + 1.5", "m"),
        ("x - 57.3", "m"),
        ("57.3*x", None),
        ("x*180/pi", None),
        ("100*x", None),
        ("3/(1 + x**2)", None),
        ("exp(-(x - 0.3)/(2*x))", None),
        ("x_dot", "m/s"),
        ("x_dot/x", "1/s"),
        ("bead.x*bead.vx", "m^2/s"),
        ("sqrt(k/m)", "1/s"),
        ("k*x", "N"),
        ("k*x**2/2", ENERGY),
        ("x**(1/3)", "m^(1/3)"),
        ("x**c", None),
        ("(x/bead.x)**(m/m)", None),
        ("x/bead.x", None),
        ("cos(t*sqrt(k/m))", None),
        ("atan2(x, bead.x)", "rad"),
        ("asin(x/bead.x) - 1.0", "rad"),
        ("norm((x, 2*x, 0))", "m"),
        ("dot((x, x), (x_dot, x_dot))", "m^2/s"),
        ("dot(cross((x, x, x), (x_dot, x_dot, x_dot)), (2, 2, 2))", "m^2/s"),
        ("sum(x for i in range(3))", "m"),
        ("sum(i*x for i in range(3))", "m"),
        ("log(x)", None),
        ("m*log(x)", "kg"),
        ("1", None),
        ("0*x + x_dot", "m/s"),
    ],
)
def test_the_unit_of_an_observable(formula, unit):
    text = one(m="{value: 1, unit: kg}, c: 2", more=f'observables: {{o: "{formula}"}}')
    assert units(text).get("observables/o") == unit


def test_coordinates_without_a_unit_have_that_of_their_initial_values():
    found = units(one(x="{initial: 2*l}", more="", k="{value: 1, unit: N/m}, l: {value: 1, unit: m}"))
    assert (found["q/x"], found["v/x"], found["diagnostics/p/x"]) == ("m", "m/s", LINEAR)
    found = units(one("0", x="{initial: 0, velocity: w}", k="1, w: {value: 1, unit: km/h}"))
    assert (found["q/x"], found["v/x"]) == ("km", "km/h")


def test_a_parameter_without_a_unit_has_that_of_its_expression():
    found = units(one(k="{value: 1, unit: N/m}, w: sqrt(k/m), n: 2*3, e: k*1.234"))
    assert found["parameters/w"] == "1/s"
    assert not found.keys() & {"parameters/n", "parameters/e"}


def test_members_of_a_family_have_one_unit_or_none():
    text = "coordinates:\n  u[0]: {{initial: 1, unit: m}}\n  u[1]: {{initial: 1, unit: {}}}\n"
    text += "time: s\nlagrangian: u_dot[0]**2 + u_dot[1]**2\n"
    assert units(text.format("m"))["v/u"] == "m/s"
    assert not units(text.format("cm")).keys() & {"q/u", "v/u", "diagnostics/p/u"}


def test_a_text_that_is_no_unit_stays_as_it_is():
    found = units(one(x="{initial: 1, unit: widths of the gap}", m="{value: 1, unit: solar masses}"))
    assert (found["q/x"], found["parameters/m"], found["t"]) == ("widths of the gap", "solar masses", "s")
    assert not found.keys() & {"v/x", "diagnostics/p/x", "diagnostics/T", "positions/bead"}


def test_angles_are_in_radians_and_only_they():
    found = units(
        one(
            x="{initial: 1, unit: rad}",
            k="{value: 1, unit: N*m}",
            position="[x]",
            m="{value: 1, unit: kg*m^2}",
        )
    )
    assert (found["v/x"], found["diagnostics/p/x"], found["positions/bead"]) == ("rad/s", ANGULAR, "rad")
    degrees = one("0", x="{initial: 1, unit: deg}", position='["k*sin(x*pi/180)"]', k="{value: 1, unit: m}")
    found = units(degrees + "time: s")
    assert (found["v/x"], found["diagnostics/p/x"]) == ("deg/s", "kg*m^2/(s*deg)")
