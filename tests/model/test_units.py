"""Units as products of powers: what is read, what is the same, how it is written."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.model.unit import ALIASES, BASE, COHERENT, JOINED, KNOWN, ONE, OTHER, WHOLE, Unit
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.model.units import is_energy, meaning, same, simplified, times_within, udunits

SYMBOLS = [*sorted(KNOWN), "EUR", "Msun", "km", "GPa", "us"]


def units(symbols: list[str] = SYMBOLS, most: int = 4) -> st.SearchStrategy[Unit]:
    exponent = st.integers(-6, 6).filter(bool)
    fraction = st.builds(lambda n, d: n * WHOLE // d, exponent, st.sampled_from([1, 1, 1, 2, 3, 4]))
    return st.dictionaries(st.sampled_from(symbols), fraction, max_size=most).map(
        lambda powers: Unit(tuple(powers.items()))
    )


def read(text: str) -> Unit:
    unit = read_unit(text)
    assert unit is not None, text
    return unit


@pytest.mark.exhaustive(keep=0.35)
@settings(deadline=None)
@given(units(), units(), units())
def test_units_are_a_commutative_group(a, b, c):
    assert same(a * b, b * a)
    assert same((a * b) * c, a * (b * c))
    assert same(a * ONE, a)
    assert (a / a).powers == ()
    assert same((a / b) * b, a)


@settings(deadline=None)
@given(units(), st.integers(-4, 4), st.integers(-4, 4))
def test_powers_add_and_multiply(a, m, n):
    assert same(a.power(m) * a.power(n), a.power(m + n))
    assert same(a.power(m).power(n), a.power(m * n))
    root = a.power(1 / 2)
    if root is not None:
        assert same(root * root, a)


@pytest.mark.exhaustive(keep=0.75)
@settings(deadline=None)
@given(units())
def test_what_is_written_is_read_again(a):
    assert read(str(a)).powers == a.powers or same(read(str(a)), a)


@settings(deadline=None)
@given(units())
def test_what_udunits_gets_is_the_same_unit(a):
    text = udunits(str(a))
    if text:
        assert same(read(text.replace("turn", "rev")), a)
    else:
        fractions = any(power % WHOLE for _, power in a.powers)
        assert fractions or a.symbols & {"EUR", "Msun", "dyn", "pc"}


@pytest.mark.exhaustive(keep=0.8)
@settings(deadline=None)
@given(units([*BASE, *COHERENT]))
def test_simplified_units_are_the_same(a):
    assert same(simplified(a), a)


@pytest.mark.exhaustive(keep=0.7)
@settings(deadline=None)
@given(units(), units())
def test_the_same_units_mean_the_same(a, b):
    (scale, dimensions), (other, others) = meaning(a), meaning(b)
    assert same(a, b) == (dimensions == others and math.isclose(scale, other, abs_tol=1e-9))


@settings(deadline=None)
@given(st.text(max_size=30))
def test_any_text_is_a_unit_or_none(text):
    unit = read_unit(text)
    assert unit is None or same(read(str(unit)), unit)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("kg*m^2/s^2", "kg*m^2/s^2"),
        ("kg m2 s-2", "kg*m^2/s^2"),
        ("kg.m2.s-2", "kg*m^2/s^2"),
        ("kg\u00b7m\u00b2\u00b7s\u207b\u00b2", "kg*m^2/s^2"),
        ("m s**-2", "m/s^2"),
        ("m/s/s", "m/s^2"),
        ("1/(m s)", "1/(m*s)"),
        ("J/(kg*K)", "J/(kg*K)"),
        ("AU^1.5/Msun^0.5/d", "AU^(3/2)/(Msun^(1/2)*d)"),
        ("( kg * m ) ^ (1/2)", "kg^(1/2)*m^(1/2)"),
        ("N m", "N*m"),
        ("\u00b5m", "um"),
        ("\u03a9", "ohm"),
        ("meters/second", "m/s"),
        ("days", "d"),
        ("rads", "rad"),
        ("\u00b0/s", "deg/s"),
        ("%", "percent"),
        ("EUR/yr", "EUR/yr"),
        ("1", "1"),
    ],
)
def test_units_are_read_however_they_are_written(text, shown):
    assert str(read(text)) == shown


@pytest.mark.parametrize(
    "text",
    [
        "", "-", "solar masses", "seconds since 2000", "degrees Celsius", "J/kg K", "Msun yr-1",
        "10 m", "1.5 m",
        "arb. units", "a.u.", "m^0", "m^1000", "m(", "m/", "*m", "m^-2/3", "m^(1/0)", "meters per second",
        "(" * 60 + "m" + ")" * 60, "x" * 101, "m\0", "m\ns^", "m" + "*m^99" * 15,
        "Nm^2",
    ],
)  # fmt: skip
def test_what_is_no_product_of_powers_is_a_text(text):
    assert read_unit(text) is None
    assert udunits(text) == ""


def test_nesting_is_bounded_by_the_length():
    assert str(read("(" * 40 + "m" + ")" * 40)) == "m"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("N*m", "kg*m^2/s^2"), ("J", "W*s"), ("V*A", "J/s"), ("Pa*m^2", "N"), ("C*T*m^2/s", "J"),
        ("H*A^2", "J"), ("C^2/F", "J"), ("ohm*A^2", "W"), ("Wb/s", "V"), ("S*V", "A"), ("Hz", "1/s"),
        ("N/mm*mm^2", "t*mm^2/s^2"), ("kN", "kg*mm/ms^2"), ("GPa*mm^2", "kg*mm/ms^2"), ("dyn*cm", "erg"),
        ("g*cm^2/s^2", "erg"), ("kW*h", "h*kJ/s"), ("rad/s", "1/s"),
        ("Nm", "J"), ("kWh", "kW*h"), ("Vs", "Wb"), ("lbf", "slug*ft/s^2"), ("psi*in^2", "lbf"),
        ("Msun*AU^2/d^2", "Msun*au^2/day^2"), ("mm", "1/km^-1*mm/km"), ("L", "dm^3"),
    ],
)  # fmt: skip
def test_units_that_are_the_same(one, other):
    assert same(read(one), read(other))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("cm", "m"), ("deg", "rad"), ("min", "s"), ("yr", "d"), ("eV", "J"), ("EUR", "1"),
        ("kg*m^2/s^2", "kg*m*cm/s^2"),
        ("N", "J"), ("g", "kg"), ("rpm", "1/s"), ("percent", "1"), ("kHz", "Hz"),
    ],
)  # fmt: skip
def test_units_that_differ(one, other):
    assert not same(read(one), read(other))


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("m/s^2", ({"s"}, False)), ("N/m", ({"s"}, False)), ("AU/d", ({"d"}, False)), ("kHz", (set(), True)),
        ("mm/ms", ({"ms"}, False)), ("kg*m", (set(), False)), ("kN", (set(), True)), ("km/h", ({"h"}, False)),
        ("rpm", (set(), True)), ("Myr", ({"Myr"}, False)), ("EUR", (set(), False)), ("rad", (set(), False)),
    ],
)  # fmt: skip
def test_the_units_of_time_within(text, times):
    assert times_within(read(text)) == times


def test_energies_are_known():
    assert is_energy(read("N*mm")) and is_energy(read("eV")) and is_energy(read("u*angstrom^2/fs^2"))
    assert not is_energy(read("kg*m")) and not is_energy(read("Msun*AU^2/d^2"))


@pytest.mark.parametrize(
    ("text", "cf"),
    [
        ("kg*m^2/s^2", "kg m2 s-2"), ("days", "d"), ("seconds", "s"), ("deg", "degree"), ("AU/d", "au d-1"),
        ("rad/s", "rad s-1"),
        ("Msun", ""), ("m^0.5", ""), ("1", "1"),
        ("rev", "turn"), ("milliseconds", "ms"),
    ],
)  # fmt: skip
def test_the_spelling_of_udunits(text, cf):
    assert udunits(text) == cf


def test_no_symbol_stands_in_two_tables():
    tables = [*BASE, *COHERENT, *OTHER, *JOINED, *ALIASES]
    assert len(set(tables)) == len(tables)
    assert not KNOWN & {*JOINED, *ALIASES}
