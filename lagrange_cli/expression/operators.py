"""Expressions by precedence climbing, and products whose sign is missing."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lagrange_cli.expression.bounds import check_exponent
from lagrange_cli.expression.confusions import DEGREES, RADIANS, SPOKEN_POWERS
from lagrange_cli.expression.cursor import CONDITION_HINT, PARTS_HINT
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.operands import Operands
from lagrange_cli.expression.scan import Token
from lagrange_cli.expression.syntax import (
    Binary,
    Comparison,
    ExpressionError,
    Logic,
    Negative,
    Span,
    Tree,
    names,
    plain_names,
)
from lagrange_cli.expression.vocabulary import (
    AND,
    CALLABLE,
    COMPARISON,
    CONSTANTS,
    LEVELS,
    NOT,
    PRODUCT,
    SIGN,
    SUM,
)
from lagrange_cli.records import dataclass

_SHOWN_FACTORS = 30
"""Characters of a hint from which on it names no further factor."""


@dataclass(frozen=True)
class _Juxtaposed:
    """A token with no operator before it, the mistake as which it is reported, the ``factors`` so far, and
    whether they are ``divided`` by, as in ``1/2pi``."""

    token: Token
    error: ExpressionError
    factors: tuple[str, ...]
    divided: bool


class Parser(Operands):
    """Reads expressions: operands, signs, and the operators between them."""

    def expression(self, least: int = SUM) -> Tree:
        """An expression of operators that bind at least so tightly."""
        start = self.next.span.start
        left = self.operand()
        juxtaposition: _Juxtaposed | None = None
        while True:
            self.skip_strangers()
            token = self.next
            level = LEVELS.get(token.text, 0) if token.kind in ("sign", "word") else 0
            juxtaposed = not level and self.is_juxtaposed(token)
            if juxtaposed:
                level = PRODUCT
            if level == 0 or level < least:
                return left
            if juxtaposed:
                if self.is_unit(token) or self.is_spoken_power(token):
                    self.place += 1
                    continue
                juxtaposition = self.juxtaposed(token, juxtaposition)
                operator = "*"
            else:
                self.count(token)
                operator = self.advance().text
            if operator == "**":
                self.deeper(token)
                before = len(self.errors)
                right = self.expression(SIGN)
                self.depth -= 1
                if len(self.errors) == before:
                    self.check_exponent(right)
            else:
                right = self.expression(level + 1)
            left = self.combined(operator, level, left, right, Span(start, self.stop))

    def combined(self, operator: str, level: int, left: Tree, right: Tree, span: Span) -> Tree:
        if level == COMPARISON:
            if (
                isinstance(left, Comparison)
                and left.span.start == span.start
                and left.span.stop < right.span.start
            ):
                return Comparison((*left.operators, operator), (*left.operands, right), span)
            return Comparison((operator,), (left, right), span)
        if level <= AND:
            same = isinstance(left, Logic) and left.operator == operator and left.span.start == span.start
            before = left.operands if same and isinstance(left, Logic) else (left,)
            return Logic(operator, (*before, right), span)
        return Binary(operator, left, right, span)

    def count(self, token: Token) -> None:
        """Count an operator, and see whether it may stand here."""
        self.operators += 1
        most = self.bounds.operators
        if self.operators > most:
            self.refuse(token.span, f"expression with more than {most} operators", PARTS_HINT)
        if not self.condition and LEVELS[token.text] <= COMPARISON:
            what = "condition" if token.kind == "word" else "comparison"
            self.structural(token.span, f"{what} outside 'where' and the 'if' of a sum", CONDITION_HINT)

    def check_exponent(self, exponent: Tree) -> None:
        if plain_names(exponent) - CONSTANTS or any(one.indices for one in names(exponent)):
            return
        try:
            check_exponent(evaluate(exponent))
        except ExpressionError as error:
            self.errors.append(error)
        except ArithmeticError as error:
            self.error(exponent.span, str(error), "write the power another way")

    def operand(self) -> Tree:
        """A number, a name, a call, a group, or one of these with a sign before it."""
        token = self.next
        if token.kind == "number":
            return self.number()
        if token.kind == "name":
            return self.name()
        if self.sees("(", "["):
            return self.group()
        if self.sees("+", "-"):
            self.count(token)
            self.deeper(token)
            self.advance()
            operand = self.expression(SIGN)
            self.depth -= 1
            return operand if token.text == "+" else Negative(operand, Span(token.span.start, self.stop))
        if self.sees("not"):
            return self.negation()
        if self.sees("."):
            self.refuse(token.span, "misplaced '.'", "it follows the name of a vector, as in bead.x")
        if token.kind == "stranger":
            self.skip_strangers()
            return self.operand()
        if token.kind == "word" and token.text in ("if", "else", "and", "or") and not self.condition:
            self.unexpected([])
        return self.missing()

    def negation(self) -> Tree:
        token = self.advance()
        if not self.condition:
            self.structural(token.span, "condition outside 'where' and the 'if' of a sum", CONDITION_HINT)
        self.deeper(token)
        operand = self.expression(NOT)
        self.depth -= 1
        return Logic("not", (operand,), Span(token.span.start, self.stop))

    # Products without a sign

    def is_juxtaposed(self, token: Token) -> bool:
        """Whether a value begins here, where an operator should be."""
        if token.kind in ("number", "name") or token.text in DEGREES:
            return True
        return self.sees("(") and self.last is not None

    def is_unit(self, token: Token) -> bool:
        """Whether it is the unit of an angle, which is reported."""
        last = self.last
        if last is None or last.kind != "number" or token.text not in DEGREES | RADIANS:
            return False
        span = Span(last.span.start, token.span.stop)
        if token.text in DEGREES:
            self.error(span, "angle in degrees", f"angles are in radians: write {last.text}*pi/180")
        else:
            self.error(span, "unit after a number", f"leave out '{token.text}': angles are in radians")
        return True

    def is_spoken_power(self, token: Token) -> bool:
        """Whether it is the ``squared`` of ``r squared``, which is reported."""
        last = self.last
        if last is None or token.text not in SPOKEN_POWERS:
            return False
        hint = f"write {_factor(self._before(last))}**{SPOKEN_POWERS[token.text]}"
        self.error(Span(last.span.start, token.span.stop), "power written as a word", hint)
        return True

    def juxtaposed(self, token: Token, before: _Juxtaposed | None) -> _Juxtaposed:
        """Note a missing operator before ``token``; the two of ``m g h`` are one mistake."""
        last = self.tokens[self.place - 1]
        if before and before.token is last and len("*".join(before.factors)) < _SHOWN_FACTORS:
            error, divided = before.error, before.divided
            factors = (*before.factors, self._after(token))
        else:
            span = Span(last.span.start, token.span.stop)
            message = f"missing operator between '{last.text}' and '{token.text}'"
            error = ExpressionError(span, message, "")
            self.errors.append(error)
            factors = self._before(last), self._after(token)
            divided = (
                self.text[: last.span.stop - self.offset].removesuffix(factors[0]).rstrip().endswith("/")
            )
        error.hint = _product_hint(factors, divided=divided)
        return _Juxtaposed(token, error, factors, divided)

    def _before(self, token: Token) -> str:
        """The value that ends with a token: ``bob.y`` for its ``y``."""
        text = self.text[: token.span.stop - self.offset]
        found = re.search(r"[^\W\d]\w*(?:\[[^][]*\])?\.\w+\Z", text[-_SHOWN_FACTORS:])
        return found[0] if found and token.kind == "name" else token.text

    def _after(self, token: Token) -> str:
        """The value that begins with a token: ``bob[0].y`` for its ``bob``."""
        text = self.text[token.span.start - self.offset :]
        found = re.match(r"\w+(?:\[[^][]*\])?(?:\.\w+)?", text[:_SHOWN_FACTORS])
        if token.text in CALLABLE:
            found = re.match(r"\w+(?:\([^()]*\))?", text[:_SHOWN_FACTORS])
        return found[0] if found and token.kind == "name" else token.text


def _product_hint(factors: Sequence[str], *, divided: bool) -> str:
    left, right = factors[:2]
    product = "*".join(map(_factor, factors))
    if divided:
        return f"write {product}, or ({product}) to divide by the whole product"
    if len(factors) == 3 and right in ("x", "X"):
        if left[0].isdigit() and factors[2][0].isdigit():  # 6.67 x 10^-11
            return f"write {left}*{factors[2]}"
        return f"write {product}, or cross({_factor(left)}, {_factor(factors[2])}) for a vector product"
    return f"write {product}"


def _factor(text: str) -> str:
    return "(...)" if text in "([)]" else text
