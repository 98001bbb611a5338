"""Members of families and sums over them in sympy: ``x[i + 1]`` is a symbol of that name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import Any

import sympy
from sympy.core.basic import Atom

from lagrange_cli.expression.symbolic_switches import OfExpressions
from lagrange_cli.expression.vocabulary import TIME
from lagrange_cli.symbolic.indexed.conditions import Loop, changed
from lagrange_cli.symbolic.indexed.whole import Spans, Whole, named, reduced
from lagrange_cli.symbolic.order import Role


class Loops(Atom):  # type: ignore[misc]
    """Loops around one another, the outermost first. Sympy keeps what it has computed of those that are
    equal, which have the same text and the same numbers in tables."""

    __slots__ = ("loops", "numbers", "text")
    is_commutative = True

    def __new__(cls, loops: Sequence[Loop]) -> Loops:
        made = super().__new__(cls)
        made.loops = tuple(loops)
        made.text = " ".join(one.text for one in loops)
        made.numbers = tuple(table.in_structure for one in loops for table in one.tables)
        return made  # type: ignore[no-any-return]

    def __getnewargs__(self) -> tuple[Any, ...]:
        return (self.loops,)

    def _hashable_content(self) -> tuple[Any, ...]:
        return self.text, self.numbers

    def _sympystr(self, printer: Any) -> str:
        return str(self.text)


class Summed(OfExpressions):
    """``sum(body for ...)``: its arguments are the body, and ``Loops``."""

    is_commutative = True

    @classmethod
    def simplified(cls, body: sympy.Expr, loops: Loops) -> Any:
        """Factors that no index of a loop changes come out of the sum, and sums in sums are one."""
        if body.is_zero or not loops.loops:
            return body
        factors = sympy.Mul.make_args(body)
        sums = [one for one in factors if isinstance(one, Summed)]
        if len(sums) == 1:
            others = sympy.Mul(*(one for one in factors if one is not sums[0]))
            within = apart(sums[0], names_in(others) | names_around(loops.loops))
            return cls(others * within.body, Loops((*loops.loops, *within.loops)))
        bound = {one.index for one in loops.loops}
        outside = [one for one in factors if bound.isdisjoint(names_in(one))]
        if not outside:
            return None
        inside = [one for one in factors if one not in outside]
        if not inside:  # the number of terms
            return None if outside == [sympy.S.One] else sympy.Mul(*outside) * cls(sympy.S.One, loops)
        return sympy.Mul(*outside) * cls(sympy.Mul(*inside), loops)

    @property
    def body(self) -> sympy.Expr:
        """The summand."""
        return self.args[0]

    @property
    def loops(self) -> tuple[Loop, ...]:
        """The loops, the outermost first."""
        return tuple(self.args[1].loops)

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        raise NotImplementedError  # ``derivatives`` has it: a symbol may be a member for some index only


KNOWN: dict[str, tuple[str, tuple[Whole, ...]]] = {}
"""What the name of every symbol of a member stands for: the family, and the indices. A symbol of whole
numbers has no family."""


def member(base: str, indices: Iterable[Whole]) -> sympy.Symbol:
    """The symbol of a member; of a component of a particle, for a ``base`` such as ``bob.x``."""
    listed = tuple(indices)
    family, dot, component = base.partition(".")
    inside = ",".join(one.text for one in listed)
    name = f"{family}[{inside}]{dot}{component}" if base else f"({inside})"
    KNOWN[name] = base, listed
    return sympy.Symbol(name)


def expression_of(whole: Whole) -> sympy.Expr:
    """A whole number in an expression."""
    made = sympy.Integer(whole.constant)
    for atom, factor in whole.terms:
        symbol = sympy.Symbol(atom) if isinstance(atom, str) else member("", [Whole(((atom, 1),), 0)])
        made += factor * symbol
    return made


def names_in(expression: sympy.Expr) -> set[str]:
    """All names of indices and sizes in an expression."""
    found: set[str] = set()
    for symbol in expression.free_symbols:
        if symbol.name in KNOWN:
            for one in KNOWN[symbol.name][1]:
                found |= one.names
        else:
            found.add(symbol.name)
    for one in expression.atoms(Loops):
        for loop in one.loops:
            found |= loop.names
    return found


def rate_of(expression: sympy.Expr, rate: Callable[[sympy.Symbol], sympy.Expr | None]) -> sympy.Expr:
    """The derivative by t of an expression, where symbols have a ``rate``, or none."""
    plain, sums = opened(expression)
    made = plain.diff(sympy.Symbol(TIME))
    for symbol in sorted(plain.free_symbols, key=str):
        if symbol in sums:
            one = sums[symbol]
            found: sympy.Expr | None = Summed(rate_of(one.body, rate), one.args[1])
        else:
            found = rate(symbol)
        if found is not None:
            made += plain.diff(symbol) * found
    return made.xreplace(sums)


def renamed(expression: sympy.Expr, known: Mapping[str, Whole], spans: Spans) -> sympy.Expr:
    """The expression with whole numbers in place of indices, and remainders left out that ``spans`` allow. An
    index of a sum hides another of its name, and is called otherwise where it would hide one of these numbers
    (capture-avoiding substitution: A. Church, The Calculi of Lambda-Conversion, 1941, sec. 6)."""

    def walk(one: sympy.Expr, known: Mapping[str, Whole], spans: Spans) -> sympy.Expr:
        def change(whole: Whole) -> Whole:
            made = whole.with_names(known)
            return reduced(made, spans) if made.names <= spans.keys() else made

        if one.is_Symbol:
            if one.name in KNOWN:
                base, indices = KNOWN[one.name]
                made = [change(index) for index in indices]
                return member(base, made) if base else expression_of(made[0])
            return expression_of(known[one.name]) if one.name in known else one
        if isinstance(one, Summed):
            loops = []
            for loop in one.loops:
                inner = {name: whole for name, whole in known.items() if name != loop.index}
                index = fresh(loop.index, inner.values(), one)
                if index != loop.index:
                    inner[loop.index] = named(index)
                start, stop = change(loop.start), change(loop.stop)
                around, known = spans, inner
                spans = {name: span for name, span in spans.items() if name != index}
                conditions = tuple(changed(each, change) for each in loop.conditions)
                renewed = Loop(index, start, stop, loop.step, conditions)
                if start.names | stop.names <= around.keys():
                    spans = {**spans, index: renewed.span(around)}
                loops.append(renewed)
            return Summed(walk(one.body, known, spans), Loops(loops))
        if not one.args:
            return one
        arguments = [walk(argument, known, spans) for argument in one.args]
        return one if all(a is b for a, b in zip(arguments, one.args)) else one.func(*arguments)

    return walk(expression, known, spans)


def fresh(index: str, numbers: Iterable[Whole], within: sympy.Expr) -> str:
    """The index, or a name of its own where it is one of those in ``numbers``."""
    taken = set[str]().union(*(one.names for one in numbers))
    if index not in taken:
        return index
    return name_besides(taken | names_in(within))


def names_around(loops: Iterable[Loop]) -> set[str]:
    """All names in loops, their indices included."""
    return {name for one in loops for name in (one.index, *one.names)}


def apart(summed: Summed, taken: Collection[str]) -> Any:
    """The same sum with indices that are none of the names ``taken``."""
    if not any(one.index in taken for one in summed.loops):
        return summed
    known: dict[str, Whole] = {}
    loops, used = [], {*taken, *names_in(summed)}
    for loop in summed.loops:
        index = loop.index
        if index in taken:
            index = name_besides(used)
            used.add(index)
        around = {**known}
        known[loop.index] = named(index)
        inside = loop.changed(lambda whole: whole.with_names(known))
        outside = loop.changed(lambda whole: whole.with_names(around))  # noqa: B023 - called here
        loops.append(Loop(index, outside.start, outside.stop, loop.step, inside.conditions))
    return Summed(renamed(summed.body, known, {}), Loops(loops))


def name_besides(taken: Collection[str]) -> str:
    """The first hidden name that is not taken: sums that are shown get letters (``lines``)."""
    return next(one for one in (f"{HIDDEN}s{k}" for k in count()) if one not in taken)


def hidden(expression: sympy.Expr, count: Iterator[object]) -> sympy.Expr:
    """The expression with indices of its sums that no other index is called like."""
    if isinstance(expression, Summed):
        names = {loop.index: named(f"{HIDDEN}{next(count)}") for loop in expression.loops}
        loops = [
            Loop(names[one.index].text, one.start, one.stop, one.step, one.conditions)
            for one in (loop.changed(lambda whole: whole.with_names(names)) for loop in expression.loops)
        ]
        return Summed(hidden(renamed(expression.body, names, {}), count), Loops(loops))
    if not expression.has(Summed):
        return expression
    return expression.func(*(hidden(one, count) for one in expression.args))


HIDDEN = "@"
"""The beginning of the names of indices, which no other name has."""


def opened(expression: sympy.Expr) -> tuple[sympy.Expr, dict[sympy.Symbol, Summed]]:
    """The expression with a symbol for each of its sums."""
    sums: dict[Summed, sympy.Symbol] = {}

    def walk(one: sympy.Expr) -> sympy.Expr:
        if isinstance(one, Summed):
            return sums.setdefault(one, sympy.Dummy())
        if not one.args:
            return one
        return one.func(*map(walk, one.args))

    plain = walk(expression) if expression.has(Summed) else expression
    return plain, {symbol: one for one, symbol in sums.items()}


def even(expression: sympy.Expr) -> sympy.Expr:
    """With the same sign for what differs by its sign only in even powers: (x[i] - x[j])**2."""

    return expression.replace(
        lambda one: one.is_Pow and one.base.is_Add and one.exp.is_Integer and one.exp % 2 == 0,
        lambda one: (-one.base) ** one.exp if leads_negative(one.base) else one,
    )


def leads_negative(sum_: sympy.Expr) -> bool:
    """Whether the first term of a sum is negative."""
    first = min(sum_.args, key=lambda term: str(term.as_coeff_Mul()[1]))
    return bool(first.as_coeff_Mul()[0].is_negative)


def summed_of(body: sympy.Expr, loops: Sequence[Loop]) -> sympy.Expr:
    """The sum, with what all of its terms have in common, and no index changes, in front of it."""
    if body.is_zero:
        return sympy.S.Zero
    bound = {one.index for one in loops}
    turned = [one for one in sympy.Mul.make_args(body) if one.is_Add and leads_negative(one)]
    if turned and not body.is_Add:
        rest = [one for one in sympy.Mul.make_args(body) if one not in turned]
        return (-1) ** len(turned) * summed_of(sympy.Mul(*rest, *(-one for one in turned)), loops)
    terms = sympy.Add.make_args(body)
    numbers = [one.as_coeff_Mul()[0] for one in terms]
    sign = -1 if all(one.is_negative for one in numbers) else 1
    common = sign * abs(numbers[0]) if len({abs(one) for one in numbers}) == 1 else sympy.Integer(sign)
    powers = [dict(one.as_coeff_Mul()[1].as_powers_dict()) for one in terms]
    for base in powers[0]:
        exponents = [one.get(base, sympy.S.Zero) for one in powers]
        if bound.isdisjoint(names_in(base)) and all(one.is_Integer for one in exponents):
            least = min(exponents) if min(exponents) > 0 else max(exponents) if max(exponents) < 0 else 0
            common *= base**least
    return common * Summed(sympy.Add(*(one / common for one in terms)), Loops(loops))


class Ranks(dict[sympy.Symbol, tuple[Role, int]]):
    """The role of every symbol by the family that it is a member of, and its rank: that of the family, then
    the indices. Names of indices and sizes are parameters."""

    def __init__(self, bases: Mapping[str, tuple[Role, int]]) -> None:
        super().__init__()
        self.bases = bases

    def __missing__(self, symbol: sympy.Symbol) -> tuple[Role, int]:
        base = KNOWN[symbol.name][0] if symbol.name in KNOWN else symbol.name
        role, rank = self.bases.get(base, (Role.PARAMETER, len(self.bases)))
        text = symbol.name.partition("[")[2].replace("(", "").encode()[:8].ljust(8)
        made = self[symbol] = role, (rank << 64) + int.from_bytes(text, "big")
        return made
