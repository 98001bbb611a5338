"""Text to ``Tree`` by precedence climbing; nothing is ever evaluated by Python.

The text is bounded (length, nesting, number of operators), so that no recursion goes deep. After a mistake
the parser goes on with what was probably meant (``2x`` as ``2*x``, ``^`` as ``**``), so that all mistakes of
an expression are found at once.
"""

from __future__ import annotations

import re
import unicodedata

from lagrange_cli.expression.bounds import check_exponent
from lagrange_cli.expression.confusions import (
    DEGREES,
    FUNCTIONS,
    NOT_SMOOTH,
    PRIMES,
    QUOTES,
    RADIANS,
    STRANGERS,
    decimal_comma,
)
from lagrange_cli.expression.near import near_hint, shown
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.scan import Token, tokens
from lagrange_cli.expression.syntax import (
    Axis,
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Key,
    Logic,
    Name,
    Negative,
    Number,
    Span,
    Sum,
    Tree,
    Vector,
    names,
)
from lagrange_cli.expression.vocabulary import CALLABLE, CONSTANTS, NON_SMOOTH, RESERVED, TIME
from lagrange_cli.records import dataclass

MAX_LENGTH = 10_000
"""Characters of one expression."""
MAX_NESTING = 100
"""Parentheses, signs and powers inside one another."""
MAX_OPERATORS = 1_000
"""Operators of one expression."""
MAX_LOOPS = 8
"""Loops of sums inside one another."""

OR, AND, NOT, COMPARISON, SUM, PRODUCT, SIGN, POWER = range(1, 9)
_LEVELS = {
    "or": OR, "and": AND, "==": COMPARISON, "!=": COMPARISON, "<": COMPARISON, "<=": COMPARISON,
    ">": COMPARISON, ">=": COMPARISON, "+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "//": PRODUCT,
    "%": PRODUCT, "**": POWER,
}  # fmt: skip
"""The operators, and how tightly each binds, as in Python."""
_CLOSES = {"(": ")", "[": "]"}
_SUM = "sum(m[j]*x[j] for j in range(N) if j != i)"
_LOOP = "write 'for j in range(N)'"
_PARTS = "name parts of it under 'definitions'"
_SHOWN_FACTORS = 30
"""Characters of a hint from which on it names no further factor."""


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
        raise min(errors, key=lambda error: error.span.start)
    return tree


def read(text: str, offset: int = 0) -> tuple[Tree, list[ExpressionError]]:
    """The tree that ``text`` was probably meant to be, and all that is wrong with it."""
    parser = _Parser(text, offset)
    try:
        tree = parser.whole()
    except _Hopeless:
        tree = Number("1", Span(offset, offset + len(text)))
    except RecursionError:  # called from deep within something else
        whole = Span(offset, offset + len(text))
        return Number("1", whole), [ExpressionError(whole, "expression nested too deep", _PARTS)]
    return tree, parser.errors


def parse_key(text: str) -> Key:
    """What a section declares: a name, ``theta[i in range(N)]`` for members of a family, or ``u[0, N - 1]``.

    Raises:
        ExpressionError: where the text is neither.
    """
    parser = _Parser(text, 0)
    try:
        key = parser.key()
    except _Hopeless:
        key = Key(text, text)
    if parser.errors:
        raise min(parser.errors, key=lambda error: error.span.start)
    return key


class _Hopeless(Exception):
    """Nothing more can be said of the text than what has been said."""


@dataclass(frozen=True)
class _Juxtaposed:
    """A token with no operator before it, and the mistake as which it is reported."""

    token: Token
    error: ExpressionError


