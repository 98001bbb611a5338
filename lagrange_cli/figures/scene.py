"""``Scene``: frames of a drawing that moves. What stands still is drawn once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.drawing.drawing import Drawing, Locus
from lagrange_cli.drawing.evaluate import locus, points, sizes
from lagrange_cli.figures.solids import seen
from lagrange_cli.figures.style import COLORS, formula, styled
from lagrange_cli.records import dataclass

Array = np.ndarray
HEIGHT = 600
"""Pixels of a picture whose letters and lines have the sizes given here; others are scaled."""
LEAST, MOST = 5.0, 13.0
"""Radii of particles, in points."""
TURNS = 9
"""The windings of a spring."""
GREY = "#8a8f98"
DARK = "#4a4f57"
FAINT = "#d5d8dd"
SHADES = 40
"""Pieces of a trail, each paler than the one after it."""
CROWD = 100
"""Particles up to which each has a white edge; those of more would hide one another behind these."""
MOST_LABELS = 8
SIDE = 0.38
"""The part of the width that side panels take."""


@dataclass(frozen=True)
class Side:
    """A panel beside the drawing, with a mark at what the drawing shows: curves by their times, x, y (n,) and
    label."""

    title: str
    x: str
    y: str
    curves: tuple[tuple[Array, Array, Array, str], ...]


def nearest(times: Array, t: float) -> int:
    """The number of the sample at about that time."""
    return int(np.abs(times - t).argmin())


class View:
    """The projection of a drawing's points to the plane of the picture."""

    def __init__(self, drawing: Drawing) -> None:
        self.flat, self.upward = drawing.dimension == 2, drawing.up != "-y"
        camera = drawing.camera
        a, e = math.radians(camera.azimuth), math.radians(camera.elevation)
        self.toward = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
        right = np.array([-math.sin(a), math.cos(a), 0.0])
        above = np.cross(self.toward, right)
        if drawing.up == "y":  # x, y, z of the file are z', x', y' of the camera
            turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
            self.toward, right, above = self.toward @ turn, right @ turn, above @ turn
        self.matrix = np.stack([right, above])

    def plane(self, places: Array) -> Array:
        """Places (dimension, ...) in the picture (2, ...)."""
        if self.flat:
            return places if self.upward else (places.T * (1.0, -1.0)).T
        return np.tensordot(self.matrix, places, 1)

    def depth(self, places: Array) -> Array:
        """How near places (dimension, ...) are to the viewer."""
        return np.zeros(places.shape[1:]) if self.flat else np.tensordot(self.toward, places, 1)


def shorten(text: Any, room: float) -> None:
    """Cut a text to a width of so many pixels."""
    letters = text.get_text()
    while letters and (wide := text.get_window_extent().width) > room:
        letters = letters[: min(len(letters) - 1, int(len(letters) * room / wide))]
        text.set_text(f"{letters}\N{HORIZONTAL ELLIPSIS}")


