"""The kinds and bounds of parameters, definitions and positions, each after those that it uses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.syntax import Name, Vector, names
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import groups_of, statements
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.family import Family, MemberNames, Place
from lagrange_cli.spec.kinds import CONSTANT, Kind, called, comes_to
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.order import AXES, Needs, bases_in, dependency_order, expression_of, on_demand, uses_of
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.whole import Part, WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.recurrence import Recurrence

SECTIONS_OF = {
    Kind.PARAMETER: "parameters",
    Kind.DEFINITION: "definitions",
    Kind.PARTICLE: "embedding",
    Kind.BODY: "bodies",
}

W = TypeVar("W", bound=Written)


def check_scalar(names: Names, expression: Expression, section: str, where: str) -> frozenset[Kind]:
    """Check an expression that must be a scalar. Returns the kinds of its names."""
    kinds, bounds = names.check(expression, section, where)
    if isinstance(bounds, tuple):
        from lagrange_cli.spec.misused import vector_hint

        names.problems.add_once(
            expression.place,
            f"expected a scalar in {where}, found a vector",
            vector_hint(names, expression, section),
        )
        names.problems.distrust(expression.tree)
    return kinds


@dataclass
class Settling:
    """The table of names, and what families are ``as_written`` that follow from one another in turn."""

    names: Names
    as_written: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._counts: dict[str, int] = {}
        """How many components positions have, by name."""

    def settle_all(self, given: Mapping[Kind, Sequence[Any]]) -> list[Any]:
        """Check and settle what is ``given``, parameters by themselves or definitions and positions together,
        each after those that it uses, families as a whole. They are returned in this order, the members of
        each family in the order in which they can be computed; cycles are reported, and left out."""
        kinds, groups = dict[str, Kind](), dict[str, Any]()
        for what, entries in given.items():
            for one in groups_of(entries):
                kinds[one.name], groups[one.name] = what, one
        order, cycles = dependency_order(uses_of(groups))
        for stuck in groups.keys() - set(order):
            group, what = groups[stuck], kinds[stuck]
            if isinstance(group, WrittenFamily):
                self.settle_part(group.family, None, what, comes_to(what), None)
            else:
                self.settle(stuck, what, comes_to(what), None)
        found: list[Any] = []
        for name in order:
            if name not in groups:
                continue
            group, what = groups[name], kinds[name]
            if isinstance(group, WrittenFamily):
                settled, circles = self._family(group, what)
                cycles += circles
            else:
                settled = group
                self._settle_one(group, what)
            found += [] if settled is None else [settled]
        if cycles:
            from lagrange_cli.spec.circles import Circles

            known = Circles({**groups, **self.as_written}, kinds, [*self.as_written], self.names.sizes)
            for cycle in cycles:
                known.note(cycle, self.names.problems)
                self.names.problems.broken.update(family_name(one.removesuffix(AXES)) for one in cycle)
        return found

    def _family(
        self, group: WrittenFamily[W], what: Kind
    ) -> tuple[W | WrittenFamily[W] | None, list[list[str]]]:
        """Settle the members of a family, those that are alike at once. The family, in the order in which its
        members can be computed, and the cycles among them; None where there are some."""
        if group.name in self.names.table:
            kinds = self.names.table[group.name].kinds - {what}  # its own members are no further kind
            self.names.table[group.name] = replace(self.names.table[group.name], kinds=kinds)
        if group.name not in bases_in(*statements(group)):
            for one in self._apart(group, what):
                self._settle_one(one, what)
            return group, []
        self.names.awaited.add(group.name)
        try:
            return self._in_turn(group, what)
        finally:
            self.names.awaited.discard(group.name)

    def _in_turn(
        self, group: WrittenFamily[W], what: Kind
    ) -> tuple[WrittenFamily[W] | None, list[list[str]]]:
        """The same of a family whose members follow from one another."""
        order = self._recurrent(group, what)
        if len(order) == len(group):
            return group.ordered(tuple(order)), []
        assert isinstance(group.family.members, MemberNames)
        known = set(order)
        rest = [place for place in group.family.members.places if place not in known]
        members = {one.name: one for one in map(group.at, rest)}

        def compute(name: str) -> None:
            self._settle_one(members[name], what)

        settled, cycles = on_demand(members, compute)
        for name in members.keys() - set(settled):
            self.settle(name, what, frozenset(), None)
        if len(settled) < len(members):
            return None, cycles
        found = map(group.family.place, settled)
        return group.ordered((*order, *(place for place in found if place is not None))), cycles

    def _recurrent(self, group: WrittenFamily[W], what: Kind) -> list[Place]:
        """Settle members of a family that follow from one another, those that are alike at once. The places
        of those that have been settled, in the order in which they can be computed."""
        order: list[Place] = []
        if not any(map(self.names.has_many, group.parts)):
            return order
        heads = {group.at(place := next(part.places)).name: (part, place) for part in group.parts}
        head_of = {id(part): name for name, (part, _) in heads.items()}
        natural = True

        def compute(name: str) -> None:
            nonlocal natural
            part, place = heads[name]
            try:
                if part.count == 1:
                    natural = natural and group.name not in bases_in(part.item)
                    self._settle_one(group.at(place), what)
                    order.append(place)
                elif self.names.has_many(part) and (found := self._sequence(group, part, what)):
                    natural = natural and found.natural
                    order.extend(found.places)
            except Needs as needed:
                other = group.family.place(needed.name)
                raise needed if other is None else Needs(head_of[id(group.part_at(other))]) from needed

        on_demand(heads, compute)
        if natural and len(order) == len(group):
            assert isinstance(group.family.members, MemberNames)
            return [*group.family.members.places]
        return order

    def _sequence(self, group: WrittenFamily[W], part: Part[W], what: Kind) -> Recurrence | None:
        """Settle the members of a part that follow from one another; None where they have to be settled one
        by one."""
        from lagrange_cli.spec.recurrence import Recurrence

        value = expression_of(part.item)
        if value is None:
            return None
        value = value.member("", part.values(next(part.places)))
        kinds, sound = self.names.check_names(value, SECTIONS_OF[what], called(part.item, what))
        recurrence = Recurrence(self.names, self.names.sizes, group, part)
        bounds = recurrence.settled(value.tree) if sound else None
        if bounds is None or not fits(bounds, what):
            return None
        self.settle_part(group.family, part, what, *self._come_to(part.item, what, kinds, bounds))
        return recurrence

    def _apart(self, group: WrittenFamily[W], what: Kind) -> Iterator[W]:
        """Settle the members of a family that are alike, and yield the others."""
        alike: dict[int, list[Part[W]]] = {}
        for part in group.parts:
            alike.setdefault(id(part.item), []).append(part)
        settled = list[tuple[Sequence[Part[W]], Any]]()
        kinds = frozenset[Kind]()
        for parts in alike.values():
            item = parts[0].item
            value, found = expression_of(item), None
            if value is not None and self.names.has_many(*parts):
                value = value.member("", parts[0].values(next(parts[0].places)))
                found = self.names.check_alike(value, SECTIONS_OF[what], called(item, what))
            if found is None or not fits(found[1], what):
                for part in parts:
                    yield from group.of_part(part)
                continue
            own, bounds = self._come_to(item, what, *found)
            kinds |= own
            settled.append((parts, bounds))
        if settled:
            from lagrange_cli.spec.members import shares

            for share, value in shares(group.family, settled):
                self.settle_part(group.family, share, what, kinds, value)

    def _settle_one(self, entry: Written, what: Kind) -> None:
        value, where = expression_of(entry), called(entry, what)
        found: tuple[frozenset[Kind], Any]
        if value is None:
            found = frozenset[Kind](), None
        elif what is Kind.PARAMETER:
            found = check_scalar(self.names, value, SECTIONS_OF[what], where), scalar()
        else:
            found = self.names.check(value, SECTIONS_OF[what], where)
        self.settle(entry.name, what, *self._come_to(entry, what, *found))

    def _come_to(
        self, entry: Written, what: Kind, kinds: frozenset[Kind], bounds: Any
    ) -> tuple[frozenset[Kind], Any]:
        """What a name comes down to, and its bounds: positions have as many components as they should."""
        if what is Kind.DEFINITION:
            self._note_contact(entry)
            return kinds, bounds
        if what is Kind.PARAMETER:
            return comes_to(what), None if bounds is None else scalar()
        vector = (bounds,) if bounds is not None and not isinstance(bounds, tuple) else bounds
        count = len(vector) if vector is not None else 0
        if what is Kind.BODY:
            if count and count != 3:
                value = expression_of(entry)
                assert value is not None
                message = f"the {called(entry, what)} has {counted(count)}, not 3"
                self.names.problems.add_once(value.place, message, "write [x, y, z]")
            return comes_to(what), vector if count == 3 else (Bounds(), Bounds(), Bounds())
        due = self._counts.setdefault(family_name(entry.name), count) if count else 0
        if count != due:
            own = entry.name if "[" in entry.name else entry.key.label
            self.names.problems.add_once(
                entry.place,
                f"'{own}' has {counted(count)}, other members {due}",
                "give all members of a family the same number of components",
            )
        return comes_to(what), vector

    def _note_contact(self, entry: Written) -> None:
        """Note a definition that stands for a point which moves in its body, such as a point of contact."""
        value = expression_of(entry)
        tree = None if value is None else value.tree
        if isinstance(tree, Name) and "." not in tree.identifier and tree.base in self.names.contacts:
            self.names.contacts[family_name(entry.name)] = self.names.contacts[tree.base]
        elif value is not None and isinstance(tree, Vector):
            used = (self.names.table.get(one.base) for place in tree.places for one in names(place))
            if any(one is not None and one.kinds - CONSTANT - {Kind.SIZE} for one in used):
                self.names.contacts[family_name(entry.name)] = value.excerpt(tree.span)

    def settle(self, name: str, what: Kind, kinds: frozenset[Kind], value: Any) -> None:
        """Set the kinds and bounds of one; the kinds of a family are those of all its members."""
        base = family_name(name)
        if self.stands_for(base, what):
            self.names.settle(name, kinds | self._known(base), value)

    def settle_part(
        self, family: Family, part: Part[Any] | None, what: Kind, kinds: frozenset[Kind], value: Any
    ) -> None:
        """The same for a part of a family, or all of it."""
        if self.stands_for(family.name, what):
            self.names.settle_part(family, part, kinds | self._known(family.name), value)

    def stands_for(self, base: str, what: Kind) -> bool:
        """Whether a name stands for this, and not for another thing of the same name."""
        meaning = self.names.table.get(base)
        return meaning is not None and meaning.what is what

    def _known(self, base: str) -> frozenset[Kind]:
        """The kinds of the members of a family that have been settled."""
        meaning = self.names.table[base]
        return meaning.kinds if meaning.family is not None and meaning.value is not None else frozenset()


def fits(bounds: Any, what: Kind) -> bool:
    """Whether all members of a family may have such bounds."""
    if what is Kind.PARAMETER:
        return not isinstance(bounds, tuple)
    return what is not Kind.BODY or (isinstance(bounds, tuple) and len(bounds) == 3)


def counted(count: int) -> str:
    """So many components, in words."""
    return f"{count} component{'s' if count > 1 else ''}"
