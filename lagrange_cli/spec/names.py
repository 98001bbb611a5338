"""Whether an expression may use each name where it stands, and the bounds of its value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.expression.bounds import BoundsAlgebra
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.indices import counted
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import (
    ExpressionError,
    Name,
    Span,
    Sum,
    equalities,
    names,
    plain_names,
    sums,
)
from lagrange_cli.expression.vocabulary import (
    BODY_COMPONENTS,
    COMPONENTS,
    CONSTANTS,
    MOVING_COMPONENTS,
    MULTIPLIER,
    VELOCITY_COMPONENTS,
    velocity_name,
)
from lagrange_cli.records import replace
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.kinds import Kind, Meaning, Rule
from lagrange_cli.spec.meanings import Meanings, Unsound, has_some
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.whole import Part, WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.expression.many_bounds import BoundsBuilder

W = TypeVar("W", bound=Written)

MANY = 100
"""The number of terms of a sum from which on they are checked together."""


class Names(Meanings):
    """The names of one file, and what its expressions may use of them.

    ``rules`` say what the expressions of each section may depend on, ``sizes`` are those of the file.
    """

    def __init__(self, problems: Problems, sizes: Mapping[str, int], rules: Mapping[str, Rule]) -> None:
        super().__init__(problems)
        self.rules = rules
        self.sizes = sizes
        self._builder = SumBuilder(self, BoundsAlgebra(), sizes)
        self.siblings: Mapping[int, Sequence[Part[Any]]] = {}
        """The members of families that share an expression, by its tree."""
        self._of_siblings: dict[int, Any] = {}
        self.multiplied: dict[str, tuple[Expression, Name, str]] = {}
        """Where the multiplier of a constraint stands for the first time."""
        self._clashes: set[str] = set()
        self._found: dict[tuple[int, str], tuple[frozenset[Kind], bool]] = {}
        self.incomplete = False
        """Whether the file has no coordinates, so that unknown names are no further mistake."""

    def copy(self) -> Names:
        """A table with the same names, to which others may be added."""
        found = Names(self.problems, self.sizes, self.rules)
        found.table, found.bound, found.values = {**self.table}, {**self.bound}, self.values.copy()
        found.contacts = {**self.contacts}
        return found

    def check(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], Any]:
        """The kinds of names that ``expression`` depends on, and its bounds (None where it has a mistake).
        Every unknown or forbidden name is reported; the shapes are checked only if there is none. Of the
        members of a family, which have one tree, the first that is wrong is reported.
        """
        together = self.check_alike(expression, section, where)
        if together is not None and (section != "definitions" or unknown(together[1])):
            return together
        kinds, _ = self._found[id(expression.tree), section]
        try:
            return kinds, self._builder.build(expression.tree, expression.indices)
        except Unsound:
            self.problems.distrust(expression.tree)
            return kinds, None
        except ExpressionError as error:
            self._found[id(expression.tree), section] = kinds, False
            self.problems.add_expression(expression, error, where)
            return kinds, None

    def check_alike(
        self, expression: Expression, section: str, where: str
    ) -> tuple[frozenset[Kind], Any] | None:
        """``check`` for all members of a family that share the expression's tree; None where each of them has
        to be checked by itself."""
        kinds, sound = self.check_names(expression, section, where)
        if not sound:
            return kinds, None
        together = self.of_siblings(expression)
        return None if together is None else (kinds, together)

    def check_names(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], bool]:
        """The kinds of the names of an expression, each of which is reported where it is unknown or
        forbidden, and whether none is."""
        key = id(expression.tree), section
        if key not in self._found:
            self._found[key] = self._look_up_all(expression, section, where)
        kinds, sound = self._found[key]
        if not sound:
            self.problems.distrust(expression.tree)
        return kinds, sound

    def apart(self, group: W | WrittenFamily[W]) -> Iterator[W]:
        """What has to be checked of something written: itself, or of the members of a family those that are
        not like others which have been checked."""
        if not isinstance(group, WrittenFamily):
            yield group
            return
        for part in group.parts:
            members = group.of_part(part)
            yield next(members)
            trusted = filter(lambda one: self.problems.trusts(one.tree), part.item.expressions)
            if any(self.of_siblings(one) is None for one in trusted):
                yield from members

    @cached_property
    def many(self) -> BoundsBuilder:
        """The builder of bounds for all terms of a sum, or all members of a family, together: one for the
        file, which counts them."""
        from lagrange_cli.expression.many_bounds import BoundsBuilder
        from lagrange_cli.spec.members import bounds_of

        return BoundsBuilder(partial(bounds_of, self), self.sizes)

    def has_many(self, *parts: Part[Any]) -> bool:
        """Whether parts have so many members that they are checked together."""
        return sum(part.count for part in parts) >= MANY

    def of_siblings(self, expression: Expression) -> Any:
        """The bounds of all members that share the expression's tree, where these are many and none is wrong;
        else None."""
        key = id(expression.tree)
        if key not in self._of_siblings:
            self._of_siblings[key] = None
            parts = self.siblings.get(key, ())
            if self.has_many(*parts):
                from lagrange_cli.spec.members import indices_of_all

                count, indices = sum(part.count for part in parts), indices_of_all(parts)
                self._of_siblings[key] = self.many.of_members(expression.tree, indices, count)
        return self._of_siblings[key]

    def _look_up_all(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], bool]:
        """The kinds of the names of an expression; names that are not allowed there are reported."""
        kinds: frozenset[Kind] = frozenset()
        sound = self.problems.trusts(expression.tree)
        sound = sound and not plain_names(expression.tree) & self.problems.broken
        for loop, around in sums(expression.tree):
            try:
                self.check_index(loop.index, loop.index_span)
                if loop.index in around | expression.indices.keys():
                    message = f"the index '{loop.index}' is already used by an enclosing sum"
                    raise ExpressionError(loop.index_span, message, "give the index another name")
            except ExpressionError as error:
                self.problems.add_expression(expression, error, where)
                sound = False
            sound = sound and loop.index not in self._clashes
        sound = sound and not self._clashes & expression.indices.keys()
        differential = 0
        said: set[tuple[Span, str]] = set()  # a point of a body is made of several names in one place
        for name in names(expression.tree):
            if not name.indices and name.identifier in (*CONSTANTS, *expression.indices):
                continue
            if name.span.start < differential:  # the dt of dx/dt, which has been reported
                continue
            try:
                meaning = self._look_up(name, section, expression)
            except ExpressionError as error:
                from lagrange_cli.spec.unknown import end_of_differential

                differential = end_of_differential(name, expression.text, self.table)
                error.span = Span(error.span.start, max(error.span.stop, differential))
                if (error.span, error.message) not in said:
                    self.problems.add_expression(expression, error, where)
                said.add((error.span, error.message))
                sound = False
                continue
            if meaning.what is Kind.MULTIPLIER:
                self.multiplied.setdefault(name.base, (expression, name, where))
            kinds |= meaning.kinds
            sound = sound and (meaning.value is not None or meaning.family is not None)
        for comparison in equalities(expression.tree):
            used = [name for name in names(comparison) if name.base in self.table]
            varying = [name for name in used if self.table[name.base].kinds - {Kind.PARAMETER, Kind.SIZE}]
            if varying:
                message = (
                    f"'{varying[0].identifier}' changes with time and has an exact value only at isolated "
                    "instants"
                )
                hint = "write < <= > or >=, as in abs(x - a) < 1e-6"
                mistake = ExpressionError(comparison.span, message, hint)
                self.problems.add_expression(expression, mistake, where)
                sound = False
        return kinds, sound

    def check_index(self, index: str, span: Span) -> None:
        """Raise ExpressionError, the first time, where the index of a family or a sum has another's name."""
        other = self.table.get(index)
        if other is not None and index not in self._clashes:
            self._clashes.add(index)
            message = f"the index '{index}' has the name of a {other.what.value}"
            raise ExpressionError(span, message, "give the index another name")

    def _look_up(self, name: Name, section: str, expression: Expression) -> Meaning:
        base, _, component = name.identifier.partition(".")
        if component == MULTIPLIER:
            meaning = self._multiplier(name, base)
        elif base in self.problems.broken or base.removesuffix(velocity_name("")) in self.problems.broken:
            return Meaning(Kind.DEFINITION, frozenset(), None)
        elif base in self.table:
            meaning = self.table[base]
        elif self.incomplete:
            return Meaning(Kind.DEFINITION, frozenset(), None)
        elif base in self.bound:
            from lagrange_cli.spec.misused import constraint_itself

            raise constraint_itself(name, self.bound[base], base, component)
        else:
            from lagrange_cli.spec.unknown import Unknown

            allowed = self.rules[section].allowed
            broken = self.problems.broken  # one message is enough for a name that has not been declared
            unknown = Unknown(
                self.table, self.bound, allowed, expression.indices, broken, self.ranged, section
            )
            raise ExpressionError(name.span, *unknown.report(base))
        rule, kinds = self.rules[section], meaning.kinds
        if component in MOVING_COMPONENTS:
            kinds |= {Kind.VELOCITY}
        forbidden = [kind for kind in Kind if kind in kinds - rule.allowed]
        if forbidden:
            from lagrange_cli.spec.misused import not_allowed

            raise not_allowed(name, meaning, base, forbidden[0], rule)
        self.check_indices(name, meaning)
        if component and meaning.value is not None and component != MULTIPLIER:
            self.check_component(name, meaning, base, component)
        elif component and meaning.what is Kind.PARTICLE:  # its position is wrong: any three may be meant
            self.check_component(name, replace(meaning, value=(None,) * 3), base, component)
        return meaning if kinds is meaning.kinds else replace(meaning, kinds=kinds)

    def _multiplier(self, name: Name, base: str) -> Meaning:
        """What ``NAME.multiplier`` stands for. Raises ExpressionError where NAME is no constraint."""
        if base in self.bound:
            return self.bound[base]
        hint = near_hint(base, self.bound) or known_hint(f"{one}.{MULTIPLIER}" for one in self.bound)
        message = f"there is no constraint '{base}', whose multiplier this would be"
        raise ExpressionError(name.span, message, hint or "write one under 'constraints' or 'nonholonomic'")

    def check_indices(self, name: Name, meaning: Meaning) -> None:
        """Raise ExpressionError where a name has not as many indices as its family."""
        due = len(meaning.family.shape) if meaning.family else 0
        if len(name.indices) != due and (meaning.family is not None or meaning.value is not None):
            from lagrange_cli.spec.misused import wrong_indices

            raise wrong_indices(name, meaning)

    def check_component(self, name: Name, meaning: Meaning, base: str, component: str) -> None:
        """Raise ExpressionError where a name has no such component."""
        if isinstance(meaning.value, tuple):
            if component in COMPONENTS[: len(meaning.value)]:
                return
            if meaning.what is Kind.BODY and component in BODY_COMPONENTS:
                return
            if self.has_velocity(meaning, base) and component in VELOCITY_COMPONENTS[: len(meaning.value)]:
                if base not in self.contacts:
                    return
                from lagrange_cli.spec.misused import two_velocities

                raise two_velocities(name, base, component, self.contacts[base])
        from lagrange_cli.spec.misused import wrong_component

        raise wrong_component(name, meaning, base, component, moves=self.has_velocity(meaning, base))

    def has_velocity(self, meaning: Meaning, base: str) -> bool:
        """Whether something is a place r(q, t): a particle, a body, or a definition without velocities, which
        has been settled."""
        if meaning.what is not Kind.DEFINITION:
            return meaning.what in (Kind.PARTICLE, Kind.BODY)
        return base not in self.awaited and meaning.kinds.isdisjoint({Kind.VELOCITY, Kind.MULTIPLIER})


