"""The tokens of one expression as they are taken one by one, its bounds, and the mistakes found in it."""

from __future__ import annotations

import unicodedata

from lagrange_cli.expression.confusions import DEGREES, QUOTES, STRANGERS
from lagrange_cli.expression.scan import Token, tokens
from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.records import dataclass

MAX_NESTING = 100
"""Parentheses, signs and powers inside one another."""
MAX_LOOPS = 8
"""Loops of sums inside one another."""


@dataclass(frozen=True)
class Bounds:
    """The largest numbers of characters and of operators of one expression."""

    length: int
    operators: int


WRITTEN = Bounds(10_000, 1_000)
"""Of what people write: longer text is a mistake."""
PRINTED = Bounds(10**9, 10**9)
"""Of our own text, whose length the limit ``printed`` bounds. Sums and products lean to the left and are read
by loops, so that only nesting takes stack."""

PARTS_HINT = "name parts of it under 'definitions'"
WHERE_EXAMPLE = "where(x > 0, x**2, 0)"
CONDITION_HINT = f"as in {WHERE_EXAMPLE}"
SUM_EXAMPLE = "sum(m[j]*x[j] for j in range(N) if j != i)"


class Hopeless(Exception):
    """The text cannot be read any further; its mistakes have been reported."""


class Cursor:
    """Tokens, the place of the next one, and the mistakes found so far."""

    def __init__(self, text: str, offset: int, bounds: Bounds = WRITTEN) -> None:
        self.text = text
        self.offset = offset
        self.bounds = bounds
        self.errors: list[ExpressionError] = []
        self.tokens = [*tokens(text[: bounds.length + 1], offset)]
        self.place = 0
        self.lost = False
        """Whether the structure is lost: more errors in it would follow from the first."""
        self.condition = False
        """Whether this is within the condition of a sum or of ``where``."""
        self.whole = False
        """Whether this is within an index, or within the range of one, which are whole numbers."""
        self.depth = self.operators = self.loops = 0

    @property
    def next(self) -> Token:
        return self.tokens[self.place]

    @property
    def last(self) -> Token | None:
        return self.tokens[self.place - 1] if self.place else None

    @property
    def stop(self) -> int:
        """Where the last token ends."""
        return self.last.span.stop if self.last else self.offset

    def advance(self) -> Token:
        """Take the next token, and report mistakes in its form."""
        token = self.next
        if token.complaint:
            if token.kind == "stranger":
                self.skip_strangers()
                return self.advance()
            self.error(token.span, *token.complaint)
        if token.kind != "end":
            self.place += 1
        return token

    def skip_strangers(self) -> None:
        """Report and skip characters that have no meaning."""
        while self.next.kind == "stranger":
            token = self.next
            if token.text in DEGREES and self.last is not None and self.last.kind == "number":
                return
            self.structural(token.span, *(token.complaint or ("", "")))
            if token.text not in STRANGERS or token.text in QUOTES:
                raise Hopeless  # what follows may be anything
            self.place += 1

    def sees(self, *texts: str) -> bool:
        """Whether the next token is one of these signs or words."""
        return self.next.text in texts and self.next.kind in ("sign", "word")

    def error(self, span: Span, message: str, hint: str) -> None:
        self.errors.append(ExpressionError(span, message, hint))

    def structural(self, span: Span, message: str, hint: str) -> None:
        """Report a mistake in the structure, if it is the first."""
        if not self.lost:
            self.error(span, message, hint)
        self.lost = True

    def refuse(self, span: Span, message: str, hint: str) -> None:
        """Report a mistake and give up."""
        self.error(span, message, hint)
        raise Hopeless

    def deeper(self, token: Token) -> None:
        self.depth += 1
        if self.depth > MAX_NESTING:
            self.refuse(token.span, f"expression nested more than {MAX_NESTING} deep", PARTS_HINT)

    def name_of(self, token: Token) -> str:
        return token.text if token.text.isascii() else unicodedata.normalize("NFKC", token.text)
