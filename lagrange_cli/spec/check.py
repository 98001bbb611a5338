"""``Draft`` to ``Spec``: every name is looked up, every shape compared, and nothing needs an algebra yet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import (
    by_name,
    firsts,
    groups_by_name,
    groups_of,
    in_order,
    parts_by_name,
    statements,
)
from lagrange_cli.spec.defaults import solve_defaults, time_unit
from lagrange_cli.spec.draft import Declared, Draft, Entry, Written
from lagrange_cli.spec.entering import enter_names
from lagrange_cli.spec.formulation import check_formulation
from lagrange_cli.spec.kinds import Kind, called, lacking
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.order import bases_in, dependency_order, leading_to, uses_of, value_of
from lagrange_cli.spec.owners import Owners, note_unknown_owner, owners
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settling import SECTIONS_OF, Settling, check_scalar, counted
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.spec import Coordinate, Expression, Family, Parameter, Spec, Transformation
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.body import Body
    from lagrange_cli.spec.event import Event
    from lagrange_cli.spec.wanted import Wanted

W = TypeVar("W", bound=Written)
Expressions: TypeAlias = "Mapping[str, Expression]"
Families: TypeAlias = "Mapping[str, Mapping[str, Family]]"
IN_TURN = ("parameters",), ("definitions", "embedding", "bodies")
"""Sections whose families may follow from one another."""


def check(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Spec:
    """The draft, its families known, as a ``Spec``; what is wrong is added to ``problems``."""
    checker = checker_of(draft, sizes, problems)
    draft = checker.draft
    checker.names.incomplete = not groups_of(draft.declared("coordinates"))
    parameters = checker.parameters()
    defined, order, of_particles = checker.places()
    coordinates = checker.coordinates()
    check_formulation(draft, problems)
    masses = checker.expressions("masses")
    embedding = given_by_name(groups_of(draft.entries("embedding")))
    bodies, norms, families = checker.bodies()
    if draft.bodies:
        masses, embedding = with_bodies(draft, masses, embedding)
    forces = {row.key: checker.expressions(row.key) for row in SECTIONS.rows if row.force}
    constraints, families = checker.constraints("constraints", families)
    nonholonomic, families = checker.constraints("nonholonomic", families)
    if norms:
        constraints = by_name({**groups_by_name(constraints), **groups_by_name(norms)})
    return Spec(
        filename=problems.source.filename,
        text=problems.source.text,
        name=" ".join(draft.text("name").split()) or name_of(problems.source.filename),
        description=draft.text("description"),
        parameters=parameters,
        coordinates=coordinates,
        definitions=given_by_name(defined),
        order=order,
        of_particles=of_particles,
        masses=masses,
        embedding=embedding,
        potential=checker.expressions("potential"),
        lagrangian=checker.expressions("lagrangian").get("lagrangian"),
        forces={key: given for key, given in forces.items() if given},
        observables=checker.expressions("observables"),
        solve=solve_defaults(draft, checker.names, problems),
        sizes=sizes,
        tables=draft.tables,
        families={key: with_members(given) for key, given in families.items()},
        time_unit=time_unit(draft, problems),
        events=checker.events(),
        constraints=constraints,
        nonholonomic=nonholonomic,
        bodies=bodies,
        draw=checker.draw(),
        transformations=checker.transformations(),
    )


def checker_of(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> _Checker:
    """What checks a draft: one without families that follow from one another in turn, as far as that is
    possible. Mistakes in what these are as written come first, and are all that is reported then."""
    as_written = dict[str, Any]()
    for sections in IN_TURN:
        groups = {one.name: one for key in sections for one in groups_of(draft.sections.get(key, ()))}
        families = sum(isinstance(one, WrittenFamily) for one in groups.values())
        if families > 1 and dependency_order(uses_of(groups))[1]:
            from lagrange_cli.spec.turns import with_turns

            draft, found = with_turns(draft, sections, sizes, problems)
            as_written |= found
    names = enter_names(draft, sizes, problems)
    if as_written:
        before, checked = len(problems.found), names.copy()
        for name, one in names.table.items():  # definitions are not settled yet
            checked.table[name] = replace(one, kinds=one.kinds - {one.what})
        for name, group in as_written.items():
            what = names.table[name].what
            for item in firsts(group):
                checked.check_names(value_of(item), SECTIONS_OF[what], called(item, what))
        if len(problems.found) > before:
            problems.stop_if_any()
    return _Checker(draft, names, problems, as_written)


def with_members(families: Mapping[str, Family]) -> Mapping[str, Family]:
    """Those of some families that have any."""
    return {name: one for name, one in families.items() if one.members}


def name_of(filename: str) -> str:
    """The name of a system whose file gives none; ``?`` stands for what is no text in that of the file."""
    stem = Path(filename).stem.encode(errors="replace").decode()
    return stem.strip("<>-") or "system"


@dataclass
class _Checker:
    """The draft, the table of names, where problems go, and what families are ``as_written`` that follow
    from one another in turn."""

    draft: Draft
    names: Names
    problems: Problems
    as_written: Mapping[str, Any]

    def __post_init__(self) -> None:
        self.settling = Settling(self.names, self.as_written)

    def parameters(self) -> Sequence[Parameter]:
        settled = self.settling.settle_all({Kind.PARAMETER: self.draft.declared("parameters")})
        return in_order(mapped(settled, parameter))

    def places(self) -> tuple[list[Entry | WrittenFamily[Entry]], tuple[str, ...], tuple[str, ...]]:
        """The definitions; the order of their names together with those of particles and bodies, each after
        those that it uses; and the names of definitions that contain particles or bodies."""
        defined, places = self.draft.entries("definitions"), self.draft.entries("embedding")
        given = {Kind.DEFINITION: defined, Kind.PARTICLE: places, Kind.BODY: self.draft.bodies}
        settled, names = self.settling.settle_all(given), {one.name for one in groups_of(defined)}
        found = [one for one in settled if one.name in names]
        uses = {one.name: bases_in(*statements(one)) for one in found}
        known = (name for name, one in self.names.table.items() if one.what in (Kind.PARTICLE, Kind.BODY))
        return found, tuple(one.name for one in settled), tuple(leading_to(uses, known))

    def coordinates(self) -> Sequence[Coordinate]:
        groups = groups_of(self.draft.declared("coordinates"))
        if not groups and not self.problems.found:
            place = self.draft.places.get("coordinates", WHOLE_FILE)
            self.problems.add(
                place, "the system has no coordinates", "write 'coordinates: {x: {initial: 0}}'"
            )
        for declared in (one for group in groups for one in self.names.apart(group)):
            for field in ("initial", "velocity"):
                value = declared.fields.get(field)
                if value is not None:
                    where = f"{field} of coordinate '{declared.key.label}'"
                    check_scalar(self.names, value, "coordinates", where)
        return in_order(mapped(groups, coordinate))

    def expressions(self, section: str) -> Mapping[str, Expression]:
        """The expressions of a section by name, each checked by what the section's row says of them."""
        row, groups = SECTIONS.by_word[section], groups_of(self.draft.entries(section))
        known = owners(self.draft, row)
        for group in groups:
            for entry in self._unknown(group, known) if row.of is not None else ():
                note_unknown_owner(row, entry, [*known], self.names, self.problems)
            for entry in self.names.apart(group):
                if entry.value is not None:
                    self._expression(entry, entry.value, section, row.of is None or entry.name in known)
        return given_by_name(groups)

    def _unknown(self, group: Entry | WrittenFamily[Entry], known: Owners) -> Iterator[Entry]:
        """What belongs to something unknown: of a family, the first member that does of each part."""
        if isinstance(group, WrittenFamily) and all(known.have(group.family, part) for part in group.parts):
            return
        for one in [[group]] if not isinstance(group, WrittenFamily) else map(group.of_part, group.parts):
            yield from islice((entry for entry in one if entry.name not in known), 1)

    def _expression(self, entry: Entry, value: Expression, section: str, owned: bool) -> None:
        """Check one expression of a section; whether what it belongs to exists is known."""
        row = SECTIONS.by_word[section]
        alone = entry.passage is None and entry.name == section  # one expression in place of a mapping
        where = section if alone else f"{row.label} '{entry.key.label}'"
        if row.vector and owned:
            self._vector(entry, value, section, where)
        elif row.vector:
            self.names.check(value, section, where)
        else:
            if row.several:
                kinds, _ = self.names.check(value, section, where)
            else:
                kinds = check_scalar(self.names, value, section, where)
            missing = lacking(section, kinds)
            if missing is not None and self.problems.trusts(value.tree):
                message, hint = missing
                self.problems.add_once(value.place, message.format(entry.name), hint)

    # What checks the sections that few files have is imported for those files.

    def bodies(self) -> tuple[Mapping[str, Body], Expressions, Families]:
        """The bodies by name, the norms of their quaternions, and all families with theirs."""
        if not self.draft.bodies:
            return {}, {}, self.draft.families
        from lagrange_cli.spec.bodies.check import check_bodies
        from lagrange_cli.spec.bodies.norms import norms, with_families

        found = check_bodies(self.draft, self.names, self.problems)
        bound = norms(found)
        return found, bound, with_families(self.draft.families, bound)

    def events(self) -> Mapping[str, Event]:
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

    def constraints(self, section: str, families: Families) -> tuple[Expressions, Families]:
        """The constraints of a section, vectors by their components, and all families with theirs. Names in
        ``nonholonomic`` and in ``constraints`` are different ones."""
        if not self.draft.entries(section):
            return {}, families
        taken = given_by_name(groups_of(self.draft.entries("constraints")))
        for entry in self.draft.entries(section) if section != "constraints" else ():
            if entry.name in taken:
                message = f"'{entry.name}' is the name of another constraint"
                self.problems.add_once(entry.place, message, "rename one of them")
        given = self.expressions(section)
        from lagrange_cli.spec.components import with_components

        own = families.get(section, {})
        given, known = with_components(given, own, self.draft, self.names, self.problems)
        return given, families if known == own else {**families, section: known}

    def _vector(self, entry: Entry, value: Expression, section: str, where: str) -> None:
        """Note a vector that has not as many components as the position of its particle."""
        _, bounds = self.names.check(value, section, where)
        position = self.names.values.get(entry.name)
        if bounds is None or not isinstance(position, tuple):
            return
        given, expected = len(bounds) if isinstance(bounds, tuple) else 1, len(position)
        if given != expected:
            message = f"{where} has {counted(given)}, its position {expected}"
            self.problems.add_once(value.place, message, f"write {counted(expected)}")


