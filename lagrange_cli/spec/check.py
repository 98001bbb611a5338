"""``Draft`` to ``Spec``: every name is looked up, every shape compared, and nothing needs an algebra yet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.expression.vocabulary import ACCELERATION_SUFFIX, TIME, family_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.defaults import solve_defaults, time_unit
from lagrange_cli.spec.draft import Declared, Draft, Entry, Written
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.moving import lacking
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settling import Settling, check_scalar
from lagrange_cli.spec.source import WHOLE_FILE, Place
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
from lagrange_cli.spec.table import Row

FORCES_ON = {Kind.PARTICLE: "forces", Kind.BODY: "torques", Kind.COORDINATE: "generalized_forces"}
"""The section for what acts on each."""


def check(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Spec:
    """The draft, its families written out, as a ``Spec``; what is wrong is added to ``problems``."""
    checker = _Checker(draft, sizes, problems)
    checker.declare()
    parameters = checker.parameters()
    definitions = checker.definitions()
    coordinates = checker.coordinates()
    checker.formulation()
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
    sizes: Mapping[str, int]
    problems: Problems

    def __post_init__(self) -> None:
        self.names = Names(self.problems, self.sizes, {row.key: row.rule for row in SECTIONS.rows})
        self._settling = Settling(self.names, self.draft.families)
        self.names.siblings = siblings(self.draft)

    def declare(self) -> None:
        """Enter all names, so that a later one can be told from one that does not exist."""
        draft = self.draft
        self.names.declare(TIME, Kind.TIME, None, scalar())
        for size in draft.entries("sizes"):
            value = Bounds(float(self.sizes.get(size.name, 1)))
            if self.names.declare(size.name, Kind.SIZE, size.place, value):
                self.names.settle(size.name, frozenset(), value)  # a plain number, wherever it stands
        self.names.declare_coordinates([*self._named("coordinates", draft.declared("coordinates"))])
        for name, place, family in self._named("parameters", draft.declared("parameters")):
            self._declare_free(name, Kind.PARAMETER, place, family)
        for name, place, family in self._named("definitions", draft.entries("definitions")):
            self._declare_free(name, Kind.DEFINITION, place, family)
        for name, place, family in self._named(
            "embedding", (*draft.entries("masses"), *draft.entries("embedding"))
        ):
            self._declare_free(name, Kind.PARTICLE, place, family)
        for name, place, family in self._named("bodies", draft.bodies):
            self._declare_free(name, Kind.BODY, place, family)
        for section in ("constraints", "nonholonomic"):
            for name, place, family in self._named(section, draft.entries(section)):
                self.names.declare_multiplier(name, place, family)
        for index, place in draft.indices:
            try:
                self.names.check_index(index, Span(0, 1))
            except ExpressionError as error:
                self.problems.add(place, error.message, error.hint)

    def _named(self, section: str, entries: Iterable[Written]) -> Iterator[tuple[str, Place, Family | None]]:
        """Each name of a section once, with its place, and its family where it is that of one."""
        seen: set[str] = set()
        for entry in entries:
            name = family_name(entry.name)
            if name not in seen:
                seen.add(name)
                yield name, entry.place, self._family(section, name)

    def _family(self, section: str, name: str) -> Family | None:
        families = self.draft.families
        found = families[section].get(name)
        return families["masses"].get(name) if found is None and section == "embedding" else found

    def _declare_free(self, name: str, what: Kind, place: Place, family: Family | None) -> None:
        base = name.removesuffix(ACCELERATION_SUFFIX)
        if base != name and base in self.names.table and self.names.table[base].what is Kind.COORDINATE:
            self.problems.add(
                place, f"the {what.value} '{name}' has the name of an acceleration", "rename it"
            )
            return
        self.names.declare(name, what, place, None, family)

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

    def formulation(self) -> None:
        """Either a lagrangian, or masses that are embedded."""
        draft, places = self.draft, self.draft.places
        if "lagrangian" in places:
            for other in ("masses", "embedding", "bodies", "potential"):
                if other in places:
                    word = draft.words.get("embedding", "positions") if other == "embedding" else other
                    self.problems.add(
                        places[other],
                        f"'{word}' cannot be given together with 'lagrangian'",
                        "a Lagrangian replaces masses, positions, bodies and potential: leave one or "
                        "the other out",
                    )
            return
        if "masses" not in places and "embedding" not in places:
            if draft.strange or draft.bodies:
                return
            self.problems.add(
                WHOLE_FILE,
                "the system has no masses and no Lagrangian",
                "write 'masses' with 'positions' (or 'embedding'), or 'lagrangian'",
            )
            return
        word = draft.words.get("embedding", "positions")
        masses, embedding = _by_name(draft.entries("masses")), _by_name(draft.entries("embedding"))
        self._partners(masses, embedding, "a mass but no position", f"{word}: {{%s: [x, y]}}")
        self._partners(embedding, masses, "a position but no mass", "masses: {%s: 1.0}")
        if not masses and not embedding and not draft.bodies and not self.problems.found:
            place = places.get("masses", places.get("embedding", WHOLE_FILE))
            self.problems.add(place, "the system has no particles", "write 'masses: {bead: m}'")

    def _partners(
        self, entries: dict[str, Entry], partners: dict[str, Entry], what: str, example: str
    ) -> None:
        families = {family_name(one) for one in partners}
        alone = [one for one in partners if one not in entries]
        for name, entry in entries.items():
            if name not in partners:
                near = near_hint(name, alone)
                if family_name(name) in families:
                    near = "declare the same members in both"
                self.problems.add_once(
                    entry.place, f"the particle '{name}' has {what}", near or f"add {example % name}"
                )

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
        owners = dict.fromkeys(self._owners(row))
        for entry in self.draft.entries(section):
            if row.of is not None and entry.name not in owners:
                self._no_owner(row, entry, list(owners))
            if entry.value is None:
                continue
            alone = entry.passage is None and entry.name == section  # one expression in place of a mapping
            where = section if alone else f"{row.label} '{entry.key.label}'"
            found[entry.name] = entry.value
            if row.vector and (row.of is None or entry.name in owners):
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
        from lagrange_cli.spec.bodies import check_bodies, norms, with_families

        found = check_bodies(self.draft, self.names, self.problems)
        return found, norms(found), with_families(self.draft.families, found)

    def events(self) -> dict[str, Event]:
        """The section ``events``."""
        if not self.draft.events:
            return {}
        from lagrange_cli.spec.events import check_events

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
        from lagrange_cli.spec.drawn import check_draw

        return check_draw(self.draft, self.names, self.problems)

    def velocity_constraints(self) -> dict[str, Expression]:
        """The section ``nonholonomic``; its names and those of ``constraints`` are different ones."""
        taken = {entry.name for entry in self.draft.entries("constraints")}
        for entry in self.draft.entries("nonholonomic"):
            if entry.name in taken:
                message = f"'{entry.name}' is the name of another constraint"
                self.problems.add_once(entry.place, message, "rename one of them")
        return self.expressions("nonholonomic")

    def _owners(self, row: Row) -> Iterator[str]:
        """The names that the entries of a section may have, where they are names of something else."""
        if row.of is Kind.PARTICLE:
            yield from (entry.name for entry in self.draft.entries("embedding"))
            yield from (body.name for body in self.draft.bodies)
        elif row.of is Kind.BODY:
            yield from (body.name for body in self.draft.bodies)
        elif row.of is Kind.COORDINATE:
            yield from (declared.name for declared in self.draft.declared("coordinates"))

    def _no_owner(self, row: Row, entry: Entry, known: list[str]) -> None:
        """Note an entry for a particle or a coordinate that does not exist."""
        meaning = self.names.table.get(family_name(entry.name))
        where = FORCES_ON.get(meaning.what) if meaning is not None else None
        if meaning is not None and where is not None and meaning.what is not row.of:
            hint = f"'{entry.name}' is a {meaning.what.value}: forces on it are written under '{where}'"
        else:
            hint = self._other_hint(entry.name, known)
        if row.of is Kind.PARTICLE:
            hint = hint or "with a 'lagrangian', forces are written under 'generalized_forces'"
        if row.of is Kind.BODY:
            hint = hint or "bodies are declared under 'bodies'"
        assert row.of is not None
        message = f"unknown {row.of.value} '{entry.name}' in {row.key}"
        self.problems.add_once(entry.place, message, hint)

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

    def _other_hint(self, name: str, known: list[str]) -> str:
        meaning = self.names.table.get(family_name(name))
        if meaning is not None and meaning.family is not None and name not in self.names.values:
            if "[" not in name:
                return f"write {meaning.family.label} for its members"
            return meaning.family.hint(name)
        return near_hint(name, known) or known_hint(known)


def _components(count: int) -> str:
    return f"{count} component{'s' if count > 1 else ''}"


def _stem(filename: str) -> str:
    return Path(filename).stem.strip("<>-") or "system"


def _by_name(entries: Iterable[Entry]) -> dict[str, Entry]:
    found: dict[str, Entry] = {}
    for entry in entries:
        found.setdefault(entry.name, entry)
    return found


def siblings(draft: Draft) -> dict[int, list[Expression]]:
    """The expressions of members of families, by the tree that they share."""
    found: dict[int, list[Expression]] = {}
    for written in (one for row in SECTIONS.rows if row.family for one in draft.sections.get(row.key, ())):
        given = (
            written.fields.values() if isinstance(written, Declared) else [getattr(written, "value", None)]
        )
        for one in given:
            if isinstance(one, Expression) and one.indices:
                found.setdefault(id(one.tree), []).append(one)
    return found