class _Parser:
    """Tokens, the place of the next one, and the mistakes found so far."""

    def __init__(self, text: str, offset: int) -> None:
        self.text = text
        self.offset = offset
        self.errors: list[ExpressionError] = []
        self.tokens = [*tokens(text[: MAX_LENGTH + 1], offset)]
        self.place = 0
        self.lost = False
        """Whether the structure is lost: more errors in it would follow from the first."""
        self.condition = False
        """Whether this is within the condition of a sum."""
        self.depth = self.operators = self.loops = 0

    # What has been read and what comes

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
        """The next token, which is taken; what is wrong with its form is noted."""
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
        """Note and go past characters that have no meaning."""
        while self.next.kind == "stranger":
            token = self.next
            if token.text in DEGREES and self.last is not None and self.last.kind == "number":
                return
            self.structural(token.span, *(token.complaint or ("", "")))
            if token.text not in STRANGERS or token.text in QUOTES:
                raise _Hopeless  # what follows may be anything
            self.place += 1

    def sees(self, *texts: str) -> bool:
        """Whether the next token is one of these signs or words."""
        return self.next.text in texts and self.next.kind in ("sign", "word")

    def error(self, span: Span, message: str, hint: str) -> None:
        self.errors.append(ExpressionError(span, message, hint))

    def structural(self, span: Span, message: str, hint: str) -> None:
        """Note a mistake in the structure, if it is the first."""
        if not self.lost:
            self.error(span, message, hint)
        self.lost = True

    def refuse(self, span: Span, message: str, hint: str) -> None:
        """Note a mistake and give up."""
        self.error(span, message, hint)
        raise _Hopeless

    def deeper(self, token: Token) -> None:
        self.depth += 1
        if self.depth > MAX_NESTING:
            self.refuse(token.span, f"expression nested more than {MAX_NESTING} deep", _PARTS)

    def name_of(self, token: Token) -> str:
        return token.text if token.text.isascii() else unicodedata.normalize("NFKC", token.text)

    # The whole text

    def whole(self) -> Tree:
        """All of the text as one expression."""
        if len(self.text) > MAX_LENGTH:
            message = f"an expression of {len(self.text)} characters is too long (limit {MAX_LENGTH})"
            self.refuse(Span(self.offset, self.offset + 1), message, _PARTS)
        whole = Span(self.offset, self.offset + len(self.text))
        if self.next.kind == "end":
            self.refuse(Span(self.offset, self.offset + 1), "empty expression", "write a number or a formula")
        point = decimal_comma(self.text)
        if point:
            self.refuse(whole, "decimal comma", f"write {point}")
        items, vector = self.items("")
        return self.vector(items, whole) if vector else items[0]

    def key(self) -> Key:
        """All of the text as the key of a section."""
        token = self.next
        if token.kind == "end":
            self.refuse(Span(0, 1), "missing name", _KEY)
        if token.kind != "name" or len(self.text) > MAX_LENGTH:
            self.refuse(Span(0, max(1, len(self.text))), "this is not a name", _KEY)
        self.advance()
        if self.next.kind == "end":
            return Key(self.name_of(token), self.text)
        if not self.sees("["):
            self.refuse(Span(0, max(1, len(self.text))), "this is not a name", _KEY)
        opening = self.advance()
        if re.search(r"\.\.|:", self.text):
            span = Span(opening.span.stop, len(self.text.rstrip("] ")))
            self.refuse(span, "these are not indices", f"write {self.name_of(token)}[i in range(N)]")
        axes = [self.axis()]
        while self.sees(","):
            self.advance()
            axes.append(self.axis())
        if self.next.kind != "end" and not self.sees("]"):
            self.unexpected([])
        self.close(opening)
        if self.next.kind != "end":
            self.refuse(Span(0, len(self.text)), "this is not a name", _KEY)
        for i, axis in enumerate(axes):
            if axis.index and axis.index in [one.index for one in axes[:i]]:
                self.error(axis.span, f"the index '{axis.index}' is used twice", "give it another name")
        return Key(self.name_of(token), self.text, tuple(axes))

    def axis(self) -> Axis:
        """One index of a key."""
        start = self.next.span.start
        if self.sees("]", ","):
            self.refuse(self.next.span, "missing index", "as in theta[0] or theta[i in range(N)]")
        ahead = self.tokens[self.place + 1] if self.place + 1 < len(self.tokens) else self.next
        if self.next.kind in ("name", "number") and ahead.kind == "word" and ahead.text == "in":
            index, _ = self.index()
            self.advance()
            bounds = self.range()
            return Axis(index, bounds, Span(start, self.stop))
        tree = self.expression(OR)
        return Axis("", (tree,), Span(start, self.stop))

    # Lists, groups and vectors

    def items(self, closing: str) -> tuple[list[Tree], bool]:
        """Expressions with commas between them up to ``closing`` or the end, and whether there is a comma."""
        found: list[Tree] = []
        comma = False
        while self.next.kind != "end" and not (closing and self.sees(")", "]")):
            if self.sees(")", "]"):
                self.unopened(self.next)
                self.advance()
                continue
            found.append(self.expression(OR))
            if self.sees(","):
                comma = True
                self.advance()
                if self.sees(","):
                    self.missing()
                    self.advance()
            elif self.next.kind != "end" and not self.sees(")", "]"):
                self.unexpected(found)
        if not found and not closing:
            found.append(self.missing())
        return found, comma

    def unexpected(self, found: list[Tree]) -> None:
        """Note a token that cannot stand after an expression, and go past it."""
        token = self.next
        if self.sees("="):
            if self.condition:
                self.structural(token.span, "'=' does not compare", "write ==")
            else:
                left = self.text[: token.span.start - self.offset].strip()
                hint = f"leave out '{left} ='" if len(left) < 40 else "write only the right-hand side"
                self.structural(token.span, "'=' is not allowed", hint)
            del found[-1:]  # the left-hand side says what is meant, not what it is
        elif token.text == "else":
            self.refuse(token.span, "'else' is not allowed", "write two sums, each with its own condition")
        elif token.kind == "word" and token.text in ("for", "in"):
            self.refuse(token.span, f"'{token.text}' outside a sum", f"as in {_SUM}")
        elif token.kind == "word":
            self.refuse(token.span, "condition outside a sum", f"as in {_SUM}")
        elif self.sees("["):
            after_index = self.last is not None and self.last.text == "]"
            hint = "an index follows the name of a family, as in theta[i]"
            if after_index:
                hint = "write both indices in one pair of brackets, as in u[i, j]"
            self.refuse(token.span, "misplaced index", hint)
        elif self.sees("."):
            self.refuse(token.span, "misplaced '.'", "it follows the name of a vector, as in bead.x")
        elif token.kind != "stranger":
            self.structural(
                token.span, f"unexpected '{token.text}'", "complete the expression, or leave it out"
            )
        self.advance()

    def unopened(self, token: Token) -> None:
        self.structural(token.span, f"unmatched '{token.text}'", "leave it out, or open it first")

    def close(self, opening: Token) -> None:
        """Take what closes ``opening``."""
        closing = _CLOSES[opening.text]
        if self.next.kind == "end":
            self.structural(opening.span, f"unclosed '{opening.text}'", f"add a '{closing}'")
            return
        if not self.sees(closing):
            self.unopened(self.next)
        self.advance()

    def enclosed(self, opening: Token, *, condition: bool = False) -> tuple[list[Tree], bool]:
        """The expressions in the parentheses or brackets that ``opening`` begins."""
        self.deeper(opening)
        around, self.condition = self.condition, condition
        found = self.items(_CLOSES[opening.text])
        self.close(opening)
        self.condition = around
        self.depth -= 1
        return found

    def group(self) -> Tree:
        """What stands in parentheses, or a vector."""
        opening = self.advance()
        items, comma = self.enclosed(opening, condition=self.condition)
        if comma or opening.text == "[" or not items:
            return self.vector(items, Span(opening.span.start, self.stop))
        return items[0]

    def vector(self, items: list[Tree], span: Span) -> Tree:
        if not 1 <= len(items) <= 3:
            self.error(
                span, f"a vector of {len(items)} components", "vectors have one to three, as in (x, y, z)"
            )
        return Vector(tuple(items), span)

    # Operators

    def expression(self, least: int = SUM) -> Tree:
        """An expression of operators that bind at least so tightly."""
        start = self.next.span.start
        left = self.operand()
        juxtaposition: _Juxtaposed | None = None
        while True:
            self.skip_strangers()
            token = self.next
            level = _LEVELS.get(token.text, 0) if token.kind in ("sign", "word") else 0
            juxtaposed = not level and self.is_juxtaposed(token)
            if juxtaposed:
                level = PRODUCT
            if level == 0 or level < least:
                return left
            if juxtaposed:
                if self.is_unit(token):
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
        if self.operators > MAX_OPERATORS:
            self.refuse(token.span, f"expression with more than {MAX_OPERATORS} operators", _PARTS)
        if not self.condition and _LEVELS[token.text] <= COMPARISON:
            what = "condition" if token.kind == "word" else "comparison"
            self.structural(token.span, f"{what} outside the 'if' of a sum", f"as in {_SUM}")

    def check_exponent(self, exponent: Tree) -> None:
        if any(name.identifier not in CONSTANTS for name in names(exponent)):
            return
        try:
            check_exponent(evaluate(exponent))
        except ExpressionError as error:
            self.errors.append(error)
        except ArithmeticError as error:
            self.error(exponent.span, str(error), "write the power another way")

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
            self.error(span, "unit after a number", f"write {last.text}; angles are in radians")
        return True

    def juxtaposed(self, token: Token, before: _Juxtaposed | None) -> _Juxtaposed:
        """Note a missing operator before ``token``; the two of ``m g h`` are one mistake."""
        last = self.tokens[self.place - 1]
        if before and before.token is last and len(before.error.hint) < _SHOWN_FACTORS:
            error = before.error
            error.hint += f"*{_factor(token.text)}"
        else:
            span = Span(last.span.start, token.span.stop)
            message = f"missing operator between '{last.text}' and '{token.text}'"
            error = ExpressionError(span, message, _product_hint(last.text, token.text))
            self.errors.append(error)
        return _Juxtaposed(token, error)

    # Operands

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
            self.structural(token.span, "condition outside the 'if' of a sum", f"as in {_SUM}")
        self.deeper(token)
        operand = self.expression(NOT)
        self.depth -= 1
        return Logic("not", (operand,), Span(token.span.start, self.stop))

    def missing(self) -> Tree:
        """Note that a value is missing, and go on as if there were one."""
        token, last = self.next, self.last
        if token.kind == "end" or token.text in (")", "]", ","):
            where = f"after '{last.text}'" if last else "here"
            span = last.span if token.kind == "end" and last else token.span
        else:
            where, span = f"before '{token.text}'", token.span
        self.structural(span, f"missing value {where}", "complete the expression")
        return Number("1", token.span)

    def number(self) -> Tree:
        token = self.advance()
        if re.fullmatch("0+[1-9][0-9]*", token.text):
            self.error(
                token.span, f"the number {token.text} has a leading zero", f"write {token.text.lstrip('0')}"
            )
        elif float(token.text) == float("inf"):
            self.error(token.span, "number too large", "the largest is about 1.8e308")
            return Number("1", token.span)
        return Number(token.text, token.span)

    def name(self) -> Tree:
        token = self.advance()
        name = self.name_of(token)
        if self.sees("("):
            return self.sum(token) if name == "sum" else self.call(token, name)
        if name in CALLABLE or name == "sum":
            return self.function_without_parentheses(token, name)
        if self.next.text in PRIMES and self.next.span.start == token.span.stop:
            return self.primed(token, name)
        indices: tuple[Tree, ...] = ()
        if self.sees("["):
            indices = self.indices()
        if not self.sees("."):
            return Name(name, Span(token.span.start, self.stop), indices)
        return self.component(token, name, indices)

    def component(self, token: Token, name: str, indices: tuple[Tree, ...]) -> Tree:
        """A name with a component; there is only one."""
        parts = []
        while self.sees("."):
            dot = self.advance()
            if self.next.kind != "name":
                self.refuse(dot.span, "missing component after '.'", "as in bead.x")
            parts.append(self.name_of(self.advance()))
        span = Span(token.span.start, self.stop)
        if self.sees("("):
            hint = f"write {parts[-1]}(...)" if parts[-1] in CALLABLE else "write * for a product"
            self.error(span, f"'{name}.{parts[-1]}' is not a function", hint)
            return Vector(tuple(self.enclosed(self.advance())[0]), span)
        if self.sees("["):
            self.indices()
            span = Span(token.span.start, self.stop)
            self.error(span, "index after the component", f"write {name}[i].{parts[0]}")
        elif len(parts) > 1:
            self.error(span, f"'{name}.{parts[0]}' has no components", f"write {name}.{parts[0]}")
        return Name(f"{name}.{parts[0]}", span, indices)

    def indices(self) -> tuple[Tree, ...]:
        """What stands in the brackets behind a name."""
        opening = self.advance()
        if self.sees("]"):
            self.structural(self.next.span, "missing index", "as in theta[0] or theta[i]")
        return tuple(self.enclosed(opening)[0])

    def primed(self, token: Token, name: str) -> Tree:
        """``x'``, which is a velocity elsewhere."""
        count = 0
        while self.next.text in PRIMES and self.next.span.start == self.stop:
            count += 2 if self.next.text in '"″' else 1
            self.place += 1
        span = Span(token.span.start, self.stop)
        if count == 1:
            self.error(span, "a prime is not a derivative", f"write {name}_dot for the velocity of {name}")
        else:
            self.error(span, "accelerations cannot be used", "the equations of motion determine them")
        return Name(name, token.span)

    # Functions and sums

    def function_without_parentheses(self, token: Token, name: str) -> Tree:
        """``sin x`` or ``sin^2(x)``."""
        message = f"missing parentheses after '{name}'"
        if self.sees("**") and name in CALLABLE:
            self.place += 1
            exponent = self.next.text
            self.expression(POWER + 1) if self.next.kind == "number" else self.operand()
            self.error(Span(token.span.start, self.stop), message, f"write {name}(x)**{exponent}")
        elif self.next.kind in ("number", "name"):
            argument = self.next
            self.error(Span(token.span.start, argument.span.stop), message, f"write {name}({argument.text})")
        else:
            self.error(token.span, message, f"write {name}(...)")
            return Number("1", token.span)
        return (
            Vector((self.expression(SIGN),), token.span)
            if self.next.kind != "end"
            else Number("1", token.span)
        )

    def call(self, token: Token, name: str) -> Tree:
        was_lost = self.lost
        arguments, _ = self.enclosed(self.advance())
        span = Span(token.span.start, self.stop)
        if name in NON_SMOOTH or name.lower() in NOT_SMOOTH or name.lower() in NON_SMOOTH:
            self.error(
                token.span,
                f"'{name}' is not supported yet: it is not smooth",
                "use a smooth function, such as tanh(x/eps) or sqrt(x**2 + eps**2)",
            )
        elif name == "range":
            self.error(token.span, "'range' outside a loop", f"as in {_SUM}")
        elif name not in CALLABLE and len(arguments) == 1 and isinstance(arguments[0], Name):
            argument = arguments[0].identifier
            if argument == TIME and name.lower() not in FUNCTIONS:
                self.error(
                    span, f"unknown function {shown(name)}", f"write {name}: coordinates have no '(t)'"
                )
                return Name(name, token.span)
            self.error(token.span, f"unknown function {shown(name)}", _function_hint(name, argument))
        elif name not in CALLABLE:
            self.error(token.span, f"unknown function {shown(name)}", _function_hint(name))
        elif len(arguments) != CALLABLE[name] and self.lost == was_lost:
            self.error(span, *_wrong_count(name, arguments, self.text, self.offset))
        return Call(name, tuple(arguments), span)

    def sum(self, token: Token) -> Tree:
        """``sum(body for i in range(N) if ... for ...)``."""
        opening = self.advance()
        self.deeper(opening)
        around, self.condition = (self.condition, self.loops), False
        self.another_loop(opening)
        body = self.expression(OR)
        loops: list[tuple[str, Span, tuple[Tree, ...], tuple[Tree, ...]]] = []
        while self.sees("for"):
            word = self.advance()
            if loops:
                self.another_loop(word)
            index, place = self.index()
            if self.sees("in"):
                self.advance()
            else:
                self.refuse(self.next.span, f"missing 'in' before '{self.next.text}'", f"as in {_SUM}")
            loops.append((index, place, self.range(), self.conditions()))
        if self.sees(","):
            self.refuse(self.next.span, "unexpected ',' in a sum", f"as in {_SUM}")
        if loops and self.next.kind != "end" and not self.sees(")", "]"):
            self.unexpected([body])
        while self.next.kind != "end" and not self.sees(")", "]"):
            self.unexpected([body])
        self.close(opening)
        self.condition, self.loops = around
        self.depth -= 1
        span = Span(token.span.start, self.stop)
        if not loops:
            self.structural(span, "sum without a loop", "write sum(m[j]*x[j] for j in range(N))")
            return body
        for index, place, bounds, conditions in reversed(loops):
            body = Sum(body, index, bounds, conditions, span, place)
        return body

    def another_loop(self, token: Token) -> None:
        self.loops += 1
        if self.loops > MAX_LOOPS:
            self.refuse(token.span, f"sums are nested more than {MAX_LOOPS} deep", _PARTS)

    def conditions(self) -> tuple[Tree, ...]:
        found = []
        while self.sees("if"):
            self.advance()
            self.condition = True
            found.append(self.expression(OR))
            if self.sees("="):
                self.refuse(self.next.span, "'=' does not compare", "write ==")
            self.condition = False
        return tuple(found)

    def index(self) -> tuple[str, Span]:
        """The index of a loop."""
        token = self.next
        if self.sees("in") or token.kind == "end":
            self.refuse(token.span, f"missing name of the index before '{token.text}'", _LOOP)
        tree = self.operand()
        if not isinstance(tree, Name) or tree.indices or "." in tree.identifier:
            self.refuse(tree.span, "an index must be a name", _LOOP)
            raise AssertionError("unreachable")
        if tree.identifier in RESERVED:
            name = tree.identifier
            self.error(tree.span, f"the name '{name}' is reserved", f"call the index {name}_ or another name")
        return tree.identifier, tree.span

    def range(self) -> tuple[Tree, ...]:
        """The arguments of the range that an index runs through."""
        start = self.next
        if start.text != "range" or self.tokens[self.place + 1].text != "(":
            tree = self.expression()
            self.refuse(tree.span, "an index needs a range", _LOOP)
        self.advance()
        arguments, _ = self.enclosed(self.advance())
        if not 1 <= len(arguments) <= 3:
            self.error(
                Span(start.span.start, self.stop),
                f"wrong number of arguments for 'range': {len(arguments)} instead of 1 to 3",
                "write range(N), or range(start, stop, step); stop itself is left out",
            )
        return tuple(arguments)


