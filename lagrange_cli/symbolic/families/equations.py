"""``FamilyEquations``: what ``equations`` shows of a system of families, with their indices."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import acceleration_name, velocity_name
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.symbolic.equations import Changing, Conserved, Equation
from lagrange_cli.symbolic.families.balance import balance
from lagrange_cli.symbolic.families.bodies import rotational
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.derivatives import Part, spans_within
from lagrange_cli.symbolic.families.frames import Split
from lagrange_cli.symbolic.families.given import Given, multiplier_name
from lagrange_cli.symbolic.families.kinds import LETTERS
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.families.places import NamedPlace
from lagrange_cli.symbolic.families.reactions import ReactionForm
from lagrange_cli.symbolic.families.sums import finished
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Loops, Summed, opened
from lagrange_cli.symbolic.order import Order, Role, is_negative
from lagrange_cli.symbolic.textbook import textbook_form
from lagrange_cli.symbolic.work import attempt, size_of

AS_SUMS = 5_000_000
"""Steps of work for the equations in which places are sums: there are others."""
MASS, SLOPE, FORCE, INERTIA, PULL = "p", "dL/dq", "Q", "m a dr/dq", "lambda df/dq"
FIELD = "m a - dp/dt"


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
    masses: tuple[Line, ...] | None
    """The diagonal of M in M a = f, where M is diagonal; None of chains and trees."""
    rates: tuple[Line, ...] | None
    """f, the forces but those of constraint, likewise."""
    conserved: tuple[Conserved, ...]
    changing: tuple[Changing, ...]
    paths: tuple[Path, ...]
    constraints: tuple[Line, ...]
    """Expressions that are 0, each with a multiplier."""
    nonholonomic: frozenset[str]
    """The names of the families of those that are on velocities."""
    pulls: tuple[Line, ...]
    """A^T lambda, the forces of constraint on coordinates, where M is diagonal."""
    driving: tuple[Line, ...]
    """f + A^T lambda, the rates of momenta, likewise."""
    allowed: tuple[Line, ...]
    """The second derivatives of the constraints, and the first ones of those on velocities, which are 0, too.
    """
    places: tuple[NamedPlace, ...]
    """Where particles are, for places that are written by name, and their velocities and accelerations."""
    reactions: ReactionForm | None = None
    """The forces of constraint on particles, where they have been asked for."""

    @property
    def bound(self) -> Sequence[Family]:
        """The families of constraints."""
        return [*{one.family.name: one.family for one in self.constraints}.values()]


def family_equations(system: FamilySystem, spec: Spec | None = None) -> FamilyEquations | None:
    """The equations, with the constraints of ``spec`` if it is given; None where the conditions of a family
    are too irregular to be written with indices.

    Places along chains are written as the sums that they are, or by name, whatever is shorter.
    """
    with suppress(Unsuited, Split, ExpressionError, ArithmeticError):
        if system.joints is None:
            return equations_of(system, spec, naming=False)
        by_name = equations_of(system, spec, naming=True)
        closed = attempt(AS_SUMS, partial(equations_of, system, spec, naming=False))
        return by_name if closed is None else min(closed, by_name, key=length)
    return None


def equations_of(system: FamilySystem, spec: Spec | None = None, *, naming: bool) -> FamilyEquations:
    """The equations; if ``naming``, with names of places along chains. Raises ``Unsuited``, ``Split``,
    ``ExpressionError`` or ``ArithmeticError`` where they cannot be written with indices."""
    return _Deriver(system, spec, naming=naming).equations()


def length(equations: FamilyEquations) -> int:
    """Terms and factors of everything."""
    found = [one for one in (equations.T, equations.U, equations.h) if one is not None]
    found += [one.expression for one in equations.momenta]
    found += [one.expression for one in equations.places]
    found += [one.expression for one in equations.constraints]
    found += [line.expression for line, _ in equations.equations]
    return sum(size_of(one) for one in found)


class _Deriver(Given):
    def equations(self) -> FamilyEquations:
        """All of them."""
        spec, order = self.spec, self.order
        kinetic, potential = self.energies()
        lagrangian = potential if kinetic is None else kinetic - potential
        inertia = kinetic if kinetic is not None and self.system.vector is None else lagrangian
        momenta, forces, accelerations, masses, rates, pulls = [], [], [], [], [], []
        driving: list[Line] = []
        equations: list[tuple[Line, Equation]] = []
        constraints = [*self.constraints()]
        by_places, by_speeds = (
            self.with_multipliers((one, one.expression) for one, own in constraints if own is holonomic)
            for holonomic in (True, False)
        )
        diagonal = self.system.joints is None
        for family in self.builder.coordinates:
            inertial = {MASS: [*self.parts(inertia, velocity_name(family.name))]}
            for line, own in self.lines.of(family, inertial):
                momenta.append(line.of(self.total(own)))
                if diagonal:
                    masses.append(line.of(self.mass_of(line, own[MASS])))
            force = {FORCE: [*self.applied(family.name)]}
            if force[FORCE]:
                lines = self.lines.of(family, force)
                forces += [line.of(own[FORCE]) for line, own in lines if own[FORCE] != 0]
            held = {
                PULL: [
                    *self.parts(by_places, family.name),
                    *self.parts(by_speeds, velocity_name(family.name)),
                ]
            }
            if not diagonal:
                equations += self.balanced(family, potential, {**force, **held})
                continue
            several = {**inertial, **force, **held, SLOPE: [*self.parts(lagrangian, family.name)]}
            several[FIELD] = [*self.of_field(inertial[MASS])]
            for line, own in self.lines.of(family, several):
                equation, acceleration = self.solved(line, own)
                equations.append((line.of(equation.left), equation))
                accelerations.append(line.of(acceleration))
                driving.append(line.of(self.total({**own, MASS: sympy.S.Zero, FIELD: sympy.S.Zero})))
            if constraints or several[FIELD]:
                of_file = {**force, SLOPE: several[SLOPE], FIELD: several[FIELD]}
                rates += [line.of(self.total(own)) for line, own in self.lines.of(family, of_file)]
                pulls += [line.of(self.total(own)) for line, own in self.lines.of(family, held)]
        bound = [one.of(self.of_members(one.expression, one.loops)) for one, _ in constraints]
        written = [one.expression for one in (*momenta, *forces, *bound, *(line for line, _ in equations))]
        drawn = -self.with_multipliers((one, self.drift(one.expression, own)) for one, own in constraints)
        conserved, changing = balance(self, lagrangian, momenta, forces, drawn)
        if kinetic is None:
            h = self.energy(lagrangian if self.system.vector is None else self.even(lagrangian))
        else:
            at_rest = potential if self.system.vector is None else self.at_rest(potential)
            h = self.kinetic(moving=True) + at_rest
        h = self.neat(h)
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
            accelerations=tuple(accelerations) if diagonal and not constraints else None,
            masses=tuple(masses) if diagonal else None,
            rates=tuple(rates or driving) if diagonal else None,
            conserved=tuple(conserved),
            changing=tuple(changing),
            paths=tuple(self.builder.paths),
            constraints=tuple(bound),
            nonholonomic=frozenset(one.family.name for one, holonomic in constraints if not holonomic),
            pulls=tuple(pulls),
            driving=tuple(driving),
            allowed=tuple(
                one.of(self.of_members(self.second_rate(one.expression, own), one.loops))
                for one, own in constraints
            ),
            places=tuple(self.places(lagrangian, h, *written)),
        )
        return self.finished(found)

    @staticmethod
    def with_multipliers(listed: Iterable[tuple[Line, sympy.Expr]]) -> sympy.Expr:
        """The sum of expressions of constraints, each times its multiplier."""
        return sympy.Add(
            *(Summed(symbol_of(one, multiplier_name(one.family.name)) * expression, Loops(one.loops))
              for one, expression in listed)
        )  # fmt: skip

    def second_rate(self, expression: sympy.Expr, holonomic: bool) -> sympy.Expr:
        """What a constraint says of the accelerations: its second derivative, or the first of one on
        velocities."""
        rate = self.builder.rate
        return rate(rate(expression)) if holonomic else rate(expression)

    def of_members(self, expression: sympy.Expr, loops: Sequence[Loop]) -> sympy.Expr:
        """An expression of members in textbook form."""
        return self.neat(expression, spans_within(loops, self.lines.sizes))

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
            rates=None if found.rates is None else lines(found.rates),
            constraints=lines(found.constraints),
            pulls=lines(found.pulls),
            driving=lines(found.driving),
            allowed=lines(found.allowed),
            conserved=tuple(replace(one, expression=shown(one.expression)) for one in found.conserved),
            changing=tuple(replace(one, rate=shown(one.rate)) for one in found.changing),
            places=tuple(replace(one, expression=shown(one.expression, one.loops)) for one in found.places),
        )

    def places(self, *expressions: sympy.Expr) -> Iterator[NamedPlace]:
        """What the names of places in expressions stand for."""
        symbols = [symbol.name for one in expressions for symbol in one.free_symbols]
        used = {KNOWN[name][0] for name in symbols if name in KNOWN}
        for one in self.builder.written_places(used):
            expression = self.lines.shown(one.expression, {}, one.loops)
            yield replace(one, expression=expression)

    def solved(self, line: Line, own: Mapping[str, sympy.Expr]) -> tuple[Equation, sympy.Expr]:
        """The equation of a line, where M is diagonal and constant, and the acceleration."""
        order = self.order
        a = symbol_of(line, acceleration_name(line.family.name))
        mass = self.mass_of(line, own[MASS])
        force = own[SLOPE] + own[FORCE] + own[PULL] + own[FIELD]
        return textbook_form(mass * a - force, order), tidy(force / mass, order)

    def total(self, own: Mapping[str, sympy.Expr]) -> sympy.Expr:
        """A sum of forces."""
        return tidy(sympy.Add(*own.values()), self.order)

    def mass_of(self, line: Line, momentum: sympy.Expr) -> sympy.Expr:
        """dp/dv of a line."""
        v = symbol_of(line, velocity_name(line.family.name))
        return tidy(momentum.diff(v) if not momentum.has(Summed) else self.mass(momentum, v), self.order)

    def balanced(
        self, family: Family, potential: sympy.Expr, force: Mapping[str, Sequence[Part]]
    ) -> Iterator[tuple[Line, Equation]]:
        """The equations of a family where M is another: sum of m a . dr/dq = -dU/dq + Q + lambda df/dq
        (d'Alembert), with the rotation of bodies as d/dt dT/dq_dot - dT/dq; ``force`` has Q and what
        constraints add."""
        rate = self.builder.rate
        inertia = [
            Part(mass * rate(rate(x)) * one.factor, (*loops, *one.loops), one.indices)
            for loops, place, mass in self.particles()
            for x in place
            for one in self.parts(x, family.name)
        ]
        turning = sympy.Add(*(Summed(one, Loops(loops)) for loops, one in rotational(self.builder).items()))
        inertia += [
            Part(rate(one.factor), one.loops, one.indices)
            for one in self.parts(turning, velocity_name(family.name))
        ]
        inertia += [Part(-one.factor, one.loops, one.indices) for one in self.parts(turning, family.name)]
        several = {INERTIA: inertia, SLOPE: [*self.parts(potential, family.name)], **force}
        for line, own in self.lines.of(family, several):
            equation = textbook_form(own[INERTIA] + own[SLOPE] - own[FORCE] - own[PULL], self.order)
            sign = -1 if is_negative(self.order.sorted_terms(equation.left)[0]) else 1
            equation = Equation(sign * equation.left, sign * equation.right, sign * equation.factor)
            yield line.of(equation.left), equation

    def of_field(self, momenta: Iterable[Part]) -> Iterator[Part]:
        """The force of a U that is linear in velocities besides dL/dq: the rate of dU/dq_dot."""
        if self.system.vector is not None:
            for one in momenta:
                yield replace(one, factor=-self.builder.rate(self.at_rest(one.factor)))

    def even(self, expression: sympy.Expr) -> sympy.Expr:
        """A Lagrangian without its terms that are linear in velocities."""
        plain, sums = opened(expression)
        back = {one: -one for one in plain.free_symbols - sums.keys() if self.is_moving(one)}
        inside = {symbol: Summed(self.even(one.body), one.args[1]) for symbol, one in sums.items()}
        return sympy.expand((plain + plain.xreplace(back)) / 2).xreplace(inside)

    @staticmethod
    def mass(momentum: sympy.Expr, v: sympy.Symbol) -> sympy.Expr:
        """dp/dv where p has sums that do not contain v."""
        plain, sums = opened(momentum)
        if any(v in one.body.free_symbols for one in sums.values()):
            raise Unsuited
        return plain.diff(v).xreplace(sums)

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
