"""The section ``draw`` as written to a ``Wanted``: what it names exists, and points are points."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any

from lagrange_cli.expression.indices import counted, integer
from lagrange_cli.expression.listed import repeated
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, Name, Number, Span, Vector, names, plain_names
from lagrange_cli.expression.vocabulary import RESERVED, TIME, member_name, velocity_name
from lagrange_cli.limits import way_out, whole
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.draft import Draft, Written
from lagrange_cli.spec.draw_readers import Several, Strand, plain_name
from lagrange_cli.spec.kinds import CONSTANT, Kind, Rule
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.range_readers import WrittenCurve, WrittenRange
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.spec import Course, Expression, Path, Range, View, Wanted, by_family

SECTION = "draw"
NUMBERS = "numbers of draw"
"""Where the rule for ranges and angles is among those of the sections."""
CONSTANTS = Rule(CONSTANT, "ranges and angles may use numbers and parameters")
LINES = ("rods", "springs")
"""Words that ``colours`` has for all of a kind."""


def check_draw(draft: Draft, names: Names, problems: Problems) -> Wanted:
    """What the section of a file asks for; what is wrong is added to ``problems``."""
    names.rules = {**names.rules, NUMBERS: CONSTANTS}
    given: Mapping[str, Any] = draft.sections[SECTION]
    checker = _Checker(draft, names, problems)
    camera = given.get("camera", {})
    curves = given.get("curves")
    return Wanted(
        rods=checker.lines(given.get("rods"), "rods"),
        springs=checker.lines(given.get("springs"), "springs"),
        points=checker.points(given.get("points"), "points") or (),
        trails=checker.points(given.get("trails"), "trails"),
        hidden=checker.hidden(given.get("hide")),
        curves=None if curves is None else tuple(checker.curve(one) for one in curves),
        colours=checker.colours(given.get("colours", ())),
        view=View(
            azimuth=checker.number(camera.get("azimuth"), "azimuth of the camera"),
            elevation=checker.number(camera.get("elevation"), "elevation of the camera"),
            bounds={
                axis: checker.range(ends, f"bounds of {axis}")
                for axis, ends in camera.get("bounds", {}).items()
                if ends is not None
            },
            follow=checker.point(camera.get("follow"), "follow of the camera"),
            up=camera.get("up", ""),
        ),
        sliders=checker.sliders(given.get("sliders", ())),
    )


@dataclass
class _Checker:
    draft: Draft
    names: Names
    problems: Problems
    particles: dict[str, list[str]] = field(default_factory=dict)
    """The members of each family of particles or bodies; a particle of its own is its only member."""
    flat: bool = False
    """Whether all particles are on a line, so that a number is a place."""

    def __post_init__(self) -> None:
        every = [one.name for one in (*self.draft.entries("embedding"), *self.draft.bodies)]
        self.particles = by_family((name, name) for name in every)
        places = [self.names.values.get(name) for name in every]
        self.flat = bool(every) and all(isinstance(one, tuple) and len(one) == 1 for one in places)

    # -------------------------------------------------------------- points

    def lines(self, given: Several | None, where: str) -> tuple[Path, ...] | None:
        """The lines through points, as often as loops repeat them."""
        if given is None:
            return None
        return tuple(path for strand in given.strands for path in self._repeated(strand, where))

    def points(self, given: Several | None, where: str) -> tuple[Expression, ...] | None:
        """The points of a list; the name of a family stands for all of its members."""
        if given is None:
            return None
        if given.all:
            return tuple(_named(name) for members in self.particles.values() for name in members)
        found: list[Expression] = []
        for strand in given.strands:
            name = plain_name(strand.points[0])
            members = self.particles.get(name.identifier, []) if name and not name.indices else []
            if "[" in "".join(members[:1]):
                found += [_named(one) for one in members]
            else:
                found += [path[0] for path in self._repeated(strand, where)]
        return tuple(found)

    def _repeated(self, strand: Strand, where: str) -> Iterator[Path]:
        """The points of a strand for each value of its loops; each of them is checked."""
        for indices in self._indices(strand, where):
            path = tuple(replace(one, indices=indices) if indices else one for one in strand.points)
            for one in path:
                self.point(one, where)
            yield path

    def _indices(self, strand: Strand, where: str) -> Iterator[dict[str, int]]:
        try:
            for loop in strand.loops:
                self.names.check_index(loop.index, loop.span)
            yield from repeated(strand.loops, self.names.sizes, whole("members"))
        except ExpressionError as error:
            if not self._broken(strand):
                self.problems.add_expression(strand.text, error, where)

    def _broken(self, strand: Strand) -> bool:
        """Whether a range follows from a size that is wrong."""
        used = [bound for loop in strand.loops for bound in (*loop.bounds, *loop.conditions)]
        return any(plain_names(one) & self.problems.broken for one in used)

    def point(self, expression: Expression | None, where: str) -> Expression | None:
        """The expression, checked to be a point: a vector, or 0 for the origin."""
        if expression is None:
            return None
        _, bounds = self.names.check(expression, SECTION, where)
        if bounds is None or isinstance(bounds, tuple) or self.flat or _is_origin(expression):
            return expression
        hint = "write 0 for the origin, or (x, y)"
        what = plain_name(expression)
        if what is not None:
            meaning = self.names.table.get(what.base)
            hint = f"'{what.base}' is a {meaning.what.value}: {hint}" if meaning else hint
        span = Span(0, len(expression.text)) if expression.text else expression.tree.span
        error = ExpressionError(
            expression.tree.span if what else span, "expected a point, found a number", hint
        )
        self.problems.add_expression(expression, error, where)
        return expression

    # -------------------------------------------------------------- numbers

    def number(self, expression: Expression | None, where: str) -> Expression | None:
        """A number, made of parameters."""
        if expression is not None:
            check_scalar(self.names, expression, NUMBERS, where)
        return expression

    def range(self, ends: Range, where: str) -> Range:
        """Both ends of a range."""
        for one in ends:
            self.number(one, where)
        return ends

    # -------------------------------------------------------------- curves

    def curve(self, curve: WrittenCurve) -> Course:
        """A curve, its parameters apart from coordinates."""
        label = f"curve '{curve.name}'"
        if curve.through is not None:
            points = self.points(curve.through, label) or ()
            if len(points) == 1 and self.problems.trusts(points[0].tree):
                self.problems.add_once(curve.place, f"{label} has only one point", "write two or more")
            return Course(curve.name, curve.place, through=points)
        corners = self._corners(curve.point)
        if corners and not curve.ranges:
            return Course(curve.name, curve.place, through=corners)
        ranges: dict[str, Range | None] = {}
        free: set[str] = set()
        for one in curve.ranges:
            name = self._runs(one, label)
            if name:
                ranges[name] = one.ends and self.range(one.ends, f"range of '{name}' in {label}")
                if name == one.name and name not in self.names.table:
                    free.add(name)
                    self._is_used(one, curve, label)
        if curve.point is not None:
            with self.names.besides(free):
                self.point(curve.point, label)
        return Course(curve.name, curve.place, curve.point, ranges, frozenset(free))

    def _corners(self, point: Expression | None) -> Path:
        """The points A and B of ``[A, B]``, where these are names of vectors; nothing for components."""
        if point is None or not isinstance(point.tree, Vector) or len(point.tree.items) < 2:
            return ()
        corners = tuple(Expression(point.text, one, point.place, point.passages) for one in point.tree.items)
        for name in map(plain_name, corners):
            meaning = None if name is None else self.names.table.get(name.base)
            if meaning is None or not isinstance(meaning.value, tuple):
                return ()
        for one in corners:
            self.point(one, "curves")
        return corners

    def _runs(self, one: WrittenRange, label: str) -> str:
        """The coordinate or the parameter of a curve that a range is given for; nothing where it is wrong."""
        meaning = self.names.table.get(one.name)
        message, hint = "", ""
        if one.name in self.problems.broken:
            return ""
        if one.name == TIME:
            message, hint = (
                f"the time has no range in {label}",
                "leave it out: a curve that contains t moves by itself",
            )
        elif one.name in RESERVED:
            message, hint = f"the name '{one.name}' is reserved", f"call it {one.name}_ or another name"
        elif meaning is None:
            if one.key.axes:
                message, hint = f"unknown coordinate '{one.key.label}' in {label}", ""
            elif one.ends is None:
                message, hint = f"'{one.name}' has no range in {label}", f"write {one.name}: [0, 1]"
        elif meaning.what is not Kind.COORDINATE:
            message = f"the {meaning.what.value} '{one.name}' cannot have a range in {label}"
            hint = "ranges belong to coordinates, and to names that the file does not declare"
        else:
            members = self.members(one, self._coordinates(), "coordinate", label)
            if len(members) == 1:
                return members[0]
            if members:
                message, hint = (
                    f"a range for several coordinates in {label}",
                    f"give one for each: {members[0]}",
                )
        if message:
            self.problems.add_once(one.place, message, hint)
        return one.name if meaning is None and one.name not in RESERVED else ""

    def _is_used(self, one: WrittenRange, curve: WrittenCurve, label: str) -> None:
        """Note a parameter that the point of a curve does not contain."""
        if curve.point is None or not self.problems.trusts(curve.point.tree):
            return
        if all(name.base != one.name for name in names(curve.point.tree)):
            message = f"{label} does not contain '{one.name}', which has a range"
            known = [name.base for name in names(curve.point.tree)]
            self.problems.add_once(one.place, message, near_hint(one.name, known) or "leave the range out")

    # -------------------------------------------------------------- names

    def hidden(self, given: Several | None) -> frozenset[str]:
        """The particles and bodies that are not shown."""
        if given is None:
            return frozenset()
        if given.all:
            return frozenset(name for members in self.particles.values() for name in members)
        found: set[str] = set()
        for strand in given.strands:
            name = plain_name(strand.points[0])
            if name is None:
                error = ExpressionError(Span(0, len(strand.text.text)), "expected the name of a particle", "")
                self.problems.add_expression(strand.text, error, "hide")
                continue
            try:
                for indices in self._indices(strand, "hide"):
                    found |= {*self._hidden(name, indices)}
            except ExpressionError as error:
                self.problems.add_expression(strand.text, error, "hide")
        return frozenset(found)

    def _hidden(self, name: Name, indices: Mapping[str, int]) -> Sequence[str]:
        if name.identifier in self.problems.broken:
            return ()
        members = self.particles.get(name.identifier)
        if members is None:
            hint = near_hint(name.identifier, self.particles) or known_hint(self.particles)
            raise ExpressionError(name.span, f"unknown particle {shown(name.identifier)}", hint)
        if not name.indices:
            return members
        known = {**self.names.sizes, **indices}
        member = member_name(name.identifier, [integer(index, known) for index in name.indices])
        if member not in members:
            family = self.names.table[name.identifier].family
            hint = family.hint(member) if family else f"write {name.identifier}"
            raise ExpressionError(name.span, f"no member '{member}'", hint)
        return (member,)

    def colours(self, given: Sequence[Any]) -> dict[str, str]:
        """Colours by name, members of families one by one."""
        known = dict(self.particles)
        curves = self.draft.sections[SECTION].get("curves") or ()
        others = [one.name for one in curves]
        others += [entry.name for entry in self.draft.entries("definitions")]
        if "lagrangian" in self.draft.sections:
            others += [one.name for one in self.draft.declared("coordinates")]
        for name, members in by_family((name, name) for name in (*others, *LINES)).items():
            known.setdefault(name, members)
        found: dict[str, str] = {}
        for one in sorted(given, key=lambda one: bool(one.key.axes)):  # members after their families
            for name in self.members(one, known, "name", "colours"):
                found[name] = one.colour
        return {name: colour for name, colour in found.items() if colour}

    def sliders(self, given: Sequence[WrittenRange]) -> dict[str, Range]:
        """Ranges by name, members of families one by one."""
        parameters = [one.name for one in self.draft.declared("parameters")]
        coordinates = [one.name for one in self.draft.declared("coordinates")]
        every = (*parameters, *coordinates, *map(velocity_name, coordinates))
        known = by_family((name, name) for name in every)
        found: dict[str, Range] = {}
        for one in given:
            members = self.members(one, known, "name", "sliders")
            if one.ends is not None:
                ends = self.range(one.ends, f"slider '{one.key.label}'")
                found |= dict.fromkeys(members, ends)
        return found

    def _coordinates(self) -> dict[str, list[str]]:
        return by_family((one.name, one.name) for one in self.draft.declared("coordinates"))

    def members(
        self, one: Written, known: Mapping[str, Collection[str]], what: str, where: str
    ) -> Sequence[str]:
        """The names that a key stands for, which must be known; a family's name for all of its members."""
        base, axes = one.name, one.key.axes
        if base in self.problems.broken:
            return ()
        members = known.get(base)
        if members is None:
            hint = near_hint(base, known) or known_hint(known)
            self.problems.add_once(one.place, f"unknown {what} {shown(base)} in {where}", hint)
            return ()
        if not axes:
            return [*members]
        try:
            sizes = self.names.sizes
            ranges = [
                counted(axis, sizes) if axis.index else (integer(axis.bounds[0], sizes),) for axis in axes
            ]
            if prod(map(len, ranges)) > whole("members"):
                raise ExpressionError(axes[0].span, "too many members", way_out("members"))
            found, every = [member_name(base, place) for place in product(*ranges)], frozenset(members)
            for name in found:
                if name not in every:
                    first, *_, last = [*members, *members]
                    raise ExpressionError(axes[0].span, f"no member '{name}'", f"there are {first} to {last}")
        except ExpressionError as error:
            if not any(plain_names(bound) & self.problems.broken for axis in axes for bound in axis.bounds):
                self.problems.add_once(one.at(error.span), f"{error.message} in {where}", error.hint)
            return ()
        return found


def _named(name: str) -> Expression:
    """A particle as an expression."""
    return Expression(name, Name(name, Span(0, len(name))), WHOLE_FILE)


def _is_origin(expression: Expression) -> bool:
    """Whether it is the number 0."""
    return isinstance(expression.tree, Number) and float(expression.tree.text) == 0
