"""``Spec``: a system file that has been read, checked and found right. Nothing is derived yet."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.expression.syntax import has_decimals, names
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import bases_of, firsts_of, groups_by_name, written
from lagrange_cli.spec.family import Family as Family
from lagrange_cli.spec.source import Expression as Expression
from lagrange_cli.spec.source import Place as Place
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable
    from lagrange_cli.spec.body import Body
    from lagrange_cli.spec.event import Event
    from lagrange_cli.spec.wanted import Wanted

T = TypeVar("T")

WIDE = 1000
"""Members of a family of definitions that may all be built."""


def by_family(pairs: Iterable[tuple[str, T]]) -> dict[str, list[T]]:
    """What belongs to each name, or to the members of each family, in the file's order."""
    found: dict[str, list[T]] = {}
    for name, item in pairs:
        found.setdefault(name.partition("[")[0], []).append(item)
    return found


def grouped(names: Iterable[str], families: Mapping[str, Family]) -> tuple[Family, ...]:
    """``names`` by family, in their order; a name of its own is a family of shape ()."""
    found: dict[str, Family] = {}
    for name in bases_of(names):
        base = name.partition("[")[0]
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

    def member(self, name: str, indices: Mapping[str, int]) -> Parameter:
        """A member of a family."""
        return replace(self, name=name, value=replace(self.value, indices=indices))


@dataclass(frozen=True)
class Coordinate:
    """A generalized coordinate; the initial state is given by expressions in parameters."""

    name: str
    place: Place
    initial: Expression | None
    velocity: Expression | None
    unit: str = ""
    description: str = ""

    def member(self, name: str, indices: Mapping[str, int]) -> Coordinate:
        """A member of a family."""
        initial, velocity = (one and replace(one, indices=indices) for one in (self.initial, self.velocity))
        return replace(self, name=name, initial=initial, velocity=velocity)


SURFACE = "--where"
"""The name of the event that a section is taken at; no name of a file is like it."""


@dataclass(frozen=True)
class Transformation:
    """Other coordinates of the same system. ``replaced`` are coordinates of the file as functions of the new
    ``coordinates``, of those that stay, of t and of parameters. ``families`` are those of the new ones."""

    coordinates: Sequence[Coordinate]
    replaced: Mapping[str, Expression]
    families: Mapping[str, Family]
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
        """The ``times`` that have no value yet."""
        return frozenset(name for name in self.times if getattr(self, name) is None)


