"""``Section``: what the section ``draw`` of a system file asks for, over the graph and in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

from lagrange_cli.decimals import decimal
from lagrange_cli.drawing.curves import range_of
from lagrange_cli.drawing.drawing import FREE, Camera, Drawing
from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.drawing.sheet import Sheet
from lagrange_cli.drawing.upright import camera_of, turned, up_of
from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.records import replace
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.spelling import spelled
from lagrange_cli.spec.wanted import Course, Path, Range, Wanted

SURFACE = 2
"""Coordinates that a surface has."""


class Section:
    """The section of the scene's file, which may be missing; ``problems`` are those that its numbers have."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.wanted = scene.spec.draw or Wanted()
        self.problems = Problems(Source(scene.spec.filename, scene.spec.text))

    @property
    def has_places(self) -> bool:
        """Whether it gives any positions."""
        one = self.wanted
        return bool(one.rods or one.springs or one.points or one.curves or one.trails)

    def colour(self, name: str) -> str:
        """The colour of what has a name, or of all rods or springs; empty where the file gives none."""
        return self.wanted.colours.get(name, "")

    # -------------------------------------------------------------- what is added to a sheet

    def rods(self, sheet: Sheet, paths: Iterable[Path]) -> None:
        """Rods along the paths."""
        for a, b in self._pairs(paths):
            sheet.rod(a, b, self.colour("rods"))

    def springs(self, sheet: Sheet, paths: Iterable[Path]) -> None:
        """Springs along the paths."""
        for a, b in self._pairs(paths):
            sheet.spring(a, b, self.colour("springs"))

    def _pairs(self, paths: Iterable[Path]) -> Iterable[tuple[Place, Place]]:
        return (ends for path in paths for ends in pairwise(map(self.scene.place, path)))

    def points(self, sheet: Sheet) -> None:
        """The points that are added, and the trails that are given."""
        for one in self.wanted.points:
            label = self._label(one)
            sheet.dot(label, self.scene.place(one), group=label if label.isidentifier() else "(x, y)")
        for one in self.wanted.trails or ():
            number = sheet.point(self.scene.place(one))
            if number not in sheet.trails:
                sheet.trails.append(number)

    def _label(self, point: Expression) -> str:
        """The point as it is written, without the loops that repeat it."""
        span, whole = point.tree.span, spelled(point, self.scene.spec.sizes)
        return whole[span.start : len(whole) - (len(point.text) - span.stop)]

    def curves(self, sheet: Sheet, courses: Iterable[Course]) -> None:
        """The curves and surfaces that are given."""
        for course in courses:
            colour = self.colour(course.name)
            for a, b in self._pairs([course.through]):
                sheet.line(a, b, colour)
            if course.at is not None:
                self._locus(sheet, course, course.at, colour)

    def _locus(self, sheet: Sheet, course: Course, at: Expression, colour: str) -> None:
        """A curve, or a surface, where one or two names run."""
        scene = self.scene
        place, free = scene.along(course)
        ranges: dict[int, tuple[float, float] | None] = {}
        for name, ends in course.ranges.items():
            if name in free:
                ranges[len(scene.coordinates) + free.index(name)] = (0.0, 1.0)
            else:
                number = scene.number[name]
                label = f"range of '{name}' in curve '{course.name}'"
                ranges[number] = range_of(scene, place, number) if ends is None else self.ends(ends, label)
        if not course.ranges:
            ranges = {k: range_of(scene, place, k) for k in scene.depends(place)}
        if not 1 <= len(ranges) <= SURFACE:
            few = "no coordinate" if not ranges else f"{len(ranges)} coordinates"
            hint = f"give the range of a parameter: {{at: {at.text}, u: [0, 1]}}" if len(at.text) < 40 else ""
            self.problems.add_once(course.place, f"curve '{course.name}' depends on {few}", hint)
            return
        sheet.locus(course.name, place, ranges.keys(), ranges.values(), colour)

    # -------------------------------------------------------------- numbers

    def number(self, expression: Expression, where: str) -> float:
        """The value of an expression in parameters; 0 where it has none, which is reported."""
        (value,) = evaluate([self.scene.scope.scalar(expression)], self.scene.values.parameters)
        if math.isfinite(value):
            return float(value)
        error = ExpressionError(Span(0, len(expression.text)), "this has no finite value", "write a number")
        self.problems.add_expression(expression, error, where)
        return 0.0

    def ends(self, ends: Range, where: str) -> tuple[float, float]:
        """Both ends of a range."""
        low, high = (self.number(one, where) for one in ends)
        return low, high

    def ordered(self, ends: Range, where: str) -> tuple[float, float]:
        """Both ends of a range, the smaller one first."""
        before = len(self.problems.found)
        low, high = self.ends(ends, where)
        if not low < high and len(self.problems.found) == before:
            message = (
                f"the {where} ends at {decimal(high)}, where it begins"
                if low == high
                else (f"the {where} goes from {decimal(low)} down to {decimal(high)}")
            )
            self.problems.add_once(ends[0].place, message, "write the smaller value first")
        return low, high

    # -------------------------------------------------------------- the whole

    def completed(self, sheet: Sheet) -> Drawing:
        """The drawing of a sheet, with colours, camera and sliders.

        Raises ``SpecError`` with all numbers of the section that make no sense.
        """
        up = self._up(sheet)
        camera = self.camera(sheet, up)
        sliders = {name: self.ordered(ends, f"slider '{name}'") for name, ends in self.wanted.sliders.items()}
        self.problems.stop_if_any()
        found = sheet.drawing()
        return replace(
            found,
            up=up if sheet.dimension == 2 else up[-1],
            dots=tuple(replace(one, colour=self.colour(one.name)) for one in found.dots),
            solids=tuple(replace(one, colour=self.colour(one.name)) for one in found.solids),
            free=FREE if any(k >= len(found.coordinates) for one in found.curves for k in one.along) else (),
            camera=camera,
            sliders=sliders,
        )

    def _up(self, sheet: Sheet) -> str:
        """The axis that points upward."""
        if sheet.abstract:
            return "z" if sheet.dimension == 3 else "y"
        given = self.wanted.view.up
        return given if given and (sheet.dimension == 3 or "z" not in given) else up_of(self.scene)

    def camera(self, sheet: Sheet, up: str) -> Camera:
        """The camera."""
        view, camera = self.wanted.view, Camera() if sheet.abstract else camera_of(self.scene, up)
        if view.azimuth is not None:
            camera = replace(camera, azimuth=self.number(view.azimuth, "azimuth of the camera"))
        if view.elevation is not None:
            elevation = self.number(view.elevation, "elevation of the camera")
            camera = replace(camera, elevation=elevation + turned(up))
        if view.follow is not None:
            camera = replace(camera, follow=sheet.point(self.scene.place(view.follow), seen=False))
        if view.bounds:
            window = tuple(
                self.ordered(view.bounds[axis], f"range of {axis} in bounds") if axis in view.bounds else None
                for axis in "xyz"[: sheet.dimension]
            )
            camera = replace(camera, window=window)
        return camera
