"""What each name of a system file stands for, and the bounds of its value."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.build import NoMember
from lagrange_cli.expression.vocabulary import (
    BODY_COMPONENTS,
    COMPONENTS,
    MULTIPLIER,
    RESERVED,
    VELOCITY_COMPONENTS,
    family_name,
    velocity_name,
)
from lagrange_cli.records import replace
from lagrange_cli.spec.family import Grid, MemberNames
from lagrange_cli.spec.family import Place as MemberPlace
from lagrange_cli.spec.kinds import Kind, Meaning, comes_to
from lagrange_cli.spec.order import Needs
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Family

if TYPE_CHECKING:
    from lagrange_cli.spec.whole import Part


class Unsound(Exception):
    """Raised where an expression uses a name with a mistake, which has been reported: nothing more is."""


class Settled:
    """Bounds by name, or by the name of a member; None where what is named has a mistake."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}
        self._members: dict[str, dict[str, Any]] = {}
        """Those of them that are members of families, by family."""
        self._names: dict[str, MemberNames] = {}
        self._parts: dict[str, list[tuple[Part[Any] | None, Any]]] = {}
        """By family: parts, or None for the whole of it, and the bounds of their members."""

    def copy(self) -> Settled:
        """One that may go on by itself."""
        found = Settled()
        found._own, found._names = {**self._own}, {**self._names}
        found._members = {name: {**members} for name, members in self._members.items()}
        found._parts = {name: [*parts] for name, parts in self._parts.items()}
        return found

    def settle(self, name: str, value: Any) -> None:
        """Set the bounds of one name."""
        self._own[name] = value
        base, bracket, _ = name.partition("[")
        if bracket:
            self._members.setdefault(base, {})[name] = value

    def settle_part(self, family: Family, part: Part[Any] | None, value: Any) -> None:
        """Set those of the members of a part of a family, or of all members."""
        assert isinstance(family.members, MemberNames)
        self._names[family.name] = family.members
        self._parts.setdefault(family.name, []).append((part, value))

    def forget(self, name: str) -> None:
        """Remove a name."""
        del self._own[name]

    def __contains__(self, name: str) -> bool:
        return name in self._own or self._of_part(name) is not None

    def __getitem__(self, name: str) -> Any:
        """Raises ``KeyError`` for what is not settled yet."""
        if name in self._own:
            return self._own[name]
        found = self._of_part(name)
        if found is None:
            raise KeyError(name)
        part, place, value = found
        places = Grid(part.ranges) if part else self._names[name.partition("[")[0]].places
        return bounds_at(value, places.number(place))

    def get(self, name: str) -> Any:
        """The same, or None."""
        try:
            return self[name]
        except KeyError:
            return None

    def _of_part(self, name: str) -> tuple[Part[Any] | None, MemberPlace, Any] | None:
        base = name.partition("[")[0]
        place = self._names[base].place(name) if base in self._names and base != name else None
        if place is None:
            return None
        parts = self._parts[base]
        return next(((part, place, x) for part, x in parts if part is None or part.has(place)), None)

    def of_family(self, family: Family) -> list[Any] | None:
        """The bounds that its members have; None where some are not settled yet."""
        parts = self._parts.get(family.name, [])
        found = [value for _, value in parts]
        if all(part is not None for part, _ in parts):
            own = self._members.get(family.name, {})
            found += own.values()
            if sum(part.count for part, _ in parts if part is not None) + len(own) != len(family.members):
                return None
        return found


def bounds_at(value: Any, number: int | None) -> Any:
    """The bounds of one member of those that have been found together, which has this number."""
    if isinstance(value, tuple):
        return tuple(bounds_at(one, number) for one in value)
    if hasattr(value, "kinds"):
        return bounds_at(value.kinds[value.labels[number]], number)
    numbers = getattr(value, "numbers", None)
    if numbers is None:
        return value
    number = numbers if numbers.ndim == 0 else numbers[number]
    return Bounds(float(number), value.size, value.depth, value.kind)


