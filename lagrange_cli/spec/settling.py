"""The kinds and bounds of parameters and definitions, each after those that it uses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.expression.near import shown
from lagrange_cli.expression.syntax import Vector, names, plain_names
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.draft import Declared, Written
from lagrange_cli.spec.family import Family, MemberNames, Place
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.order import Needs, chain, dependency_order, on_demand
from lagrange_cli.spec.spec import Expression, distinct
from lagrange_cli.spec.whole import Part, WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.recurrence import Recurrence

BREAK = "break the cycle: give one of them a value that does not use the others"
AS_VECTOR = (
    "make them components of one family of vectors, as in r[i in range(1, N)]: (r[i - 1].x, r[i - 1].y)"
)
"""Families are computed one after the other, even if no member depends on itself."""
AS_PLACE = (
    "a position may not use what depends on it: write it in coordinates, or in definitions that contain no "
    "particles"
)

W = TypeVar("W", bound=Written)


def check_scalar(names: Names, expression: Expression, section: str, where: str) -> frozenset[Kind]:
    """Check an expression that must be a scalar. Returns the kinds of its names."""
    kinds, bounds = names.check(expression, section, where)
    if isinstance(bounds, tuple):
        names.problems.add_once(
            expression.place,
            f"expected a scalar in {where}, found a vector",
            vector_hint(names, expression, section),
        )
        names.problems.distrust(expression.tree)
    return kinds


def vector_items(expression: Expression) -> list[str]:
    """The components of a vector as they are written, if it is a plain one; else an example."""
    tree = expression.tree
    items = tree.items if isinstance(tree, Vector) else ()
    return [expression.text[one.span.start : one.span.stop] for one in items] or ["1", "2"]


def vector_hint(known: Names, expression: Expression, section: str = "") -> str:
    """How a scalar is made of the vectors of an expression."""
    tree = expression.tree
    if isinstance(tree, Vector) and len(tree.items) == 1:
        return "leave out the comma at the end"
    if section == "parameters":
        items = ", ".join(vector_items(expression))
        return f"write a list, [{items}]; or write vectors under 'definitions'"
    vectors = [one for one in plain_names(tree) if isinstance(known.values.get(one), tuple)]
    for one in sorted(vectors):
        components = any(name.identifier.startswith(f"{one}.") for name in names(tree))
        if components and known.table[one].what is Kind.PARTICLE:  # m1*g*m1.y: the first m1 should be a mass
            return f"{shown(one)} is a position: write its mass as a parameter M, with 'masses: {{{one}: M}}'"
    hint = f"take a component, as in {min(vectors, default='bead')}.x, or norm() or dot()"
    return f"{shown(vectors[0])} is a vector: {hint}" if len(vectors) == 1 else hint


@dataclass
class Settling:
    """The table of names."""

    names: Names

    def in_order(
        self, entries: Sequence[W], what: Kind, places: Mapping[str, set[str]] | None = None
    ) -> dict[str, W | WrittenFamily[W]]:
        """Parameters or definitions, each after those that it uses, families as a whole; cycles are reported.
        ``places`` are the names that positions of particles are made of: definitions may use particles.
        """
        groups = {one.name: one for one in groups_of(entries)}
        uses = {name: self.uses(one) for name, one in groups.items()}
        for name, one in groups.items():
            if isinstance(one, WrittenFamily):
                uses[name].discard(name)
        order, cycles = dependency_order({**(places or {}), **uses})
        for stuck in groups.keys() - set(order):
            group = groups[stuck]
            if isinstance(group, WrittenFamily):
                self.settle_part(group.family, None, what, frozenset(), None)
            else:
                self.settle(stuck, what, frozenset(), None)
        for cycle in cycles:
            self._note(cycle, groups, what)
        return {name: groups[name] for name in order if name in groups}

    def settle_all(
        self, groups: Mapping[str, W | WrittenFamily[W]], what: Kind, section: str
    ) -> list[W | WrittenFamily[W]]:
        """Check and settle parameters or definitions that are ``in_order``; the members of each family are
        put in order then."""
        found: list[W | WrittenFamily[W]] = []
        cycles: list[list[str]] = []
        for group in groups.values():
            if isinstance(group, WrittenFamily):
                settled, circles = self._family(group, what, section)
            else:
                settled, circles = group, []
                self._settle_one(group, what, section)
            if settled is not None:
                found.append(settled)
            cycles += circles
        for cycle in cycles:
            self._note(cycle, groups, what)
        return found

    def _note(self, cycle: list[str], groups: Mapping[str, W | WrittenFamily[W]], what: Kind) -> None:
        """Note a cycle, which may lead through positions of particles."""
        bases = [*map(family_name, cycle)]
        start = next(k for k, base in enumerate(bases) if base in groups)
        if start:
            cycle = [*cycle[start:], *cycle[1 : start + 1]]
        first = groups[family_name(cycle[0])]
        if isinstance(first, WrittenFamily):
            first = first.named(cycle[0]) or first[0]
        hint = BREAK
        if not groups.keys() >= {*bases}:
            hint = AS_PLACE
        elif len({*bases}) > 1 and what is Kind.DEFINITION:
            hint = AS_VECTOR if all(isinstance(groups[one], WrittenFamily) for one in bases) else BREAK
        message = f"{what.value} '{cycle[0]}' depends on itself: {chain(cycle)}"
        self.names.problems.add_once(first.place, message, hint)

    def _family(
        self, group: WrittenFamily[W], what: Kind, section: str
    ) -> tuple[W | WrittenFamily[W] | None, list[list[str]]]:
        """Settle the members of a family, those that are alike at once. The family, in the order in which its
        members can be computed, and the cycles among them; None where there are some."""
        if group.name in self.names.table:
            kinds = self.names.table[group.name].kinds - {what}  # its own members are no further kind
            self.names.table[group.name] = replace(self.names.table[group.name], kinds=kinds)
        if group.name not in self.uses(group):
            for one in self._apart(group, what, section):
                self._settle_one(one, what, section)
            return group, []
        order = self._recurrent(group, what, section)
        if len(order) == len(group):
            return group.ordered(tuple(order)), []
        assert isinstance(group.family.members, MemberNames)
        known = set(order)
        rest = [place for place in group.family.members.places if place not in known]
        members = {one.name: one for one in map(group.at, rest)}

        def compute(name: str) -> None:
            self._settle_one(members[name], what, section)

        settled, cycles = on_demand(members, compute)
        for name in members.keys() - set(settled):
            self.settle(name, what, frozenset(), None)
        if len(settled) < len(members):
            return None, cycles
        found = map(group.family.place, settled)
        return group.ordered((*order, *(place for place in found if place is not None))), cycles

    def _recurrent(self, group: WrittenFamily[W], what: Kind, section: str) -> list[Place]:
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
                    self._settle_one(group.at(place), what, section)
                    order.append(place)
                elif self.names.has_many(part) and (found := self._sequence(group, part, what, section)):
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

    def _sequence(
        self, group: WrittenFamily[W], part: Part[W], what: Kind, section: str
    ) -> Recurrence | None:
        """Settle the members of a part that follow from one another; None where they have to be settled one
        by one."""
        from lagrange_cli.spec.recurrence import Recurrence

        value = expression_of(part.item)
        if value is None:
            return None
        value = value.member("", part.values(next(part.places)))
        kinds, sound = self.names.check_names(value, section, label(part.item, what))
        recurrence = Recurrence(self.names, self.names.sizes, group, part)
        bounds = recurrence.settled(value.tree) if sound else None
        if bounds is None or (isinstance(bounds, tuple) and what is Kind.PARAMETER):
            return None
        if what is Kind.PARAMETER:
            kinds, bounds = frozenset({what}), scalar()
        self.settle_part(group.family, part, what, kinds, bounds)
        return recurrence

    def _apart(self, group: WrittenFamily[W], what: Kind, section: str) -> Iterator[W]:
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
                found = self.names.check_alike(value, section, label(item, what))
            if found is None or (isinstance(found[1], tuple) and what is Kind.PARAMETER):
                for part in parts:
                    yield from group.of_part(part)
                continue
            own, bounds = (frozenset({what}), scalar()) if what is Kind.PARAMETER else found
            kinds |= own
            settled.append((parts, bounds))
        if settled:
            from lagrange_cli.spec.members import shares

            for share, value in shares(group.family, settled):
                self.settle_part(group.family, share, what, kinds, value)

    def _settle_one(self, entry: Written, what: Kind, section: str) -> None:
        value = expression_of(entry)
        if value is None:
            self.settle(entry.name, what, frozenset(), None)
        elif what is Kind.PARAMETER:
            check_scalar(self.names, value, section, label(entry, what))
            self.settle(entry.name, what, frozenset({what}), scalar())
        else:
            self.settle(entry.name, what, *self.names.check(value, section, label(entry, what)))

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

    def uses(self, group: W | WrittenFamily[W]) -> set[str]:
        """The names that something uses, or the members of a family."""
        return bases_in(
            *([part.item for part in group.parts] if isinstance(group, WrittenFamily) else [group])
        )


def bases_in(*written: Written) -> set[str]:
    """The names that something uses."""
    given = [value for one in written if (value := expression_of(one)) is not None]
    return {name.base for one in distinct(given) for name in names(one.tree)}


def expression_of(written: Written) -> Expression | None:
    """The value of a parameter or a definition; None where it could not be read."""
    found: Expression | None
    found = written.fields.get("value") if isinstance(written, Declared) else getattr(written, "value", None)
    return found


def label(written: Written, what: Kind) -> str:
    """What messages call it."""
    return f"{what.value} '{written.key.label}'"
