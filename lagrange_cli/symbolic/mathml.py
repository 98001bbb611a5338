"""MathML: the notation, and the equations as a part of a web page. All text in it is escaped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from lagrange_cli.expression.vocabulary import dotted
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.indexed.conditions import Condition, Joined, Loop
from lagrange_cli.symbolic.indexed.whole import number
from lagrange_cli.symbolic.notations import GREEK, MEMBER, component, split_index
from lagrange_cli.symbolic.render import Level, Notation
from lagrange_cli.symbolic.report import sections
from lagrange_cli.symbolic.statements import Section, Statement

FUNCTIONS = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "log": "ln", "sign": "sgn"}
APPLY, TIMES = "<mo>&#x2061;</mo>", "<mo>&#x2062;</mo>"
"""The invisible operators between a function and its argument, and between factors."""
NUMBER = re.compile(r"<mn>[^<]*</mn>")
BETWEEN = re.compile(r"(<[^>]*>[^<]*</m[ion]>|<[^>]*>)|([^<\s]+)")
WHOLE = re.compile(rf"(\d+)|({MEMBER})|(//|\*\*|[-+*%(),])")
SIGNS = {"-": "−", "*": "⋅", "**": "^", "%": "mod"}
RELATIONS = {"==": "=", "!=": "≠", "<=": "≤", ">=": "≥"}
LONGEST = 100_000
"""Characters of MathML that a page takes; further sections are left out."""


def operator(sign: str) -> str:
    """A sign."""
    return f"<mo>{escape(sign)}</mo>"


def with_dots(text: str, dots: int) -> str:
    """A symbol with dots above it, if any."""
    return f'<mover accent="true">{text}<mo>{"˙" if dots == 1 else "¨"}</mo></mover>' if dots else text


def row(*parts: str) -> str:
    """Parts that belong together."""
    return f"<mrow>{''.join(parts)}</mrow>"


class MathML(Notation):
    """Presentation MathML (MathML Core)."""

    plus, minus, negative, becomes = map(operator, "+−−→")
    pi = "<mi>π</mi>"
    powers_of_functions = functions_last = bars_enclose = True
    powers_of_ten = powers_of_e = True

    def symbol(self, name: str) -> str:
        if name.startswith("("):  # a whole number
            return self.parentheses(self.whole(name[1:-1]))
        bare, dots = dotted(component(name))
        stem, indices = split_index(bare)
        letter = GREEK.get(stem, stem)
        text = f"<mi>{escape(letter)}</mi>"
        text = with_dots(text, dots)
        if indices:
            below = operator(",").join(self.index(index) if index else "" for index in indices)
            text = f"<msub>{text}{row(below)}</msub>"
        return text

    def verbatim(self, name: str) -> str:
        bare, dots = dotted(name)
        return with_dots(f"<mi>{escape(bare)}</mi>", dots)

    def index(self, text: str) -> str:
        """An index: a name, a number, or one that is computed."""
        return self.name(text) if re.fullmatch(rf"\d+|{MEMBER}", text) else self.whole(text)

    def whole(self, text: str) -> str:
        """A whole number that is computed of indices and sizes."""
        found = []
        for digits, name, sign in WHOLE.findall(text):
            if name:
                found.append(self.symbol(name))
            else:
                found.append(f"<mn>{digits}</mn>" if digits else operator(SIGNS.get(sign, sign)))
        return row(*found)

    summand, sum_level = Level.PRODUCT, Level.POWER

    def summed(self, body: str, loops: Sequence[Loop]) -> str:
        return row(*map(self.sign, loops), numbered(body))

    def sign(self, loop: Loop) -> str:
        """The sign of a sum with its bounds, and conditions below it."""
        start, last = (self.whole(one.text) for one in (loop.start, loop.stop + number(-1)))
        below = [row(self.symbol(loop.index), operator("="), start), *map(self.condition, loop.conditions)]
        if loop.step != 1:
            below[0] = row(below[0], self.going_on(loop))
        lines = "".join(f"<mtr><mtd>{one}</mtd></mtr>" for one in below)
        under = below[0] if len(below) == 1 else f"<mtable>{lines}</mtable>"
        return f"<munderover>{operator('∑')}{under}{last}</munderover>"

    def going_on(self, loop: Loop) -> str:
        """The second value of an index, and dots."""
        return (
            operator(",") + self.whole((loop.start + number(loop.step)).text) + operator(",") + operator("…")
        )

    def members(self, loops: Sequence[Loop]) -> str:
        said = []
        for loop in loops:
            start, last = (self.whole(one.text) for one in (loop.start, loop.stop + number(-1)))
            more = operator(",") + operator("…") if loop.step == 1 else self.going_on(loop)
            said.append(row(self.symbol(loop.index), operator("="), start, more, operator(","), last))
            said += map(self.condition, loop.conditions)
        return ", ".join(f"<math>{one}</math>" for one in said)

    def condition(self, condition: Condition) -> str:
        """A condition on indices."""
        if isinstance(condition, Joined):
            parts = [self.condition(one) for one in condition.parts]
            if condition.operator == "not":
                return row("<mtext>not&#xA0;</mtext>", self.parentheses(parts[0]))
            return row(self.joined(parts, condition.operator))
        text = self.whole(condition.operands[0].text)
        for sign, operand in zip(condition.operators, condition.operands[1:]):
            text += operator(RELATIONS.get(sign, sign)) + self.whole(operand.text)
        return row(text)

    def decimal(self, digits: str) -> str:
        mantissa, _, exponent = digits.partition("e")
        text = f"<mn>{mantissa}</mn>"
        if not exponent:
            return text
        return row(text, operator("·"), f"<msup><mn>10</mn><mn>{int(exponent)}</mn></msup>")

    def product(self, factors: Sequence[str]) -> str:
        factors = [f"<mn>{one}</mn>" if one.isdigit() else one for one in factors]
        text = factors[0]
        for one in factors[1:]:
            text += (operator("·") if NUMBER.match(one) else TIMES) + one
        return row(text)

    def fraction(self, numerator: Sequence[str], denominator: Sequence[str]) -> tuple[str, Level]:
        return (
            f"<mfrac>{self.product([*numerator] or ['1'])}{self.product(denominator)}</mfrac>",
            Level.PRODUCT,
        )

    def power(self, base: str, exponent: str) -> str:
        return f"<msup>{row(base)}{row(numbered(exponent))}</msup>"

    def root(self, text: str) -> str:
        return f"<msqrt>{numbered(text)}</msqrt>"

    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        listed = operator(",").join(map(numbered, arguments))
        if function == "abs":
            bars = row('<mo stretchy="true">|</mo>', listed, '<mo stretchy="true">|</mo>')
            return self.power(bars, exponent) if exponent else bars
        if function == "e":
            return f"<msup><mi>e</mi>{row(listed)}</msup>"
        name = f"<mi>{escape(FUNCTIONS.get(function, function))}</mi>"
        raised = f"<msup>{name}{row(numbered(exponent))}</msup>" if exponent else name
        single = re.fullmatch(
            r"<mi>[^<]*</mi>|<msub><mi>[^<]*</mi><mrow>(?:(?!<mrow>).)*</mrow></msub>", listed
        )
        return row(raised, APPLY, listed if single else self.parentheses(listed))

    def relation(self, left: str, sign: str, right: str) -> str:
        return row(numbered(left), operator({">=": "≥", "<=": "≤"}.get(sign, sign)), numbered(right))

    def joined(self, conditions: Sequence[str], word: str) -> str:
        return f"<mtext>&#xA0;{word}&#xA0;</mtext>".join(conditions)

    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        rows = [
            f"<mtr><mtd>{numbered(value)}</mtd><mtd><mtext>if&#xA0;</mtext>{condition}</mtd></mtr>"
            for value, condition in pieces
        ]
        rows.append(f"<mtr><mtd>{numbered(otherwise)}</mtd><mtd><mtext>otherwise</mtext></mtd></mtr>")
        return row('<mo stretchy="true">{</mo>', f"<mtable>{''.join(rows)}</mtable>")

    def parentheses(self, text: str) -> str:
        return row("<mo>(</mo>", numbered(text), "<mo>)</mo>")

    def rate(self, text: str) -> str:
        return row("<mfrac><mi>d</mi>", row("<mi>d</mi><mi>t</mi>"), "</mfrac>", text)

    def transposed(self, text: str) -> str:
        return f"<msup>{text}<mi>T</mi></msup>"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = "".join(
            "<mtr>" + "".join(f"<mtd>{numbered(one)}</mtd>" for one in entries) + "</mtr>" for entries in rows
        )
        return row("<mo>(</mo>", f"<mtable>{body}</mtable>", "<mo>)</mo>")

    def inline(self, formula: str) -> str:
        """Names are elements already, signs between them become some."""
        return f"<math>{BETWEEN.sub(lambda found: found[1] or operator(found[2]), formula)}</math>"

    def words(self, text: str) -> str:
        return escape(text)


def numbered(text: str) -> str:
    """Bare digits as a number."""
    return f"<mn>{text}</mn>" if text.isdigit() else text


def as_mathml(equations: Equations, form: str = "lagrange") -> str:
    """A fragment of a page: a section each for L, p_k and so on, as many as are not too long together."""
    return fragment(sections(equations, form, MathML()))


def fragment(content: Sequence[Section]) -> str:
    """Sections as a fragment of a page, likewise."""
    found, size = list[str](), 0
    for section in content:
        lines = [line(one, verbal=section.verbal) for one in section.statements]
        text = "".join(lines)
        if size + len(text) > LONGEST:
            text = "<p>Too long for a page: lagrange equations prints them.</p>"
        found.append(f"<section><h3>{escape(section.title)}</h3>{text}</section>")
        size += len(text)
    return "".join(found)


def line(statement: Statement, *, verbal: bool) -> str:
    """A formula and its remark; within a sentence where that is ``verbal``."""
    sides = [numbered(one) for one in (statement.left, statement.right) if one]
    formula = operator("=").join(sides)
    if verbal:
        shown = [f"<math>{formula}</math>"] if formula else []
        return f"<p>{': '.join([*shown, *([statement.remark] if statement.remark else [])])}</p>"
    remark = f"<span>{statement.remark}</span>" if statement.remark else ""
    return f'<p class="formula"><math display="block">{formula}</math>{remark}</p>'
