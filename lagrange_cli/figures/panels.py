"""What a page of plots shows, as data: panels with curves, bands, maps and histograms."""

from __future__ import annotations

from typing import Any

import numpy as np

from lagrange_cli.records import dataclass, replace

Array = np.ndarray
LARGEST = 1e300
"""The largest number that is drawn."""


@dataclass(frozen=True)
class Curve:
    """y (and z) over x, as a line or, with ``points``, as points. It fades from sample ``faded`` on. Its
    colour is the one with the number ``color``, or with ``shade`` (0 to 1) one of a continuous scale."""

    x: Array
    y: Array
    label: str = ""
    color: int = 0
    z: Array | None = None
    faded: int | None = None
    shade: float | None = None
    points: bool = False


@dataclass(frozen=True)
class Band:
    """The area between ``low`` and ``high`` over x."""

    x: Array
    low: Array
    high: Array
    color: int = 0
    label: str = ""


@dataclass(frozen=True)
class Map:
    """Values (rows, columns) over a grid x (columns) and y (rows)."""

    x: Array
    y: Array
    values: Array
    label: str


@dataclass(frozen=True)
class Histogram:
    """A histogram of values."""

    values: Array
    label: str = ""
    color: int = 0


@dataclass(frozen=True)
class Scale:
    """What the shades of curves stand for: a quantity from ``low`` to ``high``, or ``numbers`` of curves."""

    label: str
    low: float
    high: float
    numbers: bool = False


@dataclass(frozen=True)
class Panel:
    """One frame. ``title`` and the labels of the axes may hold formulas. With ``equal`` a length is the same
    along both axes, ``logarithmic`` names the axes ("x", "y", "xy") that are."""

    title: str
    x: str
    y: str
    items: tuple[Curve | Band | Map | Histogram, ...]
    z: str = ""
    equal: bool = False
    logarithmic: str = ""
    scale: Scale | None = None


@dataclass(frozen=True)
class Page:
    """Panels below and beside one another; ``title`` and ``note`` are plain text."""

    title: str
    panels: tuple[Panel, ...]
    note: str = ""


def finite(values: Any) -> Array:
    """An array with nan in place of what is not finite, or so large that a range of it is not: that is not
    drawn."""
    found = np.asarray(values, float)
    return np.where(np.abs(found) <= LARGEST, found, np.nan)


def drawable(panel: Panel) -> Panel:
    """A panel all of whose numbers can be drawn."""
    return replace(panel, items=tuple(map(_drawable, panel.items)))


def _drawable(item: Any) -> Any:
    names = ("values",) if isinstance(item, (Map, Histogram)) else ("x", "y", "z", "low", "high")
    given = {name: one for name in names if (one := getattr(item, name, None)) is not None}
    return replace(item, **{name: finite(one) for name, one in given.items()})
