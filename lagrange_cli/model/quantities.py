"""``find_units``: the unit of everything that a system's output holds, by dimension.

Units of parameters and coordinates, and of t, are those of the system file. The rest follows from its
expressions: positions from the embedding, T and U from masses and potential (they are added, so that one of
them tells), p_k = L/q_dot_k, the action L t. Where the file gives too little there is no unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.syntax import Number, Span
from lagrange_cli.expression.vocabulary import TIME, family_name, velocity_name
from lagrange_cli.model.dimensions import (
    BROKEN,
    UNKNOWN,
    Contradiction,
    Quantity,
    Walk,
    joined,
    named,
    rate,
    shown,
    total,
    vector,
)
from lagrange_cli.model.units import (
    RADIAN,
    WHOLE,
    Unit,
    is_energy,
    meaning,
    read_unit,
    simplified,
    times_within,
)
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.source import WHOLE_FILE, Place
from lagrange_cli.spec.spec import Coordinate, Expression, Parameter, Spec, has_units

UNNAMED = "the unit of t"
"""Stands for the unit of t where the file has no unit of time at all."""
UNNAMED_TIME = Unit(((UNNAMED, WHOLE),))


@dataclass(frozen=True)
class Conflict:
    """Units that contradict one another: where in the file, and what is wrong."""

    place: Place
    message: str
    hint: str = ""
    factor: bool = False
    """Whether they differ by no more than a factor, as m and cm do."""


@dataclass(frozen=True)
class Units:
    """The units of a system's quantities, as texts, by the path of their dataset; and what contradicts."""

    texts: Mapping[str, str] = field(default_factory=dict)
    conflicts: tuple[Conflict, ...] = ()


def find_units(spec: Spec) -> Units:
    """The units of the system's quantities."""
    if not has_units(spec):
        return Units()
    if spec.time_unit:
        survey = Survey(spec, read_unit(spec.time_unit))
        return Units(survey.texts(), tuple(survey.conflicts))
    found, unclear = times_of({one.unit for one in spec.parameters} | {one.unit for one in spec.coordinates})
    if not found and not unclear:
        survey = Survey(spec, UNNAMED_TIME)
        return Units(survey.texts(), tuple(one for one in survey.conflicts if UNNAMED not in one.message))
    if len(found) == 1:
        return with_time(spec, Unit(((found[0], WHOLE),)))
    survey = Survey(spec, None)
    if found:
        message = f"the units contain several units of time, {' and '.join(found)}: that of t is not clear"
        survey.conflicts.append(Conflict(WHOLE_FILE, message, f"add 'time: {{unit: {found[0]}}}'"))
    return Units(survey.texts(), tuple(survey.conflicts))


def with_time(spec: Spec, time: Unit) -> Units:
    """The same where t seems to be in ``time``, unless another unit of time may be right: where that is why
    units differ by a factor."""
    survey = Survey(spec, time)
    conflicts = survey.conflicts
    if any(one.factor for one in conflicts):
        without = Survey(spec, None)
        doubtful = [one.factor and one not in without.conflicts for one in conflicts]
        if any(doubtful):
            hint = f"if t is not in {time}, add 'time: {{unit: ...}}'"
            conflicts = [
                replace(one, hint=one.hint or hint) if it else one for one, it in zip(conflicts, doubtful)
            ]
            if survey.energy.broken:
                without.energy = BROKEN
            survey = without
    return Units(survey.texts(), tuple(conflicts))


def times_of(texts: Iterable[str]) -> tuple[list[str], bool]:
    """The units of time that units contain, and whether there are others that say nothing of t."""
    found, unclear = set[str](), False
    for unit in map(read_unit, texts):
        if unit is not None:
            times, further = times_within(unit)
            found, unclear = found | times, unclear or further
    return sorted(found), unclear


