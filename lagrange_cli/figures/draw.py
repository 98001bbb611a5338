"""Pages of plots as figures."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Page, Panel, drawable
from lagrange_cli.figures.style import COLORS, formula, plain, rendered, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 5.2, 3.1
"""The size of a panel, in inches."""
FADED = 0.25
"""The opacity of a curve where its values are not trusted."""
MOST_LABELS = 8
VECTORS = 20_000
"""A curve of more points is a picture within the file, so that this stays small."""
SPARSE = 200
"""Fewer points are drawn larger, unless they are those of one motion among others."""
SHADES = "viridis"
LETTERS_PER_INCH, KEY, TITLE_LETTERS = 14.0, 6, 9
"""How many letters of a legend have room beside one another, how many a key takes, and how many of the title
have room in an inch."""
STEADY, AROUND = 1e-12, 0.1
"""A quantity that varies by less than this fraction is drawn as a line in the middle of a range of this
fraction."""
TICKS, TICKS_IN_SPACE, LETTERS_IN_SPACE = 7, 4, 18
"""Ticks along a horizontal axis, along the longest one in space, and the letters that have room beside it."""
MOST_ZEROS = 4
"""The least power of ten, or of a tenth, that is part of the name of an axis in space."""
SLIM, ZOOM, CORNER = 0.5, 0.95, 0.15
"""The shortest axis of a frame in space, as a part of the longest; how large the frame is, which leaves room
for labels; and the part of an axis without any, where another one ends."""
BELOW = 0.25
"""How much smaller a frame is for each part of its longest axis that x or y is shorter."""
PAD, DISTANCE = 1.6, 4.6
"""Points between the upright axis and its numbers, and its name, for each letter of a number."""
STEPS = [1, 2, 5, 10]
"""Their distances, up to powers of ten: those with few digits, so that labels do not run into each other."""


def draw(page: Page, suffix: str, creator: str = "", size: tuple[float, float] | None = None) -> bytes:
    """The picture of a page in the format ``suffix`` (.png, .svg, .pdf); ``size`` is in inches."""
    with styled():
        return rendered(figure_of(page, size), suffix, creator)


def figure_of(page: Page, size: tuple[float, float] | None = None) -> Figure:
    """The figure of a page."""
    from matplotlib.figure import Figure

    columns = 1 if len(page.panels) == 1 else 2
    rows = math.ceil(len(page.panels) / columns)
    across = 1.35 if columns == 1 else columns
    figure = Figure(figsize=size or (across * WIDTH, max(rows, 1.25) * HEIGHT), layout="constrained")
    title = textwrap.fill(page.title, round(TITLE_LETTERS * figure.get_figwidth()))
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold", parse_math=False)
    for number, panel in enumerate(page.panels):
        last = number == len(page.panels) - 1
        wide = last and number % columns == 0 and columns > 1 and not panel.z and not panel.equal
        place = (rows, columns, (number + 1, number + columns) if wide else number + 1)
        draw_panel(figure, panel, place)
    if page.note:
        figure.supxlabel(page.note, x=0.01, ha="left", fontsize=8, color="#555555", parse_math=False)
    return figure


def draw_panel(figure: Figure, panel: Panel, place: tuple[Any, ...]) -> None:
    """Draw one frame into its place."""
    panel = drawable(panel)
    axes: Any = figure.add_subplot(*place, projection="3d" if panel.z else None)
    axes.set_title(formula(panel.title), loc="left", fontsize=10)
    axes.set_xlabel(formula(panel.x))
    axes.set_ylabel(formula(panel.y))
    if panel.z:
        axes.set_zlabel(formula(panel.z), labelpad=9)
    for item in panel.items:
        if isinstance(item, Curve):
            draw_curve(axes, item)
        elif isinstance(item, Band):
            axes.fill_between(
                item.x, item.low, item.high, color=COLORS[item.color % len(COLORS)], alpha=0.2, lw=0,
                label=formula(item.label) or None,
            )  # fmt: skip
        elif isinstance(item, Map):
            mesh = axes.pcolormesh(
                item.x, item.y, item.values, shading="nearest", cmap=SHADES, rasterized=True
            )
            figure.colorbar(mesh, ax=axes, label=formula(item.label))
            axes.grid(visible=False)
        elif isinstance(item, Histogram):
            values = item.values[np.isfinite(item.values)]
            color = COLORS[item.color % len(COLORS)]
            axes.hist(
                values,
                bins="auto" if len(values) > 1 else 1,
                color=color,
                alpha=0.8,
                label=formula(item.label) or None,
            )
    if panel.z:
        frame_space(axes, panel.equal)
    elif "x" not in panel.logarithmic:
        axes.xaxis.get_major_locator().set_params(nbins=TICKS, steps=STEPS)
    if "x" in panel.logarithmic:
        axes.set_xscale("log")
    if "y" in panel.logarithmic:
        axes.set_yscale("log")
    if panel.equal and not panel.z:
        axes.set_aspect("equal", adjustable="datalim")
    if panel.scale is not None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize
        from matplotlib.ticker import MaxNLocator

        shades = ScalarMappable(Normalize(panel.scale.low, panel.scale.high), SHADES)
        ticks = MaxNLocator(nbins=TICKS, integer=True) if panel.scale.numbers else None
        figure.colorbar(shades, ax=axes, label=formula(panel.scale.label), ticks=ticks)
    if not panel.z:
        steady(axes, panel)
    handles, _ = axes.get_legend_handles_labels()
    if 1 < len(handles) <= MOST_LABELS or (handles and any(isinstance(one, Band) for one in panel.items)):
        draw_legend(axes, panel.title)


def draw_legend(axes: Any, title: str) -> None:
    """The names of curves: beside the title where they have room there, else where curves leave some."""
    _, labels = axes.get_legend_handles_labels()
    letters = 1.4 * len(plain(title)) + sum(len(plain(one)) + KEY for one in labels)
    look: dict[str, Any] = {"edgecolor": "none", "fontsize": 8}
    if letters <= LETTERS_PER_INCH * WIDTH and not hasattr(axes, "get_zlim"):
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
        axes.legend(ncols=len(labels), columnspacing=1.2, handlelength=1.5, frameon=False, **place, **look)
    else:
        beside = {"loc": "upper right", "bbox_to_anchor": (0.0, 0.95)} if hasattr(axes, "get_zlim") else {}
        axes.legend(framealpha=0.8, ncols=2 if len(labels) > 4 and not beside else 1, **beside, **look)


def steady(axes: Any, panel: Panel) -> None:
    """Show a quantity that is constant up to rounding as a constant, without its rounding errors."""
    curves = [one for one in panel.items if isinstance(one, Curve)]
    if len(curves) < len(panel.items):
        return
    for name, set_limits in (("x", axes.set_xlim), ("y", axes.set_ylim)):
        known = [values[np.isfinite(values)] for values in (getattr(one, name) for one in curves)]
        values = np.concatenate([np.empty(0), *known])
        if len(values) < 2 or name in panel.logarithmic:
            continue
        low, high = float(values.min()), float(values.max())
        size = max(abs(low), abs(high))
        if 0 < high - low <= STEADY * size:
            set_limits(low - AROUND * size, high + AROUND * size)


def frame_space(axes: Any, equal: bool) -> None:
    """A frame in space that is not too narrow for a narrow path, with as many ticks as have room."""
    named = (axes.xaxis, axes.yaxis, axes.zaxis)
    ranges = [axis.get_view_interval() for axis in named]
    longest = max(float(high - low) for low, high in ranges)
    axes.tick_params(labelsize=8, pad=1)
    spans = []
    for axis, (low, high), set_limits in zip(named, ranges, (axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        share = 1.0
        if equal:
            share = max((high - low) / longest, SLIM)
            middle, half = (low + high) / 2, share * longest / 2
            set_limits(middle - half, middle + half)
        spans.append(share)
        locator = axis.get_major_locator()
        locator.set_params(nbins=round(TICKS_IN_SPACE * share), steps=STEPS)
        shown = [float(one) for one in locator()]
        first, last = axis.get_view_interval()
        if axis is axes.yaxis:  # where it begins are the last numbers of x
            shown = [one for one in shown if first + CORNER * (last - first) < one <= last]
        room = math.inf if axis is axes.zaxis else LETTERS_IN_SPACE * share
        numbered(axis, [one for one in shown if first <= one <= last], room)
    tall = spans[2] / math.hypot(*spans)
    below = 1 - BELOW * (1 - min(spans[:2]))  # the name of a short axis is near the lowest corner
    axes.set_box_aspect(spans, zoom=ZOOM * below * min(1.0, 3**-0.5 / tall))  # not taller than a cube
    upright = axes.zaxis
    ticks = [one.get_text() for one in upright.get_ticklabels()]
    letters = max(map(len, ticks), default=0)
    upright.set_tick_params(pad=PAD * letters)
    upright.labelpad = DISTANCE * letters + 2


def numbered(axis: Any, ticks: list[float], room: float) -> None:
    """Number an axis in space at ``ticks``, or at every second one where their letters have no ``room``.
    A power of ten is part of the name of the axis, as beside that it would be in the way."""
    size = max(map(abs, ticks), default=0.0)
    power = math.floor(math.log10(size)) if size else 0
    if -MOST_ZEROS < power < MOST_ZEROS:
        power = 0
    else:
        name, _, unit = axis.get_label_text().removesuffix(")").partition(" (")
        axis.set_label_text(f"{name} ($10^{{{power}}}$ {unit})" if unit else f"{name} ($10^{{{power}}}$)")
    step = float(min(np.diff(ticks), default=size)) / 10.0**power
    digits = max(0, -math.floor(math.log10(step) + 1e-9)) if step else 0
    labels = [f"{one / 10.0**power + 0.0:.{digits}f}".replace("-", "\N{MINUS SIGN}") for one in ticks]
    if sum(map(len, labels)) > room:
        first = (len(ticks) + 1) % 2
        ticks, labels = ticks[first::2], labels[first::2]
    axis.set_ticks(ticks, labels)


def draw_curve(axes: Any, curve: Curve) -> None:
    """Draw a curve, paler where its values are not trusted."""
    from matplotlib import colormaps

    color: Any = COLORS[curve.color % len(COLORS)]
    if curve.shade is not None:
        color = colormaps[SHADES](curve.shade)
    look: dict[str, Any] = {"color": color, "rasterized": len(curve.x) > VECTORS}
    sparse = len(curve.x) <= SPARSE and curve.shade is None
    look |= (
        {"ls": "", "marker": ".", "ms": 7 if sparse else 2.5, "mew": 0}
        if curve.points
        else {"lw": 1.2 if curve.shade is None else 0.9}
    )
    count = len(curve.x) if curve.faded is None else max(curve.faded, 0)
    for part, alpha in ((slice(0, count), 1.0), (slice(max(count - 1, 0), None), FADED)):
        data = [each[part] for each in (curve.x, curve.y, curve.z) if each is not None]
        if len(data[0]) > (0 if alpha == 1.0 else 1) and (alpha == 1.0 or curve.faded is not None):
            label = curve.label if alpha == 1.0 or not count else ""
            axes.plot(*data, alpha=alpha, label=formula(label) or None, **look)
