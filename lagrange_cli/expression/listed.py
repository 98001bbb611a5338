"""Lists of expressions that a loop may repeat: ``(bead[i], bead[i + 1]) for i in range(N - 1)``."""

from __future__ import annotations

from lagrange_cli.expression.cursor import PARTS_HINT, WRITTEN, Hopeless
from lagrange_cli.expression.operators import Parser
from lagrange_cli.expression.syntax import ExpressionError, Loop, Number, Span, Tree
from lagrange_cli.expression.vocabulary import OR
from lagrange_cli.records import dataclass

EXAMPLE = "(bead[i], bead[i + 1]) for i in range(N - 1)"


@dataclass(frozen=True)
class Listed:
    """The expressions, and the loops that repeat them, the first one outermost."""

    items: tuple[Tree, ...]
    loops: tuple[Loop, ...]


def read_listed(text: str, *, several: bool) -> tuple[Listed, list[ExpressionError]]:
    """What ``text`` lists, and all that is wrong with it.

    Where there may be ``several``, they have commas between them, and parentheses or brackets around all of
    them or none. Else there is one expression, and commas make it a vector.
    """
    parser = Parser(text, 0)
    whole = Span(0, len(text))
    try:
        if len(text) > WRITTEN.length:
            message = f"an expression of {len(text)} characters is too long (limit {WRITTEN.length})"
            parser.refuse(Span(0, 1), message, PARTS_HINT)
        if several and parser.next.text in ("(", "[") and _encloses(parser):
            items, comma = parser.enclosed(parser.advance())
        else:
            items, comma = _items(parser)
        loops = parser.several_loops(EXAMPLE)
        while parser.next.kind != "end":
            parser.unexpected(items)
        if comma and not several:
            items = [parser.vector(items, whole)]
        found = Listed(tuple(items) or (Number("0", whole),), tuple(loops))  # what '=' follows is dropped
    except Hopeless:
        found = Listed((Number("0", whole),), ())
    except RecursionError:  # called from deep within something else
        return Listed((Number("0", whole),), ()), [ExpressionError(whole, "nested too deep", PARTS_HINT)]
    return found, parser.errors


def _items(parser: Parser) -> tuple[list[Tree], bool]:
    """Expressions up to a loop or the end, and whether there is a comma."""
    if parser.next.kind == "end":
        return [parser.missing()], False
    items = [parser.expression(OR)]
    while parser.sees(","):
        parser.advance()
        items.append(parser.expression(OR))
    return items, len(items) > 1


def _encloses(parser: Parser) -> bool:
    """Whether what the first bracket opens ends before a loop, or with the text."""
    depth = 0
    for k, token in enumerate(parser.tokens):
        if token.kind == "sign":
            depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
        if depth == 0:
            after = parser.tokens[k + 1]
            return after.kind == "end" or after.text == "for"
    return True