@dataclass(frozen=True)
class Spec:
    """A whole system file. Mappings keep the file's order; coordinates' order is the order of q.

    ``potential`` maps term names to expressions that are summed (one term named ``potential`` when the
    file gives a single expression). An ``embedding`` is a vector, or a scalar for one component.
    Masses and positions of ``bodies`` are there, too, and the norms of their quaternions under
    ``constraints``. ``definitions`` and ``parameters`` are sorted so that each uses only earlier ones;
    ``order`` has the names of definitions, particles and bodies (families without indices), each after those
    that it uses. Definitions ``of_particles`` contain particles or bodies. Exactly one of ``lagrangian`` and
    ``embedding`` is given. ``forces`` are by the keys of the file that give forces (``model.forces`` says how
    each acts), then by what they act on.
    ``text`` is the file as read.

    Everything goes by the names of members, such as ``theta[3]``; families are kept as they are written, and
    their members are made where they are asked for (``spec.content``). ``families`` has them by section and
    name. ``sizes`` are the whole numbers they were written with, ``tables`` those in which
    indices are looked up.
    ``time_unit`` is the unit of t, empty where the file does not say it. ``left_out`` names constraints that
    depend on others with the numbers of the run: the equations of motion are derived without them, except
    those ``in_turn``, which depend on them by factors that change along a motion. Groups of them are
    ``tied``, in each of which some depend on the others. ``faint`` are those with a coefficient that is 0, or
    all but 0, with these numbers, or may become so: nothing may be divided by it.
    ``draw`` has no part in the equations.
    ``replaced`` are names of the file that are functions of the ``coordinates`` once these have been changed
    by one of the ``transformations``. ``massless`` are coordinates without mass, by the names of the
    constraints that are their equations of motion (``run.massless``). Those of ``first_order`` have no such
    constraints, as the loops over their families compute velocities (``families.first_order``).
    """

    filename: str
    text: str
    name: str
    description: str
    parameters: Sequence[Parameter]
    coordinates: Sequence[Coordinate]
    definitions: Mapping[str, Expression]
    order: tuple[str, ...]
    of_particles: tuple[str, ...]
    masses: Mapping[str, Expression]
    embedding: Mapping[str, Expression]
    potential: Mapping[str, Expression]
    lagrangian: Expression | None
    forces: Mapping[str, Mapping[str, Expression]]
    observables: Mapping[str, Expression]
    solve: SolveDefaults
    sizes: Mapping[str, int] = field(default_factory=dict)
    tables: Mapping[str, NumberTable] = field(default_factory=dict)
    families: Mapping[str, Mapping[str, Family]] = field(default_factory=dict)
    time_unit: str = ""
    events: Mapping[str, Event] = field(default_factory=dict)
    constraints: Mapping[str, Expression] = field(default_factory=dict)
    nonholonomic: Mapping[str, Expression] = field(default_factory=dict)
    bodies: Mapping[str, Body] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    in_turn: tuple[str, ...] = ()
    tied: tuple[tuple[str, ...], ...] = ()
    faint: tuple[str, ...] = ()
    draw: Wanted | None = None
    transformations: Mapping[str, Transformation] = field(default_factory=dict)
    replaced: Mapping[str, Expression] = field(default_factory=dict)
    massless: Mapping[str, str] = field(default_factory=dict)
    first_order: tuple[str, ...] = ()

    @property
    def coordinate_families(self) -> Mapping[str, Family]:
        """The families of coordinates, by what they are named by."""
        return self.families.get("coordinates", {})

    @property
    def written_bodies(self) -> Iterator[Body]:
        """The bodies; of members of a family that are written alike the first."""
        return written(self.bodies)

    @property
    def all_constraints(self) -> Mapping[str, Expression]:
        """Holonomic and nonholonomic ones."""
        return {**self.constraints, **self.nonholonomic} if self.nonholonomic else self.constraints

    @property
    def constrained(self) -> bool:
        """Whether there are constraints."""
        return bool(self.constraints or self.nonholonomic)

    @property
    def restricted(self) -> bool:
        """Whether the state has to satisfy something: constraints, or the equations of coordinates without
        mass."""
        return self.constrained or bool(self.first_order)

    @property
    def moving(self) -> Iterator[Expression]:
        """What the equations of motion and the events are made of; of members of a family that are written
        alike the first."""
        yield from self.in_motion(written)
        for event in written(self.events):
            yield from event.written

    @property
    def moving_members(self) -> Iterator[Expression]:
        """The same of all members."""
        yield from self.in_motion(lambda section: section.values())
        for event in self.events.values():
            yield from (event.when, *event.changes.values())

    @property
    def in_equations(self) -> Iterator[Expression]:
        """What the equations of motion of all members are made of; definitions come last, without those that
        are built where they are used."""
        if self.lagrangian is not None:
            yield self.lagrangian
        for section in (self.potential, *self.forces.values(), self.embedding):
            yield from section.values()
        for body in self.bodies.values():
            yield from body.expressions
        yield from self.all_constraints.values()
        wide = self.wide
        for name, one in groups_by_name(self.definitions).items():
            if name not in wide:
                yield from one if isinstance(one, WrittenFamily) else [one]

    @property
    def wide(self) -> frozenset[str]:
        """The families of definitions whose members are built where they are used: those that are large, and
        do not use one another."""
        return frozenset(
            name
            for name, one in groups_by_name(self.definitions).items()
            if isinstance(one, WrittenFamily) and len(one) > WIDE
            if not any(used.base == name for part in one.parts for used in names(part.item.tree))
        )

    def in_motion(self, of: Callable[[Mapping[str, Any]], Iterable[Any]]) -> Iterator[Expression]:
        """What energies, forces, positions and orientations are made of, ``of`` each section."""
        for section in (self.embedding, self.potential, *self.forces.values()):
            yield from of(section)
        for body in of(self.bodies):
            yield from body.expressions
        if self.lagrangian is not None:
            yield self.lagrangian

    @property
    def acts(self) -> bool:
        """Whether an event sets anything."""
        return any(one.sets for one in written(self.events))

    @property
    def decimals(self) -> bool:
        """Whether a number in what the equations of motion are made of has a decimal point or an exponent."""
        further = (self.masses, self.definitions, self.all_constraints)
        given = (*self.moving, *(one for section in further for one in written(section)))
        return any(has_decimals(one.tree) for one in distinct(given))

    @property
    def independent(self) -> Spec:
        """The system as if it had no constraints that are left out."""
        return replace(self.without(self.left_out), left_out=()) if self.left_out else self

    def without(self, names: Collection[str]) -> Spec:
        """The system without the constraints of these names."""
        kept = {
            section: {k: one for k, one in getattr(self, section).items() if k not in names}
            for section in ("constraints", "nonholonomic")
        }
        return replace(self, **kept)

    @property
    def of_first_order(self) -> int:
        """The number of coordinates without mass whose equations of motion give velocities."""
        return len(self.first_order) + sum(name in self.nonholonomic for name in self.massless)

    @property
    def degrees_of_freedom(self) -> int:
        """Coordinates that have a mass, less constraints that do not depend on others."""
        determined = len(self.all_constraints) + len(self.first_order)
        return len(self.coordinates) - determined + len(self.left_out)


def freedom(degrees: int, first_order: int) -> str:
    """``2 degrees of freedom``, and how many coordinates of ``first_order`` there are besides."""
    said = [f"{degrees} degree{'' if degrees == 1 else 's'} of freedom"] if degrees or not first_order else []
    if first_order:
        said.append(f"{first_order} coordinate{'' if first_order == 1 else 's'} of first order")
    return " and ".join(said)


def distinct(expressions: Iterable[Expression]) -> Iterable[Expression]:
    """The first expression of each that is written: the members of a family share its tree."""
    found: dict[int, Expression] = {}
    for one in expressions:
        found.setdefault(id(one.tree), one)
    return found.values()


def has_units(spec: Spec) -> bool:
    """Whether the file gives any unit."""
    if spec.time_unit:
        return True
    parameters, coordinates = firsts_of(spec.parameters), firsts_of(spec.coordinates)
    return any(one.unit for one in parameters) or any(one.unit for one in coordinates)