def mapped(groups: Sequence[W | WrittenFamily[W]], function: Callable[[W], Any]) -> list[Any]:
    """What ``function`` makes of each item, and of each statement of families; without those of which it is
    None."""
    found: list[Any] = []
    for one in groups:
        if not isinstance(one, WrittenFamily):
            made = function(one)
            found += [] if made is None else [made]
        elif all(function(part.item) is not None for part in one.parts):
            found.append(one.mapped(function))
    return found


def given_by_name(groups: Sequence[Entry | WrittenFamily[Entry]]) -> Mapping[str, Expression]:
    """The values that entries give, by their names."""
    return by_name(parts_by_name(groups, lambda entry: entry.value))


def with_bodies(
    draft: Draft, masses: Mapping[str, Expression], embedding: Mapping[str, Expression]
) -> tuple[Mapping[str, Expression], Mapping[str, Expression]]:
    """The masses and positions of particles together with those of bodies."""
    groups = groups_of(draft.bodies)
    weights = parts_by_name(groups, lambda body: body.mass)
    places = parts_by_name(groups, lambda body: body.position)
    return by_name({**groups_by_name(masses), **weights}), by_name({**groups_by_name(embedding), **places})


def parameter(declared: Declared) -> Parameter | None:
    """A parameter; None where its value could not be read."""
    value, fields = declared.fields.get("value"), declared.fields
    if value is None:
        return None
    return Parameter(
        declared.name, value, declared.place, fields.get("unit", ""), fields.get("description", "")
    )


def coordinate(declared: Declared) -> Coordinate:
    """A coordinate."""
    fields = declared.fields
    return Coordinate(
        declared.name,
        declared.place,
        fields.get("initial"),
        fields.get("velocity"),
        fields.get("unit", ""),
        fields.get("description", ""),
    )
