"""The printed equations of a system of families, read back and compared at random states: with those that are
compiled, with those derived for all members together, and with the system file differentiated directly."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values
from lagrange_cli.symbolic.direct import Direct, directly
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.readback import ReadBack, Reader, Sizes
from lagrange_cli.symbolic.verify import BOUND, COMPILED, DIRECT, Verification

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Compiled = Callable[[float, Array, Array, Array], Array]
    """(t, q, v, parameters) -> accelerations, by the compiled program."""
    Quantities = Iterator[tuple[str, str, float]]
    """Quantity, routes and relative difference."""

STATES, NEAR, FAR = 4, 0.1, 1.0
"""Drawn at random so far from the start; far from it only where that may be beyond switches."""
DERIVED = "printed and derived for all members together"
NEARBY = 2.0**-26
"""States that differ by this part, whose second differences are rounding errors."""
SMALL = 60
"""Coordinates up to which the file is differentiated directly, too: member by member."""

TOO_MANY = (
    "the sums of the printed equations have too many terms to be compared: choose smaller sizes with --size"
)


def verify(
    system: FamilySystem,
    equations: FamilyEquations,
    compiled: Compiled | None,
    start: Values,
    spec: Spec | None = None,
) -> Verification:
    """Compare printed equations, momenta and h with those of the system, and with the compiled equations (if
    any), at random states near the start. A difference is divided by the sizes of what is added up. Equations
    with the constraints of ``spec`` are compared with the file, at any multipliers.

    Raises ``UsageError`` where sums have too many terms, or equations with constraints too many coordinates.
    """
    if equations.constraints and system.q.count > SMALL:
        raise UsageError(
            f"--verify compares equations with constraints for at most {SMALL} coordinates: choose fewer "
            "with --size; their lines are the same"
        )
    worst = 0.0, "h", COMPILED
    comparison = Comparison(system, equations, compiled, start, spec or system.spec)
    with np.errstate(all="ignore"):
        for quantity, routes, difference in comparison.differences():
            if not difference <= worst[0]:
                worst = difference, quantity, routes
    where, most = "near the start", comparison.most
    if most < len(comparison.names):
        where += f", {most} member{'s' * (most > 1)} of each line at a time"
    states = {where: STATES} | ({"further away": comparison.far} if comparison.far else {})
    count = STATES + comparison.far
    return Verification(worst[0], worst[1], count, worst[2], states, False, not equations.constraints)


def blurred(of: Callable[[Array, Array], Array], q: Array, v: Array) -> Array:
    """Sizes of which the rounding errors of numbers at a state are some 2^-52, from second differences to
    states nearby: terms may cancel in them that printed equations do not have."""
    chance, found = np.random.default_rng(1), of(q, v)
    listed = []
    for _ in range(STATES):
        steps = [NEARBY * one * chance.uniform(-1.0, 1.0, len(one)) for one in (q, v)]
        listed.append(np.abs(of(q + steps[0], v + steps[1]) + of(q - steps[0], v - steps[1]) - 2.0 * found))
    return np.asarray(np.max(listed, axis=0) / NEARBY**2)


class Comparison:
    """What is compared."""

    def __init__(
        self,
        system: FamilySystem,
        equations: FamilyEquations,
        compiled: Compiled | None,
        start: Values,
        spec: Spec,
    ) -> None:
        self.system, self.equations, self.compiled, self.start = system, equations, compiled, start
        self.spec = spec
        self.read = ReadBack(system, equations)
        self.far = 0
        """States far from the start, so far."""
        self.names = [one.name for one in system.spec.coordinates]
        self.most = len(self.names)
        """Members of each line that are compared: fewer where the sums of all have too many terms, as those
        of chains have, which have sums within sums."""
        if system.joints is not None:
            self.most = max(1, min(self.most, Reader.most // (2 * self.most**2)))

    def differences(self) -> Quantities:
        """Those of all quantities at all states."""
        for at in self.states():
            yield from self.of_motion(at)
            yield from self.momenta(at)
            yield from self.energy(at)
            yield from self.places(at)

    def states(self) -> Iterator[Any]:
        """Time, coordinates, velocities, accelerations and parameters; far from the start only where motions
        have a value."""
        chance = np.random.default_rng(0)
        spec = self.system.spec
        parameters = np.array([self.start.parameters[one.name] for one in spec.parameters])
        for spread in [NEAR] * STATES + [FAR] * STATES * (self.system.smooth is not None):
            q, v = (
                np.array(one) + spread * (1 + np.abs(one)) * chance.uniform(-1, 1, len(one))
                for one in (self.start.q, self.start.v)
            )
            a = chance.uniform(-1, 1, len(q))
            at = spec.solve.start or 0.0, q, v, a, parameters
            if spread == FAR and not self.has_values(*at):
                continue
            self.far += spread == FAR
            yield at

    def has_values(self, t: float, q: Array, v: Array, a: Array, parameters: Array) -> bool:
        """Whether all quantities are numbers."""
        own = FamilyValues(self.system, t, q, v, parameters)
        found = [own.of(self.system.momenta), own.node(self.system.potential), own.node(self.system.kinetic)]
        if self.compiled is not None:
            found.append(self.compiled(t, q, v, parameters))
        return all(bool(np.all(np.isfinite(one))) for one in found)

    def of_motion(self, at: Any) -> Quantities:
        """Those of the equations of motion."""
        t, q, v, _, parameters = at
        alone = self.system.joints is None and self.system.coupled_masses is None
        if alone and self.equations.accelerations is not None:

            def derived(q: Array, v: Array) -> Array:
                own = FamilyValues(self.system, t, q, v, parameters)
                return np.asarray(own.of(self.system.forces) / own.of(self.system.masses))

            routes = {DERIVED: derived}
            if (compiled := self.compiled) is not None:
                routes[COMPILED] = lambda q, v: compiled(t, q, v, parameters)
            values, sizes = self.values(self.equations.accelerations, at)
            for route, of in routes.items():
                yield self.worst("{}_ddot", route, (values, np.maximum(sizes, blurred(of, q, v))), of(q, v))
            return
        left = [line.of(one.left - one.right) for line, one in self.equations.equations]
        if (solver := self.compiled) is not None:

            def left_over(q: Array, v: Array) -> tuple[Array, Array]:
                v = self.followed(t, q, v, parameters)
                return self.values(left, (t, q, v, solver(t, q, v, parameters), parameters))

            (rest, sizes), none = left_over(q, v), np.zeros(len(q))
            found = self.worst("the equation of {}", COMPILED, (rest, sizes), none)
            if not found[2] <= BOUND:  # perhaps by terms that cancel
                sizes = np.maximum(sizes, blurred(lambda q, v: left_over(q, v)[0], q, v))
                found = self.worst("the equation of {}", COMPILED, (rest, sizes), none)
            yield found
        if len(q) <= SMALL:
            factors = [line.of(one.factor) for line, one in self.equations.equations]
            divided = self.values(factors, at)[0]
            direct = self.directly(at)
            residual = np.array(direct.residual, dtype=float) / divided
            if self.equations.accelerations is not None and self.most >= len(q):
                solved = t, q, v, self.values(self.equations.accelerations, at)[0], parameters
                rest = np.array(self.directly(solved).residual, dtype=float) / divided
                sizes = np.maximum(*(self.values(left, one)[1] for one in (solved, at)))  # also where a is 0
                yield self.worst("{}_ddot", DIRECT, (rest, sizes), np.zeros(len(q)))
            yield self.worst("the equation of {}", DIRECT, self.values(left, at), residual)
            if self.equations.masses is not None:
                yield self.worst(
                    "M a - f of {}", DIRECT, self.of_matrix(at), np.array(direct.residual, dtype=float)
                )
            momenta = np.array(direct.momenta, dtype=float)
            yield self.worst("p_{}", DIRECT, self.values(self.equations.momenta, at), momenta)
            h, size = self.value(self.equations.h, {}, 1, at)
            yield "h", DIRECT, abs(float(h[0]) - float(direct.h)) / float(size[0] or 1)
            if self.equations.constraints:
                yield from self.of_constraints(direct, at)

    def followed(self, t: float, q: Array, v: Array, parameters: Array) -> Array:
        """Velocities, with those that follow from places."""
        first_order = self.system.first_order
        if first_order is None:
            return v
        found, rows = np.array(v), first_order.rows
        found[rows] = FamilyValues(self.system, t, q, v, parameters).of(first_order.velocities)[rows]
        return found

    def directly(self, at: Any) -> Direct:
        """What follows from the file, with any multipliers."""
        t, q, v, a, _ = at
        known, bound = self.start.parameters, self.read.multipliers.tolist()
        return directly(self.spec, known, t, q.tolist(), v.tolist(), a.tolist(), multipliers=bound)

    def of_matrix(self, at: Any) -> tuple[Array, Array]:
        """M a - f - A^T lambda, and the sizes of what is added up."""
        a, found = at[3], self.equations
        matrix = self.read.matrix(found.masses or (), at)
        force = [self.read.values(lines, at, len(a)) for lines in (found.rates or (), found.pulls) if lines]
        values = matrix @ a - sum(one for one, _ in force)
        return values, np.abs(matrix) @ np.abs(a) + sum(size for _, size in force)

    def of_constraints(self, direct: Direct, at: Any) -> Quantities:
        """Those of the constraints, and of their derivatives."""
        names = [name for family in self.read.bound for name in family.members]
        for quantity, lines, values in (
            ("{}", self.equations.constraints, direct.constraints),
            ("the derivative of {}", self.equations.allowed, direct.rates),
        ):
            printed = self.values(lines, at, len(names))
            yield self.worst(quantity, DIRECT, printed, np.array(values, dtype=float), names)

    def momenta(self, at: Any) -> Quantities:
        """Those of momenta."""
        t, q, v, _, parameters = at
        own = FamilyValues(self.system, t, q, v, parameters)
        yield self.worst(
            "p_{}", DERIVED, self.values(self.equations.momenta, at), own.of(self.system.momenta)
        )

    def energy(self, at: Any) -> Quantities:
        """That of h = sum p v - T + U, which is T + U where no place depends on t."""
        t, q, v, _, parameters = at
        own = FamilyValues(self.system, t, q, v, parameters)
        kinetic, potential = (
            float(np.sum(own.node(one))) for one in (self.system.kinetic, self.system.potential)
        )
        power = float(own.of(self.system.momenta) @ v)
        h, size = self.value(self.equations.h, {}, 1, at)
        least = abs(power) + abs(kinetic) + float(np.sum(Sizes(own).node(self.system.potential)))
        yield "h", DERIVED, abs(float(h[0]) - power + kinetic - potential) / max(least, float(size[0]))

    def places(self, at: Any) -> Quantities:
        """Those of places that have names."""
        for one in self.equations.places:
            ranges = [np.arange(loop.start.value(self.read.sizes), loop.stop.value(self.read.sizes))
                      for loop in one.loops]  # fmt: skip
            grid = [each.ravel()[: self.most] for each in np.meshgrid(*ranges, indexing="ij")]
            indices = {loop.index: each for loop, each in zip(one.loops, grid)}
            apart, size = self.value(one.expression - one.symbol, indices, len(grid[0]), at)
            yield one.symbol.name, DERIVED, float(np.max(np.abs(apart) / np.maximum(size, 1e-300)))

    def values(self, lines: Sequence[Line], at: Any, count: int | None = None) -> tuple[Array, Array]:
        """The values of lines and their sizes, of as many members as is possible; of coordinates, or of a
        ``count`` of constraints."""
        while True:
            try:
                return self.read.values(lines, at, self.most, count)
            except Unsuited as error:
                if self.most == 1:
                    raise UsageError(TOO_MANY) from error
                self.most = (self.most + 1) // 2

    def value(self, expression: Any, indices: dict[str, Any], count: int, at: Any) -> tuple[Array, Array]:
        """The values of an expression and their sizes, for all values of indices."""
        try:
            return self.read.value(expression, indices, count, at)
        except Unsuited as error:
            raise UsageError(TOO_MANY) from error

    def worst(
        self,
        quantity: str,
        routes: str,
        printed: tuple[Array, Array],
        other: Array,
        names: Sequence[str] = (),
    ) -> tuple[str, str, float]:
        """The largest difference of the members that are compared."""
        values, sizes = printed
        compared = np.flatnonzero(~np.isnan(sizes))
        apart = np.abs(values - other)[compared] / np.maximum(sizes[compared], np.finfo(float).tiny)
        k = int(np.argmax(np.where(np.isnan(apart), np.inf, apart)))
        return quantity.format((names or self.names)[compared[k]]), routes, float(apart[k])
