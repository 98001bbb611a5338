"""The panels of sweeps: families of curves, bands of quantiles, maps over two parameters, histograms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.errors import UsageError
from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Panel, Scale, finite
from lagrange_cli.records import dataclass
from lagrange_cli.run.plots.motions import MOST_PHASES, Run, What
from lagrange_cli.run.plots.quantities import Quantity, with_unit

MOST_CURVES = 60
"""More random members than this are drawn as bands of quantiles."""
MOST_MEMBERS, MOST_TIMES = 2000, 800
"""What a band or a family of curves is drawn from."""
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True)
class Axis:
    """A swept parameter: its symbol, its label and its values."""

    symbol: str
    label: str
    values: np.ndarray


def shape_of(run: Run) -> tuple[int, ...]:
    """How the members are arranged."""
    return run.result.held["member"].shape


def swept(run: Run) -> list[Axis]:
    """The parameters of a grid; none where members are random or from a table."""
    found = []
    for name in run.result.held["member"].axes:
        held = run.result.held.get(name)
        if held is None or name == "member" or len(held.shape) != 1:
            return []
        label = Quantity(name.removesuffix("_0") if name.endswith("_0") else name, name, (), held.unit)
        values = run.result.read(name)
        if values.dtype.kind not in "fiu":
            return []
        start = f"{label.symbol.strip('$')}(0)" if name.endswith("_0") else label.symbol.strip("$")
        found.append(Axis(f"${start}$", with_unit(f"${start}$", held.unit), values.astype(float)))
    return found


def timed(run: Run, one: Quantity) -> bool:
    """Whether a quantity has samples over time."""
    return "t" in run.result.held[one.path].axes


def member_rows(run: Run, one: Quantity, most: int) -> Iterator[tuple[tuple[int, ...], np.ndarray]]:
    """Some members, evenly chosen, with their samples at some times."""
    shape = shape_of(run)
    count = int(np.prod(shape))
    step = max(1, -(-run.result.held["t"].shape[0] // MOST_TIMES))
    for flat in range(0, count, max(1, -(-count // most))):
        member = tuple(int(k) for k in np.unravel_index(flat, shape))
        yield member, run.result.read(one.path, (*member, slice(None), *one.index))[::step]


def times_of(run: Run) -> np.ndarray:
    """The times of those samples."""
    step = max(1, -(-run.result.held["t"].shape[0] // MOST_TIMES))
    return run.result.read("t")[::step]


def families(runs: Sequence[Run], folder: str) -> list[Panel]:
    """A curve for each member, or bands if there are many and no grid has made them."""
    found = []
    for run in runs:
        for one in run.of(folder)[:MOST_PHASES]:
            if timed(run, one):
                count = int(np.prod(shape_of(run)))
                found.append(bands(run, one) if not swept(run) and count > MOST_CURVES else family(run, one))
    return found


def family(run: Run, one: Quantity) -> Panel:
    """The curves of members, shaded by the first swept parameter."""
    axes, times = swept(run), times_of(run)
    shades = axes[0].values if axes else np.arange(shape_of(run)[0], dtype=float)
    low, high = float(np.nanmin(shades)), float(np.nanmax(shades))
    curves = []
    for member, x in member_rows(run, one, 4 * MOST_CURVES):
        shade = (float(shades[member[0]]) - low) / (high - low) if high > low else 0.5
        curves.append(Curve(times, finite(x), shade=shade))
    scale = Scale(axes[0].label if axes else "member", low, high) if high > low else None
    t = with_unit("$t$", run.time.unit)
    return Panel(f"{one.symbol} of each member", t, one.label, tuple(curves), scale=scale)


def bands(run: Run, one: Quantity) -> Panel:
    """Quantiles of the members over time."""
    rows = np.array([x for _, x in member_rows(run, one, MOST_MEMBERS)])
    times = times_of(run)
    known = np.isfinite(rows).any(axis=0)
    levels = np.full((len(QUANTILES), rows.shape[1]), np.nan)
    levels[:, known] = np.nanquantile(rows[:, known], QUANTILES, axis=0)
    t = with_unit("$t$", run.time.unit)
    items = (
        Band(times, levels[0], levels[4], 0, "90 % of the members"),
        Band(times, levels[1], levels[3], 0, "50 %"),
        Curve(times, levels[2], "median"),
    )
    return Panel(f"{one.symbol}: quantiles of {len(rows)} members", t, one.label, items)


def at_end(run: Run, one: Quantity) -> np.ndarray:
    """The last value of each member, in the shape of the sweep: that at the event which stopped it, if the
    file has it, else that of its last sample."""
    if not timed(run, one):
        part = (*(slice(None) for _ in shape_of(run)), *one.index)
        return np.asarray(run.result.read(one.path, part), float)
    shape = shape_of(run)
    found = np.full(shape, np.nan)
    for flat in range(int(np.prod(shape))):
        member = tuple(int(k) for k in np.unravel_index(flat, shape))
        x = run.result.read(one.path, (*member, slice(None), *one.index))
        known = np.flatnonzero(np.isfinite(x))
        found[member] = x[known[-1]] if len(known) else np.nan
    set_where_stopped(run, one, found.reshape(-1))
    return found


def set_where_stopped(run: Run, one: Quantity, found: np.ndarray) -> None:
    """Put the values at the events that stopped members in place of those of their last samples."""
    ends, status = (run.result.read(name).reshape(-1) for name in ("t_end", "status"))
    for times in (path for path in run.result.held if path.startswith("events/") and path.endswith("/t")):
        folder = times.removesuffix("t")
        if f"{folder}{one.path}" in run.result.held:
            members = run.result.read(f"{folder}member")
            last = (run.result.read(times) == ends[members]) & (status[members] == "stopped")
            found[members[last]] = run.result.read(f"{folder}{one.path}", (slice(None), *one.index))[last]


def over_members(run: Run, values: np.ndarray, title: str, label: str, logarithmic: bool = False) -> Panel:
    """A number of each member: over one swept parameter, as a map over two, else as a histogram."""
    axes = swept(run)
    if len(axes) == 1:
        zeros = logarithmic and not np.all(values > 0)  # which a line would come down to from its neighbours
        shown = np.where(values > 0, values, np.nan) if zeros else values
        curve = Curve(axes[0].values, finite(shown), points=len(values) > 200 or zeros)
        return Panel(title, axes[0].label, label, (curve,), logarithmic="y" if logarithmic else "")
    if len(axes) == 2:
        shown = np.log10(np.where(values > 0, values, np.nan)) if logarithmic else finite(values)
        name = f"$\\log_{{10}}$ of {label}" if logarithmic else label
        return Panel(title, axes[1].label, axes[0].label, (Map(axes[1].values, axes[0].values, shown, name),))
    flat = np.asarray(values, float).reshape(-1)
    if logarithmic:
        flat = np.log10(np.where(flat > 0, flat, np.nan))
    name = f"$\\log_{{10}}$ of {label}" if logarithmic else label
    return Panel(title, name, "members", (Histogram(flat),))


def final(runs: Sequence[Run]) -> list[Panel]:
    """The final values of the coordinates."""
    return [
        over_members(run, at_end(run, one), f"{one.symbol} at the end", one.label)
        for run in runs
        for one in run.of("q/")[:MOST_PHASES]
    ]


def drift(runs: Sequence[Run]) -> list[Panel]:
    """The largest drift of each conserved quantity, for each member."""
    found = []
    for run in runs:
        for name, path in run.result.within("diagnostics/drift/").items():
            held = run.result.held[path]
            if held.shape == shape_of(run):
                values = np.asarray(run.result.read(path), float)
                title = f"drift of {Quantity(name.replace('/', '_'), path, (), held.unit).symbol}"
                logarithmic = bool((values > 0).any())
                label = with_unit(title, held.unit)
                found.append(over_members(run, values, title, label, logarithmic))
    return found


def folder_of(path: str) -> What:
    """The families of curves of a folder."""
    name = path.rstrip("/").rpartition("/")[2]
    return What(lambda runs: families(runs, path), (name,), f"{name} of each member over time")


WHAT = {
    "q": folder_of("q/"),
    "v": folder_of("v/"),
    "p": folder_of("diagnostics/p/"),
    "positions": folder_of("positions/"),
    "observables": folder_of("observables/"),
    "final": What(final, ("q",), "the coordinates at the end of each member"),
    "drift": What(drift, ("h",), "the drift of what is conserved, of each member"),
}
"""The words of ``--what`` for a sweep."""
USUAL = ("q", "final", "drift")


def across_members(run: Run, x: str, y: str) -> Panel:
    """One quantity over another, for each member."""
    one, other = run.known[x], run.known[y]
    if x == "t" and timed(run, other):
        return family(run, other)
    if timed(run, one) != timed(run, other):
        raise UsageError(f"{x} and {y} have different numbers of samples in {run.result.name}")
    if not timed(run, one):
        curve = Curve(at_end(run, one).reshape(-1), at_end(run, other).reshape(-1), points=True)
        return Panel("at the end of each member", one.label, other.label, (curve,))
    axes = swept(run)
    shades = axes[0].values if axes else np.arange(shape_of(run)[0], dtype=float)
    low, high = float(np.nanmin(shades)), float(np.nanmax(shades))
    curves = [
        Curve(finite(a), finite(b), shade=(float(shades[m[0]]) - low) / (high - low) if high > low else 0.5)
        for (m, a), (_, b) in zip(member_rows(run, one, MOST_CURVES), member_rows(run, other, MOST_CURVES))
    ]
    scale = Scale(axes[0].label if axes else "member", low, high) if high > low else None
    return Panel("members", one.label, other.label, tuple(curves), scale=scale)
