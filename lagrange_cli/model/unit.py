"""``Unit``: a product of powers of symbols, combined and written; symbols and their prefixes.

The values of units are those of the SI brochure, 9th ed. (BIPM 2019), tables 4 to 8, of CODATA 2022, and of
the international yard and pound; yr is the Julian year. The spelling for programs is that of UDUNITS-2, which
the CF conventions (1.11, section 3.1) refer to.
"""

from __future__ import annotations

import math

from lagrange_cli.records import dataclass

COHERENT: dict[str, str] = {
    "N": "kg*m/s^2", "J": "kg*m^2/s^2", "W": "kg*m^2/s^3", "Pa": "kg/m/s^2", "Hz": "1/s", "C": "A*s",
    "V": "kg*m^2/A/s^3", "F": "A^2*s^4/kg/m^2", "ohm": "kg*m^2/A^2/s^3", "S": "A^2*s^3/kg/m^2",
    "Wb": "kg*m^2/A/s^2", "T": "kg/A/s^2", "H": "kg*m^2/A^2/s^2", "rad": "1", "sr": "1",
}  # fmt: skip
"""Derived units of the SI that are products of base units, without a factor."""

OTHER: dict[str, tuple[float, str]] = {
    "g": (1e-3, "kg"), "t": (1e3, "kg"), "lb": (0.45359237, "kg"),
    "u": (1.66053906892e-27, "kg"), "min": (60, "s"), "h": (3600, "s"), "d": (86400, "s"),
    "week": (604800, "s"), "yr": (31557600, "s"), "au": (149597870700, "m"), "AU": (149597870700, "m"),
    "pc": (3.0856775814913673e16, "m"), "angstrom": (1e-10, "m"),
    "in": (0.0254, "m"), "ft": (0.3048, "m"), "mi": (1609.344, "m"), "L": (1e-3, "m^3"),
    "dyn": (1e-5, "N"), "kgf": (9.80665, "N"), "lbf": (4.4482216152605, "N"),
    "slug": (4.4482216152605 / 0.3048, "kg"), "erg": (1e-7, "J"), "eV": (1.602176634e-19, "J"),
    "bar": (1e5, "Pa"), "atm": (101325, "Pa"), "psi": (4.4482216152605 / 0.0254**2, "Pa"),
    "deg": (math.pi / 180, "1"), "arcmin": (math.pi / 10800, "1"), "arcsec": (math.pi / 648000, "1"),
    "rev": (2 * math.pi, "1"), "rpm": (math.pi / 30, "1/s"), "percent": (0.01, "1"),
}  # fmt: skip
"""Units with a factor."""

BASE = ("kg", "m", "s", "A", "K", "mol", "cd")
PREFIXES = {
    "da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12, "P": 15, "E": 18, "Z": 21, "Y": 24,
    "d": -1, "c": -2, "m": -3, "u": -6, "n": -9, "p": -12, "f": -15, "a": -18, "z": -21, "y": -24,
}  # fmt: skip
PREFIXED = frozenset((*BASE[1:], *COHERENT, "g", "eV", "bar", "L", "yr", "pc")) - {"rad", "sr"}
"""Units that may have a prefix."""
KNOWN = PREFIXED.union(BASE, COHERENT, OTHER)

