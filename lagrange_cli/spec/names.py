"""What each name of a system file means, and whether an expression may use it where it stands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.bounds import Bounds, BoundsAlgebra
from lagrange_cli.expression.build import Builder, NoMember
from lagrange_cli.expression.confusions import COMPONENTS as CONFUSED_COMPONENTS
from lagrange_cli.expression.confusions import VELOCITIES
from lagrange_cli.expression.indices import counted
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import (
    ExpressionError,
    Name,
    Number,
    Span,
    Sum,
    equalities,
    names,
    plain_names,
    sums,
)
from lagrange_cli.expression.vocabulary import (
    AXES_COMPONENTS,
    AXES_RATES,
    BODY_COMPONENTS,
    BODY_SPIN,
    COMPONENTS,
    CONSTANTS,
    MULTIPLIER,
    POINT,
    RESERVED,
    SPACE_SPIN,
    VELOCITY_COMPONENTS,
    family_name,
    member_name,
    velocity_name,
)
from lagrange_cli.records import replace
from lagrange_cli.spec.kinds import Kind, Meaning, Rule, comes_to
from lagrange_cli.spec.order import Needs
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Expression, Family
from lagrange_cli.spec.unknown import Unknown, end_of_differential, range_hint

if TYPE_CHECKING:
    from lagrange_cli.expression.many_bounds import BoundsBuilder

MANY = 100
"""Terms of a sum from which on they are looked at together."""


class Unsound(Exception):
    """Raised where an expression uses something that is wrong: nothing more is said of it."""


class Names:
    """The table of names of one file; ``values`` are the bounds by name, or by the name of a member.

    ``rules`` say what the expressions of each section may depend on, ``sizes`` are those of the file.
    """

    def __init__(self, problems: Problems, sizes: Mapping[str, int], rules: Mapping[str, Rule]) -> None:
        self.problems = problems
        self.rules = rules
        self.sizes = sizes
        self.table: dict[str, Meaning] = {}
        self.bound: dict[str, Meaning] = {}
        """What ``NAME.multiplier`` stands for, by the constraint's name: these are names of their own."""
        self.values: dict[str, Any] = {}
        self._members: set[str] = set()
        self._builder = SumBuilder(self, BoundsAlgebra(), sizes)
        self._alike: dict[str, Any] = {}
        self.siblings: Mapping[int, Sequence[Expression]] = {}
        """The expressions of all members of a family, by the tree that they share."""
        self._of_siblings: dict[int, Any] = {}
        self._clashes: set[str] = set()
        self._found: dict[tuple[int, str], tuple[frozenset[Kind], bool]] = {}

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
            self.problems.add(
                place,
                f"the {what.value} '{name}' has the name of a {other.what.value}",
                f"rename it, or the {other.what.value}{first}",
            )
            self.problems.broken.add(name)  # either may be meant
            return False
        self.table[name] = Meaning(what, comes_to(what), value, place, family)
        members = family.members if family else (name,)
        self._members.update(members)
        if value is not None:
            self.values.update(dict.fromkeys(members, value))
        return True

    @contextmanager
    def besides(self, free: Iterable[str]) -> Iterator[None]:
        """Let expressions contain further names for a while, which are free: the parameters of a curve."""
        own = {name: Meaning(Kind.PARAMETER, frozenset({Kind.PARAMETER}), scalar()) for name in free}
        self.table |= own
        self.values |= {name: scalar() for name in own}
        try:
            yield
        finally:
            for name in own:
                del self.table[name], self.values[name]

    def declare_coordinates(self, coordinates: Sequence[tuple[str, Place, Family | None]]) -> None:
        """Enter coordinates and their velocities."""
        for name, place, family in coordinates:
            self.declare(name, Kind.COORDINATE, place, scalar(), family)
        for name, place, family in coordinates:
            if family is not None:
                members = tuple(map(velocity_name, family.members))
                family = replace(family, name=velocity_name(family.name), members=members)
            self.declare(velocity_name(name), Kind.VELOCITY, place, scalar(), family)

    def copy(self) -> Names:
        """A table with the same names, to which others may be added."""
        found = Names(self.problems, self.sizes, self.rules)
        found.table, found.bound, found.values = {**self.table}, {**self.bound}, {**self.values}
        found._members = {*self._members}
        return found

    def declare_multiplier(self, constraint: str, place: Place | None, family: Family | None) -> None:
        """Enter the multiplier of a constraint, or of each member of a family."""
        kinds = frozenset({Kind.MULTIPLIER})
        self.bound[constraint] = Meaning(Kind.MULTIPLIER, kinds, scalar(), place, family)

    def settle(self, name: str, kinds: frozenset[Kind], value: Any) -> None:
        """Say what a declared definition or particle, or a member of a family of them, came to."""
        base = family_name(name)
        self.values[name] = value
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
                raise NoMember(range_hint(name, family))
            return scalar()
        if name not in self.values:
            meaning = self.table[family_name(name)]
            if name in self._members:
                raise Needs(name) if meaning.what in (Kind.PARAMETER, Kind.DEFINITION) else Unsound
            assert meaning.family is not None
            raise NoMember(range_hint(name, meaning.family))
        value = self.values[name]
        if value is None:
            raise Unsound
        if not component:
            return value
        if component in BODY_COMPONENTS:
            return scalar()
        known = COMPONENTS + VELOCITY_COMPONENTS
        if component not in known or known.index(component) % 3 >= len(value):
            raise Unsound  # not looked at, as another member of the family is wrong
        return value[known.index(component) % 3]

    def alike(self, name: str) -> Any:
        """The largest bounds of the members of a family, none of which is a number; None where one is, or is
        not settled yet."""
        if name not in self._alike:
            family = self.table[name].family
            found = [self.values.get(one) for one in family.members] if family is not None else [None]
            if any(one is None for one in found):
                return None
            self._alike[name] = largest(found)
        return self._alike[name]

    def check(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], Any]:
        """What ``expression`` comes down to, and its bounds (None where something in it is wrong).

        Every unknown or forbidden name is reported; the shapes are looked at only if there is none. Of the
        members of a family, which have one tree, the first that is wrong is reported.
        """
        key = id(expression.tree), section
        if key not in self._found:
            self._found[key] = self._look_up_all(expression, section, where)
        kinds, sound = self._found[key]
        if not sound:
            self.problems.distrust(expression.tree)
            return kinds, None
        together = self._together(expression)
        if together is not None and (section != "definitions" or unknown(together)):
            return kinds, together
        try:
            return kinds, self._builder.build(expression.tree, expression.indices)
        except Unsound:
            self.problems.distrust(expression.tree)
            return kinds, None
        except ExpressionError as error:
            self._found[key] = kinds, False
            self.problems.add_expression(expression, error, where)
            return kinds, None

    @cached_property
    def many(self) -> BoundsBuilder:
        """What finds the bounds of all terms of a sum, or of all members of a family, together: one for the
        file, which counts them."""
        from lagrange_cli.expression.many_bounds import BoundsBuilder
        from lagrange_cli.spec.members import bounds_of

        return BoundsBuilder(partial(bounds_of, self), self.sizes)

    def _together(self, expression: Expression) -> Any:
        """The bounds of all members that share the expression's tree, where these are many and none is wrong;
        else None."""
        key = id(expression.tree)
        if key not in self._of_siblings:
            self._of_siblings[key] = None
            if len(self.siblings.get(key, ())) >= MANY:
                from lagrange_cli.spec.members import indices_of

                members = indices_of(self.siblings[key])
                self._of_siblings[key] = self.many.of_members(expression.tree, members)
        return self._of_siblings[key]

    def _look_up_all(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], bool]:
        """What the names of an expression come down to, and whether each of them may stand there."""
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
                differential = end_of_differential(name, expression.text, self.table)
                error.span = Span(error.span.start, max(error.span.stop, differential))
                if (
                    error.span,
                    error.message,
                ) not in said:
                    self.problems.add_expression(expression, error, where)
                said.add((error.span, error.message))
                sound = False
                continue
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
        elif base in self.bound:
            family = self.bound[base].family
            hint = f"write {family.label if family else base}.{MULTIPLIER} for its Lagrange multiplier"
            message = f"'{base}' is a constraint, which is always 0"
            if component:
                message = f"the constraint '{base}' has no component '{component}'"
            raise ExpressionError(name.span, message, hint)
        else:
            unknown = Unknown(self.table, self.bound, self.rules[section].allowed, expression.indices)
            raise ExpressionError(name.span, *unknown.report(base))
        rule = self.rules[section]
        forbidden = [kind for kind in Kind if kind in meaning.kinds - rule.allowed]
        if forbidden:
            via = ""
            if meaning.what is Kind.DEFINITION and forbidden[0] is not Kind.DEFINITION:
                via = (
                    f", which depends on a {forbidden[0].value},"
                    if forbidden[0] is not Kind.TIME
                    else ", which depends on t,"
                )
            raise ExpressionError(
                name.span, f"the {meaning.what.value} '{base}'{via} cannot be used", rule.hint
            )
        self.check_indices(name, meaning)
        if component and meaning.value is not None and component != MULTIPLIER:
            self.check_component(name, meaning, base, component)
        elif component and meaning.what is Kind.PARTICLE:  # its position is wrong: any three may be meant
            self.check_component(name, replace(meaning, value=(None,) * 3), base, component)
        return meaning

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
        if len(name.indices) == due or (meaning.family is None and meaning.value is None):
            return
        example = member_name(name.identifier, "ijklmn"[:due]) if due else name.identifier
        if not due:
            message = f"'{name.base}' is not a family and takes no index"
            if component := _numbered_component(name, meaning):
                example = f"{name.base}.{component}"
        elif not name.indices:
            message, example = f"missing index on the family '{name.base}'", f"{example} for one member"
            members = meaning.family.members if meaning.family else ()
            if due == 1 and meaning.what is Kind.PARAMETER and len(members) in (2, 3):
                example += f", or ({', '.join(members)}) for a vector"
        else:
            message = f"wrong number of indices on '{name.base}': {len(name.indices)} instead of {due}"
        raise ExpressionError(name.span, message, f"write {example}")

    def check_component(self, name: Name, meaning: Meaning, base: str, component: str) -> None:
        """Raise ExpressionError where a name has no such component."""
        if not isinstance(meaning.value, tuple):
            hint = f"write {base}"
            if meaning.what is Kind.COORDINATE:
                hint += f", or {velocity_name(base)} for its velocity"
            raise ExpressionError(
                name.span, f"the {meaning.what.value} '{base}' has no component '{component}'", hint
            )
        label = meaning.family.label if meaning.family else base
        known = COMPONENTS[: len(meaning.value)]
        if component in BODY_COMPONENTS:
            if meaning.what is Kind.BODY:
                return
            if component in AXES_COMPONENTS + AXES_RATES:
                hint = f"only bodies have an orientation and points such as plate.{POINT}(a, b, c)"
            else:
                hint = "only bodies have an angular velocity"
            message = f"the {meaning.what.value} '{base}' is not a rigid body"
            raise ExpressionError(name.span, message, f"{hint}: see 'bodies'")
        if meaning.what in (Kind.PARTICLE, Kind.BODY):
            known += VELOCITY_COMPONENTS[: len(meaning.value)]
        if component not in known:
            meant = CONFUSED_COMPONENTS.get(component, "")
            hint = (
                f"write {label}.{meant}" if meant in known else known_hint(f"{label}.{one}" for one in known)
            )
            if meaning.what is Kind.BODY and component not in VELOCITIES:
                hint += f", {label}.{SPACE_SPIN[0]}, {label}.{BODY_SPIN[0]}, {label}.{POINT}(a, b, c), ..."
            if component in VELOCITIES and meaning.what in (Kind.PARTICLE, Kind.BODY):
                velocity = ", ".join(f"{label}.{one}" for one in known[len(meaning.value) :])
                hint = f"write ({velocity}) for its velocity"
            raise ExpressionError(
                name.span, f"the {meaning.what.value} '{base}' has no component '{component}'", hint
            )