class Survey:
    """The quantities of a system file, section by section, for one unit of t."""

    def __init__(self, spec: Spec, time: Unit | None) -> None:
        self.spec = spec
        self.time = Quantity(time)
        self.conflicts: list[Conflict] = []
        self.values: dict[str, Value] = {TIME: self.time}
        self.parameters = self._parameters()
        self.coordinates = self._coordinates()
        self._values("definition '{}'", spec.definitions, self.values)
        self._positions()
        self.energy = self._energy()
        self._forces()
        self.observables: dict[str, Quantity] = {}
        self._values("observable '{}'", spec.observables, self.observables)

    # What expressions come to

    def value(self, expression: Expression, where: str) -> Value:
        """The quantity of an expression; what contradicts in it is noted."""

        def note(error: Contradiction, span: Span) -> None:
            factor = by_a_factor(error.units)
            self.conflicts.append(Conflict(expression.at(span), f"{error} in {where}", error.hint, factor))

        counts = (*self.spec.sizes, *expression.indices)
        return Walk(self.values, lambda one: one / self.time, note, counts).value(expression.tree)

    def scalar(self, expression: Expression, where: str) -> Quantity:
        """The same of a scalar."""
        return vector(self.value(expression, where))[0]

    def _values(self, where: str, expressions: Mapping[str, Expression], known: dict[str, Value]) -> None:
        """Add the value of each name to ``known``, and of each family that of all its members, which may use
        one another."""
        for name, several in by_family(expressions.items()).items():
            for expression in distinct(several):
                value = self.value(expression, where.format(name))
                before = known.get(name, value)
                pairs = zip(vector(before), vector(value))
                found = tuple(joined(pair) for pair in pairs)
                known[name] = found if isinstance(value, tuple) else found[0]

    def agree(self, expected: Quantity, found: Quantity, place: Place, message: str) -> Quantity:
        """What two quantities have in common that should have one unit."""
        try:
            return total((expected, found))
        except Contradiction as error:
            text = message.format(*map(shown, reversed(error.units)))
            self.conflicts.append(Conflict(place, text, factor=by_a_factor(error.units)))
            return BROKEN

    # The sections

    def _parameters(self) -> dict[str, Quantity]:
        found = {}
        for name, parameters in by_family((one.name, one) for one in self.spec.parameters).items():
            found[name] = self.values[name] = joined([self._parameter(one) for one in parameters])
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
        for name, coordinates in by_family((one.name, one) for one in self.spec.coordinates).items():
            found[name] = self.values[name] = joined([self._coordinate(one) for one in alike(coordinates)])
            self.values[velocity_name(name)] = rate(found[name], self.time)
        return found

    def _coordinate(self, coordinate: Coordinate) -> Quantity:
        """The unit is that of the initial value, or the velocity, where none is given."""
        name = family_name(coordinate.name)
        quantity = Quantity(read_unit(coordinate.unit)) if coordinate.unit else UNKNOWN
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

    def _positions(self) -> None:
        self.positions: dict[str, Quantity] = {}
        for name, several in by_family(self.spec.embedding.items()).items():
            for expression in distinct(several):
                components = vector(self.value(expression, f"embedding '{name}'"))
                found = self._position(components, expression, name)
                found = self.positions[name] = joined([self.positions.get(name, found), found])
                self.values[name] = (found,) * len(components)

    def _position(self, components: tuple[Quantity, ...], expression: Expression, name: str) -> Quantity:
        """All components have one unit; that they are plain numbers says nothing."""
        try:
            found = total([named(one) for one in components])
        except Contradiction as error:
            message = f"embedding '{name}' has components in {' and '.join(map(shown, error.units))}"
            self.conflicts.append(Conflict(expression.place, message, factor=by_a_factor(error.units)))
            return BROKEN
        plain = found.unit is not None and found.unit.pure and found.unit != RADIAN
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
        for name, several in by_family(spec.embedding.items()).items():
            speed = self.positions[name] / self.time
            found = masses[name] * speed * speed
            message = f"the kinetic energy of '{name}' is in {{}}, that of others in {{}}"
            kinetic = self.agree(kinetic, found, several[0].place, message)
        energy = kinetic
        for name, expression in spec.potential.items():
            where = "potential" if name == "potential" else f"potential '{name}'"
            value = named(self.scalar(expression, where))
            message = f"the {where} is in {{}}, other energies in {{}}"
            energy = self.agree(energy, value, expression.place, message)
        if kinetic.unit is None and energy.unit is not None and not is_energy(energy.unit):
            return UNKNOWN
        return replace(energy, loose=False)

    def _forces(self) -> None:
        """Forces say nothing new, but may contradict."""
        spec = self.spec
        for name, several in by_family(spec.forces.items()).items():
            for expression in distinct(several):
                for value in vector(self.value(expression, f"force '{name}'")):
                    self._due(self.positions[name], value, expression, f"the force on '{name}'")
        for name, several in by_family(spec.generalized_forces.items()).items():
            for expression in distinct(several):
                value = self.scalar(expression, f"generalized force '{name}'")
                self._due(self.coordinates[name], value, expression, f"the generalized force '{name}'")
        if spec.dissipation is not None:
            value = self.scalar(spec.dissipation, "dissipation")
            self._due(self.time, value, spec.dissipation, "the dissipation")

    def _due(self, divisor: Quantity, value: Quantity, expression: Expression, what: str) -> None:
        """Note where a quantity is not the energy over ``divisor``."""
        message = f"{what} is in {{}}, and should be in {{}}"
        self.agree(self.energy / divisor, named(value), expression.place, message)

    # The texts

    def texts(self) -> dict[str, str]:
        """The unit of each dataset that has one, by its path, and of each parameter."""
        spec, time = self.spec, self.time
        found = {"t": spec.time_unit or told(time), "diagnostics/action": told(self.energy * time)}
        found |= dict.fromkeys(("diagnostics/h", "diagnostics/T", "diagnostics/U"), told(self.energy))
        found |= dict.fromkeys(("diagnostics/energy", "diagnostics/ledger/h"), told(self.energy))
        for name, quantity in self.coordinates.items():
            found[f"q/{name}"] = told(quantity)
            found[f"v/{name}"] = told(rate(quantity, time))
            momentum = told(self.energy * time / quantity)
            found |= {f"diagnostics/p/{name}": momentum, f"diagnostics/ledger/p/{name}": momentum}
        found |= {f"positions/{name}": told(quantity) for name, quantity in self.positions.items()}
        found |= {f"observables/{name}": told(quantity) for name, quantity in self.observables.items()}
        for parameter in spec.parameters:
            unit = parameter.unit or told(self.parameters[family_name(parameter.name)])
            found[f"parameters/{parameter.name}"] = unit
        for name, members in by_family((one.name, one) for one in spec.coordinates).items():
            written = {one.unit for one in members}
            if len(written) == 1:
                found[f"q/{name}"] = written.pop() or found[f"q/{name}"]
        return {path: text for path, text in found.items() if text}


