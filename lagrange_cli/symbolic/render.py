"""An expression as a line of text, in the order of a textbook: one walk for every notation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import IntEnum
from fractions import Fraction

import sympy

from lagrange_cli.errors import NotReal
from lagrange_cli.expression.symbolic_switches import Absolute, Switch
from lagrange_cli.expression.vocabulary import dotted
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import Summed
from lagrange_cli.symbolic.order import Order, base_and_exponent, digits_of, is_negative, reads_as_fraction
from lagrange_cli.symbolic.work import charge

STEPS_A_PIECE = 10
"""The work of writing a term or factor."""


class Level(IntEnum):
    """The precedence of a piece of text; pieces of lower precedence get parentheses."""

    SUM = 0
    PRODUCT = 1
    POWER = 2
    ATOM = 3


class Notation(ABC):
    """How one format writes numbers, names, products, fractions, powers and functions."""

    plus, minus = " + ", " - "
    negative = "-"
    becomes = " -> "

    literal: frozenset[str] = frozenset()
    """Names that are shown as they are, since others would look the same."""

    def name(self, name: str) -> str:
        """A name: a parameter, a coordinate, a velocity ``theta_dot``, an acceleration ``theta_ddot``."""
        shown_as_is = name in self.literal or dotted(name)[0] in self.literal
        return self.verbatim(name) if shown_as_is else self.symbol(name)

    @abstractmethod
    def symbol(self, name: str) -> str:
        """A name in the letters, indices and dots of the notation."""

    def verbatim(self, name: str) -> str:
        """A name, letter by letter, but for its dots."""
        return name

    @abstractmethod
    def decimal(self, digits: str) -> str:
        """A decimal number such as ``9.81`` or ``6.674e-11``."""

    @abstractmethod
    def product(self, factors: Sequence[str]) -> str:
        """Factors, each of level POWER at least."""

    @abstractmethod
    def fraction(self, numerator: Sequence[str], denominator: Sequence[str]) -> tuple[str, Level]:
        """A quotient of two products; an empty numerator is 1."""

    @abstractmethod
    def power(self, base: str, exponent: str) -> str:
        """A power; ``base`` is of level ATOM, ``exponent`` any text."""

    @abstractmethod
    def root(self, text: str) -> str:
        """A square root."""

    @abstractmethod
    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        """A function's value, raised to ``exponent`` if there is one."""

    def relation(self, left: str, sign: str, right: str) -> str:
        """A comparison, by one of < <= > >=."""
        return f"{left} {sign} {right}"

    def joined(self, conditions: Sequence[str], word: str) -> str:
        """Conditions with ``and`` or ``or`` between them."""
        return f" {word} ".join(conditions)

    @abstractmethod
    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        """Values with their conditions, the first one that holds, and a value where none holds."""

    def summed(self, body: str, loops: Sequence[Loop]) -> str:
        """A sum over indices; ``body`` is of level ``summand``."""
        return self.call("sum", [body + self.words(f" {' '.join(one.text for one in loops)}")])

    def members(self, loops: Sequence[Loop]) -> str:
        """For which members something holds, in words."""
        return self.words(" ".join(one.text for one in loops))

    summand, sum_level = Level.SUM, Level.ATOM
    """The level of what is summed, and of a sum over indices."""

    @abstractmethod
    def parentheses(self, text: str) -> str:
        """``(text)``."""

    @abstractmethod
    def rate(self, text: str) -> str:
        """The time derivative of the quantity ``text``."""

    @abstractmethod
    def transposed(self, text: str) -> str:
        """The transpose of the matrix ``text``, a letter."""

    @abstractmethod
    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """A matrix; a column is a matrix of one column."""

    def whole(self, text: str) -> str:
        """An index that is computed."""
        return text

    def inline(self, formula: str) -> str:
        """A formula in this notation as part of a sentence."""
        return formula

    def words(self, text: str) -> str:
        """Plain words."""
        return text

    pi: str
    """The circle constant."""

    powers_of_functions = False
    """Whether an exponent is written at the function's name: sin^2(x)."""

    functions_last = False
    """Whether functions follow all other factors, as is necessary if their arguments have no parentheses."""

    powers_of_ten = False
    """Whether a very large or small decimal number is a product with a power of 10: 1.5 10^-9."""

    powers_of_e = False
    """Whether exp(x) is a power of e, where e is not the name of something else: its function is then "e"."""

    bars_enclose = False
    """Whether the bar of a fraction makes parentheses around numerator and denominator unnecessary."""