class Scene:
    """The frames of a drawing, whose bounds are known; ``width`` and ``height`` are in pixels.

    A trail shows the last ``trail`` samples that are handed over with a frame.
    """

    def __init__(
        self, drawing: Drawing, parameters: Mapping[str, float], title: str, width: int, height: int,
        sides: Sequence[Side] = (), unit: str = "",
    ) -> None:  # fmt: skip
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.drawing, self.parameters, self.unit = drawing, parameters, unit
        self.sizes = sizes(drawing, parameters)
        self.middle: Array = np.zeros(drawing.dimension)
        self.view = View(drawing)
        with styled():
            dpi = 100 * min(height, 0.75 * width) / HEIGHT
            figure = Figure(figsize=(width / dpi, height / dpi), dpi=dpi)
            self.canvas: Any = FigureCanvasAgg(figure)
            part = SIDE if sides else 0.0
            self.axes: Any = figure.add_axes((0.01, 0.01, 0.98 - part, 0.93))
            self.axes.set_axis_off()
            written = figure.text(
                0.02, 0.955, title, fontsize=11, fontweight="bold", va="center", parse_math=False
            )
            shorten(written, 0.96 * width)
            self._frame()
            self._moving: list[Any] = []
            self._make()
            self.marks = self._sides(figure, sides)
        canvas: Any = self.canvas
        canvas.draw()
        self._background: Any = canvas.copy_from_bbox(figure.bbox)

    def _frame(self) -> None:
        """Show all that the motion fills, with one scale along both axes."""
        bounds = self.drawing.camera.bounds or ((-1.0,) * 3, (1.0,) * 3)
        corners = np.array(np.meshgrid(*zip(*bounds), indexing="ij")).reshape(self.drawing.dimension, -1)
        seen_part = self.view.plane(corners)
        low, high = seen_part.min(axis=1), seen_part.max(axis=1)
        place = self.axes.get_window_extent()
        frame = np.array([place.width, place.height])
        reach = frame / 2 * ((high - low) / frame).max()  # both axes have the scale of the tighter one
        middle = (low + high) / 2
        self.axes.set_xlim(middle[0] - reach[0], middle[0] + reach[0])
        self.axes.set_ylim(middle[1] - reach[1], middle[1] + reach[1])
        if not self.view.flat:
            self._box(corners)

    def _box(self, corners: Array) -> None:
        """The edges of the visible space, behind everything."""
        back = int(np.argmin(self.view.depth(corners)))
        for k in range(8):
            for bit in (1, 2, 4):
                if not k & bit and (k == back or k | bit == back):
                    edge = self.view.plane(corners[:, [k, k | bit]])
                    self.axes.plot(*edge, color=FAINT, lw=1, zorder=0)

    def _make(self) -> None:
        """The artists that move, and curves that do not."""
        from matplotlib.collections import LineCollection, PolyCollection

        axes, drawing = self.axes, self.drawing
        self.curves: list[tuple[Locus, Any]] = []
        for curve in drawing.curves:
            lines = LineCollection([], colors=curve.colour or GREY, linewidths=1.2, alpha=0.6, zorder=1)
            axes.add_collection(lines, autolim=False)
            if curve.depends or curve.on_time or drawing.camera.follow is not None:
                self.curves.append((curve, lines))
            else:
                lines.set_segments(self._lines(curve, 0.0, np.zeros(len(drawing.coordinates))))
        self.trails = LineCollection([], linewidths=1.4, zorder=2)
        self.rods = LineCollection([], linewidths=2.4, zorder=4, capstyle="round")
        self.springs = LineCollection([], linewidths=1.3, zorder=4)
        self.faces = PolyCollection([], zorder=5, edgecolors="face", linewidths=0.4)
        for each in (self.trails, self.rods, self.springs, self.faces):
            axes.add_collection(each, autolim=False)
        self.pivots = axes.scatter([], [], s=26, c="#333333", marker="o", zorder=6)
        edge = 0.8 if len(drawing.dots) <= CROWD else 0.0
        self.dots = axes.scatter([], [], zorder=7, edgecolors="white", linewidths=edge)
        self.clock = axes.text(0.02, 0.02, "", transform=axes.transAxes, fontsize=10, color="#444444")
        beside = {"xytext": (8, 6), "textcoords": "offset points", "fontsize": 10, "parse_math": False}
        self.labels = [
            (one.point, axes.annotate(one.label, (0, 0), **beside)) for one in drawing.dots if one.label
        ]
        moving = [lines for _, lines in self.curves]
        self._moving = [
            *moving, self.trails, self.rods, self.springs, self.faces, self.pivots, self.dots, self.clock,
            *(text for _, text in self.labels),
        ]  # fmt: skip
        for each in self._moving:
            each.set_animated(True)
        masses = np.array([self.sizes[one.mass] if one.mass is not None else np.nan for one in drawing.dots])
        largest = np.nanmax(masses) if np.isfinite(masses).any() else 1.0
        share = np.cbrt(np.nan_to_num(masses / largest, nan=0.1)) if largest > 0 else np.ones(len(masses))
        few = min(1.0, 24 / max(len(masses), 1) ** 0.5 / 8 + 0.25)
        self.radii = np.maximum(LEAST, MOST * share) * few
        self.colors = [one.colour or COLORS[one.group % len(COLORS)] for one in drawing.dots]

    def _sides(self, figure: Any, sides: Sequence[Side]) -> list[tuple[Any, Side]]:
        """The side panels, and the marks that move on them."""
        found = []
        for number, side in enumerate(sides):
            height = 0.9 / len(sides)
            place = (1 - SIDE + 0.09, 0.97 - height * (number + 1) + 0.08, SIDE - 0.11, height - 0.14)
            axes = figure.add_axes(place)
            axes.set_title(formula(side.title), loc="left", fontsize=9)
            axes.set_xlabel(formula(side.x), fontsize=8)
            axes.set_ylabel(formula(side.y), fontsize=8)
            axes.tick_params(labelsize=7)
            for k, (_, x, y, label) in enumerate(side.curves):
                axes.plot(
                    x, y, color=COLORS[k % len(COLORS)], lw=0.8, alpha=0.6, label=formula(label) or None
                )
            if 1 < len(side.curves) <= MOST_LABELS:
                axes.legend(
                    fontsize=7, frameon=False, loc="lower right", bbox_to_anchor=(1, 0.98), ncols=4,
                    handlelength=1, columnspacing=1, borderpad=0,
                )  # fmt: skip
            colors = [COLORS[k % len(COLORS)] for k in range(len(side.curves))]
            mark = axes.scatter([], [], s=22, zorder=5, animated=True)
            mark.set_facecolor(colors)
            found.append((mark, side))
        return found

    def _lines(self, curve: Locus, t: float, q: Array) -> list[Array]:
        """A curve, or the mesh of a surface, as lines (k, 2) in the picture."""
        place = locus(self.drawing, curve, t, q, self.parameters)
        place = self.view.plane((place.T - self.middle).T)
        if place.ndim == 2:
            return [place.T]
        return [*place[:, ::2].transpose(1, 2, 0), *place[:, :, ::2].transpose(2, 1, 0)]

    def frame(self, t: Array, q: Array) -> Array:
        """The picture (height, width, 4) of the last of these samples, t (k,) and q (k, n), the others of
        which leave trails."""
        places = points(self.drawing, t, q, self.parameters)
        if self.drawing.camera.follow is not None:
            followed, shown = places[self.drawing.camera.follow].copy(), list(self.drawing.places)
            places[shown] -= followed  # not directions
            self.middle = followed[:, -1]
        now = places[:, :, -1]
        flat = self.view.plane(np.moveaxis(now, 0, 1)).T
        self._place(places, now, flat)
        for curve, lines in self.curves:
            lines.set_segments(self._lines(curve, float(t[-1]), q[-1]))
        clock = f"t = {shown_time(float(t[-1]))}{' ' if self.unit else ''}{self.unit}"
        self.clock.set_text(clock.replace("$", r"\$"))
        self.canvas.restore_region(self._background)
        for artist in self._moving:
            self.axes.draw_artist(artist)
        for mark, side in self.marks:
            numbers = [nearest(times, float(t[-1])) for times, *_ in side.curves]
            mark.set_offsets(np.array([[x[k], y[k]] for k, (_, x, y, _) in zip(numbers, side.curves)]))
            mark.axes.draw_artist(mark)
        picture: Array = np.array(self.canvas.buffer_rgba())
        return picture

    def _place(self, places: Array, now: Array, flat: Array) -> None:
        """Move the artists; ``flat`` (points, 2) is where points are in the picture."""
        drawing = self.drawing
        self.rods.set_segments([flat[list(one.ends)] for one in drawing.rods])
        self.rods.set_color([one.colour or (GREY if one.thin else DARK) for one in drawing.rods] or DARK)
        self.rods.set_linewidth([1.2 if one.thin else 2.4 for one in drawing.rods] or 2.4)
        self.springs.set_segments([*self._zigzags(flat)])
        self.springs.set_color([one.colour or DARK for one in drawing.springs] or DARK)
        self.pivots.set_offsets(flat[[one.point for one in drawing.pivots]].reshape(-1, 2))
        order = np.argsort(
            self.view.depth(now[[one.point for one in drawing.dots]].T.reshape(now.shape[1], -1))
        )
        self.dots.set_offsets(flat[[drawing.dots[k].point for k in order]].reshape(-1, 2))
        self.dots.set_sizes(self.radii[order] ** 2)
        self.dots.set_facecolor([self.colors[k] for k in order])
        for point, text in self.labels:
            text.xy = tuple(flat[point])
        self._bodies(now)
        self._trails(places)

    def _zigzags(self, flat: Array) -> Array:
        """The springs as zigzag lines (springs, points, 2)."""
        ends = flat[np.array([one.ends for one in self.drawing.springs], dtype=int).reshape(-1, 2)]
        start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
        low, high = self.axes.get_ylim()
        length = np.hypot(*along.T)
        width = np.minimum(0.018 * (high - low), 0.25 * length) / np.where(length > 0.0, length, 1.0)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) * width[:, None]
        share = np.concatenate([[0, 0.1], 0.1 + 0.8 * (np.arange(2 * TURNS) + 0.5) / (2 * TURNS), [0.9, 1]])
        side = np.concatenate([[0, 0], [1, -1] * TURNS, [0, 0]])
        zigzags: Array = start[:, None] + share[:, None] * along[:, None] + side[:, None] * across[:, None]
        return zigzags

    def _bodies(self, now: Array) -> None:
        """The faces of rigid bodies, the nearest last."""
        found: list[tuple[float, Array, Any]] = []
        toward = np.array([0.0, 0.0, 1.0]) if self.view.flat else self.view.toward
        for body in self.drawing.solids:
            centre, axes = now[body.centre], now[list(body.axes)]
            if self.view.flat:
                centre, axes = np.append(centre, 0.0), np.column_stack([axes, np.zeros(3)])
                axes[2] = np.cross(axes[0], axes[1])
            base = self._color(body.colour or COLORS[body.group % len(COLORS)])
            for corners, depth, shade in seen(body.shape, self.sizes[list(body.sizes)], centre, axes, toward):
                flat = corners[:, :2] if self.view.flat else self.view.plane(corners.T).T
                found.append((depth, flat, base * shade + (1 - shade) * 0.15))
        found.sort(key=lambda one: one[0])
        self.faces.set_verts([flat for _, flat, _ in found])
        self.faces.set_facecolor([np.clip(color, 0, 1) for *_, color in found])
        self.faces.set_edgecolor([np.clip(color, 0, 1) for *_, color in found])

    @staticmethod
    def _color(name: str) -> Array:
        from matplotlib.colors import to_rgb

        return np.array(to_rgb(name))

    def _trails(self, places: Array) -> None:
        """Earlier positions of points, the older the paler: each trail in pieces of one shade."""
        pieces: list[Array] = []
        colors: list[Array] = []
        shades = {one.point: self._color(color) for one, color in zip(self.drawing.dots, self.colors)}
        for point in self.drawing.trails:
            path = self.view.plane(places[point]).T
            ends = np.unique(np.linspace(0, len(path) - 1, SHADES + 1).astype(int))
            pieces += [path[first : last + 1] for first, last in pairwise(ends)]
            fade = np.linspace(0.05, 0.8, len(ends) - 1)
            base = shades.get(point, self._color(COLORS[0]))
            colors.append(np.column_stack([np.broadcast_to(base, (len(fade), 3)), fade]))
        self.trails.set_segments(pieces)
        shaded: Any = np.concatenate(colors) if pieces else "none"
        self.trails.set_color(shaded)


def shown_time(t: float) -> str:
    """Three digits, and all before the point up to a million."""
    return f"{t:.0f}" if 1e3 <= abs(t) < 1e6 else decimal(t, 3)
