"""The equations of motion of the members of families, from what the file gives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from math import prod

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.equations import Equation
from lagrange_cli.symbolic.families.bodies import rotational
from lagrange_cli.symbolic.families.derivatives import Part
from lagrange_cli.symbolic.families.given import Given, multiplier_name
from lagrange_cli.symbolic.families.linear import MASS, entry_family
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.members import KNOWN, Loops, Summed, hidden, opened
from lagrange_cli.symbolic.order import Role, is_negative
from lagrange_cli.symbolic.textbook import textbook_form

MOMENTUM, INERTIA, SLOPE, FORCE, PULL = "p", "m a dr/dq", "dU/dq", "-Q", "-lambda df/dq"

MOST_ENTRIES = 4_000_000
"""Entries of the largest mass matrices that are printed: which of them are alike is decided for each."""
TOO_LARGE = (
    "the mass matrix has {} entries between two families, too many to be compared: choose smaller sizes with "
    "--size; their lines are the same"
)


class Dynamics(Given):
    """The equation of motion of members that are alike, from the parts of what acts on them by names."""

    @cached_property
    def given_energies(self) -> tuple[sympy.Expr | None, sympy.Expr]:
        """T and U; None and L."""
        return self.energies()

    @cached_property
    def bonds(self) -> list[tuple[Line, bool]]:
        """What constraints keep at 0, and whether these are holonomic."""
        return [*self.constraints()]

    @cached_property
    def lagrangian(self) -> sympy.Expr:
        """L."""
        kinetic, potential = self.given_energies
        return potential if kinetic is None else kinetic - potential

    @cached_property
    def inertia(self) -> sympy.Expr:
        """What momenta are derivatives of: T, or L where T is not given or U contains velocities."""
        kinetic, _ = self.given_energies
        return self.lagrangian if kinetic is None or self.system.vector is not None else kinetic

    @cached_property
    def pulling(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Constraints times their multipliers, those on positions and those on velocities."""
        on_positions, on_velocities = (
            self.with_multipliers((one, one.expression) for one, own in self.bonds if own is holonomic)
            for holonomic in (True, False)
        )
        return on_positions, on_velocities

    @cached_property
    def moving_energy(self) -> sympy.Expr:
        """The part of T, or of L, whose terms in the equations of motion are d/dt dE/dq_dot - dE/dq: along
        chains and trees that of rotations, as that of particles has d'Alembert's m a . dr/dq."""
        if self.system.joints is None:
            return self.inertia
        turning = rotational(self.builder).items()
        return sympy.Add(*(Summed(one, Loops(loops)) for loops, one in turning))

    def momentum(self, family: Family) -> dict[str, list[Part]]:
        """What adds up to the momenta of a family."""
        return {MOMENTUM: [*self.parts(self.inertia, velocity_name(family.name))]}

    def pull(self, family: Family) -> list[Part]:
        """A^T lambda of a family."""
        on_positions, on_velocities = self.pulling
        speed = velocity_name(family.name)
        return [*self.parts(on_positions, family.name), *self.parts(on_velocities, speed)]

    def motion(self, family: Family) -> dict[str, list[Part]]:
        """What adds up to 0 in the equations of a family: m a . dr/dq of particles along chains and trees,
        d/dt dE/dq_dot - dE/dq, dU/dq, -Q and -A^T lambda."""
        energy, rate = self.moving_energy, self.builder.rate
        potential = sympy.S.Zero if energy is self.lagrangian else self.given_energies[1]
        particles: list[Part] = []
        if self.system.joints is not None:
            particles = [
                Part(mass * rate(rate(x)) * one.factor, (*loops, *one.loops), one.indices)
                for loops, place, mass in self.particles()
                for x in place
                for one in self.parts(x, family.name, loops)
            ]
        inertia = [
            replace(one, factor=rate(one.factor)) for one in self.parts(energy, velocity_name(family.name))
        ]
        slope = negative(self.parts(energy, family.name))
        if particles:
            inertia, slope = [*particles, *inertia, *slope], []
        return {
            INERTIA: inertia,
            SLOPE: [*slope, *self.parts(potential, family.name)],
            FORCE: negative(self.applied(family.name)),
            PULL: negative(self.pull(family)),
        }

    def driving(self, family: Family) -> Iterator[Line]:
        """dL/dq + Q + A^T lambda."""
        slope, force = self.parts(self.lagrangian, family.name), self.applied(family.name)
        yield from self.summed(family, {SLOPE: [*slope], FORCE: [*force], PULL: self.pull(family)})

    def entries(self) -> Iterator[Line]:
        """The entries of M, d2T/dq_dot dq_dot, of pairs of families in order. Raises ``UsageError``
        where there are too many."""
        families = self.builder.coordinates
        for one, other in ((a, b) for k, a in enumerate(families) for b in families[k:]):
            family = entry_family(one, other)
            if prod(family.shape) > MOST_ENTRIES:
                raise UsageError(TOO_LARGE.format(prod(family.shape)))
            twice = [*self.of_places(one, other), *self.second_derivatives(self.moving_energy, one, other)]
            yield from self.summed(family, {MASS: twice})

    def of_places(self, one: Family, other: Family) -> Iterator[Part]:
        """m dr/dq . dr/dq of the particles along chains and trees."""
        for loops, place, mass in self.particles() if self.system.joints is not None else ():
            for x in place:
                beside = [*self.parts(hidden(x, self.builder.count), other.name)]
                for a in self.parts(x, one.name, loops):
                    for b in beside:
                        factor, around = mass * a.factor * b.factor, (*loops, *a.loops, *b.loops)
                        yield Part(factor, around, (*a.indices, *b.indices))

    def second_derivatives(self, energy: sympy.Expr, one: Family, other: Family) -> Iterator[Part]:
        """The derivatives of an energy by velocities of two families."""
        for a in self.parts(energy, velocity_name(one.name)):
            for b in self.parts(hidden(a.factor, self.builder.count), velocity_name(other.name)):
                yield Part(b.factor, (*a.loops, *b.loops), (*a.indices, *b.indices))

    def summed(self, family: Family, parts: Mapping[str, Sequence[Part]], sign: int = 1) -> Iterator[Line]:
        """Lines with what parts add up to."""
        given = {key: [one for one in listed if one.factor != 0] for key, listed in parts.items()}
        for line, own in self.lines.of(family, given):
            yield line.of(tidy(sign * sympy.Add(*own.values()), self.order))

    def equation(self, total: sympy.Expr) -> Equation:
        """``total = 0`` as textbooks print it."""
        equation = textbook_form(total, self.order)
        sign = -1 if is_negative(self.order.sorted_terms(equation.left)[0]) else 1
        return Equation(sign * equation.left, sign * equation.right, sign * equation.factor)

    def total(self, own: Mapping[str, sympy.Expr]) -> sympy.Expr:
        """A sum of forces."""
        return tidy(sympy.Add(*own.values()), self.order)

    def unaccelerated(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression where all accelerations of coordinates are 0."""
        plain, sums = opened(expression)
        known = {symbol: Summed(self.unaccelerated(one.body), one.args[1]) for symbol, one in sums.items()}
        for symbol in plain.free_symbols - sums.keys():
            if self.order.role(symbol) >= Role.ACCELERATION:
                if symbol not in self._unaccelerated:
                    meaning = self.builder.meaning(*KNOWN[symbol.name]) if symbol.name in KNOWN else None
                    made = sympy.S.Zero if meaning is None else self.unaccelerated(meaning)
                    self._unaccelerated[symbol] = made
                known[symbol] = self._unaccelerated[symbol]
        return plain.xreplace(known)

    @cached_property
    def _unaccelerated(self) -> dict[sympy.Symbol, sympy.Expr]:
        return {}

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


def negative(parts: Iterable[Part]) -> list[Part]:
    """Parts with the other sign."""
    return [replace(one, factor=-one.factor) for one in parts]