_KEY = "write a name, or a family as theta[i in range(N)]"


def _wrong_count(name: str, arguments: list[Tree], text: str, offset: int) -> tuple[str, str]:
    """What is said of a function with too many or too few arguments."""
    due = CALLABLE[name]
    message = f"wrong number of arguments for '{name}': {len(arguments)} instead of {due}"
    if due == 1 and len(arguments) == 2 and all(isinstance(one, Number) for one in arguments):
        written = text[arguments[0].span.start - offset : arguments[1].span.stop - offset]
        if decimal_comma(written):
            return message, f"write {name}({decimal_comma(written)}), with a decimal point"
    return message, f"write {name}({', '.join('xyz'[:due])})"


def _product_hint(left: str, right: str) -> str:
    if right.startswith("_") and left.isdigit():
        return f"write {left}{right.replace('_', '')}"
    return f"write {_factor(left)}*{_factor(right)}"


def _factor(text: str) -> str:
    return "(...)" if text in "([)]" else text


def _function_hint(function: str, argument: str = "") -> str:
    meant = FUNCTIONS.get(function) or FUNCTIONS.get(function.lower())
    if meant:
        return f"write {meant}"
    product = f"{function}*{argument}" if argument else f"{function}*(...)"
    return near_hint(function, CALLABLE) or f"write {product} for a product"
