"""``Unit``: a product of powers of symbols, read from a text, combined, compared and written.

Two units are the same if they are equal in terms of the SI's base units, so that ``N/mm*mm^2`` is
``t*mm^2/s^2``. A symbol that is not in the tables, such as ``EUR``, is a base unit of its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import lru_cache

from lagrange_cli.model.unit_tables import (
    ALIASES,
    BASE,
    COHERENT,
    JOINED,
    KNOWN,
    OTHER,
    PREFIXED,
    PREFIXES,
    UDUNITS,
    UNKNOWN_TO_UDUNITS,
)
from lagrange_cli.records import dataclass

WHOLE = 720
"""Exponents count in 720ths, so that roots of roots are whole numbers."""
HIGHEST = 99
LONGEST = 100
"""Letters of a text that is read as a unit."""


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
    def pure(self) -> bool:
        """Whether it is that of a plain number, as ``rad`` is, and ``N*m/J``."""
        scale, dimensions = meaning(self)
        return not dimensions and abs(scale) < CLOSE

    def same(self, other: Unit) -> bool:
        """Whether both are the same in terms of base units."""
        return self.powers == other.powers or (self / other).pure

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
CLOSE = 1e-9
"""Of two scales' logarithms."""


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


# What symbols mean


@lru_cache(maxsize=1024)
def meaning(unit: Unit) -> tuple[float, Mapping[str, int]]:
    """The logarithm (to base 10) of the unit's factor, and the exponents of base units without zeros."""
    scale, dimensions = 0.0, dict[str, int]()
    for symbol, power in unit.powers:
        logarithm, powers = meaning_of(symbol)
        scale += logarithm * power / WHOLE
        for name, exponent in powers.items():
            dimensions[name] = dimensions.get(name, 0) + exponent * power // WHOLE
    return scale, {name: power for name, power in dimensions.items() if power}


@lru_cache(maxsize=1024)
def meaning_of(symbol: str) -> tuple[float, Mapping[str, int]]:
    """The same of a single symbol."""
    if symbol in BASE:
        return 0.0, {symbol: WHOLE}
    if symbol in COHERENT:
        return meaning(read_known(COHERENT[symbol]))
    if symbol in OTHER:
        factor, text = OTHER[symbol]
        scale, dimensions = meaning(read_known(text))
        return scale + math.log10(factor), dimensions
    prefix, rest = split(symbol)
    if prefix:
        scale, dimensions = meaning_of(rest)
        return scale + PREFIXES[prefix], dimensions
    return 0.0, {symbol: WHOLE}


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


def is_time(symbol: str) -> bool:
    """Whether a symbol is that of a unit of time."""
    return meaning_of(symbol)[1] == {"s": WHOLE}


def times_within(unit: Unit) -> tuple[frozenset[str], bool]:
    """The units of time that a unit contains, ``s`` within N and J, and whether there are further ones with a
    factor, as in kHz, which say nothing of t."""
    found, unclear = set(), False
    for symbol in unit.symbols:
        scale, dimensions = meaning_of(symbol)
        if is_time(symbol):
            found.add(symbol)
        elif "s" in dimensions and abs(scale) < CLOSE:
            found.add("s")
        elif "s" in dimensions:
            unclear = True
    return frozenset(found), unclear


def is_energy(unit: Unit) -> bool:
    """Whether a unit is known to be one of energy."""
    return meaning(unit)[1] == {"kg": WHOLE, "m": 2 * WHOLE, "s": -2 * WHOLE}


def simplified(unit: Unit) -> Unit:
    """The unit in base units where it is a product of units without a factor, such as ``N*m``."""
    if len(unit.powers) == 1 or not all(symbol in BASE or symbol in COHERENT for symbol in unit.symbols):
        return unit
    dimensions = meaning(unit)[1]
    return Unit(tuple((name, dimensions[name]) for name in BASE if name in dimensions))


def without_angle(unit: Unit) -> Unit:
    """The unit without radians, which are plain numbers."""
    if not unit.symbols & {"rad", "sr"}:
        return unit
    return Unit(tuple(one for one in unit.powers if one[0] not in ("rad", "sr")))


def udunits(text: str) -> str:
    """A unit as UDUNITS reads it, ``kg m2 s-2``; empty where it could not."""
    unit = read_unit(text)
    if unit is None or not all(spelled(symbol) and power % WHOLE == 0 for symbol, power in unit.powers):
        return ""
    parts = (f"{spelled(symbol)}{'' if power == WHOLE else power // WHOLE}" for symbol, power in unit.powers)
    return " ".join(parts) or "1"


def spelled(symbol: str) -> str:
    """A symbol as UDUNITS has it; empty where it has none."""
    if not known(symbol) or split(symbol)[1] in UNKNOWN_TO_UDUNITS:
        return ""
    return UDUNITS.get(symbol, symbol)


# Reading

