"""Reads an expression token by token before Python's parser sees it.

Two things happen here and nowhere else: the text is bounded (length, nesting, number of operators), so that
nothing deep or long ever reaches a recursive parser, and what people type by habit (``2x``, ``sin x``,
``theta'``, ``x^2``) is answered in the terms of this language instead of those of Python's grammar.
"""

from __future__ import annotations

import keyword
import re

from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.expression.vocabulary import CALLABLE
from lagrange_cli.records import dataclass

MAX_LENGTH = 10_000
"""Characters of one expression."""
MAX_NESTING = 100
"""Parentheses, signs and powers inside one another."""
MAX_OPERATORS = 1_000
"""Operators of one expression; Python's own parser gives up at about 3000."""

_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*)"
    r"|(?P<sign>\*\*|[-+*/,.()\[\]])"
    r"|(?P<space>\s+)"
    r"|(?P<other>.)",
    re.DOTALL,
)
_CLOSES = {")": "(", "]": "["}

_STRANGERS: dict[str, tuple[str, str]] = {
    "^": ("'^' is not an operator", "write ** for powers"),
    "=": ("an expression has no '='", "give only the expression itself"),
    "<": ("comparisons are not supported yet", "only smooth expressions are accepted for now"),
    ">": ("comparisons are not supported yet", "only smooth expressions are accepted for now"),
    "!": ("'!' is not an operator", "only + - * / ** are"),
    "%": ("'%' is not an operator", "only + - * / ** are"),
    "'": ("text in quotes has no meaning in an expression", "leave the quotes out"),
    '"': ("text in quotes has no meaning in an expression", "leave the quotes out"),
    "′": ("a prime is not an operator", "write NAME_dot for a velocity"),
    "{": ("'{' has no meaning in an expression", "use parentheses"),
    "}": ("'}' has no meaning in an expression", "use parentheses"),
    ":": ("':' has no meaning in an expression", "give only the expression itself"),
    ";": ("';' has no meaning in an expression", "separate with commas"),
    "−": ("'−' is not the minus sign of a keyboard", "write -"),
    "–": ("'–' is not the minus sign of a keyboard", "write -"),
    "×": ("'×' is not an operator", "write *"),
    "·": ("'·' is not an operator", "write *"),
    "⋅": ("'⋅' is not an operator", "write *"),
    "÷": ("'÷' is not an operator", "write /"),
    "√": ("'√' is not a function", "write sqrt(...)"),
    "²": ("'²' is not an operator", "write **2"),
    "³": ("'³' is not an operator", "write **3"),
    "°": ("'°' is not a unit here", "angles are in radians: write *pi/180"),
}
_FAMILY_WORDS = frozenset({"for", "in", "if", "else"})


@dataclass(frozen=True)
class Token:
    """One token with its place: ``kind`` is ``number``, ``name`` or ``sign``."""

    kind: str
    text: str
    span: Span


