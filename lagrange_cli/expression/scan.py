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
MAX_LOOPS = 8
"""Loops of sums inside one another."""

_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*)"
    r"|(?P<sign>\*\*|//|[=!<>]=|[-+*/%<>,.()\[\]])"
    r"|(?P<space>\s+)"
    r"|(?P<other>.)",
    re.DOTALL,
)
_CLOSES = {")": "(", "]": "["}

_STRANGERS: dict[str, tuple[str, str]] = {
    "^": ("'^' is not an operator", "write ** for powers"),
    "=": ("an expression has no '='", "give only the expression itself"),
    "!": ("'!' is not an operator", "only + - * / ** are"),
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
_WORDS = frozenset({"for", "in", "if", "and", "or", "not"})
_FOLLOWS = {"for": ("", "in", "if"), "in": ("for",), "if": ("in", "if")}  # the words of a sum's loops
_COMPARISONS = frozenset({"==", "!=", "<", "<=", ">", ">="})
_SUM = "sum(m[j]*x[j] for j in range(N) if j != i)"


@dataclass(frozen=True)
class Token:
    """One token with its place: ``kind`` is ``number``, ``name`` or ``sign``."""

    kind: str
    text: str
    span: Span


@dataclass
class _Level:
    """An open parenthesis or bracket (or the whole text), and what has been read of it."""

    token: Token | None = None
    kind: str = ""
    """``sum`` and ``index`` for those of a sum and of an index."""
    phase: str = ""
    """The last of ``for``, ``in`` and ``if`` in a sum; ``if`` within parentheses of a condition too."""
    loops: int = 0
    """Loops of sums here and around."""
    waiting: int = 0
    """Signs and powers that wait for their operand."""


def scan(text: str, key: bool = False) -> None:
    """Pass ``text`` if it is within bounds and each token stands where one of its kind may stand.

    With ``key`` it is what a section declares, and ``i in range(N)`` may stand in brackets.

    Raises:
        ExpressionError: at the first token that does not.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            Span(0, 1),
            f"an expression of {len(text)} characters is too long (limit {MAX_LENGTH})",
            "give parts of it a name under 'definitions'",
        )
    state = _State(key)
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or "other"
        if kind != "space":
            state.take(Token(kind, match.group(), Span(*match.span())))
    state.finish()


class _State:
    """What has been read so far: the last token, whether a value just ended, and what is still open."""

    def __init__(self, key: bool) -> None:
        self.key = key
        self.last: Token | None = None
        self.after_value = False
        self.levels = [_Level()]
        self.depth = 0  # how deep a parser would be now: open levels and all that waits
        self.operators = 0

    def take(self, token: Token) -> None:
        if self.last is not None and self.last.text == "." and token.kind != "name":
            raise ExpressionError(
                self.last.span, "the name of a component is missing after '.'", "as in bead.x"
            )
        if token.kind == "number":
            self._number(token)
        elif token.kind == "name" and token.text in _WORDS:
            self._word(token)
        elif token.kind == "name":
            self._name(token)
        elif token.kind == "other":
            self._stranger(token)
        elif token.text in "([":
            self._opening(token)
        elif token.text in ")]":
            self._closing(token)
        elif token.text == ",":
            if self.levels[-1].kind == "sum":
                raise ExpressionError(token.span, "a sum has no ',' of its own", f"as in {_SUM}")
            self._need_value(token)
            self._settle()
            self.after_value = False
        elif token.text == ".":
            self._dot(token)
        elif token.text in _COMPARISONS:
            self._comparison(token)
        else:
            self._operator(token)
        self.last = token

    def finish(self) -> None:
        if self.last is None:
            raise ExpressionError(Span(0, 1), "the expression is empty", "write a number or a formula")
        token = self.levels[-1].token
        if token is not None:
            closing = ")" if token.text == "(" else "]"
            raise ExpressionError(token.span, f"this '{token.text}' is never closed", f"add a '{closing}'")
        if not self.after_value and self.last.text != ",":
            raise ExpressionError(
                self.last.span, f"a value is missing after '{self.last.text}'", "complete it or leave it out"
            )

    def _number(self, token: Token) -> None:
        if self.last is not None and self.last.text == "for":
            raise ExpressionError(token.span, "an index must be a name", f"as in {_SUM}")
        self._juxtaposed(token)
        if re.fullmatch("0+[1-9][0-9]*", token.text):
            raise ExpressionError(
                token.span, f"the number {token.text} begins with a zero", f"write {token.text.lstrip('0')}"
            )
        if float(token.text) == float("inf"):
            raise ExpressionError(token.span, "this number is too large", "the largest is about 1.8e308")
        self.after_value = True

    def _name(self, token: Token) -> None:
        if token.text == "else":
            raise ExpressionError(
                token.span, "'else' is not accepted", "write two sums, each with a condition of its own"
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

    def _word(self, token: Token) -> None:
        level, word = self.levels[-1], token.text
        if level.kind == "sum" and level.phase in _FOLLOWS.get(word, ()):
            self._need_value(token)
            if word == "for" and level.phase:
                self._another_loop(level, token)
            level.phase = word
        elif word in ("and", "or") and level.phase == "if":
            self._need_value(token)
        elif word == "not" and level.phase == "if":
            if self.after_value:
                self._juxtaposed(token)
            self._deeper(token)
            level.waiting += 1
            return
        elif not (word == "in" and level.kind == "index" and self.key and self.after_value):
            what = "a condition" if word in ("if", "and", "or", "not") else f"'{word}'"
            raise ExpressionError(token.span, f"{what} can stand only in a sum", f"as in {_SUM}")
        self._settle()
        self.after_value = False

    def _comparison(self, token: Token) -> None:
        if self.levels[-1].phase != "if":
            raise ExpressionError(
                token.span, "a comparison can stand only in a condition of a sum", f"as in {_SUM}"
            )
        self._operator(token)

    def _juxtaposed(self, token: Token) -> None:
        last = self.last
        if not self.after_value or last is None:
            return
        span = Span(last.span.start, token.span.stop)
        if self.levels[-1].phase == "for":
            raise ExpressionError(token.span, f"'in' is missing before '{token.text}'", f"as in {_SUM}")
        if last.kind == "name" and last.text in (*CALLABLE, "sum"):
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
        if token.text == "=" and self.levels[-1].phase == "if":
            raise ExpressionError(token.span, "'=' does not compare", "write ==")
        message, hint = _STRANGERS.get(
            token.text,
            (f"{token.text!r} has no meaning in an expression", "only names, numbers, + - * / ** and ( ) do"),
        )
        raise ExpressionError(token.span, message, hint)

    def _opening(self, token: Token) -> None:
        last = self.last
        kind = ""
        if self.after_value and last is not None:
            if token.text == "[" and last.kind != "name":
                hint = (
                    "write both in one, as in u[i, j]" if last.text == "]" else "as in theta[0] or theta[i]"
                )
                raise ExpressionError(token.span, "an index must follow the name of a family", hint)
            if last.kind != "name":
                self._juxtaposed(token)
            if token.text == "[":
                kind = "index"
            elif last.text == "sum":
                kind = "sum"
        around = self.levels[-1]
        self._deeper(token)
        phase = "if" if around.phase == "if" and not kind else ""
        self.levels.append(_Level(token, kind, phase, around.loops))
        if kind == "sum":
            self._another_loop(self.levels[-1], token)
        self.after_value = False

    def _another_loop(self, level: _Level, token: Token) -> None:
        level.loops += 1
        if level.loops > MAX_LOOPS:
            raise ExpressionError(
                token.span,
                f"sums are nested more than {MAX_LOOPS} deep",
                "give parts of it a name under 'definitions'",
            )

    def _closing(self, token: Token) -> None:
        opening = self.levels[-1].token
        if opening is None or opening.text != _CLOSES[token.text]:
            raise ExpressionError(
                token.span, f"this '{token.text}' closes nothing", "leave it out or add what it closes"
            )
        if self.last is opening and self.levels[-1].kind == "index":
            raise ExpressionError(token.span, "an index is missing", "as in theta[0] or theta[i]")
        if self.last is not None and self.last.text not in "([,":
            self._need_value(token)
        self._settle()
        self.levels.pop()
        self.depth -= 1
        self.after_value = True

    def _settle(self) -> None:
        """What waited at this level has its operand."""
        self.depth -= self.levels[-1].waiting
        self.levels[-1].waiting = 0

    def _dot(self, token: Token) -> None:
        last = self.last
        if not (self.after_value and last is not None and (last.kind == "name" or last.text == "]")):
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
            self.levels[-1].waiting += 1
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
