"""``FamilyEquations``: what ``equations`` shows of a system of families, with their indices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import (
    COMPONENTS,
    TIME,
    acceleration_name,
    velocity_name,
)
from lagrange_cli.families.conservation import constants_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import group_of, particle_families
from lagrange_cli.mechanics.conserved.displacements import TURNS
from lagrange_cli.model.constraints import without_force, without_work
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Expression, Family, Spec, grouped
from lagrange_cli.symbolic.equations import Changing, Conserved, Equation
from lagrange_cli.symbolic.families.builder import LETTERS
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.derivatives import Part, parts, spans_within
from lagrange_cli.symbolic.families.frames import Frame, Kind, Split
from lagrange_cli.symbolic.families.lines import Line, Lines
from lagrange_cli.symbolic.families.places import RATES, NamedPlace, WrittenPlaces
from lagrange_cli.symbolic.families.sums import exchanged, finished
from lagrange_cli.symbolic.grouping import neat, tidy
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Loops, Ranks, Summed, member, opened, summed_of
from lagrange_cli.symbolic.indexed.whole import Spans
from lagrange_cli.symbolic.order import Order, Role, is_negative
from lagrange_cli.symbolic.textbook import textbook_form
from lagrange_cli.symbolic.work import size_of

MASS, SLOPE, FORCE, INERTIA = "p", "dL/dq", "Q", "m a dr/dq"


@dataclass(frozen=True)
class FamilyEquations:
    """The equations of motion of a system of families. ``T`` and ``U`` are None where the file gives L.
    ``momenta``, ``accelerations``, ``forces`` (those outside L, where there are any) and ``equations`` have a
    line for members that are alike; the ``expression`` of an equation's line is its left side. Of chains and
    trees there are no ``accelerations``: their equations are not solved. ``paths`` are those along trees."""

    name: str
    degrees_of_freedom: int
    sizes: Mapping[str, int]
    coordinates: tuple[Family, ...]
    parameters: tuple[Family, ...]
    order: Order
    T: sympy.Expr | None
    U: sympy.Expr | None
    L: sympy.Expr
    h: sympy.Expr
    momenta: tuple[Line, ...]
    forces: tuple[Line, ...]
    equations: tuple[tuple[Line, Equation], ...]
    accelerations: tuple[Line, ...] | None
    conserved: tuple[Conserved, ...]
    changing: tuple[Changing, ...]
    paths: tuple[Path, ...]
    places: tuple[NamedPlace, ...]
    """Where particles are, for places that are written by name, and their velocities and accelerations."""


def family_equations(system: FamilySystem) -> FamilyEquations | None:
    """The equations, None where the conditions of a family are too irregular to be written with indices.

    Places along chains are written as the sums that they are, or by name, whatever is shorter.
    """
    with suppress(Unsuited, Split, ExpressionError, ArithmeticError):
        closed = _Deriver(system).equations()
        if system.joints is None:
            return closed
        by_name = _Deriver(system, naming=True).equations()
        return min(closed, by_name, key=length)
    return None


def length(equations: FamilyEquations) -> int:
    """Terms and factors of everything."""
    energies = [one for one in (equations.T, equations.U, equations.h) if one is not None]
    lines = (*equations.momenta, *equations.places, *(line for line, _ in equations.equations))
    return sum(map(size_of, (*energies, *(one.expression for one in lines))))


class _Deriver:
    def __init__(self, system: FamilySystem, *, naming: bool = False) -> None:
        self.system, self.spec = system, system.spec
        self.builder = WrittenPlaces(self.spec, naming=naming)
        self.order = Order(Ranks(roles(self.spec)), self.spec.decimals)
        self.lines = Lines(self.builder, self.order)

    # what the file gives

    def kinds(self, family: Family, written: Mapping[str, Expression]) -> Iterator[Kind]:
        """The members of a family that are written alike."""
        return self.builder.of_family(group_of(family, written))

    def particles(self) -> Iterator[tuple[tuple[Loop, ...], tuple[sympy.Expr, ...], sympy.Expr]]:
        """Members of families of particles: the loops through them, where they are, and their masses."""
        spec = self.spec
        for family in grouped(spec.embedding, particle_families(spec)):
            for kind in self.kinds(family, spec.embedding):
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
        """What builds what is written elsewhere of the members of a kind."""
        group = group_of(family, given)

        def build(frame: Frame) -> Any:
            known = {**self.spec.sizes, **frame.arrays}
            return self.builder.of_group(
                group, kind.indices, [one.value(known) for one in kind.indices], frame
            )

        return build

    def parts(self, expression: sympy.Expr, base: str) -> Iterator[Part]:
        """The derivatives of an expression by the members of a family."""
        return parts(expression, base, self.builder.meaning)

    def explicit_rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The partial derivative by t."""
        plain, sums = opened(expression)
        made = plain.diff(sympy.Symbol(TIME))
        for symbol in sorted(plain.free_symbols, key=str):
            if symbol in sums:
                one = sums[symbol]
                made += plain.diff(symbol) * Summed(self.explicit_rate(one.body), one.args[1])
                continue
            meaning = self.builder.meaning(*KNOWN[symbol.name]) if symbol.name in KNOWN else None
            if meaning is not None:
                made += plain.diff(symbol) * self.explicit_rate(meaning)
        return made.xreplace(sums)

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
                        for one in self.parts(x, name):
                            yield Part(force * one.factor, (*loops, *one.loops), one.indices)
        for power in forces.get("dissipation", {}).values():
            for each in self.parts(self.builder.scalar(power), velocity_name(name)):
                yield Part(-each.factor, each.loops, each.indices)

    # what follows

    def equations(self) -> FamilyEquations:
        """All of them."""
        spec, order = self.spec, self.order
        kinetic, potential = self.energies()
        lagrangian = potential if kinetic is None else kinetic - potential
        inertia = lagrangian if kinetic is None else kinetic
        momenta, forces, equations, accelerations = [], [], [], []
        for family in self.builder.coordinates:
            mass = {MASS: [*self.parts(inertia, velocity_name(family.name))]}
            momenta += [line.of(own[MASS]) for line, own in self.lines.of(family, mass)]
            force = {FORCE: [*self.applied(family.name)]}
            if force[FORCE]:
                lines = self.lines.of(family, force)
                forces += [line.of(own[FORCE]) for line, own in lines if own[FORCE] != 0]
            if self.system.joints is not None:
                equations += self.balanced(family, potential, force)
                continue
            several = {**mass, **force, SLOPE: [*self.parts(lagrangian, family.name)]}
            for line, own in self.lines.of(family, several):
                equation, acceleration = self.solved(line, own)
                equations.append((line.of(equation.left), equation))
                accelerations.append(line.of(acceleration))
        left = [line for line, _ in equations]
        conserved, changing = self.balance(lagrangian, momenta, forces)
        h = self.neat(self.energy(lagrangian) if kinetic is None else self.kinetic(moving=True) + potential)
        found = FamilyEquations(
            name=spec.name,
            degrees_of_freedom=spec.degrees_of_freedom,
            sizes=spec.sizes,
            coordinates=self.builder.coordinates,
            parameters=grouped([one.name for one in spec.parameters], spec.families.get("parameters", {})),
            order=order,
            T=None if kinetic is None else self.neat(kinetic),
            U=None if kinetic is None else self.neat(potential),
            L=self.neat(lagrangian),
            h=h,
            momenta=tuple(momenta),
            forces=tuple(forces),
            equations=tuple(equations),
            accelerations=None if self.system.joints is not None else tuple(accelerations),
            conserved=tuple(conserved),
            changing=tuple(changing),
            paths=tuple(self.builder.paths),
            places=tuple(self.places(lagrangian, h, *(one.expression for one in (*momenta, *forces, *left)))),
        )
        return self.finished(found)

    def finished(self, found: FamilyEquations) -> FamilyEquations:
        """The equations as they are printed."""
        paths = {one.name for one in self.builder.paths}
        letters = [one for one in LETTERS if one not in self.builder.taken]

        def shown(expression: sympy.Expr, around: Sequence[Loop] = ()) -> sympy.Expr:
            used = {one.index for one in around}
            return finished(expression, [one for one in letters if one not in used], paths)

        def lines(listed: Sequence[Line]) -> tuple[Line, ...]:
            return tuple(one.of(shown(one.expression, one.loops)) for one in listed)

        return replace(
            found,
            T=None if found.T is None else shown(found.T),
            U=None if found.U is None else shown(found.U),
            L=shown(found.L),
            h=shown(found.h),
            momenta=lines(found.momenta),
            forces=lines(found.forces),
            equations=tuple(
                (line, replace(one, left=shown(one.left, line.loops), right=shown(one.right, line.loops)))
                for line, one in found.equations
            ),
            accelerations=None if found.accelerations is None else lines(found.accelerations),
            conserved=tuple(replace(one, expression=shown(one.expression)) for one in found.conserved),
            changing=tuple(replace(one, rate=shown(one.rate)) for one in found.changing),
            places=tuple(
                replace(one, expression=shown(one.expression, one.loops)) for one in found.places
            ),
        )

    def places(self, *expressions: sympy.Expr) -> Iterator[NamedPlace]:
        """What the names of places in expressions stand for."""
        symbols = [symbol.name for one in expressions for symbol in one.free_symbols]
        used = {KNOWN[name][0] for name in symbols if name in KNOWN}
        for one in self.builder.written_places(used):
            expression = self.lines.shown(one.expression, {}, one.loops)
            yield NamedPlace(one.symbol, one.loops, expression)

    def solved(self, line: Line, own: Mapping[str, sympy.Expr]) -> tuple[Equation, sympy.Expr]:
        """The equation of a line, where M is diagonal and constant, and the acceleration."""
        name, order = line.family.name, self.order
        v, a = (symbol_of(line, one) for one in (velocity_name(name), acceleration_name(name)))
        mass = tidy(own[MASS].diff(v) if not own[MASS].has(Summed) else self.mass(own[MASS], v), order)
        force = own[SLOPE] + own[FORCE]
        return textbook_form(mass * a - force, order), tidy(force / mass, order)

    def balanced(
        self, family: Family, potential: sympy.Expr, force: Mapping[str, Sequence[Part]]
    ) -> Iterator[tuple[Line, Equation]]:
        """The equations of a family where M is another: sum of m a . dr/dq = -dU/dq + Q (d'Alembert)."""
        rate = self.builder.rate
        inertia = [
            Part(mass * rate(rate(x)) * one.factor, (*loops, *one.loops), one.indices)
            for loops, place, mass in self.particles()
            for x in place
            for one in self.parts(x, family.name)
        ]
        several = {INERTIA: inertia, SLOPE: [*self.parts(potential, family.name)], **force}
        for line, own in self.lines.of(family, several):
            equation = textbook_form(own[INERTIA] + own[SLOPE] - own[FORCE], self.order)
            sign = -1 if is_negative(self.order.sorted_terms(equation.left)[0]) else 1
            equation = Equation(sign * equation.left, sign * equation.right, sign * equation.factor)
            yield line.of(equation.left), equation

    def kinetic(self, *, moving: bool = False) -> sympy.Expr:
        """T; if ``moving``, T2 - T0: its terms of degree 2 in velocities minus those of degree 0, which are
        where the places depend on t (Goldstein, Classical Mechanics, eq. 2.57)."""

        def square(x: sympy.Expr) -> sympy.Expr:
            if not moving:
                return self.builder.rate(x) ** 2
            speed = self.builder.rate(x)
            return speed**2 - 2 * speed * self.explicit_rate(x)

        return sympy.Add(
            *(
                Summed(sympy.Add(*(mass * square(x) / 2 for x in place)), Loops(loops))
                for loops, place, mass in self.particles()
            )
        )

    @staticmethod
    def mass(momentum: sympy.Expr, v: sympy.Symbol) -> sympy.Expr:
        """dp/dv where p has sums that do not contain v."""
        plain, sums = opened(momentum)
        if any(v in one.body.free_symbols for one in sums.values()):
            raise Unsuited
        return plain.diff(v).xreplace(sums)

    def neat(self, expression: sympy.Expr, around: Spans | None = None) -> sympy.Expr:
        """An expression in textbook form, and the bodies of its sums; ``around`` has the bounds of indices."""
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

    # what is conserved

    def balance(
        self, lagrangian: sympy.Expr, momenta: Sequence[Line], forces: Sequence[Line]
    ) -> tuple[list[Conserved], list[Changing]]:
        """The conserved quantities with reasons, and those that are not conserved."""
        constants = constants_of(self.system)
        names = {each.quantity for each in constants.conserved}
        conserved = [*self.cyclic(names, momenta)]
        changing = []
        if "h" in names:
            because = "`L` does not contain `t` explicitly" + without_work(self.system.driven, False)
            plain = "; `h = T + U` (no `t` in the embedding, no velocities in `U`)"
            because += plain if self.spec.lagrangian is None else ""
            conserved.append(Conserved("h", sympy.S.Zero, because))
        else:
            reasons = [] if self.system.steady_potential else ["`L` contains `t` explicitly"]
            power = sympy.Add(
                *(
                    Summed(tidy(one.expression * symbol_of(one, velocity_name(one.family.name)), self.order),
                           Loops(one.loops))
                    for one in forces
                )
            )  # fmt: skip
            reasons += ["generalized forces or friction do work"] * (power != 0)
            rate = tidy(power - self.explicit_rate(lagrangian), self.order)
            changing.append(Changing("h", rate, " and ".join(reasons)))
        texts = dict(self.displaced(momenta))
        for each in constants.conserved:
            if each.quantity in texts:
                expression = texts[each.quantity]
                conserved.append(Conserved(each.quantity, self.neat(expression), each.because))
        return conserved, changing

    def cyclic(self, names: set[str], momenta: Sequence[Line]) -> Iterator[Conserved]:
        """Momenta of cyclic coordinates: one for a family, if all of its members are cyclic."""
        for family in self.builder.coordinates:
            own = [line for line in momenta if line.family is family]
            kept = [name for name in family.members if f"p_{name}" in names]
            if len(kept) == len(family.members):
                shown = [(one.name(), one.expression) for one in own]
            else:
                shown = [(name, sympy.S.Zero) for name in kept]
            for name, expression in shown:
                because = f"`{name}` is cyclic: `L` does not contain it, and {without_force(False)}"
                yield Conserved(f"p_{name}", expression, because)

    def displaced(self, momenta: Sequence[Line]) -> Iterator[tuple[str, sympy.Expr]]:
        """What displacements of all particles, or of all members of a family, conserve."""
        if self.spec.lagrangian is not None:
            for family in self.builder.coordinates:
                own = [one for one in momenta if one.family is family]
                yield (
                    f"P_{family.name}",
                    sympy.Add(*(Summed(one.expression, Loops(one.loops)) for one in own)),
                )
            return
        particles = [*self.particles()]
        rate, t = self.builder.rate, sympy.Symbol(TIME)

        def total(of: object) -> sympy.Expr:
            return sympy.Add(*(Summed(of(place, mass), Loops(loops)) for loops, place, mass in particles))  # type: ignore[operator]

        axes = max(len(place) for _, place, _ in particles)
        for k in range(axes):
            momentum = total(lambda x, m, k=k: m * rate(x[k]) if len(x) > k else sympy.S.Zero)
            centre = total(lambda x, m, k=k: m * x[k] if len(x) > k else sympy.S.Zero)
            yield f"P_{COMPONENTS[k]}", momentum
            yield f"K_{COMPONENTS[k]}", t * momentum - centre
        for name, (i, j) in TURNS.items():
            if max(i, j) < min(len(place) for _, place, _ in particles):
                yield f"L_{name}", total(lambda x, m, i=i, j=j: m * (x[i] * rate(x[j]) - x[j] * rate(x[i])))


def symbol_of(line: Line, base: str) -> sympy.Symbol:
    """A symbol with a line's indices."""
    return member(base, line.indices) if line.indices else sympy.Symbol(base)


def roles(spec: Spec) -> dict[str, tuple[Role, int]]:
    """The role and rank of each family."""
    found: dict[str, tuple[Role, int]] = {TIME: (Role.TIME, 0)}
    for rank, name in enumerate(dict.fromkeys(one.name.partition("[")[0] for one in spec.parameters)):
        found[name] = Role.PARAMETER, rank
    for rank, name in enumerate(dict.fromkeys(one.name.partition("[")[0] for one in spec.coordinates)):
        found[name] = Role.COORDINATE, rank
        found[velocity_name(name)] = Role.VELOCITY, rank
        found[acceleration_name(name)] = Role.ACCELERATION, rank
    first = len(spec.coordinates)
    for family in particle_families(spec):
        for components, role in zip(RATES, (Role.COORDINATE, Role.VELOCITY, Role.ACCELERATION)):
            found |= {f"{family}.{one}": (role, first + k) for k, one in enumerate(components)}
        first += 1
    return found
