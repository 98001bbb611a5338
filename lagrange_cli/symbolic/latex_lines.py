"""Long LaTeX formulas over several lines: the width of a formula, and the places to break it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

from lagrange_cli.records import dataclass

WIDTH = 62.0
"""Width of a line of an article in letters (345 pt with 10 pt type)."""

SIGN, SPACE, SCRIPT = 2.2, 0.3, 0.7
"""Widths of a sign between two terms and of a thin space, in letters; the size of an index or exponent."""

_TOKEN = re.compile(
    r"\\(?:left|right|Bigl|Bigr)?[()]|\\begin\{\w+\}|\\end\{\w+\}|\\[a-zA-Z]+|\\.| [-+=] |[\s\S]"
)
_HEAVY = {r"\frac": 2, r"\sqrt": 1, r"\dot": 1, r"\ddot": 1, r"\mathrm": 1, r"\operatorname": 1, r"\text": 1}
"""Commands with arguments in braces, and how many each has."""


@dataclass(frozen=True)
class Break:
    """A place before a sign between two terms, within ``depth`` parentheses, of which ``scaled`` are those
    whose size LaTeX chooses."""

    index: int
    depth: int
    scaled: tuple[tuple[int, int], ...]


def width(formula: str) -> float:
    """The width of the formula in letters."""
    return _width(_TOKEN.findall(formula))


def _width(tokens: list[str]) -> float:
    total, place = 0.0, 0
    while place < len(tokens):
        token = tokens[place]
        place += 1
        if token in _HEAVY:
            parts = []
            for _ in range(_HEAVY[token]):
                inner, place = _group(tokens, place)
                parts.append(_width(inner))
            total += max(parts) + (1.0 if token == r"\sqrt" else SPACE)
        elif token in "^_":
            inner, place = _group(tokens, place)
            total += SCRIPT * _width(inner)
        elif token in (" + ", " - ", " = ", r"\cdot"):
            total += SIGN
        elif token.startswith((r"\begin", r"\end")) or token in " {}":
            total += 0.0
        elif token.startswith("\\") and token[1:].isalpha() and len(token) > 1:
            total += _command_width(token[1:])
        else:
            total += SPACE if token in (r"\,", r"\ ") else 1.0
    return total


def _command_width(name: str) -> float:
    """The width of a command: that of a function's name, or else one letter."""
    return SCRIPT * len(name) + SPACE if name in _FUNCTIONS else 1.0


_FUNCTIONS = frozenset({"sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "ln"})


def _group(tokens: list[str], place: int) -> tuple[list[str], int]:
    """The tokens of the argument that begins there, and its end."""
    if place >= len(tokens) or tokens[place] != "{":
        return tokens[place : place + 1], place + 1
    depth, stop = 0, place
    while stop < len(tokens):
        depth += {"{": 1, "}": -1}.get(tokens[stop], 0)
        stop += 1
        if depth == 0:
            break
    return tokens[place + 1 : stop - 1], stop


def breaks(formula: str) -> Iterator[Break]:
    """Every place before a sign between two terms, except in fractions, roots, indices and matrices."""
    opened: list[int] = []
    partners = {}
    found: list[tuple[int, tuple[int, ...]]] = []
    braces = 0
    for match in _TOKEN.finditer(formula):
        token, index = match[0], match.start()
        if token == "{" or token.startswith(r"\begin"):
            braces += 1
        elif token == "}" or token.startswith(r"\end"):
            braces -= 1
        elif token in ("(", r"\left("):
            opened.append(index)
        elif token in (")", r"\right)"):
            partners[opened.pop()] = index
        elif token in (" + ", " - ") and braces == 0:
            found.append((index, tuple(opened)))
    for index, around in found:
        scaled = tuple((one, partners[one]) for one in around if formula[one] == "\\")
        yield Break(index, len(around), scaled)


def is_sum(formula: str) -> bool:
    """Whether it is a sum of several terms."""
    return any(place.depth == 0 for place in breaks(formula))


def broken(formula: str, most: float) -> list[str]:
    """The formula in lines of width ``most`` where there are places to break it: before signs between terms,
    in as few parentheses as possible.

    Parentheses that are broken into get a fixed size, as LaTeX wants it.
    """
    places = list(breaks(formula))
    chosen: list[Break] = []
    start = 0
    while width(formula[start:]) > most:
        left = [place for place in places if place.index > start]
        fitting = [place for place in left if width(formula[start : place.index]) <= most]
        options = fitting or left[:1]
        if not options:
            break
        best = max(options, key=lambda place: (-place.depth, place.index))
        chosen.append(best)
        start = best.index
    cut = {index for place in chosen for pair in place.scaled for index in pair}
    edges = [0, *(place.index for place in chosen), len(formula)]
    return ["".join(sized(formula, a, b, cut)).strip() for a, b in pairwise(edges)]


def sized(formula: str, start: int, stop: int, cut: set[int]) -> Iterator[str]:
    """A piece of the formula, with the parentheses at the places ``cut`` of a fixed size."""
    for index in sorted(index for index in cut if start <= index < stop):
        yield formula[start:index]
        opening = formula.startswith(r"\left(", index)
        yield r"\Bigl(" if opening else r"\Bigr)"
        start = index + len(r"\left(" if opening else r"\right)")
    yield formula[start:stop]
