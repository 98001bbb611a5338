"""All names of a file, entered in one table before anything refers to them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.expression.vocabulary import ACCELERATION_SUFFIX, TIME, family_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.kinds import Kind, Meaning
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Family
from lagrange_cli.spec.whole import Part, WrittenFamily


def enter_names(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Names:
    """The table of names, so that a later one can be told from one that does not exist."""
    names = Names(problems, sizes, {row.key: row.rule for row in SECTIONS.rows})
    names.siblings = siblings(draft)
    _Entering(draft, names, problems).enter()
    return names


@dataclass
class _Entering:
    """The draft, the table of names, and where problems go."""

    draft: Draft
    names: Names
    problems: Problems

    def enter(self) -> None:
        draft = self.draft
        self.names.declare(TIME, Kind.TIME, None, scalar())
        for size in draft.entries("sizes"):
            value = Bounds(float(self.names.sizes.get(size.name, 1)))
            if self.names.declare(size.name, Kind.SIZE, size.place, value):
                self.names.settle(size.name, frozenset(), value)  # a plain number, wherever it stands
        self.names.declare_coordinates(
            [*self._named("coordinates", groups_of(draft.declared("coordinates")))]
        )
        particles = *groups_of(draft.entries("masses")), *groups_of(draft.entries("embedding"))
        self._free("parameters", groups_of(draft.declared("parameters")), Kind.PARAMETER)
        self._free("definitions", groups_of(draft.entries("definitions")), Kind.DEFINITION)
        self._free("embedding", particles, Kind.PARTICLE)
        self._free("bodies", groups_of(draft.bodies), Kind.BODY)
        for name, place, _ in self._named("observables", groups_of(draft.entries("observables"))):
            self._observable(name, place)
        for section in ("constraints", "nonholonomic"):
            for name, place, family in self._named(section, groups_of(draft.entries(section))):
                self.names.declare_multiplier(name, place, family)
        self._without_members()
        for index, place in draft.indices:
            try:
                self.names.check_index(index, Span(0, 1))
            except ExpressionError as error:
                self.problems.add(place, error.message, error.hint)

    def _without_members(self) -> None:
        """Enter families that have no members, as the pairs of one body: sums over them are 0."""
        for section, what, table in (
            ("definitions", Kind.DEFINITION, self.names.table),
            ("constraints", Kind.MULTIPLIER, self.names.bound),
            ("nonholonomic", Kind.MULTIPLIER, self.names.bound),
        ):
            for name, family in self.draft.families[section].items():
                if not family.members:
                    table.setdefault(name, Meaning(what, frozenset(), None, None, family))

    def _observable(self, name: str, place: Place) -> None:
        """Note the name of an observable that is that of a coordinate or a velocity: its values are written
        beside theirs."""
        other = self.names.table.get(name)
        if other is not None and other.place and other.what in (Kind.COORDINATE, Kind.VELOCITY):
            message = f"the observable '{name}' has the name of a {other.what.value}"
            self.problems.add(place, message, f"rename it, or the coordinate in line {other.place.line}")

    def _named(self, section: str, entries: Iterable[Any]) -> Iterator[tuple[str, Place, Family | None]]:
        """Each name of a section once, with its place, and its family where it is that of one."""
        seen: set[str] = set()
        for entry in entries:
            name = family_name(entry.name)
            if name not in seen:
                seen.add(name)
                first = entry[0] if isinstance(entry, WrittenFamily) else entry
                yield name, first.place, self._family(section, name)

    def _family(self, section: str, name: str) -> Family | None:
        families = self.draft.families
        found = families[section].get(name)
        return families["masses"].get(name) if found is None and section == "embedding" else found

    def _free(self, section: str, entries: Iterable[Any], what: Kind) -> None:
        """Enter names that may be any but those of accelerations."""
        for name, place, family in self._named(section, entries):
            base = name.removesuffix(ACCELERATION_SUFFIX)
            meaning = self.names.table.get(base) if base != name else None
            if meaning is not None and meaning.what is Kind.COORDINATE:
                message = f"the {what.value} '{name}' has the name of an acceleration"
                self.problems.add(place, message, "rename it")
            else:
                self.names.declare(name, what, place, None, family)


def siblings(draft: Draft) -> dict[int, list[Part[Any]]]:
    """The members of families that share an expression, by its tree."""
    found: dict[int, list[Part[Any]]] = {}
    for row in SECTIONS.rows:
        for group in groups_of(draft.sections.get(row.key, ())) if row.family else ():
            for part in group.parts if isinstance(group, WrittenFamily) else ():
                for one in part.item.expressions if part.axes else ():
                    found.setdefault(id(one.tree), []).append(part)
    return found
