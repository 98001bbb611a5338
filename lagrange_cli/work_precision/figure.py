"""Work-precision diagrams: run time against error, both logarithmic.

The error decreases to the right: points further right are more accurate, and lower points are faster.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.figures.style import COLORS, FORMATS, MARKERS, check_matplotlib, rendered, styled
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINE = 12.0
"""Least distance between two labels, in points."""
WIDE = 70.0
"""Width of a label, in points."""


@dataclass(frozen=True)
class Point:
    """A run: its error and time; if ``bounded``, the error is an upper bound."""

    error: float
    seconds: float
    bounded: bool = False


@dataclass(frozen=True)
class Curve:
    """The runs of one method, beginning with the coarsest tolerance."""

    name: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Picture:
    """The content of one frame; errors below ``floor`` cannot be measured, ``chosen`` is circled."""

    title: str
    error_label: str
    curves: tuple[Curve, ...]
    floor: float | None = None
    wanted: float | None = None
    chosen: Point | None = None


def check_picture(name: str) -> None:
    """Check, before any work is done, that a picture can be drawn.

    Raises ``UsageError`` for another format, ``FileError`` where no file can be written.
    """
    path = Path(name)
    if path.suffix not in FORMATS:
        raise UsageError(f"--plot {name}: the name must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    if not path.parent.is_dir():
        raise FileError(f"{name} cannot be written: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise FileError(f"{name} cannot be written: no permission to write in {path.parent}")
    check_matplotlib("--plot")


def write_picture(name: str, *pictures: Picture) -> None:
    """Draw pictures side by side into a file. If there are several, they have the same curves and one legend.

    Raises ``FileError`` where it cannot be written.
    """
    from matplotlib.figure import Figure

    path = Path(name)
    with styled():
        width = 7.2 if len(pictures) == 1 else 2.0 + 4.3 * len(pictures)
        figure = Figure(figsize=(width, 4.6), layout="constrained")
        frames = figure.subplots(1, len(pictures), squeeze=False)[0]
        for axes, picture in zip(frames, pictures):
            draw(axes, picture)
        if len(pictures) == 1:
            label_ends(figure, frames[0], pictures[0].curves)
        else:
            figure.legend(*frames[0].get_legend_handles_labels(), loc="outside right center", frameon=False)
        drawn = rendered(figure, path.suffix)
    try:
        path.write_bytes(drawn)
    except OSError as error:
        raise FileError(f"{name} could not be written: {error.strerror or error}") from error


def draw(axes: Axes, picture: Picture) -> None:
    """Draw one frame: the curves, the required error, and the errors that cannot be measured."""
    axes.set(xscale="log", yscale="log", xlabel=picture.error_label, ylabel="run time (s)")
    axes.set_title(picture.title, loc="left")
    for k, curve in enumerate(picture.curves):
        draw_curve(axes, curve, k)
    axes.margins(x=0.09, y=0.1)
    axes.invert_xaxis()
    axes.set_xlim(axes.get_xlim())  # what follows does not widen it
    if picture.wanted is not None:
        axes.axvline(picture.wanted, color="#555555", linewidth=1, linestyle=(0, (4, 3)), zorder=1)
        note(axes, picture.wanted, "required error")
    if picture.floor is not None:
        axes.axvspan(picture.floor, min(picture.floor, axes.get_xlim()[1]), color="#f2f2f2", zorder=0)
        note(axes, picture.floor, "error of the reference")
    if picture.chosen is not None:
        chosen = picture.chosen
        axes.plot(chosen.error, chosen.seconds, "o", ms=14, mfc="none", mec="#333333", mew=1.2)


def draw_curve(axes: Axes, curve: Curve, k: int) -> None:
    """Draw the line and its points, hollow where the error is an upper bound."""
    color, marker = COLORS[k % len(COLORS)], MARKERS[k % len(MARKERS)]
    errors, seconds = [p.error for p in curve.points], [p.seconds for p in curve.points]
    width = 2.2 if k == 0 else 1.4
    axes.plot(
        errors,
        seconds,
        marker=marker,
        ms=6,
        color=color,
        lw=width,
        zorder=4 if k == 0 else 3,
        label=curve.name,
    )
    for point in curve.points:
        if point.bounded:
            axes.plot(point.error, point.seconds, marker, color=color, mfc="white", ms=6, zorder=5)


def note(axes: Axes, error: float, text: str) -> None:
    """Write a label along a vertical line, at its top, if the line is within the frame."""
    loosest, tightest = axes.get_xlim()
    if tightest < error < loosest:
        axes.annotate(
            text, (error, 1), xycoords=("data", "axes fraction"), xytext=(3, -3), textcoords="offset points",
            va="top", fontsize=8, color="#555555", rotation=90,
        )  # fmt: skip


def label_ends(figure: Figure, axes: Axes, curves: tuple[Curve, ...]) -> None:
    """Write each curve's name beside its last point, moved up where it would overlap another."""
    figure.draw_without_rendering()
    points = 72.0 / figure.dpi
    ends = []
    for k, curve in enumerate(curves):
        if curve.points:
            last = min(curve.points, key=lambda point: point.error)
            x, y = axes.transData.transform((last.error, last.seconds)) * points
            ends.append((y, x, last, curve.name, COLORS[k % len(COLORS)]))
    placed: list[tuple[float, float]] = []
    for y, x, last, name, color in sorted(ends, key=lambda end: end[0]):
        up = y
        for other_x, other_y in placed:
            if abs(x - other_x) < WIDE and abs(up - other_y) < LINE:
                up = other_y + LINE
        placed.append((x, up))
        axes.annotate(
            name, (last.error, last.seconds), xytext=(8, up - y), textcoords="offset points",
            color=color, va="center", fontweight="bold", annotation_clip=False, zorder=6,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
        )  # fmt: skip