class Meanings:
    """The table of names of one file; ``values`` are the bounds by name, or by the name of a member."""

    def __init__(self, problems: Problems) -> None:
        self.problems = problems
        self.table: dict[str, Meaning] = {}
        self.bound: dict[str, Meaning] = {}
        """What ``NAME.multiplier`` stands for, by the constraint's name: these are names of their own."""
        self.values = Settled()
        self.ranged = False
        """Whether an unknown name may be given a range, as in the point of a curve."""
        self._alike: dict[str, Any] = {}
        self.awaited: set[str] = set()
        """Families of particles and bodies whose members may follow from one another."""
        self.contacts: dict[str, str] = {}
        """Definitions that stand for a point which moves in its body, as they are written: such a point has
        two velocities, that of the body there and its own."""

    def declare(
        self, name: str, what: Kind, place: Place | None, value: Any = None, family: Family | None = None
    ) -> bool:
        """Enter a name, and the members where it is that of a family; it must be free.

        ``value`` is that of every member, and None where it is yet to be settled.
        """
        if place is not None and name in RESERVED:
            self.problems.add(
                place, f"the name '{name}' is reserved", f"call the {what.value} {name}_ or another name"
            )
            return False
        other = self.table.get(name)
        if other is not None and place is not None:
            first = f" in line {other.place.line}" if other.place else ""
            message = f"the {what.value} '{name}' has the name of a {other.what.value}"
            hint = f"rename it, or the {other.what.value}{first}"
            if what is Kind.VELOCITY and other.what is Kind.COORDINATE and other.place:
                one = name.removesuffix(velocity_name(""))
                message, place = (
                    f"the coordinate '{name}' has the name of the velocity of '{one}'",
                    other.place,
                )
                hint = f"write '{one}: {{velocity: ...}}', or rename it"
            self.problems.add(place, message, hint)
            self.problems.broken.add(name)  # either may be meant
            return False
        self.table[name] = Meaning(what, comes_to(what), value, place, family)
        if value is not None and family is not None:
            self.values.settle_part(family, None, value)
        elif value is not None:
            self.values.settle(name, value)
        return True

    @contextmanager
    def besides(self, free: Iterable[str], *, more: bool) -> Iterator[None]:
        """Let expressions contain further names for a while, which are free: the parameters of a curve, which
        may have ``more`` of them."""
        own = {name: Meaning(Kind.PARAMETER, frozenset({Kind.PARAMETER}), scalar()) for name in free}
        self.table |= own
        for name in own:
            self.values.settle(name, scalar())
        self.ranged = more
        try:
            yield
        finally:
            self.ranged = False
            for name in own:
                del self.table[name]
                self.values.forget(name)

    def declare_coordinates(self, coordinates: Sequence[tuple[str, Place, Family | None]]) -> None:
        """Enter coordinates and their velocities."""
        for name, place, family in coordinates:
            self.declare(name, Kind.COORDINATE, place, scalar(), family)
        for name, place, family in coordinates:
            family = None if family is None else family.renamed(velocity_name(name))
            self.declare(velocity_name(name), Kind.VELOCITY, place, scalar(), family)

    def declare_multiplier(self, constraint: str, place: Place | None, family: Family | None) -> None:
        """Enter the multiplier of a constraint, or of each member of a family."""
        kinds = frozenset({Kind.MULTIPLIER})
        self.bound[constraint] = Meaning(Kind.MULTIPLIER, kinds, scalar(), place, family)

    def settle(self, name: str, kinds: frozenset[Kind], value: Any) -> None:
        """Set the kinds and bounds of a declared definition or particle, or of a member of a family of
        them."""
        self.values.settle(name, value)
        self._meaning(family_name(name), kinds, value)

    def settle_part(self, family: Family, part: Part[Any] | None, kinds: frozenset[Kind], value: Any) -> None:
        """The same for all members of a part of a family at once."""
        self.values.settle_part(family, part, value)
        self._meaning(family.name, kinds, value)

    def _meaning(self, base: str, kinds: frozenset[Kind], value: Any) -> None:
        known = self.table[base]
        if known.value is not value or known.kinds != kinds:
            self.table[base] = replace(known, kinds=kinds, value=value)

    def value(self, identifier: str) -> Any:
        """The bounds of a (dotted) name that has been looked up.

        Raises:
            Needs: a member of a family that is not settled yet.
            NoMember: one that does not exist.
            Unsound: what is wrong itself.
        """
        name, _, component = identifier.partition(".")
        if component == MULTIPLIER:
            family = self.bound[family_name(name)].family
            if family is not None and name not in family.members:
                raise NoMember(family.hint(name))
            return scalar()
        if name not in self.values:
            meaning = self.table[family_name(name)]
            if meaning.family is None or name in meaning.family.members:
                awaited = (
                    meaning.what in (Kind.PARAMETER, Kind.DEFINITION) or family_name(name) in self.awaited
                )
                raise Needs(name) if awaited else Unsound
            raise NoMember(meaning.family.hint(name))
        value = self.values[name]
        if value is None:
            raise Unsound
        if not component:
            return value
        if component in BODY_COMPONENTS:
            return scalar()
        known, parts = COMPONENTS + VELOCITY_COMPONENTS, value if isinstance(value, tuple) else ()
        if component not in known or known.index(component) % 3 >= len(parts):
            raise Unsound  # not checked, as another member of the family is wrong
        return parts[known.index(component) % 3]

    def alike(self, name: str) -> Any:
        """The largest bounds of the members of a family, none of which is a number; None where one is, or is
        not settled yet."""
        if name not in self._alike:
            family = self.table[name].family
            found = None if family is None else self.values.of_family(family)
            if found is None or any(one is None for one in found):
                return None
            self._alike[name] = largest(found)
        return self._alike[name]


def largest(bounds: Sequence[Any]) -> Any:
    """The largest of the bounds of several members; None where one is a number, or they differ in kind."""
    first = bounds[0]
    if isinstance(first, tuple):
        if any(not isinstance(one, tuple) or len(one) != len(first) for one in bounds):
            return None
        parts = [largest(component) for component in zip(*bounds)]
        return None if any(one is None for one in parts) else tuple(parts)
    if any(isinstance(one, tuple) or one.value is not None or has_some(one) for one in bounds):
        return None
    deepest = max(bounds, key=lambda one: one.depth)
    return Bounds(None, max(one.size for one in bounds), deepest.depth, deepest.kind)


def has_some(bounds: Bounds) -> bool:
    """Whether numbers of members are known that differ from member to member."""
    return hasattr(bounds, "numbers") or hasattr(bounds, "kinds")


def scalar() -> Bounds:
    """The bounds of a parameter, a coordinate, a velocity or the time."""
    return Bounds()
