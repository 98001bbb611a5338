"""The equations of motion of the members of families, from what the file gives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import acceleration_name, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.equations import Equation
from lagrange_cli.symbolic.families.bodies import rotational
from lagrange_cli.symbolic.families.derivatives import Part
from lagrange_cli.symbolic.families.given import Given, multiplier_name
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.members import Loops, Summed, opened
from lagrange_cli.symbolic.order import is_negative
from lagrange_cli.symbolic.textbook import textbook_form

MASS, SLOPE, FORCE, INERTIA, PULL = "p", "dL/dq", "Q", "m a dr/dq", "lambda df/dq"
FIELD = "m a - dp/dt"


class Dynamics(Given):
    """The equation of motion of members that are alike, from the parts of what acts on them by names."""

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

    @staticmethod
    def mass(momentum: sympy.Expr, v: sympy.Symbol) -> sympy.Expr:
        """dp/dv where p has sums that do not contain v."""
        plain, sums = opened(momentum)
        if any(v in one.body.free_symbols for one in sums.values()):
            raise Unsuited
        return plain.diff(v).xreplace(sums)

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

    def second_rate(self, expression: sympy.Expr, holonomic: bool) -> sympy.Expr:
        """What a constraint says of the accelerations: its second derivative, or the first of one on
        velocities."""
        rate = self.builder.rate
        return rate(rate(expression)) if holonomic else rate(expression)

    @staticmethod
    def with_multipliers(listed: Iterable[tuple[Line, sympy.Expr]]) -> sympy.Expr:
        """The sum of expressions of constraints, each times its multiplier."""
        return sympy.Add(
            *(Summed(symbol_of(one, multiplier_name(one.family.name)) * expression, Loops(one.loops))
              for one, expression in listed)
        )  # fmt: skip
