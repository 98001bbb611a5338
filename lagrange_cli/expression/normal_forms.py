"""The normal forms of the expression graph: equal expressions are one node.

Constants are folded, like terms and like factors collected, 0 and 1 vanish, and cos^2 + sin^2 = 1 is applied
wherever both squares stand in one sum with equal factors. sqrt(1 + u^4) - u^2 is a fraction in which nothing
cancels. Products of sums are kept as written (each costs one convolution in Taylor space). What has a kink or
a jump is a switch (``switch_forms``), and roots of squares are absolute values.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from lagrange_cli.expression.node import Kind, Node, in_order
from lagrange_cli.expression.signs import Sign, is_absolute, is_sign, signs
from lagrange_cli.expression.switch_forms import SwitchForms, whole

SQUARE_ROOT = (0.5,)
"""The exponents of a product that is one."""


class NormalForms(SwitchForms):
    """A table in which every distinct expression exists once, in its normal form."""

    def __init__(self) -> None:
        super().__init__()
        self._squares: dict[Node, Sequence[tuple[Node, int]]] = {}

    # ------------------------------------------------------------------ sums

    def sum(self, terms: Iterable[tuple[Node, float]]) -> Node:
        """``sum coefficient * node``, flattened, like terms collected."""
        constant = 0.0
        collected: dict[Node, float] = {}
        count = 0
        for node, coefficient in terms:
            count += 1
            if node.kind is Kind.NUMBER:
                constant = added(constant, coefficient * node.data)
            elif node.kind is Kind.SUM:
                count += len(node.arguments)
                inner, coefficients = node.data
                constant = added(constant, coefficient * inner)
                for argument, factor in zip(node.arguments, coefficients):
                    before = collected.get(argument)
                    here = coefficient * factor
                    collected[argument] = 0.0 + here if before is None else added(before, here)
            else:
                before = collected.get(node)
                collected[node] = 0.0 + coefficient if before is None else added(before, coefficient)
        self.work.charge(count)
        if 0.0 in collected.values():
            collected = {node: c for node, c in collected.items() if c != 0.0}
        constant += self._fold_squares(collected)
        if not collected:
            return self.constant(constant)
        if constant == 0.0 and len(collected) == 1:
            ((node, coefficient),) = collected.items()
            if coefficient == 1.0:
                return node
        ordered = tuple(in_order(collected))
        node = self._make(Kind.SUM, (constant + 0.0, tuple(map(collected.__getitem__, ordered))), ordered)
        if (constant or len(ordered) > 1) and any(one.data == SQUARE_ROOT for one in ordered):
            from lagrange_cli.expression.conjugates import conjugate  # few sums have roots

            fraction = conjugate(node)
            if fraction is not None:
                return self.product([(fraction[0], 1), (fraction[1], -1)])
        return node

    def _fold_squares(self, collected: dict[Node, float]) -> float:
        """Replace c R cos(u)^2 + c R sin(u)^2 by c R in place; returns what became a constant."""
        constant = 0.0
        pending = [node for node in collected if node.kind is Kind.PRODUCT]
        while pending:
            node = pending.pop()
            if node not in collected:
                continue
            for factor, exponent in zip(node.arguments, node.data):
                if exponent != 2 or factor.kind is not Kind.FUNCTION or factor.data not in ("cos", "sin"):
                    continue
                rest = self.product([(node, 1), (factor, -2)])
                partner = self.function("sin" if factor.data == "cos" else "cos", factor.arguments)
                twin = self.product([(rest, 1), (partner, 2)])
                if collected.get(twin) != collected[node]:
                    continue
                coefficient = collected.pop(node)
                del collected[twin]
                scale, left = self.split_coefficient(rest)
                if left is self.one:
                    constant += coefficient * scale
                else:
                    total = added(collected.pop(left, 0.0), coefficient * scale)
                    if total != 0.0:
                        collected[left] = total
                        if left.kind is Kind.PRODUCT:
                            pending.append(left)
                break
        return constant

    @staticmethod
    def divides(first: float, constant: float, others: Sequence[float]) -> bool:
        """Whether a sum is divided by its first coefficient, no power of two, without rounding."""
        return False

    def split_coefficient(self, node: Node) -> tuple[float, Node]:
        """``node`` as a number times a node that carries no numerical factor.

        Out of a sum comes what its first term has of a sign and powers of two, which is exact: y - x and
        2*x - 2*y are multiples of x - y.
        """
        if node.kind is Kind.NUMBER:
            return node.data, self.one
        if node.kind is not Kind.SUM:
            return 1.0, node
        constant, (first, *others) = node.data
        if not others and constant == 0.0:
            return first, node.arguments[0]
        if first == 1.0 or not (abs(math.frexp(first)[0]) == 0.5 or self.divides(first, constant, others)):
            return 1.0, node
        data = (constant / first + 0.0, (1.0, *(coefficient / first for coefficient in others)))
        return first, self._make(Kind.SUM, data, node.arguments)

    # ------------------------------------------------------------------ products and powers

    def product(self, factors: Iterable[tuple[Node, int | float]]) -> Node:
        """``prod node ** exponent``, flattened, like factors collected, numbers in front."""
        coefficient = 1.0
        collected: dict[Node, int | float] = {}
        broken: set[Node] = set()
        pending = list(factors)
        count, switches = 0, False
        while (
            pending
            or (switches and self._settle(collected, pending))
            or (broken and self._whole_again(collected, broken, pending))
        ):
            count += 1
            node, exponent = pending.pop()
            kind, plain = node.kind, type(exponent) is int or whole(exponent)
            if kind is Kind.NUMBER:
                coefficient *= self.power_of(node.data, exponent)
                continue
            if kind is Kind.PRODUCT:
                if plain:
                    pending.extend((a, e * exponent) for a, e in zip(node.arguments, node.data))
                    continue
                roots = self._even_roots(node, exponent)
                if roots:
                    pending.extend(roots)
                    continue
            elif kind is Kind.SUM:
                squared = () if plain else self._roots(node)
                if squared:
                    pending.extend((one, times * exponent) for one, times in squared)
                    continue
                scale, rest = self.split_coefficient(node)
                if rest is not node and (plain or scale > 0.0):
                    coefficient *= self.power_of(scale, exponent)
                    pending.append((rest, exponent))
                    continue
            elif kind is Kind.SWITCH:
                switches = True
            if not plain:
                broken.add(node)
            collected[node] = collected.get(node, 0) + exponent
        self.work.charge(count)
        if coefficient == 0.0:
            return self.zero
        bases = [node for node, exponent in collected.items() if exponent != 0]
        if not bases:
            return self.constant(coefficient)
        bases = in_order(bases)
        exponents = tuple([self.tidy(collected[base]) for base in bases])
        node = bases[0] if exponents == (1,) else self._make(Kind.PRODUCT, exponents, tuple(bases))
        return node if coefficient == 1.0 else self.sum([(node, coefficient)])

    def _roots(self, node: Node) -> Sequence[tuple[Node, int]]:
        """The factors of a sum of which others are squares, with the exponents that they have; nothing where
        it is no such product."""
        if node not in self._squares:
            from lagrange_cli.expression.squares import square  # few expressions have roots

            found = square(self, node)
            self._squares[node] = []
            if found is not None:
                even = [(found.root, 2), *found.denominators]
                self._squares[node] = [(found.factor, 1), *((self.absolute(a), e) for a, e in even)]
        return self._squares[node]

    def _even_roots(self, node: Node, exponent: float) -> list[tuple[Node, int | float]]:
        """A fractional power of a product without its even powers, which are powers of absolute values;
        nothing where it has none."""
        parts = list(zip(node.arguments, node.data))
        even = [(a, e) for a, e in parts if isinstance(e, int) and e % 2 == 0]
        if not even:
            return []
        rest = self.product([(a, e) for a, e in parts if (a, e) not in even])
        roots = [(self.absolute(a), self.tidy(e * exponent)) for a, e in even]
        return roots if rest is self.one else [*roots, (rest, exponent)]

    def _whole_again(
        self, collected: dict[Node, int | float], broken: set[Node], pending: list[tuple[Node, int | float]]
    ) -> bool:
        """Put a base whose fractional exponents add up to an integer from ``collected`` to ``pending``: a sum
        or a product is taken apart then, as if it had been written so."""
        for node in broken:
            exponent = collected.get(node, 0)
            if exponent and whole(exponent):
                broken.remove(node)
                del collected[node]
                pending.append((node, self.tidy(exponent)))
                return True
        return False

    def _settle(self, collected: dict[Node, int | float], pending: list[tuple[Node, int | float]]) -> bool:
        """Put what a power of an absolute value or a sign is without it from ``collected`` to ``pending``.

        |u|**3 is u**2 |u|; |u| times the sign of u is u; |u|/u is the sign of u, divided by nothing.
        """
        for node, exponent in collected.items():
            if node.kind is not Kind.SWITCH or not exponent or not whole(exponent):
                continue
            u, size = node.arguments[0], is_absolute(node)
            if size and abs(exponent) >= 2:
                odd = int(math.copysign(exponent % 2, exponent))
                pending.append((u, self.tidy(exponent - odd)))
                collected[node] = odd
                return True
            if size and exponent == 1 and collected.get(u, 0) < 0:
                pending += [(u, 1), (self.switch(u, self.one, self.constant(-1.0)), 1)]
                del collected[node]
                return True
            if is_sign(node) and exponent >= 1 and collected.get(partner := self.absolute(u), 0) >= 1:
                collected[node] -= 1
                collected[partner] -= 1
                pending.append((u, 1))
                return True
        return False

    # ------------------------------------------------------------------ functions

    def power(self, base: Node, exponent: Node) -> Node:
        """``base ** exponent``; a numerical exponent makes a product, any other a power node, of a root that
        of what is under it."""
        if exponent.kind is Kind.NUMBER:
            return self.product([(base, self.tidy(exponent.data))])
        if base.kind is Kind.PRODUCT and len(base.arguments) == 1 and not whole(base.data[0]):
            return self.power(base.arguments[0], base.data[0] * exponent)
        if base is self.one:
            return self.one
        return self._make(Kind.POWER, None, (base, exponent))

    def function(self, name: str, arguments: Sequence[Node]) -> Node:
        """An elementary function; of numbers, its value; ``sqrt`` is the power 1/2. A value that the rounding
        of the number makes, as cos(pi/2), is 0.

        asin(z) is the angle of z and sqrt(1 - z^2), with a kink at w = 0 where this is |w|. So is acos(z).
        """
        arguments = tuple(arguments)
        if name == "sqrt":
            return self.product([(arguments[0], 0.5)])
        if all(argument.kind is Kind.NUMBER for argument in arguments):
            value = self.function_of(name, [argument.data for argument in arguments])
            is_zero = name in ("sin", "cos", "tan") and abs(value) <= self.rounding * abs(arguments[0].data)
            return self.zero if is_zero else self.constant(value)
        if name in ("asin", "acos"):
            leg = self.product([(1.0 - arguments[0] * arguments[0], 0.5)])
            if not self._is_root(leg):
                angle = self._make(Kind.FUNCTION, "atan2", (arguments[0], leg))
                return angle if name == "asin" else self.function_of("acos", [self.number(0)]) - angle
        return self._make(Kind.FUNCTION, name, arguments)

    def _is_root(self, node: Node) -> bool:
        """Whether it has a factor with a fractional power, whose base may become 0."""
        _, node = self.split_coefficient(node)
        parts = zip(node.arguments, node.data) if node.kind is Kind.PRODUCT else ()
        return any(not whole(e) and signs(a, self._signs) is not Sign.POSITIVE for a, e in parts)

    def ddt(self, node: Node) -> Node:
        """The total time derivative along the motion, left for the Taylor series to take."""
        if node.kind is Kind.NUMBER:
            return self.zero
        return self._make(Kind.DDT, None, (node,))


def added(one: Any, other: Any) -> Any:
    """The sum of two numbers; the difference of doubles is that of what was written."""
    total = one + other
    if type(total) is not float or not 0 < abs(total) < max(abs(one), abs(other)) < math.inf:
        return total
    from lagrange_cli.expression.written import difference  # most systems have no such coefficients

    return difference(one, other)