T = TypeVar("T")


def by_family(pairs: Iterable[tuple[str, T]]) -> dict[str, list[T]]:
    """What belongs to each name, or to the members of each family, in the file's order."""
    found: dict[str, list[T]] = {}
    for name, item in pairs:
        found.setdefault(family_name(name), []).append(item)
    return found


def distinct(expressions: list[Expression]) -> list[Expression]:
    """One expression of each that is written: members share theirs."""
    found: dict[int, Expression] = {}
    for one in expressions:
        found.setdefault(id(one.tree), one)
    return list(found.values())


def alike(coordinates: list[Coordinate]) -> list[Coordinate]:
    """Likewise one coordinate of each that is written."""
    found: dict[tuple[object, ...], Coordinate] = {}
    for one in coordinates:
        trees = (None if given is None else id(given.tree) for given in (one.initial, one.velocity))
        found.setdefault((one.unit, *trees), one)
    return list(found.values())


def by_a_factor(units: tuple[Unit, ...]) -> bool:
    """Whether two units have the same dimensions."""
    return len(units) == 2 and not meaning(units[0] / units[1])[1]


def told(quantity: Quantity) -> str:
    """The unit as it is written to the output; empty where it is not known, or a plain number."""
    unit = quantity.unit
    if unit is None or quantity.broken or quantity.number is not None or UNNAMED in unit.symbols:
        return ""
    if "rad" in unit.symbols:
        return str(unit)
    return "" if unit.pure else str(simplified(unit))
