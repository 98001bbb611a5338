"""``Draft``: the content of a system file, section by section, before any name has been looked up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.syntax import Key, Span
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.source import Passage, Place
from lagrange_cli.spec.spec import Expression, Family

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable
    from lagrange_cli.spec.body import Inertia, Orientation


@dataclass(frozen=True)
class Written:
    """Something of a section that has a name: ``key`` is what was written, in ``passage``.

    In a statement of a family ``name`` is that of the family, in a member that of the member.
    """

    name: str
    place: Place
    key: Key
    passage: Passage | None

    def at(self, span: Span) -> Place:
        """The place of a piece of the key."""
        return self.place if self.passage is None else self.passage.place(span)

    @property
    def is_list(self) -> bool:
        """Whether it is a family whose members are written one after the other."""
        return False

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """What is written with the indices of the key; nothing where members have more than expressions."""
        return ()

    def member(self, name: str, indices: Mapping[str, int]) -> Written:
        """The one of a member of a family."""
        return replace(self, name=name)


@dataclass(frozen=True)
class Entry(Written):
    """``name: expression`` of a section; ``value`` is None where the expression could not be read."""

    value: Expression | None = None

    @property
    def expressions(self) -> tuple[Expression, ...]:
        return () if self.value is None else (self.value,)

    def member(self, name: str, indices: Mapping[str, int]) -> Entry:
        """The entry of one member."""
        return replace(self, name=name, value=_with(self.value, indices))


@dataclass(frozen=True)
class Declared(Written):
    """A parameter or a coordinate: its name, and the fields given for it."""

    fields: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_list(self) -> bool:
        return isinstance(self.fields.get("value"), tuple)

    @property
    def expressions(self) -> tuple[Expression, ...]:
        return tuple(one for one in self.fields.values() if isinstance(one, Expression))

    def member(self, name: str, indices: Mapping[str, int]) -> Declared:
        """The declaration of one member."""
        return replace(self, name=name, fields={key: _with(x, indices) for key, x in self.fields.items()})


@dataclass(frozen=True)
class WrittenEvent(Written):
    """An event. ``changes`` are the entries of ``set``, whose names may be those of members of families;
    ``indices`` are the values of the indices that they are written with. ``when`` is None where it could not
    be read."""

    when: Expression | None = None
    direction: int = 0
    stops: bool = False
    changes: tuple[Entry, ...] = ()
    indices: Mapping[str, int] = field(default_factory=dict)

    @property
    def expressions(self) -> tuple[Expression, ...]:
        alike = (one for one in self.changes if not any(axis.index for axis in one.key.axes))
        given = (self.when, *(one.value for one in alike))
        return tuple(one for one in given if one is not None)

    def member(self, name: str, indices: Mapping[str, int]) -> WrittenEvent:
        """The event of one member."""
        return replace(self, name=name, when=_with(self.when, indices), indices=indices)


@dataclass(frozen=True)
class WrittenBody(Written):
    """A rigid body; what could not be read is None."""

    mass: Expression | None = None
    position: Expression | None = None
    inertia: Inertia | None = None
    orientation: Orientation | None = None

    @property
    def expressions(self) -> tuple[Expression, ...]:
        alone = (one for one in (self.mass, self.position) if one is not None)
        several = (one.entries for one in (self.inertia, self.orientation) if one is not None)
        return (*alone, *chain.from_iterable(several))

    def member(self, name: str, indices: Mapping[str, int]) -> WrittenBody:
        """The body of one member."""
        mass, position = _with(self.mass, indices), _with(self.position, indices)
        inertia, orientation = (one and one.member(indices) for one in (self.inertia, self.orientation))
        return replace(
            self, name=name, mass=mass, position=position, inertia=inertia, orientation=orientation
        )


@dataclass(frozen=True)
class WrittenTransformation(Written):
    """Other coordinates: their declarations, and the ``entries`` for those that they replace. ``families``
    are known once sizes are."""

    coordinates: Sequence[Declared] = ()
    entries: Sequence[Entry] = ()
    families: Mapping[str, Family] = field(default_factory=dict)


def _with(value: Any, indices: Mapping[str, int]) -> Any:
    return replace(value, indices=indices) if isinstance(value, Expression) else value


LOOKED_UP = "parameters", "definitions"
"""Sections with families whose members may be indices, as in ``x[a[n]]``."""


@dataclass(frozen=True)
class Draft:
    """A system file's sections as written.

    ``sections`` has what was read of each that the file gives, by key; ``places`` the place of each key, and
    ``words`` the word that stands there. ``families`` and ``indices`` (of keys, with their places) are known
    once sizes are.
    """

    sections: Mapping[str, Any]
    places: Mapping[str, Place]
    words: Mapping[str, str] = field(default_factory=dict)
    strange: bool = False
    """Whether there are unknown sections, which may be meant to be those that are missing."""
    solve_places: Mapping[str, Place] = field(default_factory=dict)
    families: Mapping[str, Mapping[str, Family]] = field(default_factory=dict)
    indices: tuple[tuple[str, Place], ...] = ()
    tables: Mapping[str, NumberTable] = field(default_factory=dict)
    """Families of whole numbers that indices are looked up in."""

    def text(self, key: str) -> str:
        """The text of a section, empty where it is not given."""
        return str(self.sections.get(key, ""))

    def entries(self, key: str) -> Sequence[Entry]:
        """What a section gives by name."""
        given: Sequence[Entry] = self.sections.get(key, ())
        return given

    def written(self, key: str) -> Sequence[Written]:
        """What a section gives that has names."""
        given: Sequence[Written] = self.sections.get(key, ())
        return given

    def declared(self, key: str) -> Sequence[Declared]:
        """What ``parameters`` or ``coordinates`` declare."""
        given: Sequence[Declared] = self.sections.get(key, ())
        return given

    @property
    def events(self) -> Sequence[WrittenEvent]:
        """The ``events`` section."""
        given: Sequence[WrittenEvent] = self.sections.get("events", ())
        return given

    @property
    def bodies(self) -> Sequence[WrittenBody]:
        """The ``bodies`` section."""
        given: Sequence[WrittenBody] = self.sections.get("bodies", ())
        return given

    @property
    def transformations(self) -> tuple[WrittenTransformation, ...]:
        """The ``transformations`` section."""
        return tuple(self.sections.get("transformations", ()))

    @property
    def solve(self) -> Mapping[str, Any]:
        """The ``solve`` section, by its keys."""
        return dict(self.sections.get("solve", {}))
