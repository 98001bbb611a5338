"""``Spec``: a system file that has been read, checked and found right. Nothing is derived yet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from lagrange_cli.expression.syntax import Span, Tree
from lagrange_cli.expression.vocabulary import family_name, member_name
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.source import Passage
from lagrange_cli.spec.source import Place as Place

T = TypeVar("T")


@dataclass(frozen=True)
class Expression:
    """An expression: its text, its tree, and where in the file it stands.

    ``tree`` is a ``Vector`` (or a vector-valued tree) where a vector is due and scalar-valued otherwise:
    this has been checked, and every name in it is known. ``passages`` are the pieces of the file the text
    was put together from, each with its offset in ``text``. ``indices`` are the values of the indices that
    stand in it, where it is that of a member of a family.
    """

    text: str
    tree: Tree
    place: Place
    passages: tuple[tuple[int, Passage], ...] = field(default=(), repr=False, compare=False)
    indices: Mapping[str, int] = field(default_factory=dict)

    def at(self, span: Span) -> Place:
        """Where ``span`` of the text stands in the file."""
        for offset, passage in reversed(self.passages):
            if offset <= span.start:
                return passage.place(Span(span.start - offset, span.stop - offset))
        return self.place


@dataclass(frozen=True)
class Family:
    """Quantities of one name: ``members`` are called ``u[0,0]``, ``u[0,1]`` and so on, the last index
    fastest, and ``shape`` says how far each index runs. ``axes`` are the indices' names in the output."""

    name: str
    shape: tuple[int, ...]
    members: tuple[str, ...]
    axes: tuple[str, ...]

    @property
    def label(self) -> str:
        """The family as it is called in texts: ``u[i,j]``."""
        return member_name(self.name, "ijklmn"[: len(self.shape)]) if self.shape else self.name


def by_family(pairs: Iterable[tuple[str, T]]) -> dict[str, list[T]]:
    """What belongs to each name, or to the members of each family, in the file's order."""
    found: dict[str, list[T]] = {}
    for name, item in pairs:
        found.setdefault(family_name(name), []).append(item)
    return found


def grouped(names: Iterable[str], families: Mapping[str, Family]) -> tuple[Family, ...]:
    """``names`` by family, in their order; a name of its own is a family of shape ()."""
    found: dict[str, Family] = {}
    for name in names:
        base = family_name(name)
        found.setdefault(base, families.get(base) or Family(name, (), (name,), ()))
    return tuple(found.values())


@dataclass(frozen=True)
class Parameter:
    """A constant of the system; ``value`` may use other parameters (never in a cycle)."""

    name: str
    value: Expression
    place: Place
    unit: str = ""
    description: str = ""


@dataclass(frozen=True)
class Coordinate:
    """A generalized coordinate; the initial state is given by expressions in parameters."""

    name: str
    place: Place
    initial: Expression | None
    velocity: Expression | None
    unit: str = ""
    description: str = ""


SURFACE = "--where"
"""The name of the event that a section is taken at; no name of a file is like it."""


@dataclass(frozen=True)
class Event:
    """What happens where ``when`` becomes 0.

    ``direction`` is +1 where it must rise, -1 where it must fall, 0 where either counts. The motion ends
    there if it ``stops``. ``changes`` are the new values of coordinates, velocities and parameters, by name.
    """

    when: Expression
    direction: int
    stops: bool
    changes: Mapping[str, Expression]
    place: Place


@dataclass(frozen=True)
class SolveDefaults:
    """The ``solve`` section: defaults of the command line; ``None`` where the file is silent.

    ``times`` are those of ``start``, ``stop`` and ``step`` that depend on parameters; they are ``None`` until
    these have values.
    """

    start: float | None = None
    stop: float | None = None
    samples: int | None = None
    step: float | None = None
    method: str | None = None
    tolerance: float | None = None
    outputs: tuple[str, ...] | None = None
    places: Mapping[str, Place] = field(default_factory=dict)
    """Where the file gives each of them."""
    times: Mapping[str, Expression] = field(default_factory=dict)

    @property
    def pending(self) -> frozenset[str]:
        """Those of ``times`` that have no value yet."""
        return frozenset(name for name in self.times if getattr(self, name) is None)


@dataclass(frozen=True)
class Spec:
    """A whole system file. Mappings keep the file's order; coordinates' order is the order of q.

    ``potential`` maps term names to expressions that are summed (one term named ``potential`` when the
    file gives a single expression). An ``embedding`` is a vector, or a scalar for one component.
    ``definitions`` and ``parameters`` are sorted so that each uses only
    earlier ones. Exactly one of ``lagrangian`` and ``embedding`` is given. ``forces`` are by the keys of the
    file that give forces (``model.forces`` says how each acts), then by what they act on. ``text`` is the
    file as read.

    Families are written out: everything goes by the names of members, such as ``theta[3]``, and
    ``families`` has them by section and name. ``sizes`` are the whole numbers they were written with.
    ``time_unit`` is the unit of t, empty where the file does not say it.
    """

    filename: str
    text: str
    name: str
    description: str
    parameters: tuple[Parameter, ...]
    coordinates: tuple[Coordinate, ...]
    definitions: Mapping[str, Expression]
    masses: Mapping[str, Expression]
    embedding: Mapping[str, Expression]
    potential: Mapping[str, Expression]
    lagrangian: Expression | None
    forces: Mapping[str, Mapping[str, Expression]]
    observables: Mapping[str, Expression]
    solve: SolveDefaults
    sizes: Mapping[str, int] = field(default_factory=dict)
    families: Mapping[str, Mapping[str, Family]] = field(default_factory=dict)
    time_unit: str = ""
    events: Mapping[str, Event] = field(default_factory=dict)


def has_units(spec: Spec) -> bool:
    """Whether the file gives any unit."""
    if spec.time_unit:
        return True
    return any(one.unit for one in spec.parameters) or any(one.unit for one in spec.coordinates)
