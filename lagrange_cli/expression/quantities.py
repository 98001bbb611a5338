"""Numbers as people write them: with superscripts, with units, and with commas."""

from __future__ import annotations

import re

RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹"
"""Superscripts, read as powers."""
_LOWERED = str.maketrans(f"{RAISED}⁻⁺−–", "0123456789-+--")
TEN = (
    r"10\s*(?:(?:\^|\*\*)\s*[({]?\s*(?P<exponent>[-+−–]?[0-9]+)\s*[)}]?"
    rf"|(?P<raised>[⁺⁻]?[{RAISED}]+))"
)
"""A power of ten, as a regular expression."""


def lowered(text: str) -> str:
    """A number with superscripts, or with other characters for its sign, as one of the keyboard."""
    return text.translate(_LOWERED)


_UNITS = """
    kg g mg t lb u m cm mm km nm um pm ft in au AU pc ly s ms us ns min h hr d yr N kN mN J kJ mJ eV keV
    MeV W kW Pa kPa bar C A V T K Hz kHz MHz rad deg sr L l mol F H Ohm Wb Gauss dyn erg kilogram
    kilograms gram grams meter meters metre metres second seconds sec minute minutes hour hours day days
    year years newton newtons joule joules volt volts tesla hertz
"""
_PREFIXED = "(?:[fpnuµmckMGT](?:m|g|s|A|K|N|J|W|Pa|V|T|C|F|H|Hz|Wb|Ohm|Ω|eV|bar|pc|l|L|mol))"
_UNIT = (
    "(?:" + "|".join([*sorted(_UNITS.split(), key=len, reverse=True), _PREFIXED]) + rf")(?![^\W\d_{RAISED}])"
)
_FACTOR = rf"{_UNIT}(?:(?:\^|\*\*)?\(?[-−]?[0-9]+\)?|⁻?[{RAISED}]+)?"
_BETWEEN = r"(?:\s*[*/·⋅∙.]\s*|\s+)"
_QUANTITY = (
    r"\s*(?P<number>[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
    rf"(?:\s*[*xX×·⋅∙]\s*{TEN})?\s*"
    rf"(?P<unit>{_FACTOR}(?:{_BETWEEN}{_FACTOR})*"
    rf"(?:\s*/\s*\({_FACTOR}(?:{_BETWEEN}{_FACTOR})*\))?)\s*"
)
"""Compiled for the first text that may be one: that takes 10 ms."""
_DIGITS, _TIMES = "0123456789.", "*xX×·⋅∙"
_LONGEST = 100
"""Characters of a number with a unit."""


def quantity(text: str) -> tuple[str, str] | None:
    """The number and the unit of ``9.81 m/s^2``, or None where a text is no number with a unit."""
    match = re.fullmatch(_QUANTITY, text) if len(text) <= _LONGEST and _may_have_unit(text) else None
    if match is None:
        return None
    power = match["exponent"] or match["raised"]
    return match["number"] + (f"e{lowered(power)}" if power else ""), match["unit"]


def _may_have_unit(text: str) -> bool:
    """Whether it begins with a number, and a letter or a power of ten follows."""
    beginning = text.lstrip().lstrip("+-")
    rest = beginning.lstrip(_DIGITS)
    following = rest.lstrip()
    power = following[:1] in _TIMES and following[1:].lstrip().startswith("10")
    return rest != beginning and bool(following) and (following[0].isalpha() or power)


def is_unit(text: str) -> bool:
    """Whether it is the name of a unit."""
    return quantity(f"1 {text}") is not None


_DECIMAL_COMMA = re.compile(r"\s*[-+]?[0-9]+,[0-9]+\s*")
_COMMA_INSIDE = re.compile(r"(?<![\w.,])[0-9]+,[0-9]+(?![\w.,])")
_THOUSANDS = re.compile(r"\s*[-+]?[1-9][0-9]{0,2}(?:,[0-9]{3})+(?P<decimals>\.[0-9]*)?\s*")


def decimal_comma(text: str) -> str:
    """``1.5`` for ``1,5``, or nothing for other texts."""
    return text.strip().replace(",", ".") if _DECIMAL_COMMA.fullmatch(text) else ""


def comma_inside(text: str) -> str:
    """The way out where a number within a text is written with a decimal comma, as ``0,5*x``; nothing for
    other texts, such as vectors in parentheses."""
    found = None if text.lstrip().startswith("(") else _COMMA_INSIDE.search(text)
    return f"write {found[0].replace(',', '.')} for {found[0]}, with a decimal point" if found else ""


def with_comma(text: str) -> tuple[str, str] | None:
    """What is wrong with a number that is written with commas, ``1,5`` or ``1,000.0``, and the way out; None
    for other texts. A comma before three digits may have either meaning."""
    number = text.strip().replace(",", "")
    grouped = _THOUSANDS.fullmatch(text)
    if grouped and (grouped["decimals"] or text.count(",") > 1):
        return ("comma between thousands", f"write {number}") if ",0" in text else None
    point = decimal_comma(text)
    if point and grouped:
        return "comma in a number", f"write {number} or {point}"
    return ("decimal comma", f"write {point}") if point else None
