"""``Scope``: the values of a system file's names over any algebra."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Generic

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.algebra import Algebra, E, Value
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.syntax import ExpressionError, names
from lagrange_cli.expression.vocabulary import (
    BODY_COMPONENTS,
    COMPONENTS,
    MULTIPLIER,
    TIME,
    VELOCITY_COMPONENTS,
    family_name,
    velocity_name,
)
from lagrange_cli.model.orientation import Turning, turning
from lagrange_cli.spec.content import groups_by_name, statements
from lagrange_cli.spec.order import Needs, on_demand
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.whole import WrittenFamily


def multiplier_name(constraint: str) -> str:
    """The name of the symbol of a multiplier, which differs from all names of a file."""
    return f"lambda {constraint}"


class Scope(Generic[E]):
    """The values of names: symbols, definitions, and the particles once all of them are built."""

    def __init__(self, spec: Spec, algebra: Algebra[E]) -> None:
        self.spec = spec
        self.algebra = algebra
        self.time = algebra.symbol(TIME)
        self.q = tuple(algebra.symbol(coordinate.name) for coordinate in spec.coordinates)
        self.v = tuple(algebra.symbol(velocity_name(coordinate.name)) for coordinate in spec.coordinates)
        self.parameters = {one.name: algebra.symbol(one.name) for one in spec.parameters}
        self.values: dict[str, Value] = {TIME: self.time, **self.parameters}
        for coordinate, q, v in zip(spec.coordinates, self.q, self.v, strict=True):
            self.values |= {coordinate.name: q, velocity_name(coordinate.name): v}
        self.rates = dict(zip(self.q, self.v, strict=True))
        self.velocities: dict[str, tuple[E, ...]] = {}
        self.multipliers: list[E] = []
        """The multipliers that are used."""
        self._turning: dict[str, Turning[E]] = {}
        self.builder = Builder(self, algebra, spec.sizes)
        self.replaced = {name: self.scalar(written) for name, written in spec.replaced.items()}
        self.values |= self.replaced
        self.values |= {velocity_name(name): self._rate(one) for name, one in self.replaced.items()}
        self.wide = spec.wide
        self._waiting = {*spec.of_particles} - self.wide
        """Definitions that are built when they are first asked for."""
        definitions, places = groups_by_name(spec.definitions), groups_by_name(spec.embedding)
        for name in spec.order:
            if name in places:
                self._place(name)
            elif name in definitions and name not in self.wide and name not in self._waiting:
                self._define(name)

    def __call__(self, identifier: str) -> Value:
        base, _, component = identifier.partition(".")
        if component == MULTIPLIER:
            return self.multiplier(base)
        if component in BODY_COMPONENTS:
            return self.turning(base).component(component)
        if base not in self.values:
            self._find(base)
        if component in VELOCITY_COMPONENTS:
            return self.velocity(base)[VELOCITY_COMPONENTS.index(component)]
        value = self.values[base]
        return value[COMPONENTS.index(component)] if component else value

    def _find(self, name: str) -> None:
        """Build a definition that has not been built, after those that it is made of."""
        base = family_name(name)
        if base in self.wide:
            self.values[name] = self.build(self.spec.definitions[name])
        elif base in self._waiting:
            groups, needed = groups_by_name(self.spec.definitions), {base}
            for one in [*groups][::-1]:
                for written in statements(groups[one]) if one in needed else ():
                    needed |= {symbol.base for symbol in names(written.tree)}
            for one in groups:
                if one in needed & self._waiting:
                    self._define(one)
                    self._waiting.discard(one)
        elif name in self.spec.embedding:
            raise Needs(name)

    def _define(self, name: str) -> None:
        """Build a definition, or a family of them, whose members may use one another."""
        one = groups_by_name(self.spec.definitions)[name]
        if not isinstance(one, WrittenFamily):
            self.values[name] = self.build(one)
            return
        for member, definition in zip(one.names, one):
            self.values[member] = self.build(definition)

    def _place(self, name: str) -> None:
        """Build the position of a particle, or those of a family, whose members may follow from one
        another."""
        one = groups_by_name(self.spec.embedding)[name]
        if not isinstance(one, WrittenFamily):
            self.values[name] = self.vector(one)
            return

        def build(member: str) -> None:
            self.values[member] = self.vector(self.spec.embedding[member])

        on_demand(one.names, build)

    @property
    def in_equations(self) -> Iterator[Expression]:
        """What the equations of motion are made of, with definitions that are built where they are used."""
        for one in self.spec.in_equations:
            with suppress(SpecError, LookupError, NotImplementedError, ValueError, ArithmeticError):
                if self.wide:
                    self.build(one)
            yield one
        used = [name for name in self.values if "[" in name and family_name(name) in self.wide]
        yield from (self.spec.definitions[name] for name in used)

    def multiplier(self, constraint: str) -> E:
        """The Lagrange multiplier of a constraint."""
        found = self.algebra.symbol(multiplier_name(constraint))
        if found not in self.multipliers:
            self.multipliers.append(found)
        return found

    def velocity(self, name: str) -> tuple[E, ...]:
        """dr/dt = sum_k dr/dq_k q_dot_k + dr/dt of a particle, or of a definition r(q, t), built when it is
        first asked for."""
        if name not in self.velocities:
            self.velocities[name] = tuple(self._rate(component) for component in self.values[name])
        return self.velocities[name]

    def turning(self, body: str) -> Turning[E]:
        """How a rigid body stands and turns, built when it is first asked for."""
        if body not in self._turning:
            how = self.spec.bodies[body].orientation
            given = [self.scalar(one) for one in how.entries]
            self._turning[body] = turning(self.algebra, how.form, how.sequence, given, self._rate)
        return self._turning[body]

    def _rate(self, component: E) -> E:
        terms: list[E] = []
        for symbol in self.algebra.symbols(component):
            if symbol in self.rates:
                terms.append(self.algebra.diff(component, symbol) * self.rates[symbol])  # type: ignore[operator]
            elif symbol == self.time:
                terms.append(self.algebra.diff(component, symbol))
        return self.total(terms)

    def total(self, terms: list[E]) -> E:
        """The sum of any number of elements."""
        return self.algebra.total(terms) if terms else self.algebra.number("0")

    def scalar(self, expression: Expression) -> E:
        value: E = self.build(expression)
        return value

    def vector(self, expression: Expression) -> tuple[E, ...]:
        value = self.build(expression)
        return value if isinstance(value, tuple) else (value,)

    def build(self, expression: Expression) -> Value:
        try:
            return self.builder.build(expression.tree, expression.indices)
        except ExpressionError as error:
            source = Source(self.spec.filename, self.spec.text)
            place = expression.at(error.span)
            raise SpecError(source.filename, [source.problem(place, error.message, error.hint)]) from error