ALIASES = {
    **dict.fromkeys(("metre", "meter"), "m"), **dict.fromkeys(("second", "sec"), "s"), "gram": "g",
    "kilogram": "kg", "ampere": "A", "kelvin": "K", "minute": "min", **dict.fromkeys(("hour", "hr"), "h"),
    "day": "d", "year": "yr", "radian": "rad", "steradian": "sr", "degree": "deg", "newton": "N",
    "joule": "J", "watt": "W", "pascal": "Pa", "hertz": "Hz", "coulomb": "C", "volt": "V", "farad": "F",
    "siemens": "S", "weber": "Wb", "tesla": "T", "henry": "H", "tonne": "t", "inch": "in", "foot": "ft",
    "feet": "ft", "mile": "mi", "pound": "lb", "litre": "L", "liter": "L", "turn": "rev",
    "revolution": "rev", "kilometre": "km", "kilometer": "km", "centimetre": "cm", "centimeter": "cm",
    "millimetre": "mm", "millimeter": "mm", "millisecond": "ms", "microsecond": "us", "nanosecond": "ns",
    "\N{DEGREE SIGN}": "deg", "\N{OHM SIGN}": "ohm", "\N{GREEK CAPITAL LETTER OMEGA}": "ohm", "%": "percent",
    "\N{LATIN CAPITAL LETTER A WITH RING ABOVE}": "angstrom",
}  # fmt: skip
JOINED = {
    "Nm": "N*m", "kNm": "kN*m", "Nms": "N*m*s", "Ws": "W*s", "Wh": "W*h", "kWh": "kW*h", "As": "A*s",
    "Ah": "A*h", "Vs": "V*s", "mph": "mi/h", "kph": "km/h", "kmh": "km/h",
}  # fmt: skip
"""Products that are often written as one word."""
UDUNITS = {"AU": "au", "deg": "degree", "rev": "turn"}
"""Symbols that UDUNITS spells otherwise; those that it does not know are in ``UNKNOWN_TO_UDUNITS``."""
UNKNOWN_TO_UDUNITS = frozenset({"dyn", "pc"})

WHOLE = 720
"""Exponents count in 720ths, so that roots of roots are whole numbers."""
HIGHEST = 99


@dataclass(frozen=True)
class Unit:
    """Symbols with their exponents, in 720ths and none of them 0, in the order in which they are written."""

    powers: tuple[tuple[str, int], ...] = ()

    def __mul__(self, other: Unit) -> Unit:
        return combined(self, other, 1)

    def __truediv__(self, other: Unit) -> Unit:
        return combined(self, other, -1)

    def power(self, exponent: float) -> Unit | None:
        """The unit to a power; None where the exponents are out of bounds, or no 720ths."""
        powers = [(symbol, power * exponent) for symbol, power in self.powers]
        if not all(fits(power) for _, power in powers):
            return None
        return Unit(tuple((symbol, round(power)) for symbol, power in powers if round(power)))

    @property
    def symbols(self) -> frozenset[str]:
        """The symbols it is made of."""
        return frozenset(symbol for symbol, _ in self.powers)

    def __str__(self) -> str:
        """The unit as it is written in system files: ``kg*m^2/s^2``."""
        above = [written(symbol, power) for symbol, power in self.powers if power > 0]
        below = [written(symbol, -power) for symbol, power in self.powers if power < 0]
        text = "*".join(above) or "1"
        if not below:
            return text
        return f"{text}/({'*'.join(below)})" if len(below) > 1 else f"{text}/{below[0]}"


ONE = Unit()
RADIAN = Unit((("rad", WHOLE),))


def combined(one: Unit, other: Unit, sign: int) -> Unit:
    """The product of ``one`` and ``other`` to the power of ``sign``."""
    powers = dict(one.powers)
    for symbol, power in other.powers:
        powers[symbol] = powers.get(symbol, 0) + sign * power
    return Unit(tuple((symbol, power) for symbol, power in powers.items() if power))


def fits(power: float) -> bool:
    """Whether a power, in 720ths, is a whole number of them and not too high."""
    return abs(power) <= HIGHEST * WHOLE and abs(power - round(power)) < 1e-6


def written(symbol: str, power: int) -> str:
    """A symbol with its exponent."""
    if power == WHOLE:
        return symbol
    divisor = math.gcd(power, WHOLE)
    above, below = power // divisor, WHOLE // divisor
    return f"{symbol}^{above}" if below == 1 else f"{symbol}^({above}/{below})"


def split(symbol: str) -> tuple[str, str]:
    """A symbol's prefix and the rest; no prefix where it is none, as in ``min``."""
    if symbol not in BASE and symbol not in COHERENT and symbol not in OTHER:
        for length in (1, 2):
            if symbol[:length] in PREFIXES and symbol[length:] in PREFIXED:
                return symbol[:length], symbol[length:]
    return "", symbol


def known(symbol: str) -> bool:
    """Whether a symbol is in the tables."""
    return split(symbol)[1] in KNOWN
