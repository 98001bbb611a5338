"""``Draft`` to ``Spec``: every name is looked up, every shape compared, and nothing needs an algebra yet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.defaults import solve_defaults, time_unit
from lagrange_cli.spec.draft import Declared, Draft, Entry
from lagrange_cli.spec.entering import enter_names
from lagrange_cli.spec.formulation import check_formulation
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.moving import lacking
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.owners import note_unknown_owner, owners
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settling import Settling, check_scalar
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.spec import (
    Body,
    Coordinate,
    Event,
    Expression,
    Family,
    Parameter,
    Spec,
    Transformation,
    Wanted,
)


def check(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Spec:
    """The draft, its families written out, as a ``Spec``; what is wrong is added to ``problems``."""
    checker = _Checker(draft, enter_names(draft, sizes, problems), problems)
    parameters = checker.parameters()
    definitions = checker.definitions()
    coordinates = checker.coordinates()
    check_formulation(draft, problems)
    masses = checker.expressions("masses")
    embedding = checker.embedding()
    bodies, norms, families = checker.bodies()
    for body in draft.bodies:
        if body.mass is not None and body.position is not None:
            masses[body.name], embedding[body.name] = body.mass, body.position
    forces = {row.key: checker.expressions(row.key) for row in SECTIONS.rows if row.force}
    return Spec(
        filename=problems.source.filename,
        text=problems.source.text,
        name=draft.text("name") or _stem(problems.source.filename),
        description=draft.text("description"),
        parameters=parameters,
        coordinates=coordinates,
        definitions=definitions,
        masses=masses,
        embedding=embedding,
        potential=checker.expressions("potential"),
        lagrangian=checker.expressions("lagrangian").get("lagrangian"),
        forces={key: given for key, given in forces.items() if given},
        observables=checker.expressions("observables"),
        solve=solve_defaults(draft, checker.names, problems),
        sizes=sizes,
        families=families,
        time_unit=time_unit(draft, problems),
        events=checker.events(),
        constraints={**checker.expressions("constraints"), **norms},
        nonholonomic=checker.velocity_constraints(),
        bodies=bodies,
        draw=checker.draw(),
        transformations=checker.transformations(),
    )


@dataclass
class _Checker:
    """The draft, the table of names, and where problems go."""

    draft: Draft
    names: Names
    problems: Problems

    def __post_init__(self) -> None:
        self._settling = Settling(self.names, self.draft.families)

    def parameters(self) -> tuple[Parameter, ...]:
        declared = {one.name: one for one in self.draft.declared("parameters")}
        values = {name: one.fields.get("value") for name, one in declared.items()}
        found = []
        for name in self._settling.settle_all(
            self.draft.declared("parameters"), values, Kind.PARAMETER, "parameters"
        ):
            value, fields = values[name], declared[name].fields
            if value is not None:
                unit, description = fields.get("unit", ""), fields.get("description", "")
                found.append(Parameter(name, value, declared[name].place, unit, description))
        return tuple(found)

    def coordinates(self) -> tuple[Coordinate, ...]:
        if not self.draft.declared("coordinates") and not self.problems.found:
            place = self.draft.places.get("coordinates", WHOLE_FILE)
            self.problems.add(
                place, "the system has no coordinates", "write 'coordinates: {x: {initial: 0}}'"
            )
        return tuple(self._coordinate(coordinate) for coordinate in self.draft.declared("coordinates"))

    def _coordinate(self, declared: Declared) -> Coordinate:
        initial, velocity = declared.fields.get("initial"), declared.fields.get("velocity")
        for field, value in (("initial", initial), ("velocity", velocity)):
            if value is not None:
                check_scalar(
                    self.names, value, "coordinates", f"{field} of coordinate '{declared.key.label}'"
                )
        return Coordinate(
            declared.name,
            declared.place,
            initial,
            velocity,
            declared.fields.get("unit", ""),
            declared.fields.get("description", ""),
        )

    def definitions(self) -> dict[str, Expression]:
        values = {entry.name: entry.value for entry in self.draft.entries("definitions")}
        order = self._settling.settle_all(
            self.draft.entries("definitions"), values, Kind.DEFINITION, "definitions"
        )
        return {name: value for name in order if (value := values[name]) is not None}

    def embedding(self) -> dict[str, Expression]:
        found = {}
        for entry in self.draft.entries("embedding"):
            bounds = None
            if entry.value is not None:
                _, bounds = self.names.check(entry.value, "embedding", f"position of '{entry.key.label}'")
                found[entry.name] = entry.value
            vector = (bounds,) if bounds is not None and not isinstance(bounds, tuple) else bounds
            meaning = self.names.table.get(family_name(entry.name))
            first = meaning.value if meaning is not None and meaning.what is Kind.PARTICLE else None
            if vector is not None and first is not None and len(vector) != len(first):
                self.problems.add_once(
                    entry.place,
                    f"'{entry.name}' has {_components(len(vector))}, other members {len(first)}",
                    "give all members of a family the same number of components",
                )
            self._settling.settle(entry.name, Kind.PARTICLE, frozenset({Kind.PARTICLE}), vector)
        return found

    def expressions(self, section: str) -> dict[str, Expression]:
        """The expressions of a section by name, each checked by what the section's row says of them."""
        row, found = SECTIONS.by_word[section], {}
        known = dict.fromkeys(owners(self.draft, row))
        for entry in self.draft.entries(section):
            if row.of is not None and entry.name not in known:
                note_unknown_owner(row, entry, [*known], self.names, self.problems)
            if entry.value is None:
                continue
            alone = entry.passage is None and entry.name == section  # one expression in place of a mapping
            where = section if alone else f"{row.label} '{entry.key.label}'"
            found[entry.name] = entry.value
            if row.vector and (row.of is None or entry.name in known):
                self._vector(entry, entry.value, section, where)
            elif row.vector:
                self.names.check(entry.value, section, where)
            else:
                kinds = check_scalar(self.names, entry.value, section, where)
                missing = lacking(section, kinds)
                if missing is not None and self.problems.trusts(entry.value.tree):
                    message, hint = missing
                    self.problems.add_once(entry.value.place, message.format(entry.name), hint)
        return found

    # What checks the sections that few files have is imported for those files.

    def bodies(self) -> tuple[dict[str, Body], dict[str, Expression], Mapping[str, Mapping[str, Family]]]:
        """The bodies by name, the norms of their quaternions, and all families with theirs."""
        if not self.draft.bodies:
            return {}, {}, self.draft.families
        from lagrange_cli.spec.bodies.check import check_bodies
        from lagrange_cli.spec.bodies.norms import norms, with_families

        found = check_bodies(self.draft, self.names, self.problems)
        return found, norms(found), with_families(self.draft.families, found)

    def events(self) -> dict[str, Event]:
        """The section ``events``."""
        if not self.draft.events:
            return {}
        from lagrange_cli.spec.events.check import check_events

        return check_events(self.draft, self.names, self.problems)

    def transformations(self) -> dict[str, Transformation]:
        """The section ``transformations``."""
        if not self.draft.transformations:
            return {}
        from lagrange_cli.spec.transformations import check_transformations

        return check_transformations(self.draft, self.names, self.problems)

    def draw(self) -> Wanted | None:
        """The section ``draw``."""
        if "draw" not in self.draft.sections:
            return None
        from lagrange_cli.spec.draw.check import check_draw

        return check_draw(self.draft, self.names, self.problems)

    def velocity_constraints(self) -> dict[str, Expression]:
        """The section ``nonholonomic``; its names and those of ``constraints`` are different ones."""
        taken = {entry.name for entry in self.draft.entries("constraints")}
        for entry in self.draft.entries("nonholonomic"):
            if entry.name in taken:
                message = f"'{entry.name}' is the name of another constraint"
                self.problems.add_once(entry.place, message, "rename one of them")
        return self.expressions("nonholonomic")

    def _vector(self, entry: Entry, value: Expression, section: str, where: str) -> None:
        """Note a vector that has not as many components as the position of its particle."""
        _, bounds = self.names.check(value, section, where)
        position = self.names.values.get(entry.name)
        if bounds is None or not isinstance(position, tuple):
            return
        given, expected = len(bounds) if isinstance(bounds, tuple) else 1, len(position)
        if given != expected:
            message = f"{where} has {_components(given)}, its position {expected}"
            self.problems.add_once(value.place, message, f"write {_components(expected)}")


def _components(count: int) -> str:
    return f"{count} component{'s' if count > 1 else ''}"


def _stem(filename: str) -> str:
    return Path(filename).stem.strip("<>-") or "system"
