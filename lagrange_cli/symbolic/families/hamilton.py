"""Hamilton's form of systems of families, with indices (Goldstein, Classical Mechanics, eq. 8.27):
H = (p - b) . M^-1 (p - b)/2 - L0, where b is dL/dq_dot, and L0 is L, where all velocities are 0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import count

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.kinds import LETTERS
from lagrange_cli.symbolic.families.linear import Block, entry_name
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.families.sums import finished, gathered
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import (
    KNOWN,
    Loops,
    Ranks,
    Summed,
    hidden,
    opened,
    renamed,
    summed_of,
)
from lagrange_cli.symbolic.indexed.whole import named, number
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.textbook import neat

INVERTED, OFFSET = "Minv", "b_"
INVERSE = "`Minv` is the inverse of the mass matrix `M`, and symmetric as `M` is"


@dataclass(frozen=True)
class FamilyHamiltonian:
    """H and the canonical equations in q, p and t: dq/dt = dH/dp (``velocities``) and dp/dt = -dH/dq + Q
    (``rates``; with constraints, + A^T lambda), with a line for members that are alike.

    Where it is not ``solved``, the inverse of M is written Minv, and dp/dt is dL/dq + Q, the same as a
    function of q and the velocities; b is the ``offsets``, if it is not 0.
    """

    order: Order
    H: sympy.Expr
    velocities: tuple[Line, ...]
    rates: tuple[Line, ...]
    solved: bool
    offsets: tuple[Line, ...] = ()


def momentum_name(coordinate: str) -> str:
    """``p_x`` for ``x``."""
    return f"p_{coordinate}"


def hamilton_form(equations: FamilyEquations) -> FamilyHamiltonian:
    """The Legendre transform of L. Raises ``UsageError`` where a name is taken."""
    energy = -equations.L if equations.U is None or equations.T is None else equations.U - equations.T
    potential, driving = at_rest(energy, equations), equations.driving
    assert driving is not None
    if equations.blocks is not None:
        with suppress(Unsuited):
            return solved_form(equations, equations.blocks, potential, driving)
    return with_inverse(equations, potential, driving)


def solved_form(
    equations: FamilyEquations, blocks: Sequence[Block], potential: sympy.Expr, driving: Sequence[Line]
) -> FamilyHamiltonian:
    """The same where velocities follow for each block of M by itself. Raises ``Unsuited`` where they are too
    long, or do not fit the lines of forces."""
    order, known = order_of(equations), equations.order
    kinetic: list[sympy.Expr] = []
    velocities = list[Line]()
    by_block: dict[tuple[Family, ...], tuple[list[Line], list[Line]]] = {}
    apart = all(is_apart(one, equations.coordinates, known) for one in blocks)
    for block in blocks:
        lines = [one.of(tidy(one.expression, order)) for one in block.lines(block.rest)]
        excess = [symbol_of(one, momentum_name(one.family.name)) - one.expression for one in lines]
        found = block.solved(excess, order)
        velocities += block.lines(found)
        energy = sympy.Add(*(p * v / 2 for p, v in zip(excess, found, strict=True)))
        energy = neat(energy, order, Role.COORDINATE)
        kinetic.append(summed_of(energy, block.line.loops))
        moving, (at_v, at_p) = moving_part(block, lines), by_block.setdefault(block.families, ([], []))
        for family in equations.coordinates if apart else ():
            if family.shape == block.families[0].shape:
                line, q = replace(block.line, family=family), symbol_of(block.line, family.name)
                at_v.append(line.of(moving.diff(q)))
                at_p.append(line.of(energy.diff(q)))
    rates = []
    for line in driving:  # -dH/dq is that at fixed momenta
        own = [one for families, one in by_block.items() if families[0].shape == line.family.shape]
        before, after = (
            sympy.Add(*(of_member(one[k], line) for one in own)) if apart else sympy.S.Zero for k in (0, 1)
        )
        force = tidy(line.expression - before, known) if apart else line.expression
        rates.append(line.of(tidy(force.xreplace(velocities_in(force, velocities)) - after, order)))
    H = gathered(sympy.Add(*kinetic), order) + potential
    names = [one.name for one in equations.coordinates]
    velocities.sort(key=lambda line: names.index(line.family.name))
    return FamilyHamiltonian(order, H, tuple(velocities), tuple(rates), True)


def is_apart(block: Block, families: Sequence[Family], order: Order) -> bool:
    """Whether M and b of a block contain no coordinates of members with other indices."""
    own = {symbol_of(block.line, one.name) for one in families if one.shape == block.families[0].shape}
    entries = [*block.rest, *(entry for row in block.matrix for entry in row)]
    found = {one for entry in entries for one in entry.free_symbols if order.role(one) is Role.COORDINATE}
    return found <= own


def moving_part(block: Block, lines: Sequence[Line]) -> sympy.Expr:
    """v . M v/2 + b . v of a block, what L has besides its value at rest."""
    v = [symbol_of(one, velocity_name(one.family.name)) for one in lines]
    rows = (sympy.Add(*(entry * own for entry, own in zip(row, v))) for row in block.matrix)
    pairs = zip(rows, v, lines, strict=True)
    return sympy.Add(*(own * (row / 2 + line.expression) for row, own, line in pairs))


def velocities_in(expression: sympy.Expr, lines: Sequence[Line]) -> dict[sympy.Symbol, sympy.Expr]:
    """The velocities in a force. Raises ``Unsuited`` where those of one line do not all have the same
    line."""
    speeds = {velocity_name(one.family.name): one for one in lines}
    found = ((one, KNOWN.get(one.name, (one.name, ()))) for one in expression.free_symbols)
    return {
        one: of_member(lines, replace(speeds[base], indices=indices))
        for one, (base, indices) in found
        if base in speeds
    }


def of_member(lines: Sequence[Line], member: Line) -> sympy.Expr:
    """What lines say of the members of another. Raises ``Unsuited`` where that is not one line."""
    own = [one for one in lines if one.family.name == member.family.name]
    alike = [one for one in own if one.indices == member.indices]
    if alike:
        return alike[0].expression
    if len(own) > 1:
        raise Unsuited
    loops = {loop.index for loop in own[0].loops}
    names = {a.text: b for a, b in zip(own[0].indices, member.indices) if a.text in loops}
    return renamed(own[0].expression, names, {})


def with_inverse(
    equations: FamilyEquations, potential: sympy.Expr, driving: tuple[Line, ...]
) -> FamilyHamiltonian:
    """The same with the inverse of M, and with b by name where it is not 0."""
    families = equations.coordinates
    offsets = [one.of(at_rest(one.expression, equations, one.loops)) for one in equations.momenta]
    still = all(one.expression == 0 for one in offsets)
    names = [INVERTED + entry_name(a, b) for k, a in enumerate(families) for b in families[k:]]
    names += [] if still else [OFFSET + one.name for one in families]
    order = order_of(equations, names)
    letters = free_letters(order, equations.sizes)

    def excess(line: Line) -> sympy.Expr:
        p = symbol_of(line, momentum_name(line.family.name))
        return p if still else p - symbol_of(line, OFFSET + line.family.name)

    def inverse(one: Line, other: Line) -> sympy.Symbol:
        pair = sorted((one, other), key=lambda line: families.index(line.family))
        return symbol_of(Line(one.family, (*pair[0].indices, *pair[1].indices), (), one.expression),
                         INVERTED + entry_name(*(line.family for line in pair)))  # fmt: skip

    kinetic, velocities = sympy.S.Zero, []
    for k, family in enumerate(families):
        own, total = every(family, letters, equations.sizes), sympy.S.Zero
        for n, partner in enumerate(families):
            other = every(partner, letters[len(family.shape) :], equations.sizes)
            moved = inverse(own, other) * excess(other)
            total += Summed(moved, Loops(other.loops))
            if n >= k:
                twice = Summed(excess(own) * moved, Loops((*own.loops, *other.loops)))
                kinetic += twice / (2 if n == k else 1)
        velocities.append(own.of(total))
    known = () if still else tuple(offsets)
    return FamilyHamiltonian(order, kinetic + potential, tuple(velocities), driving, False, known)


def every(family: Family, letters: Sequence[str], sizes: Mapping[str, int]) -> Line:
    """A line of all members of a family, which is 0."""
    loops = []
    for letter, size, axis in zip(letters, family.shape, family.axes):
        name = axis.partition("_")[0]
        loops.append(Loop(letter, number(0), named(name) if sizes.get(name) == size else number(size)))
    return Line(family, tuple(named(one.index) for one in loops), tuple(loops), sympy.S.Zero)


def order_of(equations: FamilyEquations, names: Sequence[str] = ()) -> Order:
    """The order of symbols without velocities, but with momenta in their place, or where there are ``names``
    besides, with all of these. Raises ``UsageError`` where a name is taken."""
    known = equations.order.ranks
    assert isinstance(known, Ranks)
    bases = {one: role for one, role in known.bases.items() if names or role[0] < Role.VELOCITY}
    momenta = [momentum_name(one.name) for one in equations.coordinates]
    for rank, name in enumerate([*momenta, *names]):
        if name in known.bases:
            what = "a momentum" if name in momenta else "something else"
            raise UsageError(f"{name} is the name of {what} in --form hamilton: rename yours")
        role = Role.VELOCITY if name in momenta else Role.COORDINATE
        bases[name] = role, rank if name in momenta else rank + len(bases)
    return Order(Ranks(bases), equations.order.decimals)


def at_rest(expression: sympy.Expr, equations: FamilyEquations, around: Sequence[Loop] = ()) -> sympy.Expr:
    """An expression, within loops ``around`` it, where all velocities are 0: those of particles by name are
    then what t changes of their places."""
    order, number_of = equations.order, count()
    places = {
        one.symbol.name.partition("[")[0] + one.symbol.name.rpartition("]")[2]: one
        for one in equations.places
    }

    def still(expression: sympy.Expr) -> sympy.Expr:
        plain, sums = opened(expression)
        inside = {symbol: summed_of(still(one.body), one.loops) for symbol, one in sums.items()}
        moving = (one for one in plain.free_symbols - sums.keys() if order.role(one) >= Role.VELOCITY)
        return plain.xreplace({one: speed(one) for one in moving}).xreplace(inside)

    def speed(symbol: sympy.Symbol) -> sympy.Expr:
        base, indices = KNOWN.get(symbol.name, (symbol.name, ()))
        if base not in places:
            return sympy.S.Zero
        known = dict(zip((one.index for one in places[base].loops), indices))
        return renamed(hidden(still(places[base].expression), number_of), known, {})

    made, used = still(expression), {one.index for one in around}
    letters = [one for one in free_letters(order, equations.sizes) if one not in used]
    return finished(made, letters, {one.name for one in equations.paths}) if places else made


def free_letters(order: Order, sizes: Mapping[str, int]) -> list[str]:
    """Letters for indices that nothing else is called."""
    return [one for one in LETTERS if one not in order.ranks.bases and one not in sizes]  # type: ignore[attr-defined]
