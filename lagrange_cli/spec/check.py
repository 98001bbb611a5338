"""``Draft`` to ``Spec``: every name is looked up, every shape compared, and nothing needs an algebra yet."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import names
from lagrange_cli.expression.vocabulary import ACCELERATION_SUFFIX, TIME, velocity_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.names import Kind, Names, scalar
from lagrange_cli.spec.order import chain, dependency_order
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import Declared, Draft, Entry
from lagrange_cli.spec.source import WHOLE_FILE, Place
from lagrange_cli.spec.spec import Coordinate, Expression, Parameter, SolveDefaults, Spec


def check(draft: Draft, problems: Problems) -> Spec:
    """The draft as a ``Spec``.

    Raises:
        SpecError: with everything that is wrong in the file.
    """
    checker = _Checker(draft, problems)
    checker.declare()
    parameters = checker.parameters()
    definitions = checker.definitions()
    coordinates = checker.coordinates()
    checker.formulation()
    masses = checker.scalars("masses", "mass of")
    embedding = checker.embedding()
    forces = checker.forces()
    spec = Spec(
        filename=problems.source.filename,
        text=problems.source.text,
        name=draft.name or _stem(problems.source.filename),
        description=draft.description,
        parameters=parameters,
        coordinates=coordinates,
        definitions=definitions,
        masses=masses,
        embedding=embedding,
        potential=checker.potential(),
        lagrangian=checker.one("lagrangian"),
        forces=forces,
        generalized_forces=checker.generalized_forces(),
        dissipation=checker.one("dissipation"),
        observables=checker.scalars("observables", "observable"),
        solve=_solve(draft, problems),
    )
    problems.stop_if_any()
    return spec


@dataclass
class _Checker:
    """The draft, the table of names, and where problems go."""

    draft: Draft
    problems: Problems

    def __post_init__(self) -> None:
        self.names = Names(self.problems)

    def declare(self) -> None:
        """Enter all names, so that a later one can be told from one that does not exist."""
        draft = self.draft
        self.names.declare(TIME, Kind.TIME, None, scalar())
        for coordinate in draft.coordinates:
            self.names.declare(coordinate.name, Kind.COORDINATE, coordinate.place, scalar())
        for coordinate in draft.coordinates:
            self.names.declare(velocity_name(coordinate.name), Kind.VELOCITY, coordinate.place, scalar())
        for parameter in draft.parameters:
            self._declare_free(parameter.name, Kind.PARAMETER, parameter.place, scalar())
        for definition in draft.definitions:
            self._declare_free(definition.name, Kind.DEFINITION, definition.place, None)
        for particle in _once((*draft.masses, *draft.embedding)):
            self._declare_free(particle.name, Kind.PARTICLE, particle.place, None)

    def _declare_free(self, name: str, what: Kind, place: Place, value: Any) -> None:
        base = name.removesuffix(ACCELERATION_SUFFIX)
        if base != name and base in self.names.table and self.names.table[base].what is Kind.COORDINATE:
            self.problems.add(
                place, f"the {what.value} '{name}' has the name of an acceleration", "rename it"
            )
            return
        self.names.declare(name, what, place, value)

    def parameters(self) -> tuple[Parameter, ...]:
        values = {parameter.name: parameter.fields.get("value") for parameter in self.draft.parameters}
        declared = {parameter.name: parameter for parameter in self.draft.parameters}
        for name, value in values.items():
            if value is not None:
                self._scalar(value, "parameters", f"parameter '{name}'")
        order = self._order(values, {name: one.place for name, one in declared.items()}, "parameter")
        found = []
        for name in order:
            value, fields = values[name], declared[name].fields
            if value is not None:
                unit, description = fields.get("unit", ""), fields.get("description", "")
                found.append(Parameter(name, value, declared[name].place, unit, description))
        return tuple(found)

    def coordinates(self) -> tuple[Coordinate, ...]:
        if not self.draft.coordinates and not self.problems.found:
            place = self.draft.places.get("coordinates", WHOLE_FILE)
            self.problems.add(
                place, "the system has no coordinates", "write 'coordinates: {x: {initial: 0}}'"
            )
        return tuple(self._coordinate(coordinate) for coordinate in self.draft.coordinates)

    def _coordinate(self, declared: Declared) -> Coordinate:
        initial, velocity = declared.fields.get("initial"), declared.fields.get("velocity")
        for field, value in (("initial", initial), ("velocity", velocity)):
            if value is not None:
                self._scalar(value, "coordinates", f"{field} of coordinate '{declared.name}'")
        return Coordinate(
            declared.name,
            declared.place,
            initial,
            velocity,
            declared.fields.get("unit", ""),
            declared.fields.get("description", ""),
        )

    def definitions(self) -> dict[str, Expression]:
        entries = {entry.name: entry for entry in self.draft.definitions}
        values = {name: entry.value for name, entry in entries.items()}
        order = self._order(values, {name: entry.place for name, entry in entries.items()}, "definition")
        for name in values.keys() - set(order):
            self._settle(name, Kind.DEFINITION, frozenset(), None)
        found = {}
        for name in order:
            value = values[name]
            if value is None:
                self._settle(name, Kind.DEFINITION, frozenset(), None)
                continue
            kinds, bounds = self.names.check(value, "definitions", f"definition '{name}'")
            self._settle(name, Kind.DEFINITION, kinds, bounds)
            found[name] = value
        return found

    def _settle(self, name: str, what: Kind, kinds: frozenset[Kind], value: Any) -> None:
        if name in self.names.table and self.names.table[name].what is what:
            self.names.settle(name, kinds, value)

    def _order(self, values: dict[str, Expression | None], places: dict[str, Place], what: str) -> list[str]:
        uses = {
            name: {one.identifier.partition(".")[0] for one in names(value.tree)} if value else set()
            for name, value in values.items()
        }
        order, cycles = dependency_order(uses)
        for cycle in cycles:
            self.problems.add(
                places[cycle[0]],
                f"{what} '{cycle[0]}' depends on itself: {chain(cycle)}",
                "give one of them a value that does not use the others",
            )
        return order

    def formulation(self) -> None:
        """Either a lagrangian, or masses that are embedded."""
        draft, places = self.draft, self.draft.places
        if "lagrangian" in places:
            for other in ("masses", "embedding", "potential"):
                if other in places:
                    self.problems.add(
                        places[other],
                        f"'{other}' cannot be given together with 'lagrangian'",
                        "the lagrangian takes the place of masses, embedding and potential",
                    )
            return
        if "masses" not in places and "embedding" not in places:
            self.problems.add(
                WHOLE_FILE,
                "the system has neither 'masses' with an 'embedding' nor a 'lagrangian'",
                "give one of the two",
            )
            return
        masses, embedding = _by_name(draft.masses), _by_name(draft.embedding)
        self._partners(masses, embedding, "a mass but no embedding", "embedding: {%s: [x, y]}")
        self._partners(embedding, masses, "an embedding but no mass", "masses: {%s: 1.0}")
        if not masses and not embedding and not self.problems.found:
            place = places.get("masses", places.get("embedding", WHOLE_FILE))
            self.problems.add(place, "the system has no particle", "write 'masses: {bead: m}'")

    def _partners(
        self, entries: dict[str, Entry], partners: dict[str, Entry], what: str, example: str
    ) -> None:
        for name, entry in entries.items():
            if name not in partners:
                near = near_hint(name, [one for one in partners if one not in entries])
                self.problems.add(
                    entry.place, f"the particle '{name}' has {what}", near or f"add {example % name}"
                )

    def embedding(self) -> dict[str, Expression]:
        found = {}
        for entry in self.draft.embedding:
            bounds = None
            if entry.value is not None:
                _, bounds = self.names.check(entry.value, "embedding", f"embedding '{entry.name}'")
                found[entry.name] = entry.value
            vector = (bounds,) if bounds is not None and not isinstance(bounds, tuple) else bounds
            self._settle(entry.name, Kind.PARTICLE, frozenset({Kind.PARTICLE}), vector)
        return found

    def forces(self) -> dict[str, Expression]:
        particles = [entry.name for entry in self.draft.embedding]
        found = {}
        for entry in self.draft.forces:
            meaning = self.names.table.get(entry.name)
            if meaning is None or meaning.what is not Kind.PARTICLE:
                hint = near_hint(entry.name, particles) or known_hint(particles)
                self.problems.add(
                    entry.place,
                    f"unknown particle '{entry.name}' in forces",
                    hint or "a system given by its lagrangian has 'generalized_forces' only",
                )
            if entry.value is None:
                continue
            where = f"force '{entry.name}'"
            _, bounds = self.names.check(entry.value, "forces", where)
            found[entry.name] = entry.value
            if bounds is None or meaning is None or not isinstance(meaning.value, tuple):
                continue
            given, due = len(bounds) if isinstance(bounds, tuple) else 1, len(meaning.value)
            if given != due:
                self.problems.add(
                    entry.value.place,
                    f"{where} has {_components(given)}, and '{entry.name}' moves in {due}",
                    f"write {_components(due)}",
                )
        return found

    def potential(self) -> dict[str, Expression]:
        alone = len(self.draft.potential) == 1 and self.draft.potential[0].name == "potential"
        return self.scalars("potential", "potential", named=not alone)

    def generalized_forces(self) -> dict[str, Expression]:
        known = [coordinate.name for coordinate in self.draft.coordinates]
        for entry in self.draft.generalized_forces:
            if entry.name not in known:
                self.problems.add(
                    entry.place,
                    f"unknown coordinate '{entry.name}' in generalized_forces",
                    near_hint(entry.name, known) or known_hint(known),
                )
        return self.scalars("generalized_forces", "generalized force")

    def scalars(self, section: str, what: str, named: bool = True) -> dict[str, Expression]:
        found = {}
        for entry in getattr(self.draft, section):
            if entry.value is not None:
                self._scalar(entry.value, section, f"{what} '{entry.name}'" if named else what)
                found[entry.name] = entry.value
        return found

    def one(self, section: str) -> Expression | None:
        value: Expression | None = getattr(self.draft, section)
        if value is not None:
            self._scalar(value, section, section)
        return value

    def _scalar(self, expression: Expression, section: str, where: str) -> None:
        _, bounds = self.names.check(expression, section, where)
        if isinstance(bounds, tuple):
            self.problems.add(
                expression.place,
                f"a scalar is due in {where}, and this is a vector",
                "take a component, as in bead.x, or norm() or dot()",
            )


def _solve(draft: Draft, problems: Problems) -> SolveDefaults:
    given = {key: value for key, value in draft.solve.items() if value is not None and value != ""}
    places = draft.solve_places
    solve = SolveDefaults(**given, places=places)
    if solve.stop is not None and solve.stop <= solve.start:
        problems.add(
            places["stop"], f"stop = {solve.stop:g} is not after start = {solve.start:g}", "give a later time"
        )
    for key in ("step", "tolerance"):
        value = getattr(solve, key)
        if value is not None and value <= 0:
            problems.add(places[key], f"{key} must be greater than 0, not {value:g}", f"write {key}: 0.01")
    if solve.samples is not None and solve.samples < 2:
        problems.add(
            places["samples"],
            f"samples must be at least 2, not {solve.samples}",
            "both ends of the motion count",
        )
    if solve.samples is not None and solve.step is not None:
        problems.add(places["step"], "'samples' and 'step' cannot both be given", "leave one of them out")
    return solve


def _components(count: int) -> str:
    return f"{count} component{'s' if count > 1 else ''}"


def _stem(filename: str) -> str:
    return Path(filename).stem.strip("<>-") or "system"


def _once(entries: Iterable[Entry]) -> list[Entry]:
    return list(_by_name(entries).values())


def _by_name(entries: Iterable[Entry]) -> dict[str, Entry]:
    found: dict[str, Entry] = {}
    for entry in entries:
        found.setdefault(entry.name, entry)
    return found
