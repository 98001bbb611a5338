"""What the file of a system of families gives, with indices: energies, forces, and where particles are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import TIME, acceleration_name, velocity_name
from lagrange_cli.families.bonds import bound_families
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import group_of, particle_families
from lagrange_cli.spec.spec import Expression, Family, Spec, grouped
from lagrange_cli.symbolic.families.bodies import rotational, torques
from lagrange_cli.symbolic.families.derivatives import Part, parts, spans_within
from lagrange_cli.symbolic.families.frames import Frame, Kind
from lagrange_cli.symbolic.families.lines import Line, Lines
from lagrange_cli.symbolic.families.places import RATES, WrittenPlaces
from lagrange_cli.symbolic.families.sums import exchanged
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Loops, Ranks, Summed, opened, rate_of, summed_of
from lagrange_cli.symbolic.indexed.whole import Spans
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.textbook import neat


class Given:
    """The file of a system, or another ``spec`` that has constraints besides; places along chains have names
    if ``naming``."""

    def __init__(self, system: FamilySystem, spec: Spec | None = None, *, naming: bool = False) -> None:
        self.system, self.spec = system, spec or system.spec
        self.builder = WrittenPlaces(self.spec, naming=naming)
        self.order = Order(Ranks(roles(self.spec)), self.spec.decimals)
        self.lines = Lines(self.builder, self.order)

    def kinds(self, family: Family, written: Mapping[str, Expression]) -> Iterator[Kind]:
        """The members of a family that are written alike."""
        return self.builder.of_family(group_of(family, written))

    def particles(self) -> Iterator[tuple[tuple[Loop, ...], tuple[sympy.Expr, ...], sympy.Expr]]:
        """Members of families of particles: the loops through them, where they are, and their masses."""
        spec = self.spec
        for family in grouped(spec.embedding, particle_families(spec)):
            follows = self.builder.follows(group_of(family, spec.embedding))
            for kind in self.kinds(family, spec.masses if follows else spec.embedding):
                mass = self.elsewhere(kind, family, spec.masses)
                where = self.elsewhere(kind, family, spec.embedding)
                for loops, (place, (own,)) in self.values(kind, where, mass):
                    yield loops, place, own

    def values(
        self, kind: Kind, *trees: Callable[[Frame], Any]
    ) -> Iterator[tuple[tuple[Loop, ...], list[tuple[sympy.Expr, ...]]]]:
        """The values of the members of a kind, in parts that are alike, with their loops."""

        def build(frame: Frame) -> list[tuple[sympy.Expr, ...]]:
            made = [one(frame) for one in trees]
            return [one if isinstance(one, tuple) else (one,) for one in made]

        yield from self.builder.kinds(kind.loops, kind.frame, build)

    def written(self, kind: Kind) -> Callable[[Frame], Any]:
        """The builder of the expression of a kind's members."""
        return lambda frame: self.builder.value(kind.tree, frame)

    def elsewhere(
        self, kind: Kind, family: Family, given: Mapping[str, Expression]
    ) -> Callable[[Frame], Any]:
        """What builds what is written elsewhere of the members of a kind, and of others."""
        group = group_of(particle_families(self.spec).get(family.name, family), given)
        return self.builder.among(group, kind)

    def parts(self, expression: sympy.Expr, base: str, around: Sequence[Loop] = ()) -> Iterator[Part]:
        """The derivatives of an expression within loops by the members of a family."""
        return parts(expression, base, self.builder.meaning, around)

    def explicit_rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The partial derivative by t."""

        def rate(symbol: sympy.Symbol) -> sympy.Expr | None:
            meaning = self.builder.meaning(*KNOWN[symbol.name]) if symbol.name in KNOWN else None
            return None if meaning is None else self.explicit_rate(meaning)

        return rate_of(expression, rate)

    def constraints(self) -> Iterator[tuple[Line, bool]]:
        """The expressions that constraints keep at 0, and whether these are holonomic. Raises ``Unsuited``
        where they are not linear in the velocities."""
        for family, section, holonomic in bound_families(self.spec):
            for kind in self.kinds(family, section):
                for loops, ((one,),) in self.values(kind, self.written(kind)):
                    if not holonomic and any(map(self.is_moving, self.slopes(one))):
                        raise Unsuited
                    yield Line(family, kind.indices, loops, one), holonomic

    def slopes(self, expression: sympy.Expr) -> Iterator[sympy.Expr]:
        """The derivatives of an expression by velocities, each as far as it is one product."""
        for family in self.builder.coordinates:
            yield from (one.factor for one in self.parts(expression, velocity_name(family.name)))

    def is_moving(self, expression: sympy.Expr) -> bool:
        """Whether an expression contains velocities."""
        return self.order.role(expression) >= Role.VELOCITY

    def drift(self, expression: sympy.Expr, holonomic: bool) -> sympy.Expr:
        """What a constraint says of the velocities where these are 0: df/dt, or g itself."""
        return self.explicit_rate(expression) if holonomic else self.at_rest(expression)

    def at_rest(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression where all velocities are 0."""
        plain, sums = opened(expression)
        still = {one: sympy.S.Zero for one in plain.free_symbols - sums.keys() if self.is_moving(one)}
        inside = {symbol: Summed(self.at_rest(one.body), one.args[1]) for symbol, one in sums.items()}
        return plain.xreplace(still).xreplace(inside)

    def energies(self) -> tuple[sympy.Expr | None, sympy.Expr]:
        """T and U; None and L."""
        spec = self.spec
        if spec.lagrangian is not None:
            return None, self.builder.scalar(spec.lagrangian)
        return self.kinetic(), sympy.Add(*map(self.builder.scalar, spec.potential.values()))

    def applied(self, name: str) -> Iterator[Part]:
        """The parts of Q by the members of a family of coordinates."""
        spec, forces = self.spec, self.spec.forces
        written = forces.get("generalized_forces", {})
        for family in grouped(written, spec.families.get("generalized_forces", {})):
            if family.name == name:
                for kind in self.kinds(family, written):
                    for loops, ((force,),) in self.values(kind, self.written(kind)):
                        yield Part(force, loops, kind.indices)
        written = forces.get("forces", {})
        families = {**particle_families(spec), **spec.families.get("forces", {})}
        for family in grouped(written, families):
            for kind in self.kinds(family, written):
                position = self.elsewhere(kind, family, spec.embedding)
                for loops, (acting, place) in self.values(kind, self.written(kind), position):
                    for force, x in zip(acting, place, strict=True):
                        for one in self.parts(x, name, loops):
                            yield Part(force * one.factor, (*loops, *one.loops), one.indices)
        yield from torques(self.builder, name, self.builder.meaning)
        for power in forces.get("dissipation", {}).values():
            for each in self.parts(self.builder.scalar(power), velocity_name(name)):
                yield Part(-each.factor, each.loops, each.indices)

    def kinetic(self, *, moving: bool = False) -> sympy.Expr:
        """T; if ``moving``, T2 - T0: its terms of degree 2 in velocities minus those of degree 0, which are
        where the places depend on t (Goldstein, Classical Mechanics, eq. 2.57)."""

        def square(x: sympy.Expr) -> sympy.Expr:
            if not moving:
                return self.builder.rate(x) ** 2
            speed = self.builder.rate(x)
            return speed**2 - 2 * speed * self.explicit_rate(x)

        turning, found = rotational(self.builder, self.at_rest if moving else None), sympy.S.Zero
        for loops, place, mass in self.particles():
            own = sympy.Add(*(mass * square(x) / 2 for x in place), turning.pop(loops, sympy.S.Zero))
            found += Summed(own, Loops(loops))
        return sympy.Add(found, *(Summed(own, Loops(loops)) for loops, own in turning.items()))

    def even(self, expression: sympy.Expr) -> sympy.Expr:
        """A Lagrangian without its terms that are linear in velocities."""
        plain, sums = opened(expression)
        back = {one: -one for one in plain.free_symbols - sums.keys() if self.is_moving(one)}
        inside = {symbol: Summed(self.even(one.body), one.args[1]) for symbol, one in sums.items()}
        return sympy.expand((plain + plain.xreplace(back)) / 2).xreplace(inside)

    def energy(self, expression: sympy.Expr) -> sympy.Expr:
        """h = sum of p v - L of a given L: its terms that are quadratic in velocities, minus the others."""
        if expression.is_Add:
            return sympy.Add(*map(self.energy, expression.args))
        if isinstance(expression, Summed):
            return Summed(self.energy(sympy.expand_mul(expression.body)), expression.args[1])
        moving = [one for one in sympy.Mul.make_args(expression) if self.order.role(one) >= Role.VELOCITY]
        if not moving:
            return -expression
        if len(moving) == 1 and (moving[0].is_Add or isinstance(moving[0], Summed)):
            return expression / moving[0] * self.energy(moving[0])
        return expression

    def neat(self, expression: sympy.Expr, around: Spans | None = None) -> sympy.Expr:
        """An expression and the bodies of its sums in textbook form; ``around`` has the bounds of indices."""
        spans = self.lines.sizes if around is None else around
        if isinstance(expression, Summed):
            fewer = exchanged(expression, spans)
            if fewer != expression:
                return self.neat(fewer, spans)
            inside = spans_within(expression.loops, spans)
            return summed_of(self.neat(expression.body, inside), expression.loops)
        if expression.has(Summed):
            expression = expression.func(*(self.neat(one, spans) for one in expression.args))
        return neat(expression, self.order, Role.COORDINATE)


