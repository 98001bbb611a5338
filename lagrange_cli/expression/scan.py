"""Text to tokens; what people type by habit (``^``, ``×``, ``x²``) becomes the token that is meant."""

from __future__ import annotations

import re
from collections.abc import Iterator
from unicodedata import category

from lagrange_cli.expression.confusions import CHARACTERS, STRANGERS, SUBSCRIPTS
from lagrange_cli.expression.near import shown
from lagrange_cli.expression.quantities import RAISED, TEN, lowered
from lagrange_cli.expression.syntax import Span
from lagrange_cli.records import dataclass

_TOKEN = re.compile(
    r"(?P<literal>0[xob][0-9a-fA-F][0-9a-fA-F_]*|[0-9]+(?:_[0-9]+)+(?:\.[0-9_]*)?(?:e[+-]?[0-9]+)?)(?!\w)"
    r"|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    rf"|(?P<raised>[⁺⁻]?[{RAISED}]+)"
    rf"|(?P<name>[^\W\d][^\W{RAISED}]*)"
    r"|(?P<sign>\*\*|//|[=!<>]=|[-+*/%<>,.()\[\]=])"
    r"|(?P<space>\s+)"
    r"|(?P<other>.)",
    re.DOTALL,
)
_POWER_OF_TEN = re.compile(rf"(?:\s*[×·⋅∙xX]\s*{TEN}|(?P<apart>\s*[eE]\s?(?P<sign>[-+−–][0-9]+)))(?![\w.])")
"""What follows the 1.602 of ``1.602×10^-19`` and ``1.602 e-19``."""
_SHOWN_DIGITS = 60
WORDS = frozenset({"for", "in", "if", "and", "or", "not", "else"})
"""Words of sums and their conditions: no names."""


@dataclass(frozen=True)
class Token:
    """One token with its place: ``kind`` is ``number``, ``name``, ``word``, ``sign``, ``stranger``, ``end``.

    ``complaint`` is what is wrong with the way in which it is written, and how to write it.
    """

    kind: str
    text: str
    span: Span
    complaint: tuple[str, str] | None = None


def tokens(text: str, offset: int = 0) -> Iterator[Token]:
    """The tokens of ``text``, the last one its end; ``offset`` is added to every place."""
    end = 0
    for match in _TOKEN.finditer(text):
        kind, start = match.lastgroup or "other", match.start() + offset
        if match.start() < end:
            continue  # within a power of ten that has been read
        power = _POWER_OF_TEN.match(text, match.end()) if kind == "number" else None
        if power and match.group().strip("0123456789.") == "":
            end = power.end()
            number = f"{match.group()}e{lowered(power['exponent'] or power['raised'] or power['sign'])}"
            message = (
                "unknown notation of a number" if power["apart"] else "power of ten written as a product"
            )
            yield Token(kind, number, Span(start, end + offset), (message, f"write {number}"))
        elif kind == "raised":
            yield from _raised(match.group(), start)
        elif kind == "literal":
            yield _literal(match.group(), start)
        elif kind == "name" and not match.group().isidentifier():
            yield from _pieces(match.group(), start)
        elif kind == "name":
            yield Token(
                "word" if match.group() in WORDS else kind,
                match.group(),
                Span(start, start + len(match.group())),
            )
        elif kind == "other":
            yield from _other(match.group(), start)
        elif kind != "space":
            yield Token(kind, match.group(), Span(start, start + len(match.group())))
    yield Token("end", "", Span(len(text) + offset, len(text) + offset))


def _literal(text: str, start: int) -> Token:
    """A number in the notation of a programming language: ``0x10``, ``1_000``."""
    number = text.replace("_", "")
    if text[1:2] in ("x", "o", "b"):
        try:
            number = str(int(number, 0))
        except ValueError:  # no such digit, as in 0b12
            number = "0"
    complaint = f"unknown notation of a number: {shown(text)}", f"write {number[:_SHOWN_DIGITS]}"
    return Token("number", number, Span(start, start + len(text)), complaint)


def _raised(text: str, start: int) -> Iterator[Token]:
    """The power that superscripts mean, as in ``x⁻²``."""
    power, span = lowered(text), Span(start, start + len(text))
    yield Token("sign", "**", span, (f"unknown operator '{text}'", f"write **{power}"))
    if not power.isdecimal():
        yield Token("sign", power[0], span)
    yield Token("number", power.lstrip("+-"), span)


def _pieces(text: str, start: int) -> Iterator[Token]:
    """A name with characters in it that no name has: ``x₁``."""
    first = 0
    for i, character in enumerate(text):
        if not ("a" + character).isidentifier():
            yield from _piece(text[first:i], start + first)
            yield from _other(character, start + i)
            first = i + 1
    yield from _piece(text[first:], start + first)


def _piece(text: str, start: int) -> Iterator[Token]:
    """A name, or a number as in ``x₁3``, after what may stand within a name but not begin one."""
    while text and not (text.isidentifier() or (text.isdecimal() and text.isascii())):
        yield from _other(text[0], start)
        text, start = text[1:], start + 1
    if text:
        kind = "name" if text.isidentifier() else "number"
        yield Token(kind, text, Span(start, start + len(text)))


def _other(character: str, start: int) -> Iterator[Token]:
    span = Span(start, start + 1)
    if character in CHARACTERS:
        meant, message, hint = CHARACTERS[character]
        yield Token("name" if meant.isidentifier() else "sign", meant, span, (message, hint))
    elif character in SUBSCRIPTS:
        digit = SUBSCRIPTS.index(character)
        complaint = f"the character {character!r} is not allowed", f"write {digit}, or _{digit}"
        yield Token("stranger", character, span, complaint)
    elif character == "#":
        yield Token(
            "stranger", character, span, ("misplaced '#'", "a comment begins with a space before the #")
        )
    elif category(character) == "Cf":  # which shows nothing
        yield Token("stranger", character, span, (f"invisible character U+{ord(character):04X}", "delete it"))
    else:
        unknown = f"the character {character!r} is not allowed", "use names, numbers, + - * / ** and ( )"
        yield Token("stranger", character, span, STRANGERS.get(character, unknown))
