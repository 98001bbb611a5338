"""LaTeX with the package amsmath: the notation, and pages whose long formulas are broken over lines."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lagrange_cli.expression.vocabulary import dotted
from lagrange_cli.records import replace
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.indexed.conditions import Condition, Joined, Loop
from lagrange_cli.symbolic.indexed.whole import number
from lagrange_cli.symbolic.latex_lines import SIGN, WIDTH, broken, is_sum, width
from lagrange_cli.symbolic.notations import GREEK, MEMBER, component, multiplied, split_index
from lagrange_cli.symbolic.render import Level, Notation
from lagrange_cli.symbolic.report import sections
from lagrange_cli.symbolic.statements import Section, Statement

FUNCTIONS = {
    "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "log": r"\ln",
    "atan2": r"\operatorname{atan2}", "sign": r"\operatorname{sgn}",
}  # fmt: skip
WHOLE = {
    "%": r"\bmod", "//": r"\mathbin{/\!/}", "*": r"\,",
    "min": r"\min", "max": r"\max", "abs": r"\operatorname{abs}",
}  # fmt: skip
RELATIONS = {"==": "=", "!=": r"\ne", "<=": r"\le", ">=": r"\ge"}
BREAK = r" \\ "
SINGLE = r"(?:[^\W\d_]|\\[a-zA-Z]+)(?:_\{[^{}]*\})?"
"""An argument that needs no parentheses."""
CALL = re.compile(rf"^(\\[a-zA-Z{{}}]+(?:\^\{{.*\}})?) ({SINGLE})$")
"""A function with such an argument; before a sum, it gets them: the sum would seem to belong to it."""
LETTERS = {letter: rf"\{name}" for name, letter in GREEK.items()}


class Latex(Notation):
    """LaTeX for a displayed formula."""

    pi, becomes = r"\pi", r" \to "
    powers_of_functions = functions_last = bars_enclose = True
    powers_of_ten = powers_of_e = True

    def symbol(self, name: str) -> str:
        if name.startswith("("):  # a whole number
            return self.parentheses(self.whole(name[1:-1]))
        bare, dots = dotted(component(name))
        stem, indices = split_index(bare)
        text = LETTERS.get(stem, rf"\{stem}" if stem in GREEK else stem)
        if len(stem) > 1 and not stem.isdigit() and stem not in GREEK:
            text = rf"\mathrm{{{escaped(stem)}}}"
        text = with_dots(text, dots)
        if indices:
            text += "_{" + ",".join(self.index(index) for index in indices) + "}"
        return text

    def verbatim(self, name: str) -> str:
        bare, dots = dotted(name)
        return with_dots(rf"\mathrm{{{escaped(bare)}}}", dots)

    def index(self, text: str) -> str:
        """An index: a name, a number, or one that is computed."""
        return self.name(text) if re.fullmatch(rf"\d+|{MEMBER}", text) else self.whole(text)

    def whole(self, text: str) -> str:
        """A whole number that is computed of indices and sizes."""
        text = re.sub(rf"\*\*({MEMBER}|\d+|\([^()]*\))", r"^{\1}", text)
        parts = re.split(rf"({MEMBER}|//|[%*])", text)
        parts[1::2] = [WHOLE.get(one) or self.symbol(one) for one in parts[1::2]]
        return "".join(parts)

    def summed(self, body: str, loops: Sequence[Loop]) -> str:
        signs = "".join(map(self.sign, loops))
        return f"{signs} {body}"

    summand, sum_level = Level.PRODUCT, Level.POWER

    def sign(self, loop: Loop) -> str:
        """The sign of a sum with its bounds, and conditions below it."""
        index, start = self.symbol(loop.index), self.whole(loop.start.text)
        rows = [f"{index} = {start}"]
        if loop.step != 1:
            rows[0] += rf",\, {self.whole((loop.start + number(loop.step)).text)},\, \dots"
        rows += map(self.condition, loop.conditions)
        below = rows[0] if len(rows) == 1 else rf"\substack{{{BREAK.join(rows)}}}"
        last = loop.stop + number(-1)
        return rf"\sum_{{{below}}}^{{{self.whole(last.text)}}}"

    def members(self, loops: Sequence[Loop]) -> str:
        said = []
        for loop in loops:
            last = self.whole((loop.stop + number(-1)).text)
            said.append(rf"{self.symbol(loop.index)} = {self.whole(loop.start.text)}, \dots, {last}")
            said += map(self.condition, loop.conditions)
        return ", ".join(f"${one}$" for one in said)

    def condition(self, condition: Condition) -> str:
        """A condition on indices."""
        if isinstance(condition, Joined):
            parts = [self.condition(one) for one in condition.parts]
            if condition.operator == "not":
                return rf"\text{{not }} ({parts[0]})"
            return rf" \text{{ {condition.operator} }} ".join(parts)
        text = self.whole(condition.operands[0].text)
        for operator, operand in zip(condition.operators, condition.operands[1:]):
            text += f" {RELATIONS.get(operator, operator)} {self.whole(operand.text)}"
        return text

    def decimal(self, digits: str) -> str:
        mantissa, _, exponent = digits.partition("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else digits

    def product(self, factors: Sequence[str]) -> str:
        enclosed = [
            CALL.sub(r"\1(\2)", one) if following.startswith(r"\sum") else one
            for one, following in zip(factors, [*factors[1:], ""])
        ]
        return multiplied(enclosed, r" \cdot ")

    def fraction(self, numerator: Sequence[str], denominator: Sequence[str]) -> tuple[str, Level]:
        """A fraction; factors that are too wide for the numerator, or divided by a number only, follow it."""
        beside: list[str] = []
        above = list(numerator)
        if all(map(str.isdigit, denominator)):
            above = [factor for factor in numerator if factor.isdigit()]
            beside = [factor for factor in numerator if not factor.isdigit()]
        elif width(self.product(numerator)) > WIDTH / 2:
            beside = [max(numerator, key=width)]
            above.remove(beside[0])
        if len(beside) == 1 and len(numerator) == 1:
            beside = [self.parentheses(beside[0]) if is_sum(beside[0]) else beside[0]]
        bar = rf"\frac{{{self.product(above) or '1'}}}{{{self.product(denominator)}}}"
        return self.product([bar, *beside]), Level.PRODUCT

    def power(self, base: str, exponent: str) -> str:
        return f"{base}^{{{exponent}}}"

    def root(self, text: str) -> str:
        return rf"\sqrt{{{text}}}"

    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        if function == "abs":
            bars = rf"\left|{arguments[0]}\right|"
            return self.power(bars, exponent) if exponent else bars
        if function == "e":
            return rf"e^{{{arguments[0]}}}"
        name = FUNCTIONS.get(function, f"\\{function}")
        raised = f"{name}^{{{exponent}}}" if exponent else name
        if len(arguments) == 1 and re.fullmatch(SINGLE, arguments[0]):
            return f"{raised} {arguments[0]}"
        return raised + self.parentheses(", ".join(arguments))

    def relation(self, left: str, sign: str, right: str) -> str:
        return super().relation(left, {">=": r"\ge", "<=": r"\le"}.get(sign, sign), right)

    def joined(self, conditions: Sequence[str], word: str) -> str:
        return rf" \text{{ {word} }} ".join(conditions)

    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        rows = [rf"{value} & \text{{if }} {condition} \\ " for value, condition in pieces]
        return rf"{{\begin{{cases}} {''.join(rows)}{otherwise} & \text{{otherwise}} \end{{cases}}}}"

    def parentheses(self, text: str) -> str:
        tall = r"\frac" in text or r"\begin{cases}" in text or r"\left(" in text
        return rf"\left({text}\right)" if tall else f"({text})"

    def rate(self, text: str) -> str:
        return rf"\frac{{d}}{{dt}} {text}"

    def transposed(self, text: str) -> str:
        return f"{text}^{{T}}"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = r" \\ ".join(" & ".join(row) for row in rows)
        return rf"\begin{{pmatrix}} {body} \end{{pmatrix}}"

    def inline(self, formula: str) -> str:
        return f"${formula}$"

    def words(self, text: str) -> str:
        return escaped(text)


def as_latex(equations: Equations, form: str) -> str:
    """A fragment for a document that uses amsmath: a section each for L, p_k and so on."""
    return blocks(equations.name, sections(equations, form, Latex()))


def blocks(name: str, content: Sequence[Section]) -> str:
    """The sections in sequence."""
    found = [f"% {' '.join(name.split())}", r"% This needs \usepackage{amsmath}."]
    for section in content:
        found.append(rf"\paragraph{{{section.title}}}")
        found += listed(section) if section.verbal else aligned(section)
    return "\n".join(found)


def as_display(equations: Equations, form: str) -> str:
    """The formulas as one display, as notebooks show it."""
    return displayed(sections(equations, form, Latex()))


def displayed(content: Sequence[Section]) -> str:
    """Sections as one display, without those of sentences."""
    rows: list[str] = []
    for section in content:
        if not section.verbal:
            at_margin = any(width(each.left + each.remark) > WIDTH for each in section.statements)
            rows.append(rf"  &\textbf{{{section.title}}}")
            rows += [row for each in section.statements for row in rows_of(each, at_margin=at_margin)]
    return "\n".join([r"$$\begin{aligned}", " \\\\\n".join(rows), r"\end{aligned}$$"])


def listed(section: Section) -> list[str]:
    """A list of sentences."""
    return [r"\begin{itemize}", *map(item, section.statements), r"\end{itemize}"]


def item(statement: Statement) -> str:
    """One item of the list: a formula and its remark."""
    formula = " = ".join(filter(None, (statement.left, statement.right)))
    if width(formula) > WIDTH:
        rows = " \\\\\n".join(rows_of(replace(statement, remark=""), at_margin=True))
        return f"  \\item\n  \\begin{{align*}}\n{rows}\n  \\end{{align*}}\n  {statement.remark}"
    return f"  \\item {': '.join(filter(None, (formula and f'${formula}$', statement.remark)))}"


def aligned(section: Section) -> list[str]:
    """Formulas aligned at their equals signs, or at the left margin if some left sides are too long."""
    at_margin = any(width(each.left + each.remark) > WIDTH for each in section.statements)
    rows = [" \\\\\n".join(rows_of(each, at_margin=at_margin)) for each in section.statements]
    return [r"\begin{align*}", " \\\\\n".join(rows), r"\end{align*}"]


def rows_of(statement: Statement, *, at_margin: bool) -> list[str]:
    """The rows of an align* that a formula takes, followed by the remark in parentheses."""
    if at_margin:
        first, *others = broken(f"{statement.left} = {statement.right}", WIDTH)
        rows = [f"  & {first}"]
    else:
        first, *others = broken(statement.right, WIDTH - width(statement.left) - SIGN)
        rows = [f"  {statement.left} &= {first}"]
    rows = [*rows, *(f"  &\\quad {{}}{line}" for line in others)]
    if statement.remark:
        remark = rf"\text{{({statement.remark})}}"
        if at_margin:
            rows.append(f"  &\\quad {remark}")
        else:
            rows[-1] += f" && {remark}"
    return rows


def with_dots(text: str, dots: int) -> str:
    """A symbol with dots above it, if any."""
    return rf"\{'d' * dots}ot{{{text}}}" if dots else text


def escaped(text: str) -> str:
    """Plain words inside LaTeX."""
    text = re.sub(r"[&%$#_{}]", lambda letter: f"\\{letter[0]}", text.replace("\\", "/"))
    return text.replace("~", r"\textasciitilde{}").replace("^", r"\textasciicircum{}").replace("--", "-{}-")