def multiplier_name(constraint: str) -> str:
    """``lambda_rod`` for ``rod``, ``lambda_body_norm`` for ``body.norm``."""
    return f"lambda_{constraint.replace('.', '_')}"


def roles(spec: Spec) -> dict[str, tuple[Role, int]]:
    """The role and rank of each family."""
    found: dict[str, tuple[Role, int]] = {TIME: (Role.TIME, 0)}
    for rank, name in enumerate(dict.fromkeys(one.name.partition("[")[0] for one in spec.parameters)):
        found[name] = Role.PARAMETER, rank
    for rank, name in enumerate(dict.fromkeys(one.name.partition("[")[0] for one in spec.coordinates)):
        found[name] = Role.COORDINATE, rank
        found[velocity_name(name)] = Role.VELOCITY, rank
        found[acceleration_name(name)] = Role.ACCELERATION, rank
    for rank, (family, _, _) in enumerate(bound_families(spec)):
        name = multiplier_name(family.name)
        if name in found:
            raise Unsuited
        found[name] = Role.MULTIPLIER, rank
    first = len(spec.coordinates)
    for particle in particle_families(spec):
        for components, role in zip(RATES, (Role.COORDINATE, Role.VELOCITY, Role.ACCELERATION)):
            found |= {f"{particle}.{one}": (role, first + k) for k, one in enumerate(components)}
        first += 1
    return found
