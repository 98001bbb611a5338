"""The normal forms of what has a kink or a jump: a switch between two expressions by the sign of a third.

Absolute values are such switches, and signs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.node_table import NodeTable
from lagrange_cli.expression.signs import Sign, proportional, signs


class SwitchForms(NodeTable):
    """A table in which every distinct switch exists once, in its normal form."""

    def __init__(self) -> None:
        super().__init__()
        self._signs: dict[Node, Sign] = {}

    # what switches are made of, and made to (``normal_forms``)

    def sum(self, terms: Iterable[tuple[Node, float]]) -> Node:
        """``sum coefficient * node``."""
        raise NotImplementedError

    def product(self, factors: Iterable[tuple[Node, int | float]]) -> Node:
        """``prod node ** exponent``."""
        raise NotImplementedError

    def split_coefficient(self, node: Node) -> tuple[float, Node]:
        """``node`` as a number times a node that carries no numerical factor."""
        raise NotImplementedError

    # switches

    def switch(self, u: Node | float, above: Node | float, below: Node | float, at: int = 0) -> Node:
        """``above`` where u > 0, ``below`` where u < 0; where u is 0, that of the side ``at``, 0: their mean.

        A number decides, and so does what is visibly of one sign. Positive factors of u are left out.
        """
        u, above, below = self.lift(u), self.lift(above), self.lift(below)
        if above is below:
            return above
        u, turned = self._oriented(u)
        if turned:
            above, below, at = below, above, -at
        if u.kind is Kind.NUMBER:
            if u.data != u.data:
                return self.constant(math.nan)
            at = at if u.data == 0 else 1 if u.data > 0 else -1
            return self.sum([(above, 0.5), (below, 0.5)]) if at == 0 else above if at > 0 else below
        continuous = proportional(self.split_coefficient(above - below)[1], u)
        at = 0 if continuous else at
        known = signs(u, self._signs)
        if known is Sign.POSITIVE or (known is Sign.NEVER_NEGATIVE and (continuous or at > 0)):
            return above
        above, below = self._within(u, above, 1, at), self._within(u, below, -1, at)
        if above is below:
            return above
        (first, one), (second, other) = self.split_coefficient(above), self.split_coefficient(below)
        scale = second if above.is_zero else first
        alike = above.is_zero or below.is_zero or abs(first) == abs(second)
        if alike and scale != 1 and math.isfinite(scale):
            above, below = (first / scale) * one, (second / scale) * other
            return scale * self._make(Kind.SWITCH, at, (u, above, below))
        return self._make(Kind.SWITCH, at, (u, above, below))

    def _within(self, u: Node, branch: Node, side: int, at: int) -> Node:
        """A branch of a switch by u; a switch by the same u has but one side there."""
        if branch.kind is not Kind.SWITCH or branch.arguments[0] is not u:
            return branch
        if at == -side or branch.data == side or proportional(branch.arguments[1] - branch.arguments[2], u):
            return branch.arguments[1 if side > 0 else 2]
        return branch

    def _oriented(self, u: Node) -> tuple[Node, bool]:
        """An expression of the same sign without positive factors; and whether it is of the opposite one."""
        turned = False
        while True:
            before = u
            scale, u = self.split_coefficient(u)
            if u is self.one:
                return self.constant(scale), turned
            if u.kind is Kind.SUM and u.data[1][0] < 0:
                scale, u = -scale, -u
            turned ^= scale < 0
            if u.kind is Kind.PRODUCT:
                parts = [(a, 1 if whole(e) and e % 2 else e) for a, e in zip(u.arguments, u.data)]
                parts = [(a, e) for a, e in parts if e > 0 or not whole(e)]
                u = self.product([(a, e) for a, e in parts if signs(a, self._signs) is not Sign.POSITIVE])
            if u is before:
                return u, turned

    def absolute(self, u: Node) -> Node:
        """|u|, of a product those of its factors."""
        if u.kind is Kind.NUMBER:
            return self.constant(abs(u.data))
        scale, rest = self.split_coefficient(u)
        if rest.kind is Kind.PRODUCT:
            parts = zip(rest.arguments, rest.data)
            listed = [(self.absolute(a) if whole(e) else a, e) for a, e in parts]
            return abs(scale) * self.product(listed)
        if rest.kind is Kind.SUM and rest.data[1][0] < 0:
            rest = -rest
        return abs(scale) * self.switch(rest, rest, -rest)

    def sign(self, u: Node) -> Node:
        """The sign of u, of a product those of its factors, as of absolute values."""
        scale, rest = self.split_coefficient(u)
        if rest.kind is not Kind.PRODUCT or not all(whole(e) and e % 2 == 1 for e in rest.data):
            return self.switch(u, 1.0, -1.0)
        return math.copysign(1.0, scale) * self.product([(self.sign(a), 1) for a in rest.arguments])


def whole(exponent: float) -> bool:
    """Whether a power is one of a whole number."""
    return isinstance(exponent, int) or (math.isfinite(exponent) and exponent == int(exponent))
