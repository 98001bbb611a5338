"""The printed equations of a system of families, read back and evaluated for many members at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.index_arrays import MOST, Whole, flat
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.parse import read_printed
from lagrange_cli.expression.syntax import ExpressionError, Sum, Tree
from lagrange_cli.expression.vocabulary import ACCELERATION_COMPONENTS, VELOCITY_COMPONENTS, acceleration_name
from lagrange_cli.families.arrays import NONE, Array, Chain, Source, Total
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import places_of
from lagrange_cli.families.values import FamilyValues, along
from lagrange_cli.spec.lookups import with_found
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.given import multiplier_name
from lagrange_cli.symbolic.families.linear import pairs_of
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.indexed.conditions import holds
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.printed import unreadable
from lagrange_cli.symbolic.render import render

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]
    State = tuple[float, Numbers, Numbers, Numbers, Numbers]
    """t, q, v, the accelerations and the parameters."""


MOST_NUMBERS = 20_000_000
"""Of the matrix of a path: 160 MB."""


class Reader(ChainBuilder):
    """Builds what is printed, which has accelerations and paths besides what system files have."""

    most = 2 * MOST

    def __init__(self, system: FamilySystem, paths: Sequence[Path], bound: Sequence[Family] = ()) -> None:
        super().__init__(system.spec)
        self.multipliers = Array(Source.PARAMETERS, sum(len(one.members) for one in bound))
        self.a = Array(Source.VELOCITIES, len(system.spec.coordinates))
        self.faster[self.v] = self.a
        self.further = {
            acceleration_name(one.family.name): (self.a, places_of(one.family) + one.first, one.family.shape)
            for one in self.rows.values()
            if one.array is self.q
        }
        self.paths = {Array(Source.PARAMETERS, len(one.table) ** 2): one for one in paths}
        first = 0
        for family in bound:
            table = places_of(family) + first
            self.further[multiplier_name(family.name)] = self.multipliers, table, family.shape
            first += len(family.members)
        for array, path in self.paths.items():
            count = len(path.table)
            self.further[path.name] = array, np.arange(count * count), (count, count)

    def named(self, identifier: str, places: list[Whole], members: Members) -> Any:
        name, _, component = identifier.partition(".")
        if component in ACCELERATION_COMPONENTS:
            speed = VELOCITY_COMPONENTS[ACCELERATION_COMPONENTS.index(component)]
            return self.rate(super().named(f"{name}.{speed}", places, members), members.domain)
        if identifier not in self.further:
            return super().named(identifier, places, members)
        array, table, shape = self.further[identifier]
        return self.slots.symbol(members.domain, array, table[flat(places, shape, members.count)])

    def summed(self, tree: Sum, members: Members) -> Any:
        if members.alike is None:
            members.alike = dict(members)
        self._running.pop(id(tree), None)
        return super().summed(tree, members)

    def at(self, state: State, multipliers: Numbers) -> FamilyValues:
        """The values at a state, with these multipliers of constraints."""
        t, q, v, a, parameters = state
        others = {array: matrix(one).ravel() for array, one in self.paths.items()}
        return FamilyValues(self, t, q, v, parameters, {self.a: a, self.multipliers: multipliers, **others})


def matrix(path: Path) -> Numbers:
    """The numbers of a path. Raises ``Unsuited`` where there are too many."""
    count = len(path.table)
    if count * count > MOST_NUMBERS:
        raise Unsuited
    made, places = np.eye(count), np.arange(count)
    rows = np.arange(count)
    while len(rows):
        places = path.table[places]
        rows, places = rows[places != NONE], places[places != NONE]
        made[rows, places] = 1.0
    return made


class ReadBack:
    """The printed text of some lines, parsed: a value for each coordinate."""

    def __init__(self, system: FamilySystem, equations: FamilyEquations) -> None:
        self.system, self.order, self.paths = system, equations.order, equations.paths
        self.coordinates = equations.coordinates
        self.sizes, self.chance = system.spec.sizes, np.random.default_rng(1)
        self.first: dict[str, int] = {}
        first = 0
        for family in equations.coordinates:
            self.first[family.name] = first
            first += len(family.members)
        self.count = first
        self.bound = equations.bound
        self.multipliers = self.chance.uniform(-1, 1, sum(len(one.members) for one in self.bound))
        """Any, as equations are linear in them."""
        first = 0
        for family in self.bound:
            self.first[family.name] = first
            first += len(family.members)
        self._read: dict[sympy.Expr, Tree] = {}

    def values(
        self, lines: Sequence[Line], state: State, most: int, count: int | None = None
    ) -> tuple[Numbers, Numbers]:
        """Their values for coordinates, or for a ``count`` of constraints, and bounds on the sizes of what
        has been added up: (n,) both. They are those of ``most`` members of each line, nan for all others."""
        made = np.full((2, self.count if count is None else count), np.nan)
        for line in lines:
            places, indices = self.members(line)
            which = np.sort(self.chance.permutation(len(places))[:most])
            indices = {name: one[which] for name, one in indices.items()}
            made[:, places[which]] = self.value(line.expression, indices, len(which), state)
        return made[0], made[1]

    def matrix(self, lines: Sequence[Line], state: State) -> Numbers:
        """The mass matrix (n, n) that has these entries from the diagonal on."""
        made, pairs = np.zeros((self.count, self.count)), pairs_of(self.coordinates)
        for line in lines:
            one, other = pairs[line.family.name]
            indices, count = self.running(line)
            wholes = [whole.value({**self.sizes, **indices}) for whole in line.indices]
            rows = flat(wholes[: len(one.shape)], one.shape, count) + self.first[one.name]
            columns = flat(wholes[len(one.shape) :], other.shape, count) + self.first[other.name]
            values, _ = self.value(line.expression, indices, count, state)
            made[rows, columns] = made[columns, rows] = values
        return made

    def members(self, line: Line) -> tuple[Any, dict[str, Any]]:
        """The coordinates of a line, and the indices that these have."""
        indices, count = self.running(line)
        wholes = [one.value({**self.sizes, **indices}) for one in line.indices]
        places = places_of(line.family)[flat(wholes, line.family.shape, count)]
        return places + self.first[line.family.name], indices

    def running(self, line: Line) -> tuple[dict[str, Any], int]:
        """The values of a line's indices, and how many there are."""
        indices, count = dict[str, Any](), 1
        for loop in line.loops:
            ends = (one.value({**self.sizes, **indices}) for one in (loop.start, loop.stop))
            start, stop = (np.broadcast_to(one, count) for one in ends)
            times = np.maximum(-((start - stop) // loop.step), 0)
            owners = np.repeat(np.arange(count), times)
            within = np.arange(len(owners)) - np.repeat(np.cumsum(times) - times, times)
            indices = {name: one[owners] for name, one in indices.items()}
            indices[loop.index], count = start[owners] + loop.step * within, len(owners)
            for condition in loop.conditions:
                chosen = np.broadcast_to(holds(condition, {**self.sizes, **indices}), count)
                indices, count = {name: one[chosen] for name, one in indices.items()}, int(chosen.sum())
        return indices, count

    def value(
        self, expression: sympy.Expr, indices: dict[str, Any], count: int, state: State
    ) -> tuple[Any, Any]:
        """The values of an expression, whose text is read back, for all values of indices, and their sizes.
        Raises ``Unsuited`` where its sums have too many terms."""
        reader = Reader(self.system, self.paths, self.bound)
        values = reader.at(state, self.multipliers)
        found = np.zeros((2, count))
        known = {**self.sizes, **indices}
        for _, node, which in reader.each(self.read(expression), known, count):
            if isinstance(node, tuple):
                raise Unsuited
            found[0, which] = values.node(node)
            found[1, which] = Sizes(values).node(node)
        return found[0], found[1]

    def read(self, expression: sympy.Expr) -> Tree:
        """The text of an expression, parsed: once for all states."""
        if expression not in self._read:
            try:
                printed = read_printed(render(expression, Text(), self.order))
                find = self.system.spec.tables.get
                self._read[expression] = with_found(printed, lambda one: find(one.identifier), False)
            except ExpressionError as error:
                raise unreadable(error) from error
        return self._read[expression]


class Sizes:
    """Bounds on the sizes of what is added up in an expression: with them, rounding errors are compared."""

    def __init__(self, values: FamilyValues) -> None:
        self.values = values
        self.known: dict[Total, Numbers] = {}

    def of(self, total: Total) -> Numbers:
        """The sizes of a total's sums (count,)."""
        if total not in self.known:
            made = np.zeros(total.count)
            for term in total.terms:
                sizes = np.broadcast_to(self.node(term.node), term.domain.count)
                made += np.bincount(term.targets, sizes, total.count)
            self.known[total] = along(total, made) if isinstance(total, Chain) else made
        return self.known[total]

    def node(self, node: Node) -> Any:
        """That of each member of a domain."""
        known: dict[Node, Any] = {}
        for one in reachable([node]):
            arguments = [known[argument] for argument in one.arguments]
            if one.kind is Kind.SUM:
                constant, coefficients = one.data
                known[one] = abs(float(constant)) + sum(
                    abs(float(c)) * size for c, size in zip(coefficients, arguments)
                )
            elif one.kind is Kind.PRODUCT:
                bases = [
                    size if exponent > 0 else np.abs(self.values.node(argument))
                    for argument, exponent, size in zip(one.arguments, one.data, arguments)
                ]
                powers = [base ** float(exponent) for base, exponent in zip(bases, one.data)]
                known[one] = np.prod(np.broadcast_arrays(*powers), axis=0)
            elif one.kind is Kind.SYMBOL and one in self.values.slots.of:
                slot = self.values.slots.of[one]
                total = slot.array if isinstance(slot.array, Total) else None
                known[one] = np.abs(self.values.node(one)) if total is None else self.of(total)[slot.table]
            else:
                known[one] = np.abs(self.values.node(one))
        return known[node]
