"""Pages of plots as figures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Page, Panel
from lagrange_cli.figures.style import COLORS, STYLE, rendered

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 5.2, 3.1
"""Of a panel, in inches."""
FADED = 0.25
"""How opaque a curve is where its values are not trusted."""
MOST_LABELS = 8
VECTORS = 20_000
"""A curve of more points is a picture within the file, so that this stays small."""
SHADES = "viridis"
TICKS, TICKS_IN_SPACE = 7, 4
"""Ticks along a horizontal axis, and along the longest one in space."""
STEPS = [1, 2, 5, 10]
"""Their distances, up to powers of ten: those with few digits, so that labels do not run into each other."""


def draw(page: Page, suffix: str, creator: str = "", size: tuple[float, float] | None = None) -> bytes:
    """The picture of a page in the format ``suffix`` (.png, .svg, .pdf); ``size`` is in inches."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        return rendered(figure_of(page, size), suffix, creator)


def figure_of(page: Page, size: tuple[float, float] | None = None) -> Figure:
    """The figure of a page."""
    from matplotlib.figure import Figure

    columns = 1 if len(page.panels) == 1 else 2
    rows = math.ceil(len(page.panels) / columns)
    across = 1.35 if columns == 1 else columns
    figure = Figure(figsize=size or (across * WIDTH, max(rows, 1.25) * HEIGHT), layout="constrained")
    figure.suptitle(page.title, x=0.01, ha="left", fontweight="bold", parse_math=False)
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
    axes: Any = figure.add_subplot(*place, projection="3d" if panel.z else None)
    axes.set_title(panel.title, loc="left", fontsize=10, parse_math=False)
    axes.set_xlabel(panel.x)
    axes.set_ylabel(panel.y)
    if panel.z:
        axes.set_zlabel(panel.z)
    for item in panel.items:
        if isinstance(item, Curve):
            draw_curve(axes, item)
        elif isinstance(item, Band):
            axes.fill_between(
                item.x, item.low, item.high, color=COLORS[item.color % len(COLORS)], alpha=0.2, lw=0,
                label=item.label or None,
            )  # fmt: skip
        elif isinstance(item, Map):
            mesh = axes.pcolormesh(
                item.x, item.y, item.values, shading="nearest", cmap=SHADES, rasterized=True
            )
            figure.colorbar(mesh, ax=axes, label=item.label)
            axes.grid(visible=False)
        elif isinstance(item, Histogram):
            values = item.values[np.isfinite(item.values)]
            color = COLORS[item.color % len(COLORS)]
            axes.hist(
                values,
                bins="auto" if len(values) > 1 else 1,
                color=color,
                alpha=0.8,
                label=item.label or None,
            )
    if panel.z:
        sparse_ticks(axes, panel.equal)
    elif "x" not in panel.logarithmic:
        axes.xaxis.get_major_locator().set_params(nbins=TICKS, steps=STEPS)
    if "x" in panel.logarithmic:
        axes.set_xscale("log")
    if "y" in panel.logarithmic:
        axes.set_yscale("log")
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim" if not panel.z else "box")
    if panel.scale is not None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize
        from matplotlib.ticker import MaxNLocator

        shades = ScalarMappable(Normalize(panel.scale.low, panel.scale.high), SHADES)
        ticks = MaxNLocator(nbins=TICKS, integer=True) if panel.scale.numbers else None
        figure.colorbar(shades, ax=axes, label=panel.scale.label, ticks=ticks)
    handles, _ = axes.get_legend_handles_labels()
    if 1 < len(handles) <= MOST_LABELS or (handles and any(isinstance(one, Band) for one in panel.items)):
        axes.legend(
            frameon=True, framealpha=0.8, edgecolor="none", fontsize=8, ncols=2 if len(handles) > 4 else 1
        )


def sparse_ticks(axes: Any, equal: bool) -> None:
    """As many ticks as have room along each axis in space; one, in the middle, where it is short."""
    named = (axes.xaxis, axes.yaxis, axes.zaxis)
    ranges = [axis.get_view_interval() for axis in named]
    spans = [float(high - low) for low, high in ranges]
    for axis, span, (low, high) in zip(named, spans, ranges):
        count = int(TICKS_IN_SPACE * (span / max(spans) if equal else 1))
        if count:
            axis.get_major_locator().set_params(nbins=count, steps=STEPS)
        else:
            middle = rounded_middle(low, high)
            axis.set_ticks([middle], [f"{middle:g}"])


def rounded_middle(low: float, high: float) -> float:
    """About the middle of a range, with no more digits than tell a tenth of it."""
    middle = (low + high) / 2
    if not high > low:
        return middle
    return round(middle, 1 - math.floor(math.log10(high - low))) + 0.0  # not -0


def draw_curve(axes: Any, curve: Curve) -> None:
    """Draw a curve, paler where its values are not trusted."""
    from matplotlib import colormaps

    color: Any = COLORS[curve.color % len(COLORS)]
    if curve.shade is not None:
        color = colormaps[SHADES](curve.shade)
    look: dict[str, Any] = {"color": color, "rasterized": len(curve.x) > VECTORS}
    look |= (
        {"ls": "", "marker": ".", "ms": 2.5, "mew": 0}
        if curve.points
        else {"lw": 1.2 if curve.shade is None else 0.9}
    )
    count = len(curve.x) if curve.faded is None else max(curve.faded, 0)
    for part, alpha in ((slice(0, count), 1.0), (slice(max(count - 1, 0), None), FADED)):
        data = [each[part] for each in (curve.x, curve.y, curve.z) if each is not None]
        if len(data[0]) > (0 if alpha == 1.0 else 1) and (alpha == 1.0 or curve.faded is not None):
            label = curve.label if alpha == 1.0 or not count else ""
            axes.plot(*data, alpha=alpha, label=label or None, **look)
