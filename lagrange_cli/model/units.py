"""What units mean: their factors and dimensions in the SI's base units, by which they are compared.

Two units are the same if they are equal in terms of the SI's base units, so that ``N/mm*mm^2`` is
``t*mm^2/s^2``. A symbol that is not in the tables, such as ``EUR``, is a base unit of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

from lagrange_cli.model.unit import (
    BASE,
    COHERENT,
    OTHER,
    PREFIXES,
    UDUNITS,
    UNKNOWN_TO_UDUNITS,
    WHOLE,
    Unit,
    known,
    split,
)
from lagrange_cli.model.unit_text import read_known, read_unit

CLOSE = 1e-9
"""The difference of the logarithms of two equal scales is smaller."""


def is_pure(unit: Unit) -> bool:
    """Whether a unit is that of a plain number, as ``rad`` is, and ``N*m/J``."""
    scale, dimensions = meaning(unit)
    return not dimensions and abs(scale) < CLOSE


def same(one: Unit, other: Unit) -> bool:
    """Whether both are the same in terms of base units."""
    return one.powers == other.powers or is_pure(one / other)


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


def times_within(unit: Unit) -> tuple[frozenset[str], bool]:
    """The units of time that a unit contains, ``s`` within N and J, and whether there are further ones with a
    factor, as in kHz, which say nothing of t."""
    found, unclear = set(), False
    for symbol in unit.symbols:
        scale, dimensions = meaning_of(symbol)
        if dimensions == {"s": WHOLE}:
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
