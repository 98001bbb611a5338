"""The content of pages: sections of statements, in some notation."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import sympy

from lagrange_cli.expression.vocabulary import CALLABLE, dotted
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.equations import Equation, Equations
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.render import Level, Notation, Renderer

KINDS = {True: "", False: ", nonholonomic"}
"""The remark for a constraint, by whether it is holonomic."""

REDUNDANT = "which depends on the others"
"""The remark for a constraint that is left out."""

_NAME = re.compile(r"[^\W\d]\w*(?:\[[^\]]*\])?")


def plain(sentence: str) -> str:
    """The sentence without the backticks around its formulas."""
    return sentence.replace("`", "")


@dataclass(frozen=True)
class Statement:
    """``left = right`` and a remark, as text in some notation; ``left`` and ``right`` may be empty."""

    left: str
    right: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Section:
    """A title and its statements; ``verbal`` where these are sentences, not formulas."""

    title: str
    statements: tuple[Statement, ...]
    verbal: bool = False


def alike(notation: Notation, order: Order) -> frozenset[str]:
    """The names that would look like another one in a notation, such as x_1 beside x1, or like a function or
    the number pi, such as sin_ and pi_.

    Of names that look the same one is not among them: one that cannot look otherwise, or a coordinate.
    """
    moving = {symbol.name for symbol, (role, _) in order.ranks.items() if role >= Role.COORDINATE}
    shown: dict[str, list[str]] = {}
    for symbol in order.ranks:
        shown.setdefault(notation.symbol(symbol.name), []).append(symbol.name)

    def first(name: str) -> tuple[bool, bool, bool]:
        return notation.verbatim(name) != notation.symbol(name), name not in moving, "_" in dotted(name)[0]

    taken = {notation.pi, *map(notation.symbol, CALLABLE)}
    others = [sorted(names, key=first)[text not in taken :] for text, names in shown.items()]
    return frozenset(name for names in others for name in names)


class Writer:
    """Expressions, symbols and derivatives in one notation."""

    def __init__(self, notation: Notation, order: Order) -> None:
        self.notation, self.order = notation, order
        notation.literal |= alike(notation, order)
        self.renderer = Renderer(notation, order)

    def text(self, expression: sympy.Expr) -> str:
        """An expression."""
        return self.renderer.at(expression, Level.SUM)

    def names(self, quantity: str) -> str:
        """``p_theta`` or ``T + U``: names with plus signs between them."""
        return self.notation.plus.join(self.notation.name(name) for name in quantity.split(" + "))

    def rate(self, quantity: str) -> str:
        """The time derivative of a quantity."""
        text = self.names(quantity)
        return self.notation.rate(self.notation.parentheses(text) if " + " in quantity else text)

    def prose(self, sentence: str) -> str:
        """A sentence with formulas between backticks, such as `h = T + U`: names joined by signs."""

        symbol, inline, words = self.notation.name, self.notation.inline, self.notation.words
        parts = sentence.split("`")
        parts[::2] = [words(part) for part in parts[::2]]
        parts[1::2] = [inline(_NAME.sub(lambda name: symbol(name[0]), part)) for part in parts[1::2]]
        return "".join(parts)

    def statement(self, name: str, expression: sympy.Expr) -> Statement:
        """``name = expression``, with a remark where the file has another quantity of this name."""
        return Statement(self.names(name), self.text(expression), self._namesake(name, expression))

    def _namesake(self, name: str, expression: sympy.Expr) -> str:
        """That a length L, for example, is not the Lagrangian L that contains it."""
        shown = self.notation.name
        own = next((one for one in expression.free_symbols if shown(str(one)) == shown(name)), None)
        if own is None:
            return ""
        role, _ = self.order.ranks.get(own, (Role.PARAMETER, 0))
        return self.prose(f"`{name}` on the right is the {role.name.lower()}")


def named_section(
    title: str, symbols: Sequence[sympy.Expr | str], values: Sequence[sympy.Expr], writer: Writer
) -> Section:
    """A value for each symbol."""
    pairs = zip(symbols, values, strict=True)
    return Section(title, tuple(writer.statement(str(symbol), value) for symbol, value in pairs))


def lagrangian_section(T: sympy.Expr | None, U: sympy.Expr | None, L: sympy.Expr, writer: Writer) -> Section:
    """The energies that are known, and L."""
    known = (("T", T), ("U", U), ("L", L))
    return Section("Lagrangian", tuple(writer.statement(name, one) for name, one in known if one is not None))


def constraint_sections(
    equations: Equations,
    writer: Writer,
    expressions: Sequence[sympy.Expr] | None = None,
    *,
    acting: bool = False,
) -> list[Section]:
    """The constraints, as they are or as other ``expressions``, or those that are ``acting``: without
    equations of motion. No section where there are none."""
    given = equations.constraints
    shown = [each.expression for each in given] if expressions is None else expressions
    statements = tuple(
        Statement(writer.text(one), "0", writer.notation.words(each.name + KINDS[each.holonomic]))
        for each, one in zip(given, shown, strict=True)
        if each.acts or not acting
    )
    statements += tuple(
        Statement(writer.text(one), "0", writer.notation.words(f"{name}, {REDUNDANT}"))
        for name, one in equations.redundant.items()
        if expressions is None or one.free_symbols.isdisjoint(equations.v)
    )
    return [Section("Constraints", statements)] if statements else []


def equation_statements(
    names: Sequence[str], written: Sequence[Equation], writer: Writer
) -> Iterable[Statement]:
    """Equations by coordinate, each with the factor by which it has been divided or multiplied, if any."""
    for name, equation in zip(names, written, strict=True):
        remark = writer.prose(f"`{name}`")
        if equation.factor != 1:
            numerator, denominator = sympy.fraction(equation.factor)
            small = abs(numerator) == 1 and denominator != 1
            word, factor = ("multiplied", 1 / equation.factor) if small else ("divided", equation.factor)
            remark += f", {word} by {writer.notation.inline(writer.text(factor))}"
        yield Statement(writer.text(equation.left), writer.text(equation.right), remark)


def multiplier_sections(equations: Equations, values: Sequence[sympy.Expr], writer: Writer) -> list[Section]:
    """The multipliers that may differ from 0; no section where there are none."""
    pairs = zip(equations.constraints, values, strict=True)
    statements = tuple(writer.statement(str(each.multiplier), value) for each, value in pairs if each.acts)
    return [Section("Multipliers", statements)] if statements else []