class SumBuilder(Builder):
    """Builds expressions over bounds, long sums without going through their terms where that is possible."""

    def __init__(self, names: Names, algebra: BoundsAlgebra, sizes: Mapping[str, int]) -> None:
        super().__init__(names.value, algebra, sizes)
        self._table = names

    def _sum(self, tree: Sum, indices: Mapping[str, int]) -> Any:
        if len(counted(tree, indices)) >= MANY:
            found = self._table.many.bounds(tree, indices)
            if found is not None:
                return found
        return super()._sum(tree, indices)


def unknown(bounds: Any) -> bool:
    """Whether no number is known of what has these bounds."""
    parts = bounds if isinstance(bounds, tuple) else (bounds,)
    return all(one.value is None and not hasattr(one, "numbers") for one in parts)


def largest(bounds: Sequence[Any]) -> Any:
    """The largest of the bounds of several members; None where one is a number, or they differ in kind."""
    first = bounds[0]
    if isinstance(first, tuple):
        if any(not isinstance(one, tuple) or len(one) != len(first) for one in bounds):
            return None
        parts = [largest(component) for component in zip(*bounds)]
        return None if any(one is None for one in parts) else tuple(parts)
    if any(isinstance(one, tuple) or one.value is not None for one in bounds):
        return None
    deepest = max(bounds, key=lambda one: one.depth)
    return Bounds(None, max(one.size for one in bounds), deepest.depth, deepest.kind)


def _numbered_component(name: Name, meaning: Meaning) -> str:
    """``z`` for the index of ``bead[2]``, where ``bead`` is a position; nothing for other names."""
    if meaning.what not in (Kind.PARTICLE, Kind.BODY) or "." in name.identifier or len(name.indices) != 1:
        return ""
    index = name.indices[0]
    return dict(zip("012", COMPONENTS, strict=True)).get(index.text, "") if isinstance(index, Number) else ""


def scalar() -> Bounds:
    """The bounds of a parameter, a coordinate, a velocity or the time."""
    return Bounds()
