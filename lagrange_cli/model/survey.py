"""``Survey``: the quantities of a system file, section by section.

Units of parameters and coordinates are those of the file. The rest follows from its expressions: positions
from the embedding, T and U from masses and potential (they are added, so that one of them tells). Where the
file gives too little a unit is unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TypeVar

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.syntax import Name, Number, Span, components, names
from lagrange_cli.expression.vocabulary import MULTIPLIER, TIME, family_name, velocity_name
from lagrange_cli.model.dimensions import Walk, vector
from lagrange_cli.model.quantity import (
    BROKEN,
    PURE,
    UNKNOWN,
    Contradiction,
    Quantity,
    joined,
    named,
    rate,
    shown,
    total,
)
from lagrange_cli.model.unit import RADIAN, Unit, known
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.model.units import is_energy, is_pure, meaning
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import (
    by_name,
    firsts_of,
    groups_by_name,
    parted,
    statements,
    written_by_family,
)
from lagrange_cli.spec.order import leading_to
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Coordinate, Expression, Parameter, Spec, by_family, distinct

T = TypeVar("T")


@dataclass(frozen=True)
class Conflict:
    """Units that contradict one another: where in the file, and what is wrong."""

    place: Place
    message: str
    hint: str = ""
    factor: bool = False
    """Whether they differ by no more than a factor, as m and cm do."""


class Survey:
    """The quantities for one unit of t, by name, and those of a family as one; ``energy`` is that of T, U and
    h, ``balance`` that of the ledgers: forces take part in them."""

    def __init__(self, spec: Spec, time: Unit | None) -> None:
        self.spec = spec
        self.time = Quantity(time)
        self.conflicts: list[Conflict] = []
        self.values: dict[str, Value] = {TIME: self.time}
        self.parameters = self._parameters()
        self.coordinates = self._coordinates()
        of_multipliers, others = parted(spec.definitions, with_multipliers(spec))
        definitions, self.positions = groups_by_name(others), dict[str, Quantity]()
        positions = written_by_family(spec.embedding)
        for name in spec.order:
            if name in definitions:
                self._values("definition '{}'", by_name({name: definitions[name]}), self.values)
            elif name in positions:
                self._place(name, positions[name])
        self.energy = self._energy()
        self.constraints: dict[str, Quantity] = {}
        self._values("constraint '{}'", spec.constraints, self.constraints)
        self.velocity_constraints: dict[str, Quantity] = {}
        self._values("constraint '{}'", spec.nonholonomic, self.velocity_constraints)
        self.values |= {f"{name}.{MULTIPLIER}": one for name, one in self.multipliers.items()}
        self._values("definition '{}'", of_multipliers, self.values)
        before = len(self.conflicts)
        self._forces()
        self.balance = self.energy if len(self.conflicts) == before else BROKEN
        self.observables: dict[str, Quantity] = {}
        self._values("observable '{}'", spec.observables, self.observables)
        self._events()
        for name, expression in spec.solve.times.items():
            found = named(self.scalar(expression, f"{name} of solve"))
            message = f"the {name} of solve is in {{}}, and t is in {{}}"
            self.agree(self.time, found, expression.place, message)

    @property
    def velocities(self) -> dict[str, Quantity]:
        """The units of the generalized velocities, by coordinate."""
        return {name: rate(quantity, self.time) for name, quantity in self.coordinates.items()}

    def momenta(self, energy: Quantity) -> dict[str, Quantity]:
        """The units of the generalized momenta, by coordinate, if ``energy`` is that of L."""
        return {name: energy * self.time / quantity for name, quantity in self.coordinates.items()}

    @property
    def multipliers(self) -> dict[str, Quantity]:
        """The units of multipliers: lambda f is an energy, and so is lambda g times a time."""
        found = {name: self.energy / quantity for name, quantity in self.constraints.items()}
        velocities = self.velocity_constraints.items()
        return found | {name: self.energy / (quantity * self.time) for name, quantity in velocities}

    # Quantities of expressions

    def value(self, expression: Expression, where: str) -> Value:
        """The quantity of an expression; contradictions in it are reported."""

        def note(error: Contradiction, span: Span) -> None:
            self._note(expression.at(span), f"{error} in {where}", error)

        counts = (*self.spec.sizes, *expression.indices)
        return Walk(self.values, lambda one: one / self.time, note, counts).value(expression.tree)

    def scalar(self, expression: Expression, where: str) -> Quantity:
        """The same of a scalar."""
        return vector(self.value(expression, where))[0]

    def _values(self, where: str, expressions: Mapping[str, Expression], known: dict[str, Value]) -> None:
        """Add the value of each name to ``known``, and of each family that of all its members, which may use
        one another."""
        for name, several in written_by_family(expressions).items():
            for expression in self._in_turn(name, distinct(several), itself):
                value = self.value(expression, where.format(name))
                before = known.get(name, value)
                pairs = zip(vector(before), vector(value))
                found = tuple(joined(pair) for pair in pairs)
                known[name] = found if isinstance(value, tuple) else found[0]

    def _in_turn(self, name: str, written: Iterable[T], value: Callable[[T], Expression]) -> list[T]:
        """What is ``written`` of the members of a family, first that whose ``value`` uses no other member.
        Where all do, nothing is known of other members but their number of components."""
        found = {True: list[T](), False: list[T]()}
        for one in written:
            found[any(used.base == name for used in names(value(one).tree))].append(one)
        if not found[False] and name not in self.values:
            shape = max(components(value(one).tree, self._components) for one in found[True])
            self.values[name] = (UNKNOWN,) * shape if shape > 1 else UNKNOWN
        return [*found[False], *found[True]]

    def _components(self, name: Name) -> int:
        """The number of components of a known name."""
        return len(vector(self.values.get(name.identifier, ())))

    def agree(self, expected: Quantity, found: Quantity, place: Place, message: str) -> Quantity:
        """The common quantity of two that should have one unit."""
        try:
            return total((expected, found))
        except Contradiction as error:
            self._note(place, message.format(*map(shown, reversed(error.units))), error)
            return BROKEN

    def _note(self, place: Place, message: str, error: Contradiction) -> None:
        one, other = error.units
        strange = sorted(symbol for symbol in (one / other).symbols if not known(symbol))
        hint = error.hint or (f"unknown unit '{strange[0]}': write it in terms of others" if strange else "")
        self.conflicts.append(Conflict(place, message, hint, factor=not meaning(one / other)[1]))

    # The sections

    def _parameters(self) -> dict[str, Quantity]:
        found = {}
        for name, parameters in by_family((one.name, one) for one in firsts_of(self.spec.parameters)).items():
            known: list[Quantity] = []
            for one in self._in_turn(name, parameters, lambda one: one.value):
                known.append(self._parameter(one))
                found[name] = self.values[name] = joined(known)
        return found

    def _parameter(self, parameter: Parameter) -> Quantity:
        declared = Quantity(read_unit(parameter.unit)) if parameter.unit else UNKNOWN
        if isinstance(parameter.value.tree, Number) or (parameter.unit and declared.unit is None):
            return declared  # members of a list are written one by one, and may be many
        name = family_name(parameter.name)
        value = self.scalar(parameter.value, f"parameter '{name}'")
        message = f"the value of parameter '{name}' is in {{}}, and its unit is {{}}"
        return self.agree(declared, named(value), parameter.value.place, message)

    def _coordinates(self) -> dict[str, Quantity]:
        found = {}
        for name, coordinates in by_family(
            (one.name, one) for one in firsts_of(self.spec.coordinates)
        ).items():
            found[name] = self.values[name] = joined([self._coordinate(one) for one in alike(coordinates)])
            self.values[velocity_name(name)] = rate(found[name], self.time)
        return found

    @cached_property
    def _turning(self) -> frozenset[str]:
        """Coordinates that are components of a quaternion: plain numbers."""
        given = (one.orientation for one in self.spec.written_bodies)
        entries = [entry.tree for one in given if one.form == "quaternion" for entry in one.entries]
        return frozenset(tree.base for tree in entries if isinstance(tree, Name))

    def _coordinate(self, coordinate: Coordinate) -> Quantity:
        """The unit is that of the initial value, or the velocity, where none is given."""
        name = family_name(coordinate.name)
        quantity = Quantity(read_unit(coordinate.unit)) if coordinate.unit else UNKNOWN
        if not coordinate.unit and name in self._turning:
            quantity = PURE
        if coordinate.initial is not None:
            initial = named(self.scalar(coordinate.initial, f"initial of coordinate '{name}'"))
            message = f"the initial value of coordinate '{name}' is in {{}}, and its unit is {{}}"
            found = self.agree(quantity, initial, coordinate.initial.place, message)
            quantity = quantity if coordinate.unit else replace(found, loose=False)
        if coordinate.velocity is not None:
            velocity = named(self.scalar(coordinate.velocity, f"velocity of coordinate '{name}'"))
            message = f"the initial velocity of coordinate '{name}' is in {{}}, and by its unit in {{}}"
            due = rate(quantity, self.time)
            self.agree(due, velocity, coordinate.velocity.place, message)
            if quantity == UNKNOWN and not coordinate.unit:
                quantity = velocity * self.time
        return quantity

    def _place(self, name: str, several: list[Expression]) -> None:
        """Add the position of a particle, or those of all members of a family, which may use one another."""
        for expression in self._in_turn(name, distinct(several), itself):
            parts = vector(self.value(expression, f"the position of '{name}'"))
            found = self._position(parts, expression, name)
            found = self.positions[name] = joined([self.positions.get(name, found), found])
            self.values[name] = (found,) * len(parts)

    def _position(self, components: tuple[Quantity, ...], expression: Expression, name: str) -> Quantity:
        """All components have one unit; that they are plain numbers says nothing."""
        try:
            found = total([named(one) for one in components])
        except Contradiction as error:
            message = f"the position of '{name}' has components in {' and '.join(map(shown, error.units))}"
            self._note(expression.place, message, error)
            return BROKEN
        plain = found.unit is not None and is_pure(found.unit) and found.unit != RADIAN
        return UNKNOWN if plain else replace(found, loose=False)

    def _energy(self) -> Quantity:
        """The unit of T, U and L. That of U alone tells only if it is one of energy: masses may have been
        left out."""
        spec = self.spec
        if spec.lagrangian is not None:
            return replace(named(self.scalar(spec.lagrangian, "lagrangian")), loose=False)
        masses: dict[str, Quantity] = {}
        self._values("mass '{}'", spec.masses, masses)
        kinetic = UNKNOWN
        for name, several in written_by_family(spec.embedding).items():
            speed = self.positions[name] / self.time
            found = masses[name] * speed * speed
            message = f"the kinetic energy of '{name}' is in {{}}, that of others in {{}}"
            kinetic = self.agree(kinetic, found, several[0].place, message)
        kinetic = self._spinning(kinetic, masses)
        energy = kinetic
        for name, expression in spec.potential.items():
            where = "potential" if name == "potential" else f"potential '{name}'"
            value = named(self.scalar(expression, where))
            message = f"the {where} is in {{}}, other energies in {{}}"
            energy = self.agree(energy, value, expression.place, message)
        if kinetic.unit is None and energy.unit is not None and not is_energy(energy.unit):
            return UNKNOWN
        return replace(energy, loose=False)

    def _spinning(self, kinetic: Quantity, masses: Mapping[str, Quantity]) -> Quantity:
        """``kinetic``, or its unit by the energies of rotation: moments of inertia over the square of a
        time."""
        for name, bodies in written_by_family(self.spec.bodies).items():
            inertia = bodies[0].inertia
            for expression in inertia.entries:
                moment = named(self.scalar(expression, f"inertia of '{name}'"))
                moment = masses[name] * moment * moment if inertia.solid else moment
                message = f"the energy of rotation of '{name}' is in {{}}, other energies in {{}}"
                kinetic = self.agree(kinetic, moment / (self.time * self.time), expression.place, message)
        return kinetic

    def _forces(self) -> None:
        """Forces give no new units, but may contradict known ones."""
        if not self.spec.forces:
            return
        from lagrange_cli.model.forces.table import FORCES  # which a short run without forces does not need

        for key, given in self.spec.forces.items():
            row = SECTIONS.by_word[key]
            for name, several in written_by_family(given).items():
                what = key if name == key else f"{row.label} '{name}'"
                expected = FORCES[key].unit(name, self)
                message = f"the {what} is in {{}}, and should be in {{}}"
                for expression in distinct(several):
                    for value in vector(self.value(expression, what)):
                        self.agree(expected, named(value), expression.place, message)

    def _events(self) -> None:
        """A quantity that an action sets keeps its unit; the expression of an event may have any unit."""
        for name, several in written_by_family(self.spec.events).items():
            for when in distinct([event.when for event in several]):
                self.scalar(when, f"event '{name}'")
            changes = [
                (x.key.name, value) for event in several for x, value in zip(event.sets, event.written[1:])
            ]
            for target, values in by_family(changes).items():
                expected = vector(self.values[target])[0]
                where = f"the new {target} of event '{name}'"
                for value in distinct(values):
                    message = f"{where} is in {{}}, and should be in {{}}"
                    self.agree(expected, named(self.scalar(value, where)), value.place, message)


def itself(expression: Expression) -> Expression:
    """What is an expression by itself."""
    return expression


def with_multipliers(spec: Spec) -> list[str]:
    """The definitions that contain multipliers, or what does: energies and constraints do not use them."""
    uses: dict[str, set[str]] = {}
    for name, group in groups_by_name(spec.definitions).items():
        used = [one.identifier for written in statements(group) for one in names(written.tree)]
        uses[name] = {MULTIPLIER if one.endswith(f".{MULTIPLIER}") else one.partition(".")[0] for one in used}
    return leading_to(uses, [MULTIPLIER])


def alike(coordinates: list[Coordinate]) -> list[Coordinate]:
    """One coordinate of each that is written, as members of a family share expressions."""
    found: dict[tuple[object, ...], Coordinate] = {}
    for one in coordinates:
        trees = (None if given is None else id(given.tree) for given in (one.initial, one.velocity))
        found.setdefault((one.unit, *trees), one)
    return list(found.values())
