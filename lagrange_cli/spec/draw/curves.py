"""Curves and surfaces of the section ``draw``: points, and what runs through ranges."""

from __future__ import annotations

from lagrange_cli.expression.near import near_hint
from lagrange_cli.expression.syntax import Vector, names
from lagrange_cli.expression.vocabulary import RESERVED, TIME
from lagrange_cli.records import dataclass
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.draw.named import Named
from lagrange_cli.spec.draw.numbers import ends
from lagrange_cli.spec.draw.points import Points
from lagrange_cli.spec.draw.ranges import WrittenCurve, WrittenRange
from lagrange_cli.spec.draw.readers import plain_name
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression, by_family
from lagrange_cli.spec.wanted import Course, Path, Range


@dataclass
class Curves:
    """The draft, the table of names, where problems go, and what checks points and names."""

    draft: Draft
    names: Names
    problems: Problems
    points: Points
    named: Named

    def curve(self, curve: WrittenCurve) -> Course:
        """A curve, its parameters apart from coordinates."""
        label = f"curve '{curve.name}'"
        if curve.through is not None:
            points = self.points.points(curve.through, label) or ()
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
                ranges[name] = one.ends and ends(self.names, one.ends, f"range of '{name}' in {label}")
                if name == one.name and name not in self.names.table:
                    free.add(name)
                    self._is_used(one, curve, label)
        if curve.point is not None:
            with self.names.besides(free, more=len(curve.ranges) < 2):
                self.points.point(curve.point, label)
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
            self.points.point(one, "curves")
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
            known = by_family((each.name, each.name) for each in self.draft.declared("coordinates"))
            members = self.named.members(one, known, "coordinate", label)
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
