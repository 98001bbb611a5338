"""The panels of sections: the crossings as points in the planes of coordinates and velocities.

Colours distinguish those of many motions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.figures.panels import Curve, Panel, Scale, finite
from lagrange_cli.records import replace
from lagrange_cli.run.plots import motions, sweeps
from lagrange_cli.run.plots.motions import MOST_PHASES, Run, What, dotted, drift
from lagrange_cli.run.plots.quantities import Quantity
from lagrange_cli.run.plots.reading import POINTS
from lagrange_cli.run.plots.sweeps import shape_of, swept

MOST_MEMBERS, SEEN = 2000, 50
"""Motions whose crossings are drawn, evenly chosen; and motions that show which coordinates vary."""


def crossings(runs: Sequence[Run]) -> list[Panel]:
    """Velocity over coordinate at the crossings, for each coordinate that the section does not fix."""
    names = [one.name for one in runs[0].of("q/") if dotted(one.name) in runs[0].known]
    ranges = {name: extent(runs[0], name) for name in names}
    most = max(ranges.values(), default=0.0)
    varying = [name for name in names if ranges[name] > 1e-9 * most] or names
    return [
        wrapped(across(runs, name, dotted(name), f"section, {runs[0].known[name].symbol}"))
        for name in varying[:MOST_PHASES]
    ]


def many(run: Run) -> bool:
    """Whether it is a section of many motions."""
    return "member" in run.result.held


def chosen(run: Run, most: int) -> list[tuple[int, ...]]:
    """Some of the members, evenly chosen, by their place in the sweep."""
    shape = shape_of(run)
    count = int(np.prod(shape))
    places = range(0, count, max(1, -(-count // most)))
    return [tuple(int(k) for k in np.unravel_index(flat, shape)) for flat in places]


def of_member(run: Run, one: Quantity, member: tuple[int, ...], most: int) -> np.ndarray:
    """Its first crossings."""
    return finite(run.result.read(one.path, (*member, slice(0, most), *one.index)))


def extent(run: Run, name: str) -> float:
    """How much a coordinate varies over the first crossings."""
    one = run.known[name]
    members = chosen(run, SEEN) if many(run) else [()]
    values = np.concatenate([of_member(run, one, member, 1000) for member in members])
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def across(runs: Sequence[Run], x: str, y: str, title: str) -> Panel:
    """One quantity over another at the crossings; members are shaded by the first parameter that differs."""
    if not any(map(many, runs)):
        return motions.across(runs, x, y, title)
    curves: list[Curve] = []
    label, low, high = "member", 0.0, 0.0
    for number, run in enumerate(runs):
        if not many(run):
            curves += motions.across([run], x, y, title).items  # type: ignore[arg-type]
            continue
        members, axes = chosen(run, MOST_MEMBERS), swept(run)
        own = axes[0].values if axes else np.arange(shape_of(run)[0], dtype=float)
        label, low, high = axes[0].label if axes else "member", float(np.min(own)), float(np.max(own))
        most = max(1, POINTS // len(members))
        for member in members:
            a, b = (of_member(run, run.known[name], member, most) for name in (x, y))
            shade = (float(own[member[0]]) - low) / (high - low) if high > low else 0.5
            curves.append(Curve(a, b, "", number, shade=shade, points=True))
    first = runs[0]
    scale = Scale(label, low, high) if high > low else None
    return Panel(title, first.known[x].label, first.known[y].label, tuple(curves), scale=scale)


def over(runs: Sequence[Run], title: str, folder: str) -> list[Panel]:
    """The datasets of a folder at the crossings, over time."""
    if not any(map(many, runs)):
        return motions.over(runs, title, folder)
    names = [one.name for one in runs[0].of(folder)]
    return [across(runs, "t", name, f"{name} at the crossings") for name in names[:MOST_PHASES]]


def diagram(runs: Sequence[Run]) -> list[Panel]:
    """Coordinates at the crossings over the swept parameter, which show where periods double."""
    panels = []
    for run in runs:
        axes = swept(run) if many(run) else []
        if len(axes) != 1:
            continue
        members = chosen(run, MOST_MEMBERS)
        most = max(1, POINTS // len(members))
        for one in run.of("q/")[:MOST_PHASES]:
            rows = [of_member(run, one, member, most) for member in members]
            x = np.concatenate([np.full(len(row), axes[0].values[m[0]]) for m, row in zip(members, rows)])
            points = Curve(x, np.concatenate(rows), points=True)
            panel = Panel(f"crossings over {axes[0].symbol}", axes[0].label, one.label, (points,))
            panels.append(wrapped(panel, "y"))
    return panels


def wrapped(panel: Panel, axis: str = "x") -> Panel:
    """An angle along an axis that turns round many times, as one between -pi and pi."""
    curves = [one for one in panel.items if isinstance(one, Curve)]
    label, farthest = getattr(panel, axis), 0.0
    for one in curves:
        values = getattr(one, axis)
        farthest = max(farthest, float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)))
    if "(rad)" not in label or farthest <= 2 * np.pi:
        return panel
    items = tuple(
        replace(one, **{axis: (getattr(one, axis) + np.pi) % (2 * np.pi) - np.pi}) for one in curves
    )
    turned = label.replace("(rad)", "mod 2\N{GREEK SMALL LETTER PI} (rad)")
    return replace(panel, items=items, **{axis: turned})


def drifts(runs: Sequence[Run]) -> list[Panel]:
    """The drift of conserved quantities: of one motion over time, of many over the members."""
    single, several = [run for run in runs if not many(run)], [run for run in runs if many(run)]
    return [*(drift(single) if single else []), *(sweeps.drift(several) if several else [])]


WHAT = {
    "phase": What(crossings, ("q", "v"), "velocity over coordinate at the crossings"),
    "q": What(lambda runs: over(runs, "coordinates at the crossings", "q/"), ("q",), "coordinates over time"),
    "v": What(lambda runs: over(runs, "velocities at the crossings", "v/"), ("v",), "velocities over time"),
    "p": What(
        lambda runs: over(runs, "momenta at the crossings", "diagnostics/p/"), ("p",), "momenta over time"
    ),
    "diagram": What(diagram, ("q",), "coordinates at the crossings over the swept parameter"),
    "drift": What(drifts, ("h",), "the drift of what is conserved"),
}
"""The words of ``--what`` for a section."""
USUAL = ("phase",)
