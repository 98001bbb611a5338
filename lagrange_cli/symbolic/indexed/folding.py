"""Sums over members that are written out, as sums with an index: sum(x[i] for i in range(5)).

Terms are alike if they differ in their indices alone. Those of one member, or of two whose indices differ by
the same number, are one sum if the indices run through a range; and so are those of two members if all pairs
of a range occur.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import sympy

from lagrange_cli.records import replace
from lagrange_cli.symbolic.indexed.conditions import Loop, relation
from lagrange_cli.symbolic.indexed.members import Loops, Summed, member
from lagrange_cli.symbolic.indexed.whole import Whole, named, number
from lagrange_cli.symbolic.order import Order

FEWEST = 5
"""Terms from which on they are one sum."""
MOST = 20_000
"""Terms up to which they are looked at."""
MEMBER = re.compile(r"(\w+)\[(\d+)\]((?:\.\w+)?)")

LETTERS = "ijklmnpq"

Place = tuple[int, ...]


class Folding:
    """Expressions with sums, and their ``order``."""

    def __init__(self, order: Order) -> None:
        self.order = Order({**order.ranks}, order.decimals, order.written)
        taken = {symbol.name for symbol in order.ranks}
        self.first, self.second = [letter for letter in LETTERS if letter not in taken][:2]

    def folded(self, expression: sympy.Expr) -> sympy.Expr:
        """The expression with sums in place of terms that are alike; itself if there are none."""
        terms = [*self.terms(expression)]
        if len(terms) > MOST:
            return expression
        alike: dict[sympy.Expr, dict[Place, sympy.Expr]] = {}
        for term in terms:
            place = tuple(sorted({index for index, _ in self.members(term)}))
            if 1 <= len(place) <= 2:
                alike.setdefault(self.template(term, place), {})[place] = term
        made, used = list[sympy.Expr](), set[sympy.Expr]()
        for template in [*alike]:
            for sum_, own in self.sums(template, alike):
                made.append(sum_)
                used.update(own)
        if not made:
            return expression
        return sympy.Add(*made, *(term for term in terms if term not in used))

    def members(self, term: sympy.Expr) -> list[tuple[int, sympy.Symbol]]:
        """The members of families in a term, with their indices."""
        symbols = (one for one in term.free_symbols if one in self.order.ranks)
        return [(parts[1], symbol) for symbol in symbols if (parts := parts_of(symbol))[0]]

    def terms(self, expression: sympy.Expr) -> Iterator[sympy.Expr]:
        """Its terms; products of sums over many members are multiplied out."""
        for term in sympy.Add.make_args(expression):
            if len({index for index, _ in self.members(term)}) > 2:
                yield from sympy.Add.make_args(sympy.expand(term))
            else:
                yield term

    def template(self, term: sympy.Expr, place: Place) -> sympy.Expr:
        """The term with letters in place of its indices, the first one for the smaller."""
        return self.renamed(term, dict(zip(place, (named(self.first), named(self.second)))))

    def renamed(self, term: sympy.Expr, indices: dict[int, Whole]) -> sympy.Expr:
        """The term with other indices."""
        new: dict[sympy.Symbol, sympy.Symbol] = {}
        for index, symbol in self.members(term):
            base, _, component = parts_of(symbol)
            new[symbol] = member(base + component, [indices[index]])
            self.order.ranks.setdefault(new[symbol], self.order.ranks[symbol])
        return term.xreplace(new)

    def sums(
        self, template: sympy.Expr, alike: dict[sympy.Expr, dict[Place, sympy.Expr]]
    ) -> Iterator[tuple[sympy.Expr, list[sympy.Expr]]]:
        """The sums of a template, each with its terms, which are taken from those that are ``alike``."""
        found = alike[template]
        pairs = len(next(iter(found), ())) == 2
        if pairs and (whole := self.of_pairs(template, alike)):
            yield whole
        by_distance: dict[int, dict[int, sympy.Expr]] = {}
        for place, term in alike[template].items():
            by_distance.setdefault(place[-1] - place[0], {})[place[0]] = term
        for distance, own in sorted(by_distance.items()):
            for run in runs(sorted(own)):
                if len(run) < FEWEST:
                    continue
                first = named(self.first)
                indices = {run[0]: first, run[0] + distance: first + number(distance)}
                loop = Loop(self.first, number(run[0]), number(run[-1] + 1))
                yield Summed(self.renamed(own[run[0]], indices), Loops([loop])), [own[i] for i in run]

    def of_pairs(
        self, template: sympy.Expr, alike: dict[sympy.Expr, dict[Place, sympy.Expr]]
    ) -> tuple[sympy.Expr, list[sympy.Expr]] | None:
        """The sum over all pairs of a range, with that of the opposite pairs where they have one."""
        found = alike[template]
        indices = sorted({index for place in found for index in place})
        count = len(indices)
        if count < FEWEST or len(found) != count * (count - 1) // 2 or indices[-1] - indices[0] != count - 1:
            return None
        start, stop = number(indices[0]), number(indices[-1] + 1)
        one, other = named(self.first), named(self.second)
        place = (indices[0], indices[1])
        opposite = self.renamed(found[place], {place[0]: other, place[1]: one})
        terms = [*found.values()]
        outer = Loop(self.first, start, stop)
        inner = Loop(self.second, start, one)
        body = opposite
        if opposite != template and alike.get(opposite, {}).keys() == found.keys():
            terms += alike[opposite].values()
            alike[opposite] = {}
            inner = replace(inner, stop=stop, conditions=(relation(other, "!=", one),))
        alike[template] = {}
        return Summed(body, Loops([outer, inner])), terms


def parts_of(symbol: sympy.Symbol) -> tuple[str, int, str]:
    """The family of a member, its index and its component; an empty name for other symbols."""
    found = MEMBER.fullmatch(symbol.name)
    return (found[1], int(found[2]), found[3]) if found else ("", 0, "")


def runs(numbers: Sequence[int]) -> Iterator[list[int]]:
    """Ascending numbers as ranges without gaps."""
    run: list[int] = []
    for one in numbers:
        if run and one != run[-1] + 1:
            yield run
            run = []
        run.append(one)
    if run:
        yield run
