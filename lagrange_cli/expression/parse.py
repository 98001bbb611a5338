"""Text to ``Tree`` by precedence climbing; nothing is ever evaluated by Python.

The text is bounded (length, nesting, number of operators), so that no recursion goes deep. After a mistake
the parser goes on with what was probably meant (``2x`` as ``2*x``, ``^`` as ``**``), so that all mistakes of
an expression are found at once.
"""

from __future__ import annotations

from lagrange_cli.expression.confusions import DEGREES, RADIANS
from lagrange_cli.expression.cursor import PARTS_HINT, PRINTED, WRITTEN, Bounds, Hopeless
from lagrange_cli.expression.operators import Parser
from lagrange_cli.expression.quantities import quantity, with_comma
from lagrange_cli.expression.syntax import ExpressionError, Number, Span, Tree


def parse(text: str, offset: int = 0) -> Tree:
    """The tree of the expression ``text``; ``offset`` is added to every span.

    A top-level ``x, y`` is a vector with or without its parentheses. Numbers keep their text. Names are
    normalized as Python's are (NFKC).

    Raises:
        ExpressionError: where the text is not an expression of the language, or passes its bounds; its
            span includes ``offset``.
    """
    tree, errors = read(text, offset)
    if errors:
        amount = quantity(text)
        if amount and amount[1] not in DEGREES | RADIANS:
            number, unit = amount
            product = f", or {number}*{unit} for a product" if unit.isidentifier() else ""
            span = Span(offset, offset + len(text))
            raise ExpressionError(span, "number with a unit", f"write {number}{product}")
        raise min(errors, key=lambda error: error.span.start)
    return tree


def read_printed(text: str) -> Tree:
    """The tree of an expression that the program itself has printed, however long.

    Raises ``ExpressionError`` where it is nested too deep.
    """
    tree, errors = read(text, bounds=PRINTED)
    if errors:
        raise errors[0]
    return tree


def read(text: str, offset: int = 0, bounds: Bounds = WRITTEN) -> tuple[Tree, list[ExpressionError]]:
    """The tree that ``text`` was probably meant to be, and all that is wrong with it."""
    parser = Parser(text, offset, bounds)
    try:
        tree = _whole(parser)
    except Hopeless:
        tree = Number("1", Span(offset, offset + len(text)))
    except RecursionError:  # called from deep within something else
        whole = Span(offset, offset + len(text))
        return Number("1", whole), [ExpressionError(whole, "expression nested too deep", PARTS_HINT)]
    return tree, parser.errors


def _whole(parser: Parser) -> Tree:
    """All of the text as one expression."""
    most = parser.bounds.length
    if len(parser.text) > most:
        message = f"an expression of {len(parser.text)} characters is too long (limit {most})"
        parser.refuse(Span(parser.offset, parser.offset + 1), message, PARTS_HINT)
    whole = Span(parser.offset, parser.offset + len(parser.text))
    if parser.next.kind == "end":
        parser.refuse(
            Span(parser.offset, parser.offset + 1), "empty expression", "write a number or a formula"
        )
    mistake = with_comma(parser.text)
    if mistake:
        parser.refuse(whole, *mistake)
    items, vector = parser.items("")
    return parser.vector(items, whole) if vector else items[0]
