"""What the entries of a section belong to: a force acts on a particle, a torque on a body."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.draft import Draft, Entry
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Family
from lagrange_cli.spec.table import Row
from lagrange_cli.spec.whole import Part, WrittenFamily

FORCES_ON = {Kind.PARTICLE: "forces", Kind.BODY: "torques", Kind.COORDINATE: "generalized_forces"}
"""The section for what acts on each."""


class Owners:
    """The names that the entries of a section may have, where they are names of something else."""

    def __init__(self, groups: Iterable[Any]) -> None:
        self._families: dict[str, WrittenFamily[Any]] = {}
        self._single: dict[str, None] = {}
        for one in groups:
            if isinstance(one, WrittenFamily):
                self._families[one.name] = one
            else:
                self._single[one.name] = None

    def __contains__(self, name: str) -> bool:
        family = self._families.get(name.partition("[")[0])
        return name in self._single or (family is not None and name in family.family.members)

    def __iter__(self) -> Iterator[str]:
        yield from self._single
        for one in self._families.values():
            yield from one.names

    def have(self, family: Family, part: Part[Any]) -> bool:
        """Whether it is seen at once that all members of a part of a family are among them."""
        found = self._families.get(family.name)
        return found is not None and any(part.within(one) for one in found.parts)


def owners(draft: Draft, row: Row) -> Owners:
    """Those of a section."""
    if row.of is Kind.PARTICLE:
        return Owners((*groups_of(draft.entries("embedding")), *groups_of(draft.bodies)))
    if row.of is Kind.BODY:
        return Owners(groups_of(draft.bodies))
    return Owners(groups_of(draft.declared("coordinates")) if row.of is Kind.COORDINATE else ())


def note_unknown_owner(
    row: Row, entry: Entry, known: Sequence[str], names: Names, problems: Problems
) -> None:
    """Note an entry for a particle, a body or a coordinate that is none of the ``known``."""
    if family_name(entry.name) in problems.broken:
        return  # one message is enough
    meaning = names.table.get(family_name(entry.name))
    where = FORCES_ON.get(meaning.what) if meaning is not None else None
    if meaning is not None and where is not None and meaning.what is not row.of:
        hint = f"'{entry.name}' is a {meaning.what.value}: forces on it are written under '{where}'"
    else:
        hint = _other_hint(entry.name, known, names)
    if row.of is Kind.PARTICLE:
        hint = hint or "with a 'lagrangian', forces are written under 'generalized_forces'"
    if row.of is Kind.BODY:
        hint = hint or "bodies are declared under 'bodies'"
    assert row.of is not None
    message = f"unknown {row.of.value} '{entry.name}' in {row.key}"
    problems.add_once(entry.place, message, hint)


def _other_hint(name: str, known: Sequence[str], names: Names) -> str:
    meaning = names.table.get(family_name(name))
    if meaning is not None and meaning.family is not None and name not in names.values:
        if "[" not in name:
            return f"write {meaning.family.label} for its members"
        return meaning.family.hint(name)
    return near_hint(name, known) or known_hint(known)
