"""Long LaTeX formulas over several lines: the width of a formula, and the places to break it.

A formula is read once, however long it is: its places carry the width of what stands before them.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator
from itertools import accumulate, pairwise
from typing import TypeAlias

from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.work import charge

WIDTH = 62.0
"""Width of a line of an article in letters (345 pt with 10 pt type)."""

SIGN, SPACE, SCRIPT = 2.2, 0.3, 0.7
"""Widths of a sign between two terms and of a thin space, in letters; the size of an index or exponent."""
ROUNDING = 1e-6
"""What a line may be wider for the rounding of sums."""

_TOKEN = re.compile(
    r"\\(?:left|right|Bigl|Bigr)?[()]|\\begin\{\w+\}|\\end\{\w+\}|\\[a-zA-Z]+|\\.| [-+=] |[\s\S]"
)
_HEAVY = {r"\frac": 2, r"\sqrt": 1, r"\dot": 1, r"\ddot": 1, r"\mathrm": 1, r"\operatorname": 1, r"\text": 1}
"""Commands with arguments in braces, and how many each has."""


Opened: TypeAlias = "tuple[int, Opened] | None"
"""The indices of the parentheses around a place, the innermost first."""


@dataclass(frozen=True)
class Break:
    """A place before a sign between two terms, within ``depth`` parentheses; ``before`` is the width of the
    formula up to there."""

    index: int
    depth: int
    before: float
    around: Opened


def width(formula: str) -> float:
    """The width of the formula in letters."""
    return _width(_tokens(formula))[0]


def _tokens(formula: str) -> list[str]:
    """The tokens, which are the formula when they are put together again."""
    tokens = _TOKEN.findall(formula)
    charge(len(tokens))
    return tokens


def _width(
    tokens: list[str], place: int = 0, *, inside: bool = False, signs: dict[int, float] | None = None
) -> tuple[float, int]:
    """The width of the tokens from ``place`` on, and where they end: ``inside`` an argument, after its brace.

    ``signs`` gets the width before each sign between two terms, by its place.
    """
    total, depth = 0.0, 0
    while place < len(tokens):
        token = tokens[place]
        if signs is not None and token in (" + ", " - "):
            signs[place] = total
        place += 1
        if token == "{":
            depth += 1
        elif token == "}":
            if inside and depth == 0:
                break
            depth -= 1
        elif token in _HEAVY:
            widest = 0.0
            for _ in range(_HEAVY[token]):
                inner, place = _argument(tokens, place)
                widest = max(widest, inner)
            total += widest + (1.0 if token == r"\sqrt" else SPACE)
        elif token in "^_":
            inner, place = _argument(tokens, place)
            total += SCRIPT * inner
        elif token in (" + ", " - ", " = ", r"\cdot"):
            total += SIGN
        elif token.startswith((r"\begin", r"\end")) or token == " ":
            total += 0.0
        elif token.startswith("\\") and token[1:].isalpha() and len(token) > 1:
            total += SCRIPT * len(token[1:]) + SPACE if token[1:] in _FUNCTIONS else 1.0
        else:
            total += SPACE if token in (r"\,", r"\ ") else 1.0
    return total, place


_FUNCTIONS = frozenset({"sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "ln"})


def _argument(tokens: list[str], place: int) -> tuple[float, int]:
    """The width of the argument that begins there, in braces or a single token, and its end."""
    if place < len(tokens) and tokens[place] == "{":
        return _width(tokens, place + 1, inside=True)
    return _width(tokens[place : place + 1])[0], place + 1


def breaks(formula: str) -> list[Break]:
    """Every place before a sign between two terms, except in fractions, roots, indices and matrices."""
    return _places(formula)[0]


def _places(formula: str) -> tuple[list[Break], dict[int, int], float]:
    """The places to break, where each parenthesis is closed that is open there, and the formula's width."""
    tokens = _tokens(formula)
    signs: dict[int, float] = {}
    total, _ = _width(tokens, signs=signs)
    found: list[Break] = []
    closed: dict[int, int] = {}
    opened: Opened = None
    depth = braces = 0
    for place, (token, end) in enumerate(zip(tokens, accumulate(map(len, tokens)), strict=True)):
        index = end - len(token)
        if token == "{" or token.startswith(r"\begin"):
            braces += 1
        elif token == "}" or token.startswith(r"\end"):
            braces -= 1
        elif token in ("(", r"\left("):
            opened, depth = (index, opened), depth + 1
        elif token in (")", r"\right)") and opened is not None:
            closed[opened[0]] = index
            opened, depth = opened[1], depth - 1
        elif braces == 0 and place in signs and token in (" + ", " - "):
            found.append(Break(index, depth, signs[place], opened))
    return found, closed, total


def is_sum(formula: str) -> bool:
    """Whether it is a sum of several terms."""
    return any(place.depth == 0 for place in breaks(formula))


def broken(formula: str, most: float) -> list[str]:
    """The formula in lines of width ``most`` where there are places to break it: before signs between terms,
    in as few parentheses as possible.

    Parentheses that are broken into get a fixed size, as LaTeX wants it.
    """
    places, closed, total = _places(formula)
    chosen: list[int] = []
    cut: set[int] = set()
    before, after = 0.0, 0  # the width of the lines so far, the first place behind their end
    while total - before > most + ROUNDING and after < len(places):
        best = after  # where nothing fits
        for number in range(after, len(places)):
            if places[number].before - before > most + ROUNDING:
                break
            if places[number].depth <= places[best].depth:
                best = number
        chosen.append(places[best].index)
        cut.update(_scaled(formula, places[best].around, closed, cut))
        before, after = places[best].before, best + 1
    edges = [0, *chosen, len(formula)]
    cuts = sorted(cut)
    return ["".join(sized(formula, a, b, cuts)).strip() for a, b in pairwise(edges)]


def _scaled(formula: str, around: Opened, closed: dict[int, int], cut: set[int]) -> Iterator[int]:
    """Where the parentheses around a place are whose size LaTeX chooses, without those in ``cut`` already."""
    while around is not None and around[0] not in cut:
        if formula[around[0]] == "\\":
            yield from (around[0], closed[around[0]])
        around = around[1]


def sized(formula: str, start: int, stop: int, cuts: list[int]) -> Iterator[str]:
    """A piece of the formula, with the parentheses at the places ``cuts`` of a fixed size."""
    for index in cuts[bisect_left(cuts, start) : bisect_left(cuts, stop)]:
        yield formula[start:index]
        opening = formula.startswith(r"\left(", index)
        yield r"\Bigl(" if opening else r"\Bigr)"
        start = index + len(r"\left(" if opening else r"\right)")
    yield formula[start:stop]
