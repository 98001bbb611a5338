"""The printed equations of a system of families, read back and evaluated for all members at random states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.parse import parse
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.spec.values import Values
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.indexed.conditions import holds
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.verify import COMPILED, Verification

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Compiled = Callable[[float, Array, Array, Array], Array]
    """(t, q, v, parameters) -> accelerations, by the compiled program."""

STATES, NEAR = 4, 0.1
DERIVED = "printed and derived for all members together"


class ReadBack:
    """The printed text of some lines, parsed: a value for each coordinate."""

    def __init__(self, system: FamilySystem, equations: FamilyEquations) -> None:
        self.spec, self.order = system.spec, equations.order
        self.first: dict[str, int] = {}
        first = 0
        for family in equations.coordinates:
            self.first[family.name] = first
            first += len(family.members)
        self.count = first

    def values(self, lines: Sequence[Line], at: tuple[float, Array, Array, Array]) -> Array:
        """Their values for all coordinates, 0 where there is no line."""
        made = np.zeros(self.count)
        for line in lines:
            bounds = [
                np.arange(*(end.value(self.spec.sizes) for end in (one.start, one.stop)))
                for one in line.loops
            ]
            grid = [one.ravel() for one in np.meshgrid(*bounds, indexing="ij")] if bounds else []
            indices = {loop.index: one for loop, one in zip(line.loops, grid)}
            known = {**self.spec.sizes, **indices}
            count = len(grid[0]) if grid else 1
            for condition in (each for loop in line.loops for each in loop.conditions):
                chosen = np.broadcast_to(holds(condition, known), count)
                indices = {name: one[chosen] for name, one in indices.items()}
                known, count = {**self.spec.sizes, **indices}, int(chosen.sum())
            places: Any = 0
            for whole, size in zip(line.indices, line.family.shape):
                places = places * size + whole.value(known)
            places = np.broadcast_to(places, count) + self.first[line.family.name]
            made[places] = self.value(line.expression, indices, count, at)
        return made

    def value(
        self,
        expression: sympy.Expr,
        indices: dict[str, Any],
        count: int,
        at: tuple[float, Array, Array, Array],
    ) -> Any:
        """The values of an expression, whose text is read back, for all values of indices."""
        builder = FamilyBuilder(self.spec)
        tree = parse(render(expression, Text(), self.order))
        node = builder.value(tree, Members(builder.domain(count), count, {**self.spec.sizes, **indices}))
        t, q, v, parameters = at
        return np.broadcast_to(FamilyValues(builder, t, q, v, parameters).node(node), count)


def verify(
    system: FamilySystem, equations: FamilyEquations, compiled: Compiled, start: Values
) -> Verification:
    """Compare printed accelerations, momenta and h with those of the system, and with the compiled ones, at
    random states near the start. A difference is divided by the terms that forces have."""
    read = ReadBack(system, equations)
    worst = 0.0, "h", COMPILED
    with np.errstate(all="ignore"):
        for quantity, routes, difference in differences(system, equations, read, compiled, start):
            if not difference <= worst[0]:
                worst = difference, quantity, routes
    return Verification(worst[0], worst[1], STATES, worst[2], {"near the start": STATES}, False)


def differences(
    system: FamilySystem, equations: FamilyEquations, read: ReadBack, compiled: Compiled, start: Values
) -> Iterator[tuple[str, str, float]]:
    """Quantity, routes and relative difference."""
    chance = np.random.default_rng(0)
    names = [one.name for one in system.spec.coordinates]
    parameters = np.array([start.parameters[one.name] for one in system.spec.parameters])
    t = system.spec.solve.start or 0.0
    for _ in range(STATES):
        q, v = (
            np.array(one) + NEAR * (1 + np.abs(one)) * chance.uniform(-1, 1, len(one))
            for one in (start.q, start.v)
        )
        at = t, q, v, parameters
        own = FamilyValues(system, *at)
        masses = own.of(system.masses)
        sizes = own.added(len(q), system.forces.terms, sizes=True) / np.abs(masses)
        derived, printed = own.of(system.forces) / masses, read.values(equations.accelerations, at)
        for routes, other in ((COMPILED, compiled(*at)), (DERIVED, derived)):
            apart = np.abs(printed - other) / np.maximum(sizes, np.finfo(float).tiny)
            worst = int(np.argmax(np.where(np.isnan(apart), np.inf, apart)))
            yield f"{names[worst]}_ddot", routes, float(apart[worst])
        momenta = read.values(equations.momenta, at)
        apart = np.abs(momenta - masses * v) / np.maximum(np.abs(masses * v), np.finfo(float).tiny)
        yield f"p_{names[int(np.argmax(apart))]}", DERIVED, float(np.max(apart))
        kinetic, potential = (float(np.sum(own.node(one))) for one in (system.kinetic, system.potential))
        size = abs(kinetic) + potential_size(system, own)
        h = float(read.value(equations.h, {}, 1, at)[0])
        yield "h", DERIVED, abs(h - kinetic - potential) / size


def potential_size(system: FamilySystem, own: FamilyValues) -> float:
    """The sum of the absolute values of the potential's terms."""
    sums = [float(np.sum(own.added(one.count, one.terms, sizes=True))) for one in system.energies]
    return abs(float(np.sum(own.node(system.potential)))) + sum(sums)
