"""The keys of a section's entries: names, and families with their indices."""

from __future__ import annotations

import re

from lagrange_cli.expression.cursor import WRITTEN, Hopeless
from lagrange_cli.expression.operators import Parser
from lagrange_cli.expression.syntax import Axis, Key, Span
from lagrange_cli.expression.vocabulary import OR

_KEY = "write a name, or a family as theta[i in range(N)]"


def parse_key(text: str) -> Key:
    """What a section declares: a name, ``theta[i in range(N)]`` for members of a family, or ``u[0, N - 1]``.

    Raises:
        ExpressionError: where the text is neither.
    """
    parser = Parser(text, 0)
    try:
        key = _key(parser)
    except Hopeless:
        key = Key(text, text)
    if parser.errors:
        raise min(parser.errors, key=lambda error: error.span.start)
    return key


def _key(parser: Parser) -> Key:
    """All of the text as the key of a section."""
    token = parser.next
    if token.kind == "end":
        parser.refuse(Span(0, 1), "missing name", _KEY)
    if token.kind != "name" or len(parser.text) > WRITTEN.length:
        parser.refuse(Span(0, max(1, len(parser.text))), "neither a name nor a family", _KEY)
    parser.advance()
    if parser.next.kind == "end":
        return Key(parser.name_of(token), parser.text)
    if not parser.sees("["):
        parser.refuse(Span(0, max(1, len(parser.text))), "neither a name nor a family", _KEY)
    opening = parser.advance()
    if re.search(r"\.\.|:", parser.text):
        span = Span(opening.span.stop, len(parser.text.rstrip("] ")))
        parser.refuse(span, "these are not indices", f"write {parser.name_of(token)}[i in range(N)]")
    axes = [_axis(parser)]
    while parser.sees(","):
        parser.advance()
        axes.append(_axis(parser))
    if parser.next.kind != "end" and not parser.sees("]"):
        parser.unexpected([])
    parser.close(opening)
    if parser.next.kind != "end":
        parser.refuse(Span(0, len(parser.text)), "neither a name nor a family", _KEY)
    for i, axis in enumerate(axes):
        if axis.index and axis.index in [one.index for one in axes[:i]]:
            parser.error(axis.span, f"the index '{axis.index}' is used twice", "give it another name")
    return Key(parser.name_of(token), parser.text, tuple(axes))


def _axis(parser: Parser) -> Axis:
    """One index of a key."""
    start = parser.next.span.start
    if parser.sees("]", ","):
        parser.refuse(parser.next.span, "missing index", "as in theta[0] or theta[i in range(N)]")
    ahead = parser.tokens[parser.place + 1] if parser.place + 1 < len(parser.tokens) else parser.next
    if parser.next.kind in ("name", "number") and ahead.kind == "word" and ahead.text == "in":
        index, _ = parser.index()
        parser.advance()
        bounds, conditions = parser.range(), parser.conditions()
        return Axis(index, bounds, Span(start, parser.stop), conditions)
    tree = parser.expression(OR)
    return Axis("", (tree,), Span(start, parser.stop))
