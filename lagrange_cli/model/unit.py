"""``Unit``: a product of powers of symbols, combined and written; symbols and their prefixes."""

from __future__ import annotations

import math

from lagrange_cli.model.unit_tables import BASE, COHERENT, KNOWN, OTHER, PREFIXED, PREFIXES
from lagrange_cli.records import dataclass

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
