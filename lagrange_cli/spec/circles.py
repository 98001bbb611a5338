"""What members of families follow from, one by one: which of them follow from themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, TypeAlias

from lagrange_cli.expression.indices import Indices, counted, holds, integer, known_indices
from lagrange_cli.expression.syntax import Call, ExpressionError, Lookup, Name, Sum, Tree, children
from lagrange_cli.expression.vocabulary import family_name, member_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import statements
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.kinds import Kind, called
from lagrange_cli.spec.order import AXES, Needs, expression_of, on_demand, value_of
from lagrange_cli.spec.order import chain as shown
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.whole import WrittenFamily

Group: TypeAlias = "Written | WrittenFamily[Any]"
Groups: TypeAlias = "Mapping[str, Group]"

BREAK = "break the cycle: give one of them a value that does not use the others"
AS_PLACE = "a position may not use what depends on it: write one of them in coordinates"
IN_COORDINATES = "write it in coordinates, t, parameters and positions that do not depend on it"

MOST = 1_000_000
"""The most names that are looked at one by one."""


class Unsuited(Exception):
    """What is asked cannot be found out, or not in a short time."""


class Missing(Exception):
    """An item uses a member that does not exist: the item, and what is wrong in it."""

    def __init__(self, item: Written, error: ExpressionError) -> None:
        super().__init__(str(error))
        self.item, self.error = item, error


class Uses:
    """Looks at names of expressions, a limited number of them: which of the ``groups`` are used."""

    def __init__(self, groups: Groups, sizes: Indices) -> None:
        self.groups, self.sizes, self._left = groups, sizes, MOST

    def of(self, item: Written, indices: Indices) -> Iterator[tuple[Name, tuple[int, ...]]]:
        """The names of groups that an item uses for these values of its indices, with their own; of ``where``
        the branch that these choose.

        Raises:
            ExpressionError: where an index is no whole number.
            Missing: where a family has no such member.
            Unsuited: where that takes too long.
        """
        pending: list[tuple[Tree, Indices]] = [(written_in(item).tree, {**self.sizes, **indices})]
        while pending:
            node, known = pending.pop()
            self._left -= 1
            if self._left < 0:
                raise Unsuited
            if isinstance(node, Name):
                if node.base in self.groups:
                    yield node, self._place(node, item, known)
            elif isinstance(node, Sum):
                for value in counted(node, known)[: self._left]:
                    inner = {**known, node.index: value}
                    if all(holds(one, inner) for one in node.conditions):
                        pending.append((node.body, inner))
            elif not isinstance(node, Lookup):
                pending += [(one, known) for one in branches(node, known)]

    def _place(self, name: Name, item: Written, indices: Indices) -> tuple[int, ...]:
        """The indices of a name, which has a member there."""
        place, group = tuple(integer(one, indices) for one in name.indices), self.groups[name.base]
        member = member_name(name.base, place)
        due = len(group.family.shape) if isinstance(group, WrittenFamily) else 0
        if isinstance(group, WrittenFamily) and len(place) == due and group.named(member) is None:
            message = f"no member '{member}'{known_indices(name, indices)}"
            raise Missing(item, ExpressionError(name.span, message, group.family.hint(member)))
        return place


def branches(tree: Tree, indices: Indices) -> tuple[Tree, ...]:
    """What is used of a tree: of ``where`` one branch, if indices alone decide."""
    if not isinstance(tree, Call) or tree.function != "where":
        return children(tree)
    condition, above, below = tree.arguments
    try:
        return (above if holds(condition, indices) else below,)
    except ExpressionError:
        return tree.arguments


def are_sound(groups: Iterable[Group], problems: Problems) -> bool:
    """Whether nothing wrong has been found in what is written of some groups."""
    items = chain.from_iterable(map(statements, groups))
    return all(problems.trusts(one.tree) for item in items for one in item.expressions)


def written_in(item: Written) -> Expression:
    """What an item is. Raises ``Unsuited`` where it could not be read, or is given by a list."""
    value = expression_of(item)
    if not isinstance(value, Expression):
        raise Unsuited
    return value


@dataclass(frozen=True)
class Circles:
    """Groups of ``kinds``, by name. Those ``in_turn`` follow from one another."""

    groups: Groups
    kinds: Mapping[str, Kind]
    in_turn: Sequence[str]
    sizes: Indices

    def note(self, cycle: list[str], problems: Problems) -> None:
        """Note a cycle of names; of families that of their members, if there is one."""
        cycle = [one.removesuffix(AXES) for one in cycle]
        bases = {*map(family_name, cycle)}
        families, found = len(bases) > 1 and all(map(self._is_family, bases)), list[str]()
        turns = bases <= {*self.in_turn}  # these were sound when they were rewritten
        if families and not turns and not are_sound(map(self.groups.__getitem__, bases), problems):
            return  # they may only take turns, once their mistakes are corrected
        if turns or families:
            try:
                found = self.among_members(self.in_turn if turns else [*bases])
            except Missing as missing:
                where = called(missing.item, self.kinds[family_name(missing.item.name)])
                problems.add_expression(value_of(missing.item), missing.error, where)
                return
        cycle = found or self._from_first(cycle)
        bases = {*map(family_name, cycle)}
        hint = BREAK if {self.kinds[one] for one in bases} <= {Kind.PARAMETER, Kind.DEFINITION} else AS_PLACE
        if hint is AS_PLACE and len(bases) == 1:
            hint = IN_COORDINATES
        base = family_name(cycle[0])
        first: Any = self.groups[base]
        if self._is_family(base):
            first = first.named(cycle[0]) or first[0]
        message = f"{called(first, self.kinds[base])} depends on itself: {shown(cycle)}"
        if families and not found:
            message, hint = (
                f"families cannot be computed one after the other: {shown(cycle)}",
                self._in_one(cycle[:-1]),
            )
        problems.add_once(first.place, message, hint)

    def _from_first(self, cycle: list[str]) -> list[str]:
        """The cycle, from the name on that is first in the file."""
        order = {name: number for number, name in enumerate(self.groups)}
        ring = cycle[:-1]
        begin = min(range(len(ring)), key=lambda at: order[family_name(ring[at])], default=0)
        return [*ring[begin:], *ring[: begin + 1]]

    def _in_one(self, names: Sequence[str]) -> str:
        """How families may be one in which they take turns, so that all of it follows from earlier members.
        (They are computed one after the other, even if no member depends on itself, unless one may stand in
        the others: ``turns``.)"""
        said = []
        for number, name in enumerate(names):
            group = self.groups[name]
            first, *others = [*"ijkl"][: len(group.family.shape) if isinstance(group, WrittenFamily) else 1]
            place = f"{len(names)}*{first} + {number}" if number else f"{len(names)}*{first}"
            said.append(f"r[{', '.join([place, *others])}] for {name}[{', '.join([first, *others])}]")
        return f"write them as one family, whose members take turns: {' and '.join(said)}"

    def _is_family(self, name: str) -> bool:
        return isinstance(self.groups[name], WrittenFamily)

    def among_members(self, among: Sequence[str]) -> list[str]:
        """A member of some families that follows from itself, the members on the way, and itself again;
        nothing where there is none, or where it takes too long to find one.

        Raises:
            Missing: where one follows from a member that does not exist.
        """
        done, uses = set[str](), Uses({one: self.groups[one] for one in among}, self.sizes)

        def compute(name: str) -> None:
            group = self.groups[family_name(name)]
            item: Any = group.named(name) if isinstance(group, WrittenFamily) else group
            for one, place in uses.of(item, written_in(item).indices):
                other = member_name(one.base, place) if place else one.base
                if other not in done:
                    raise Needs(other)
            done.add(name)

        try:
            for base in among:
                group = self.groups[base]
                circles = on_demand(group.names if isinstance(group, WrittenFamily) else [base], compute)[1]
                if circles:
                    return circles[0]
        except (Unsuited, ExpressionError):
            pass
        return []
