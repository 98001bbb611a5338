"""Values of formulas in LaTeX, read as a mathematician reads them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import mpmath

TOKEN = re.compile(
    r"\\begin\{cases\}|\\end\{cases\}|\\operatorname\{\w+\}|\\mathrm\{(?:\\.|[^{}\\])+\}"
    r"|\\(?:left|right|Bigl|Bigr)[()|]|\\text\{[^}]*\}|\\\\|\\[a-zA-Z]+|\d+\.?\d*|\S"
)
FUNCTIONS = {
    r"\sin": mpmath.sin, r"\cos": mpmath.cos, r"\tan": mpmath.tan, r"\arcsin": mpmath.asin,
    r"\arccos": mpmath.acos, r"\arctan": mpmath.atan, r"\sinh": mpmath.sinh, r"\cosh": mpmath.cosh,
    r"\tanh": mpmath.tanh, r"\ln": mpmath.log, r"\exp": mpmath.exp, r"\max": max, r"\min": min,
    r"\operatorname{atan2}": mpmath.atan2, r"\operatorname{sgn}": mpmath.sign,
}  # fmt: skip
OPEN = {"(": ")", r"\left(": r"\right)", r"\Bigl(": r"\Bigr)"}
DOTS = {r"\dot": "'", r"\ddot": "''"}
ENDS = {
    "+",
    "-",
    "}",
    ",",
    "&",
    "<",
    ">",
    "=",
    r"\\",
    r"\ge",
    r"\le",
    r"\right|",
    r"\end{cases}",
    "",
    *OPEN.values(),
}


def value(text: str, names: Mapping[str, Any]) -> Any:
    """The value of a formula; ``names`` are values of symbols by their letters, a line before indices, and a
    prime for each dot, as in ``theta|1'``. A name that is written out, as in ``x\\_1``, goes before."""
    reader = Reader(TOKEN.findall(text), names)
    found = reader.sum()
    assert reader.next() == "", text
    return found


class Reader:
    """A parser by recursive descent, with products that have no sign."""

    def __init__(self, tokens: list[str], names: Mapping[str, Any]) -> None:
        self.tokens, self.names = tokens, names
        self.bare = False
        """Whether what has just been read is a function of what stands behind it without parentheses."""

    @property
    def following(self) -> str:
        return self.tokens[0] if self.tokens else ""

    def next(self) -> str:
        return self.tokens.pop(0) if self.tokens else ""

    def take(self, token: str) -> None:
        assert self.following == token, (token, self.tokens[:9])
        self.next()

    def sum(self) -> Any:
        total = mpmath.mpf(0)
        sign = self.next() if self.following in ("+", "-") else "+"
        while sign:
            term = self.product()
            total = total + term if sign == "+" else total - term
            sign = self.next() if self.following in ("+", "-") else ""
        return total

    def product(self) -> Any:
        found = self.power()
        while self.following not in ENDS and not self.following.startswith(r"\text"):
            function = self.bare and self.following in FUNCTIONS
            assert function or not self.bare, ("does this belong to the argument?", self.tokens[:9])
            if self.following == r"\cdot":
                self.next()
            else:
                assert not self.following[0].isdigit(), ("a digit without a dot", self.tokens[:9])
            found = found * self.power()
        self.bare = False
        return found

    def power(self) -> Any:
        self.bare = False
        base = self.factor()
        if self.following != "^":
            return base
        assert not self.bare, ("a power of what?", self.tokens[:9])
        exponent = self.exponent()
        assert self.following != "^", "two exponents"
        return base**exponent

    def exponent(self) -> Any:
        self.take("^")
        return self.group()

    def group(self) -> Any:
        self.take("{")
        found = self.sum()
        self.take("}")
        return found

    def factor(self) -> Any:
        token = self.next()
        if token[0].isdigit():
            return mpmath.mpf(token)
        if token in OPEN:
            found = self.sum()
            self.take(OPEN[token])
            return found
        if token == r"\left|":
            found = abs(self.sum())
            self.take(r"\right|")
            return found
        if token == r"\frac":
            above = self.group()
            return above / self.group()
        if token == r"\sqrt":
            return mpmath.sqrt(self.group())
        if token == "e" and self.following == "^" and "e" not in self.names:
            return mpmath.exp(self.exponent())
        if token == "{":
            return self.cases()
        if token in FUNCTIONS:
            return self.call(token)
        return self.symbol(token)

    def symbol(self, token: str) -> Any:
        dots = DOTS.get(token, "")
        if dots:
            self.take("{")
            token = self.next()
            self.take("}")
        if self.following != "_":
            written = verbatim(token) + dots
            if written in self.names:
                return self.names[written]
            return +mpmath.pi if token == r"\pi" else self.names[letters(token) + dots]
        tokens = self.indices()
        written = f"p|{verbatim(tokens[1])}{dots}"
        if token == "p" and len(tokens) == 3 and written in self.names:
            return self.names[written]
        index = letters("".join(tokens))
        if token != "p":  # the momentum of what has indices
            index = index.replace("|", "")
        return self.names[f"{letters(token)}|{index}{dots}"]

    def indices(self) -> list[str]:
        """The tokens of an index, which may have indices."""
        self.take("_")
        depth, found = 0, list[str]()
        while True:
            token = self.next()
            assert token, "an index without an end"
            depth += (token == "{") - (token == "}")
            found.append(token)
            if depth == 0:
                return found

    def call(self, function: str) -> Any:
        exponent = self.exponent() if self.following == "^" else 1
        if self.following not in OPEN:
            found = FUNCTIONS[function](self.factor()) ** exponent
            self.bare = True
            return found
        close = OPEN[self.next()]
        arguments = [self.sum()]
        while self.following == ",":
            self.next()
            arguments.append(self.sum())
        self.take(close)
        return FUNCTIONS[function](*arguments) ** exponent

    def cases(self) -> Any:
        """The first value whose condition holds; the others may be undefined."""
        self.take(r"\begin{cases}")
        chosen = None
        while True:
            found = self.sum()
            self.take("&")
            otherwise = self.next() == r"\text{otherwise}"
            if (otherwise or self.condition()) and chosen is None:
                chosen = found
            if otherwise:
                break
            self.take(r"\\")
        self.take(r"\end{cases}")
        self.take("}")
        return chosen

    def condition(self) -> bool:
        found = self.relation()
        while self.following in (r"\text{ and }", r"\text{ or }"):
            both = self.next() == r"\text{ and }"
            other = self.relation()
            found = found and other if both else found or other
        return found

    def relation(self) -> bool:
        left, sign, right = self.sum(), self.next(), self.sum()
        if any(isinstance(one, mpmath.mpc) for one in (left, right)):
            return False  # it is not reached: in x > 0 and sqrt(x) < 1, where x < 0
        return bool(
            {"<": left < right, ">": left > right, r"\ge": left >= right, r"\le": left <= right}[sign]
        )


def verbatim(token: str) -> str:
    """The letters of a name that is written out."""
    return token.removeprefix(r"\mathrm{").removesuffix("}").replace("\\", "")


def letters(text: str) -> str:
    """The letters, digits and commas of a symbol, with a line before indices."""
    return re.sub(r"\\mathrm|[\\{}]", "", text).replace("_", "|")
