"""Pages of plots as text, for a shell without pictures."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import MissingPackage
from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Page, Panel, drawable
from lagrange_cli.figures.style import plain

HEIGHT = 18
MOST_CURVES = 8
MOST_POINTS = 2000


def check_plotext(asked: str) -> None:
    """Raise ``MissingPackage`` where there is no plotext, which ``asked`` needs."""
    if importlib.util.find_spec("plotext") is None:
        raise MissingPackage(asked, "plotext", "plot")


def as_text(page: Page, width: int, *, colored: bool) -> str:
    """The panels below one another, ``width`` characters wide; no text of a file is a command of the
    terminal."""
    parts = [plain(page.title), *(panel_as_text(panel, width, colored=colored) for panel in page.panels)]
    return "\n".join([*parts, *([plain(page.note)] if page.note else [])])


def panel_as_text(panel: Panel, width: int, *, colored: bool) -> str:
    """One panel."""
    import plotext

    panel = drawable(panel)
    plotext.clear_figure()
    plotext.plotsize(width, HEIGHT)
    plotext.theme("clear")
    plotext.title(plain(panel.title))
    plotext.xlabel(plain(panel.x))
    plotext.ylabel(plain(panel.y))
    drawn = 0
    for item in panel.items:
        if isinstance(item, Curve) and drawn < MOST_CURVES:
            drawn += draw(plotext, item, panel.logarithmic)
        elif isinstance(item, Histogram):
            values = item.values[np.isfinite(item.values)]
            if len(values):
                plotext.hist(values.tolist(), 30)
                drawn += 1
        elif isinstance(item, Map):
            plotext.matrix_plot(np.nan_to_num(item.values[::-1]).tolist())
            drawn += 1
        elif isinstance(item, Band) and len(item.x) > 2:
            for edge in (item.low, item.high):
                drawn += draw(plotext, Curve(item.x, edge), "")
    label_ticks(plotext, panel)
    text: str = plotext.build()
    return text if colored else plotext.uncolorize(text)


def label_ticks(plotext: Any, panel: Panel) -> None:
    """Short numbers beside the frame, of curves of any size."""
    curves = [one.y for one in panel.items if isinstance(one, Curve) and np.isfinite(one.y).any()]
    if not curves or "y" in panel.logarithmic:
        return
    low, high = min(map(np.nanmin, curves)), max(map(np.nanmax, curves))
    if high > low:
        ticks, grain = np.linspace(low, high, 5).tolist(), (high - low) / 500
        plotext.yticks(ticks, [decimal(0.0 if abs(tick) < grain else tick, 3) for tick in ticks])


def draw(plotext: Any, curve: Curve, logarithmic: str) -> int:
    """Draw a curve, if there is anything of it; how many were drawn."""
    step = max(1, len(curve.x) // MOST_POINTS)
    x, y = curve.x[::step], curve.y[::step]
    if "y" in logarithmic:
        y = np.log10(np.where(y > 0, y, np.nan))
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return 0
    plot = plotext.scatter if curve.points else plotext.plot
    plot(x[known].tolist(), y[known].tolist(), label=plain(curve.label) or None)
    return 1