def render(expression: sympy.Expr, notation: Notation, order: Order) -> str:
    """The expression in the given notation."""
    return Renderer(notation, order).at(expression, Level.SUM)


class Renderer:
    """The traversal of an expression: every method returns a text and its precedence."""

    def __init__(self, notation: Notation, order: Order) -> None:
        self.notation = notation
        self.order = order
        others = (notation.name(symbol.name) for symbol in order.ranks)
        power = notation.powers_of_e and notation.symbol("e") not in others
        self.exponential = "e" if power else "exp"
        """What the function exp is called."""

    def at(self, expression: sympy.Expr, level: Level) -> str:
        """The text, in parentheses if its precedence is below ``level``."""
        text, own = self.piece(expression)
        return text if own >= level else self.notation.parentheses(text)

    def piece(self, expression: sympy.Expr) -> tuple[str, Level]:
        """The text and precedence of an expression."""
        charge(STEPS_A_PIECE)
        if expression.is_Add:
            return self.sum(expression), Level.SUM
        if is_negative(expression):
            return self.notation.negative + self.at(negated(expression), Level.PRODUCT), Level.SUM
        if expression.is_Symbol:
            return self.notation.name(expression.name), Level.ATOM
        if expression.is_Rational or expression.is_Mul:
            return self.quotient(expression)
        if expression.is_Pow and expression.exp.is_Rational:
            return self.quotient(expression) if expression.exp.is_negative else self.power(expression)
        if expression.is_Pow:
            return self.raised(expression.base, self.at(expression.exp, Level.SUM))
        if isinstance(expression, Switch):
            return self.cases(expression), Level.ATOM
        if isinstance(expression, Summed):
            notation = self.notation
            return notation.summed(
                self.at(expression.body, notation.summand), expression.loops
            ), notation.sum_level
        if expression.is_Function:
            return self.call(expression), Level.ATOM
        if expression is sympy.E:
            return self.notation.call(self.exponential, ["1"]), Level.ATOM
        if expression is sympy.pi:
            return self.notation.pi, Level.ATOM
        raise NotReal(
            "the equations of motion contain the logarithm or a fractional power of a negative number",
            "look for a negative number raised to a power that varies, as in (-2)**x",
        )

    def sum(self, expression: sympy.Expr) -> str:
        """Terms with their signs between them."""
        first, *others = self.order.sorted_terms(expression)
        text = self.at(first, Level.SUM)
        for term in others:
            sign = self.notation.minus if is_negative(term) else self.notation.plus
            text += sign + self.at(negated(term) if is_negative(term) else term, Level.PRODUCT)
        return text

    def quotient(self, expression: sympy.Expr) -> tuple[str, Level]:
        """A product, with negative powers in the denominator."""
        above: list[sympy.Expr] = []
        below: list[sympy.Expr] = []
        number = Fraction(1)
        for factor in sympy.Mul.make_args(expression):
            base, exponent = base_and_exponent(factor)
            if factor.is_Rational:
                number *= Fraction(int(factor.p), int(factor.q))
            elif exponent.is_Rational and exponent.is_negative:
                below.append(base**-exponent)
            else:
                above.append(factor)
        front, bottom = self.number(number)
        above.sort(key=self.factor_key)
        below.sort(key=self.factor_key)
        if len(above) == 1 and not front and not bottom and not below:
            return self.piece(above[0])
        numerator = front + self.factors(above, alone=not front and bool(below or bottom))
        denominator = bottom + self.factors(below, alone=not bottom)
        if denominator:
            return self.notation.fraction(numerator, denominator)
        if len(numerator) > 1 or (self.notation.powers_of_ten and "e" in digits_of(number)):
            return self.notation.product(numerator), Level.PRODUCT
        return (numerator or ["1"])[0], Level.ATOM

    def factors(self, factors: Sequence[sympy.Expr], *, alone: bool) -> list[str]:
        """Each factor as text; ``alone`` means that it is the only one in its part of the fraction."""
        enclosed = alone and len(factors) == 1 and self.notation.bars_enclose
        return [self.at(factor, Level.SUM if enclosed else Level.POWER) for factor in factors]

    def factor_key(self, factor: sympy.Expr) -> tuple[object, ...]:
        base = base_and_exponent(factor)[0]
        return (self.notation.functions_last and self.has_name(base), *self.order.factor_key(base))

    def has_name(self, expression: sympy.Expr) -> bool:
        """Whether the name of a function is written before its arguments, or the sign of a sum."""
        enclosed = isinstance(expression, Switch | Absolute)
        power = expression.func is sympy.exp and self.exponential == "e"
        return bool(expression.is_Function) and not (enclosed or power)

    def number(self, value: Fraction) -> tuple[list[str], list[str]]:
        """The factors of a positive rational in numerator and denominator: 2 below for 1/2, 9.81 above."""
        if value == 1:
            return [], []
        if value.denominator == 1 and value.numerator < 10**15:
            return [str(value.numerator)], []
        if not reads_as_fraction(value, self.order.decimals):
            return [self.notation.decimal(digits_of(value))], []
        return ([] if value.numerator == 1 else [str(value.numerator)]), [str(value.denominator)]

    def power(self, expression: sympy.Expr) -> tuple[str, Level]:
        """A positive rational power."""
        base, exponent = expression.base, expression.exp
        if exponent == sympy.Rational(1, 2):
            return self.notation.root(self.at(base, Level.SUM)), Level.ATOM
        if base.is_Add and exponent.is_even and self.order.is_reversed(base):
            base = sympy.Add(*(-term for term in base.args))
        return self.raised(base, self.at(exponent, Level.SUM))

    def raised(self, base: sympy.Expr, exponent: str) -> tuple[str, Level]:
        if self.notation.powers_of_functions and base.is_Function and not isinstance(base, Switch | Summed):
            return self.call(base, exponent), Level.POWER
        return self.notation.power(self.at(base, Level.ATOM), exponent), Level.POWER

    def cases(self, expression: Switch) -> str:
        """Switches in one another's second branches are cases, one by one."""
        pieces = []
        while isinstance(expression, Switch):
            condition, above, expression = self.condition(expression)
            pieces.append((self.at(above, Level.SUM), condition))
        return self.notation.cases(pieces, self.at(expression, Level.SUM))

    def condition(self, switch: Switch) -> tuple[str, sympy.Expr, sympy.Expr]:
        """A condition, the value where it holds, and that where it does not: switches that share a branch
        have one."""
        conditions, word = [self.relation(switch)], ""
        _, above, below, _ = switch.args
        while word != "or" and isinstance(above, Switch) and above.args[2] == below:
            conditions.append(self.relation(above))
            word, above = "and", above.args[1]
        while word != "and" and isinstance(below, Switch) and below.args[1] == above:
            conditions.append(self.relation(below))
            word, below = "or", below.args[2]
        return self.notation.joined(conditions, word), above, below

    def relation(self, switch: Switch) -> str:
        """The condition of one switch, without minus signs where terms can be on the other side."""
        u, _, _, at = switch.args
        terms = sympy.Add.make_args(u)
        right = [negated(term) for term in terms if is_negative(term)]
        left = [term for term in terms if not is_negative(term)]
        sides = [
            sympy.Add(*side, evaluate=False) if len(side) > 1 else sympy.Add(*side) for side in (left, right)
        ]
        sign = ">=" if at == 1 else ">"
        if sides[0].is_number and not sides[1].is_number:
            sides, sign = sides[::-1], sign.replace(">", "<")
        return self.notation.relation(self.at(sides[0], Level.SUM), sign, self.at(sides[1], Level.SUM))

    def call(self, expression: sympy.Expr, exponent: str = "") -> str:
        arguments = [self.at(argument, Level.SUM) for argument in expression.args]
        name = expression.func.__name__
        if name == "exp" and not exponent:
            name = self.exponential
        return self.notation.call(name, arguments, exponent)


def negated(expression: sympy.Expr) -> sympy.Expr:
    """A term written with a minus sign, without this sign; a sum in the term is not expanded."""
    coefficient, rest = expression.as_coeff_Mul()
    if rest.is_Add and coefficient != -1:
        return sympy.Mul(-coefficient, rest, evaluate=False)
    return -coefficient * rest
