"""Units as texts, ``kg*m^2/s^2``: reading them."""

from __future__ import annotations

import math
import re
from functools import lru_cache

from lagrange_cli.model.unit import ALIASES, JOINED, KNOWN, ONE, WHOLE, Unit, fits, known

LONGEST = 100
"""Letters of a text that is read as a unit."""
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