EXPONENT = r"[+-]?\d+(?:\.\d+)?"
TOKEN = re.compile(
    r"(?P<symbol>([^\W\d]+|[\N{DEGREE SIGN}%])([+-]?\d+)?)|(?P<one>1(?![\d.]))"
    rf"|\s*(?P<power>(?:\^|\*\*)\s*({EXPONENT}|\(\s*{EXPONENT}\s*(?:/\s*\d+\s*)?\)))"
    r"|\s*(?P<times>[*\N{MIDDLE DOT}\N{DOT OPERATOR}\N{MULTIPLICATION SIGN}])\s*|(?P<dot>\.(?=[^\W\d]))"
    r"|\s*(?P<per>/)\s*|(?P<open>\(\s*)|\s*(?P<close>\))|(?P<space>\s+)"
)
END = ("end", "", "")
PLAIN = str.maketrans(
    "\N{SUPERSCRIPT ZERO}\N{SUPERSCRIPT ONE}\N{SUPERSCRIPT TWO}\N{SUPERSCRIPT THREE}\N{SUPERSCRIPT FOUR}"
    "\N{SUPERSCRIPT FIVE}\N{SUPERSCRIPT SIX}\N{SUPERSCRIPT SEVEN}\N{SUPERSCRIPT EIGHT}\N{SUPERSCRIPT NINE}"
    "\N{SUPERSCRIPT MINUS}\N{MINUS SIGN}\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}",
    "0123456789--uu",
)


def read_known(text: str) -> Unit:
    """A unit of the tables."""
    unit = read_unit(text)
    assert unit is not None
    return unit


@lru_cache(maxsize=1024)
def read_unit(text: str) -> Unit | None:
    """The unit that a text is, or None where it is no product of powers.

    ``kg*m^2/s^2``, ``kg m2 s-2``, ``N m`` and ``1/(m s)`` are understood. Words side by side are only if all
    of them are known units: ``solar masses`` is a text. So is ``J/kg K``, which may mean two things.
    """
    if len(text) > LONGEST:
        return None
    try:
        return Reading(text.translate(PLAIN).strip()).whole()
    except Unreadable:
        return None


class Unreadable(Exception):
    """Raised where a text is no unit."""


class Reading:
    """A text on the way to a unit: its tokens (kind, name, exponent), and which is next."""

    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, str, str]] = []
        at = 0
        while at < len(text):
            match = TOKEN.match(text, at)
            if match is None:
                raise Unreadable
            name, direct, power = match.group(2, 3, 6)
            self.tokens.append((str(match.lastgroup), name or "", direct or power or ""))
            at = match.end()
        self.tokens.append(END)
        self.next = 0

    def take(self, *kinds: str) -> bool:
        """Whether the next token is one of these kinds, and has been read."""
        found = self.tokens[self.next][0] in kinds
        self.next += found
        return found

    def whole(self) -> Unit:
        """The unit that all of the text is."""
        unit = self.product()
        if self.tokens[self.next] is not END:
            raise Unreadable
        if any(kind == "space" for kind, _, _ in self.tokens) and not all(map(known, unit.symbols)):
            raise Unreadable
        return unit

    def product(self) -> Unit:
        """Factors up to the end, or a closing parenthesis."""
        unit, divided = self.factor(), False
        while True:
            if self.take("times", "dot"):
                unit *= self.factor()
            elif self.take("per"):
                unit, divided = unit / self.factor(), True
            elif self.take("space"):
                if divided:
                    raise Unreadable
                unit *= self.factor()
            elif all(fits(power) for _, power in unit.powers):
                return unit
            else:
                raise Unreadable

    def factor(self) -> Unit:
        """A symbol or a parenthesis with its exponent, or 1."""
        _, name, exponent = self.tokens[self.next]
        if self.take("open"):
            unit = self.product()
            if not self.take("close"):
                raise Unreadable
        elif self.take("symbol"):
            if name in JOINED:
                if exponent or self.tokens[self.next][0] == "power":
                    raise Unreadable  # Nm^2 may mean two things
                return read_known(JOINED[name])
            unit = Unit(((resolved(name), WHOLE),))
            if exponent:
                return raised(unit, float(exponent))
        elif self.take("one"):
            return ONE
        else:
            raise Unreadable
        exponent = self.tokens[self.next][2]
        if not self.take("power"):
            return unit
        above, _, below = exponent.strip("() ").partition("/")
        return raised(unit, float(above) / (float(below or 1) or math.nan))


def raised(unit: Unit, exponent: float) -> Unit:
    """The unit to a power that is not 0."""
    power = unit.power(exponent) if math.isfinite(exponent) and exponent else None
    if power is None:
        raise Unreadable
    return power


def resolved(name: str) -> str:
    """The symbol of a unit, which may be given by its name."""
    singular = name.removesuffix("s") if len(name) > 3 else name
    if name in ALIASES or singular in ALIASES:
        return ALIASES.get(name, ALIASES.get(singular, name))
    return singular if singular in KNOWN and name not in KNOWN else name