class SumBuilder(Builder):
    """Builds expressions over bounds, long sums without going through their terms where that is possible."""

    def __init__(self, names: Names, algebra: BoundsAlgebra, sizes: Mapping[str, int]) -> None:
        super().__init__(names.value, algebra, sizes)
        self._table = names

    def _sum(self, tree: Sum, indices: Mapping[str, int]) -> Any:
        if rounds(tree, indices) >= MANY:
            found = self._table.many.bounds(tree, indices)
            if found is not None:
                return found
        return super()._sum(tree, indices)


def rounds(tree: Sum, indices: Mapping[str, int]) -> int:
    """About how many terms a sum has, with those of sums that it is a sum of: as many as there are of its
    first index or of its last one, as pairs with i < j have none of the last."""
    values = counted(tree, indices)
    if not isinstance(tree.body, Sum) or not 0 < len(values) < MANY:
        return len(values)
    try:
        ends = ({**indices, tree.index: value} for value in (values[0], values[-1]))
        return len(values) * max(rounds(tree.body, one) for one in ends)
    except ExpressionError:  # which is reported by who goes through the terms
        return len(values)


def unknown(bounds: Any) -> bool:
    """Whether no number is known of what has these bounds, or nothing because of a mistake."""
    if bounds is None:
        return True
    parts = bounds if isinstance(bounds, tuple) else (bounds,)
    return all(one.value is None and not has_some(one) for one in parts)