def scan(text: str) -> None:
    """Pass ``text`` if it is within bounds and each token stands where one of its kind may stand.

    Raises:
        ExpressionError: at the first token that does not.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            Span(0, 1),
            f"an expression of {len(text)} characters is too long (limit {MAX_LENGTH})",
            "give parts of it a name under 'definitions'",
        )
    state = _State()
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or "other"
        if kind != "space":
            state.take(Token(kind, match.group(), Span(*match.span())))
    state.finish()


class _State:
    """What has been read so far: the last token, whether a value just ended, and what is still open."""

    def __init__(self) -> None:
        self.last: Token | None = None
        self.after_value = False
        self.open: list[Token] = []
        self.waiting = [0]  # signs and powers that wait for their operand, at each open level
        self.depth = 0  # how deep a parser would be now: open levels and all that waits
        self.operators = 0

    def take(self, token: Token) -> None:
        if self.last is not None and self.last.text == "." and token.kind != "name":
            raise ExpressionError(
                self.last.span, "the name of a component is missing after '.'", "as in bead.x"
            )
        if token.kind == "number":
            self._number(token)
        elif token.kind == "name":
            self._name(token)
        elif token.kind == "other":
            self._stranger(token)
        elif token.text in "([":
            self._opening(token)
        elif token.text in ")]":
            self._closing(token)
        elif token.text == ",":
            self._need_value(token)
            self._settle()
            self.after_value = False
        elif token.text == ".":
            self._dot(token)
        else:
            self._operator(token)
        self.last = token

    def finish(self) -> None:
        if self.last is None:
            raise ExpressionError(Span(0, 1), "the expression is empty", "write a number or a formula")
        if self.open:
            token = self.open[-1]
            closing = ")" if token.text == "(" else "]"
            raise ExpressionError(token.span, f"this '{token.text}' is never closed", f"add a '{closing}'")
        if not self.after_value and self.last.text != ",":
            raise ExpressionError(
                self.last.span, f"a value is missing after '{self.last.text}'", "complete it or leave it out"
            )

    def _number(self, token: Token) -> None:
        self._juxtaposed(token)
        if re.fullmatch("0+[1-9][0-9]*", token.text):
            raise ExpressionError(
                token.span, f"the number {token.text} begins with a zero", f"write {token.text.lstrip('0')}"
            )
        if float(token.text) == float("inf"):
            raise ExpressionError(token.span, "this number is too large", "the largest is about 1.8e308")
        self.after_value = True

    def _name(self, token: Token) -> None:
        if token.text in _FAMILY_WORDS:
            raise ExpressionError(
                token.span,
                f"'{token.text}': indexed families and conditions are not supported yet",
                "write the terms out one by one",
            )
        if keyword.iskeyword(token.text):
            raise ExpressionError(
                token.span, f"'{token.text}' cannot be a name", f"call it '{token.text}_' or another name"
            )
        for offset, character in enumerate(token.text):
            if not ("a" + character).isidentifier():
                start = token.span.start + offset
                self._stranger(Token("other", character, Span(start, start + 1)))
        self._juxtaposed(token)
        self.after_value = True

    def _juxtaposed(self, token: Token) -> None:
        last = self.last
        if not self.after_value or last is None:
            return
        span = Span(last.span.start, token.span.stop)
        if last.kind == "name" and last.text in CALLABLE:
            raise ExpressionError(
                span, f"the function '{last.text}' needs parentheses", f"write {last.text}({token.text})"
            )
        raise ExpressionError(
            span,
            f"an operator is missing between '{last.text}' and '{token.text}'",
            _product_hint(last.text, token.text),
        )

    def _stranger(self, token: Token) -> None:
        last = self.last
        if token.text in "'′" and self.after_value and last is not None and last.kind == "name":
            raise ExpressionError(
                Span(last.span.start, token.span.stop),
                "a prime is not an operator",
                f"write {last.text}_dot for the velocity of {last.text}",
            )
        message, hint = _STRANGERS.get(
            token.text,
            (f"{token.text!r} has no meaning in an expression", "only names, numbers, + - * / ** and ( ) do"),
        )
        raise ExpressionError(token.span, message, hint)

    def _opening(self, token: Token) -> None:
        last = self.last
        if self.after_value and last is not None:
            if token.text == "[":
                raise ExpressionError(
                    token.span,
                    "'[...]': indexed families are not supported yet",
                    "give each member a name of its own, such as theta1",
                )
            if last.kind != "name":
                self._juxtaposed(token)
        self._deeper(token)
        self.open.append(token)
        self.waiting.append(0)
        self.after_value = False

    def _closing(self, token: Token) -> None:
        if not self.open or self.open[-1].text != _CLOSES[token.text]:
            raise ExpressionError(
                token.span, f"this '{token.text}' closes nothing", "leave it out or add what it closes"
            )
        if self.last is not None and self.last.text not in "([,":
            self._need_value(token)
        self._settle()
        self.open.pop()
        self.waiting.pop()
        self.depth -= 1
        self.after_value = True

    def _settle(self) -> None:
        """What waited at this level has its operand."""
        self.depth -= self.waiting[-1]
        self.waiting[-1] = 0

    def _dot(self, token: Token) -> None:
        last = self.last
        if not (self.after_value and last is not None and last.kind == "name"):
            raise ExpressionError(
                token.span, "'.' needs the name of a vector before it", "as in bead.x or bead.vx"
            )
        self.after_value = False

    def _operator(self, token: Token) -> None:
        self.operators += 1
        if self.operators > MAX_OPERATORS:
            raise ExpressionError(
                token.span,
                f"an expression has more than {MAX_OPERATORS} operators",
                "give parts of it a name under 'definitions'",
            )
        if token.text == "**" or not self.after_value:
            if token.text not in ("+", "-"):
                self._need_value(token)
            self._deeper(token)
            self.waiting[-1] += 1
        else:
            self._settle()
        self.after_value = False

    def _deeper(self, token: Token) -> None:
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise ExpressionError(
                token.span,
                f"an expression is nested more than {MAX_NESTING} deep",
                "give parts of it a name under 'definitions'",
            )

    def _need_value(self, token: Token) -> None:
        if not self.after_value:
            last = self.last
            if last is not None and last.text == "/" and token.text == "/":
                raise ExpressionError(token.span, "'//' is not an operator", "write / for division")
            where = (
                f"after '{last.text}'"
                if last is not None and token.text in ")],"
                else f"before '{token.text}'"
            )
            raise ExpressionError(token.span, f"a value is missing {where}", "complete it or leave it out")


def _product_hint(left: str, right: str) -> str:
    if right.startswith("_"):
        return f"leave the '_' out of the number {left}{right}"
    if right in "([" or left in ")]":
        return "write * between them for a product"
    return f"write {left}*{right} for a product"
