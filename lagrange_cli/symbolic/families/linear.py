"""Equations that are linear in velocities or accelerations of families, with indices: p = M v and M a = f.

Where members are coupled only to those with their own indices, as the angles of one top are, they are solved
for each block of these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TypeAlias

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import acceleration_name, velocity_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.constraints import LONGEST, attempt
from lagrange_cli.symbolic.families.derivatives import Part
from lagrange_cli.symbolic.families.lines import Line, Lines, symbol_of
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.members import KNOWN, opened
from lagrange_cli.symbolic.linear import LARGEST_BLOCK, Singular, solve
from lagrange_cli.symbolic.order import Order, Role

Parts: TypeAlias = "Mapping[str, Sequence[Part]]"
Sums: TypeAlias = "Sequence[tuple[Line, Mapping[str, sympy.Expr]]]"
"""The lines of a family with their sums of parts."""
MASS = "M"


@dataclass(frozen=True)
class Block:
    """Equations of members of ``families`` that have the indices of the ``line``: ``matrix`` times their
    velocities or accelerations, plus ``rest``."""

    families: tuple[Family, ...]
    line: Line
    matrix: tuple[tuple[sympy.Expr, ...], ...]
    rest: tuple[sympy.Expr, ...]

    def lines(self, values: Sequence[sympy.Expr]) -> Iterator[Line]:
        """A line for each family."""
        for family, value in zip(self.families, values, strict=True):
            yield replace(self.line, family=family, expression=value)

    def solved(self, right: Sequence[sympy.Expr], order: Order) -> tuple[sympy.Expr, ...]:
        """The solution where ``matrix`` times it is ``right``. Raises ``Unsuited`` where that is too long, or
        there is none."""
        longest = LONGEST if len(right) > 1 else math.inf
        try:
            found = attempt(lambda: solve(self.matrix, right.__getitem__, order, LARGEST_BLOCK, longest))
        except Singular as error:
            raise Unsuited from error
        if found is None:
            raise Unsuited
        return found

    def entries(self) -> Iterator[Line]:
        """The entries of the matrix from the diagonal on."""
        for i, row in enumerate(self.matrix):
            for k, value in enumerate(row[i:], i):
                family = entry_family(self.families[i], self.families[k])
                yield Line(family, 2 * self.line.indices, self.line.loops, value)


def entry_family(one: Family, other: Family) -> Family:
    """The entries of M between two families of coordinates: ``M_x[i,j]``, ``M_x_y[i,j]``."""
    return Family(MASS + entry_name(one, other), (*one.shape, *other.shape), (), (*one.axes, *other.axes))


def entry_name(one: Family, other: Family) -> str:
    """The end of their name."""
    return f"_{one.name}" if one is other else f"_{one.name}_{other.name}"


def pairs_of(families: Sequence[Family]) -> dict[str, tuple[Family, Family]]:
    """The pairs of families by the name of their entries. Raises ``UsageError`` where two have one."""
    found: dict[str, tuple[Family, Family]] = {}
    for one, other in ((a, b) for k, a in enumerate(families) for b in families[k:]):
        name = MASS + entry_name(one, other)
        if name in found:
            names = " and ".join(sorted({each.name for each in (*found[name], one, other)}))
            raise UsageError(f"{name} are entries of two blocks of the mass matrix: rename one of {names}")
        found[name] = one, other
    return found


def blocks_of(
    lines: Lines, families: Sequence[Family], parts: Mapping[str, Parts], sums: Mapping[str, Sums], role: Role
) -> tuple[Block, ...] | None:
    """The blocks of equations that are linear in what has a ``role``, velocities or accelerations, with the
    ``parts`` and their ``sums`` of each family; None where members are coupled to those with other indices,
    or equations are not linear."""
    rate = velocity_name if role is Role.VELOCITY else acceleration_name
    names = {rate(one.name): one.name for one in families}
    groups = [[one] for one in families]
    for family in families:
        for line, own in sums[family.name]:
            found = partners(line, sympy.Add(*own.values()), lines.order, role)
            if found is None or not found <= names.keys():
                return None
            joined = {family.name, *(names[one] for one in found)}
            apart = [group for group in groups if joined.isdisjoint(one.name for one in group)]
            together = [one for group in groups if group not in apart for one in group]
            groups = [*apart, sorted(together, key=families.index)]
    made: list[Block] = []
    for group in sorted(groups, key=lambda group: families.index(group[0])):
        if len({one.shape for one in group}) > 1:
            return None
        for line, rows in grouped_lines(lines, group, parts, sums):
            unknown = [symbol_of(line, rate(one.name)) for one in group]
            matrix = tuple(tuple(tidy(row.diff(one), lines.order) for one in unknown) for row in rows)
            if any(lines.order.role(entry) >= role for row in matrix for entry in row):
                return None
            still = dict.fromkeys(unknown, sympy.S.Zero)
            made.append(Block(tuple(group), line, matrix, tuple(row.xreplace(still) for row in rows)))
    return tuple(made)


def grouped_lines(
    lines: Lines, group: Sequence[Family], parts: Mapping[str, Parts], sums: Mapping[str, Sums]
) -> Iterator[tuple[Line, list[sympy.Expr]]]:
    """The lines of families of one shape, with an expression for each family."""
    if len(group) == 1:
        for line, own in sums[group[0].name]:
            yield line, [sympy.Add(*own.values())]
        return
    several = {f"{one.name} {key}": listed for one in group for key, listed in parts[one.name].items()}
    for line, own in lines.of(group[0], several):
        yield line, [sympy.Add(*(own[f"{one.name} {key}"] for key in parts[one.name])) for one in group]


def partners(line: Line, expression: sympy.Expr, order: Order, role: Role) -> set[str] | None:
    """The names of what has a role in an expression, if it has the indices of the line; else None."""
    plain, sums = opened(expression)
    if any(order.role(one) >= role for one in sums.values()):
        return None
    found = [
        KNOWN.get(one.name, (one.name, ()))
        for one in plain.free_symbols - sums.keys()
        if order.role(one) >= role
    ]
    return {base for base, _ in found} if all(own == line.indices for _, own in found) else None


def solution_of(
    blocks: Sequence[Block] | None, families: Sequence[Family], order: Order
) -> tuple[Line, ...] | None:
    """The velocities or accelerations of families for which all equations are 0; None where they are too
    long, there are none, or no blocks."""
    with suppress(Unsuited):
        solved = [(one, one.solved([-own for own in one.rest], order)) for one in blocks or ()]
        found = [line for one, values in solved for line in one.lines(values)]
        return tuple(sorted(found, key=lambda line: families.index(line.family))) if blocks else None
    return None
