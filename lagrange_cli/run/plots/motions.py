"""The panels of motions: over time, in phase space, in space, drifts, spectra."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from lagrange_cli.errors import UsageError
from lagrange_cli.figures.panels import Band, Curve, Panel, Scale, finite
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.plots.paths import in_space, standing
from lagrange_cli.run.plots.quantities import Quantity, quantities, unit_text, with_unit
from lagrange_cli.run.plots.reading import extremes, over_time, rows_of, together
from lagrange_cli.store.result import Result

MOST_CURVES = 8
"""Curves of a panel that have colours and names of their own; more are shaded by their number."""
MOST_SHADED = 200
MOST_PATHS = 1000
MOST_PHASES = 4
ROUNDING = {"double-double": 2.0**-104}
LONGEST_SPECTRUM = 2**22


@dataclass(frozen=True)
class Run:
    """A result with its quantities by name, and what tells it from other runs in the same plot."""

    result: Result
    known: dict[str, Quantity]
    label: str = ""

    def of(self, folder: str) -> list[Quantity]:
        """The quantities of a folder, coordinates in the order of the system file."""
        found = [one for one in self.known.values() if one.path.startswith(folder)]
        return sorted(found, key=lambda one: self.ranks.get(one.path.removeprefix(folder), 0))

    @cached_property
    def ranks(self) -> dict[str, int]:
        """The place of each coordinate in the system file, as the final state has them."""
        try:
            final = json.loads(str(self.result.attributes.get("final", "null")))
            names = [name.partition("[")[0] for name in final["q"]]
        except (ValueError, TypeError, KeyError, AttributeError):
            names = []
        return {name: rank for rank, name in enumerate(dict.fromkeys(names))}

    @property
    def time(self) -> Quantity:
        """The time of the samples; raises ``UsageError`` where there is none."""
        if "t" not in self.known:
            raise UsageError(f"{self.result.name} has no samples: solve again with --outputs q,v")
        return self.known["t"]

    @property
    def trusted_until(self) -> float | None:
        """The time up to which digits can be trusted, where an error was estimated."""
        found = self.result.attributes.get("trusted_until")
        return float(found) if isinstance(found, (int, float)) else None

    def faded(self, times: np.ndarray) -> int | None:
        """From which of the samples on the motion is not trusted."""
        if self.trusted_until is None:
            return None
        beyond = np.flatnonzero(times > self.trusted_until)
        return int(beyond[0]) if len(beyond) else None


def opened(result: Result, label: str = "") -> Run:
    """A result with its quantities."""
    return Run(result, quantities(result), label)


def over(runs: Sequence[Run], title: str, folder: str) -> list[Panel]:
    """The datasets of a folder over time: a panel for each unit."""
    units: dict[str, list[tuple[Run, Quantity]]] = {}
    for run in runs:
        for one in run.of(folder):
            units.setdefault(one.unit, []).append((run, one))
    return [panel_over_time(title, pairs) for pairs in units.values()]


def panel_over_time(title: str, pairs: Sequence[tuple[Run, Quantity]], logarithmic: str = "") -> Panel:
    """Quantities of one unit over time; many of them are shaded by their number."""
    count = len(pairs)
    many = count > MOST_CURVES
    curves, drawn = [], pairs[:: -(-count // MOST_SHADED)] if many else pairs
    read = {
        key: iter(over_time(run.result, run.time, [one for each, one in drawn if each is run]))
        for key, run in {id(run): run for run, _ in drawn}.items()
    }
    for number, (run, one) in enumerate(drawn):
        t, x = next(read[id(run)])
        label = " ".join(part for part in (run.label, one.symbol) if part)
        shade = number / max(min(count, MOST_SHADED) - 1, 1) if many else None
        curves.append(Curve(t, finite(x), "" if many else label, number, None, run.faded(t), shade))
    first = pairs[0][1]
    label = first.label if count == 1 or len({one.name for _, one in pairs}) == 1 else unit_text(first.unit)
    if many and label == unit_text(first.unit):
        label = with_unit(f"{pairs[0][1].symbol} ... {pairs[-1][1].symbol}", first.unit)
    scale = Scale("number", 0.0, float(count - 1), numbers=True) if many else None
    x_label = with_unit("$t$", pairs[0][0].time.unit)
    return Panel(title, x_label, label, tuple(curves), logarithmic=logarithmic, scale=scale)


def phase(runs: Sequence[Run]) -> list[Panel]:
    """Velocities over coordinates, of the runs that have them."""
    found = {one.name: one for run in runs for one in run.of("q/") if dotted(one.name) in run.known}
    return [
        across(runs, name, dotted(name), f"phase portrait of {one.symbol}")
        for name, one in list(found.items())[:MOST_PHASES]
    ]


def dotted(name: str) -> str:
    """The name of the velocity of a coordinate."""
    base, bracket, index = name.partition("[")
    return f"{base}_dot{bracket}{index}"


def across(runs: Iterable[Run], x: str, y: str, title: str) -> Panel:
    """One quantity over another, of the runs that have both."""
    curves, labels = [], ("", "")
    for number, run in enumerate(runs):
        if not {x, y} <= run.known.keys():
            continue
        one, other = run.known[x], run.known[y]
        if rows_of(run.result, one) != rows_of(run.result, other):
            raise UsageError(f"{x} and {y} have different numbers of samples in {run.result.name}")
        times = run.known.get("t")
        wanted = [one, other, *([times] if times and run.result.kind == "motion" else [])]
        (a, b, *t), _ = together(run.result, wanted)
        faded = run.faded(t[0]) if t else None
        points = run.result.kind == "section"
        curves.append(Curve(finite(a), finite(b), run.label, number, None, faded, points=points))
        labels = one.label, other.label
    return Panel(title, labels[0], labels[1], tuple(curves))


def path(runs: Sequence[Run]) -> list[Panel]:
    """The particles' paths in space."""
    found = [(run, label, parts) for run in runs for label, parts in particles(run).items()]
    if not found:
        return []
    drawn = found[:: -(-len(found) // MOST_PATHS)]
    dimensions = max(len(parts) for _, _, parts in drawn)
    unit = drawn[-1][2][0].unit
    curves: list[Curve] = []
    for run in runs:
        mine = [(label, parts) for each, label, parts in drawn if each is run]
        wanted = [run.time, *(one for _, parts in mine for one in parts)]
        (t, *values), _ = together(run.result, wanted)
        rest, faded = iter(values), run.faded(t)
        for label, parts in mine:
            r = [next(rest) for _ in parts]
            first, second = (r[0], r[1]) if len(r) > 1 else (t, r[0])
            third = finite(r[2]) if len(r) > 2 else None
            named = " ".join(part for part in (run.label, plain(label)) if part)
            curves.append(Curve(finite(first), finite(second), named, len(curves), third, faded))
    if len(found) > MOST_CURVES:
        shades = np.linspace(0, 1, len(curves))
        curves = [replace(one, label="", shade=float(s)) for one, s in zip(curves, shades)]
    if dimensions == 1:
        time = with_unit("$t$", runs[0].time.unit)
        return [Panel("positions", time, with_unit("$x$", unit), tuple(curves))]
    return [in_space(standing(curves), [with_unit(f"${axis}$", unit) for axis in "xyz"])]


def particles(run: Run) -> dict[str, list[Quantity]]:
    """The components of the positions that the run has, by particle."""
    found: dict[str, list[Quantity]] = {}
    for one in run.of("positions/"):
        found.setdefault(one.name.rpartition(".")[0], []).append(one)
    return found


def plain(name: str) -> str:
    """A name of a user's as text of a label, and no formula."""
    return name.replace("$", r"\$")


def drift(runs: Sequence[Run]) -> list[Panel]:
    """The drift of each conserved quantity from its first value, beside its rounding error."""
    found: dict[str, Panel] = {}
    for number, run in enumerate(runs):
        rounding = ROUNDING.get(str(run.result.attributes.get("precision")), 2.0**-52)
        for one in conserved(run):
            ((t, x),) = over_time(run.result, run.time, [one])
            if not len(t):  # the motion has no sample, as one that ends where it begins
                continue
            first, largest = extremes(run.result, one)
            if one.name == "h":
                largest = max(
                    [largest, *(extremes(run.result, run.known[k])[1] for k in "TU" if k in run.known)]
                )
            moved = finite(x) - first
            curve = Curve(t, moved, run.label, number, None, run.faded(t))
            grain = rounding * largest
            band = Band(t[[0, -1]], np.full(2, -grain), np.full(2, grain), 6, "one unit of rounding")
            symbol = one.symbol.strip("$")
            before = found.get(one.name)
            items = before.items if before else (*([band] if largest else []),)
            label = with_unit(f"${symbol} - {symbol}(0)$", one.unit)
            x_label = with_unit("$t$", run.time.unit)
            found[one.name] = Panel(f"drift of {one.symbol}", x_label, label, (*items, curve))
    return list(found.values())


def conserved(run: Run) -> list[Quantity]:
    """The conserved quantities that the run has written."""
    told = run.result.attributes
    names = ["h"] if number(told.get("h_drift")) else []
    try:
        drifts = json.loads(str(told.get("p_drift", "{}")))
    except ValueError:
        drifts = {}
    names += [f"p_{name}" for name, found in drifts.items() if number(found)]
    others = [one.name for one in run.of("diagnostics/conserved/") if one.name not in (*names, "h")]
    return [run.known[name] for name in (*names, *others) if name in run.known]


def number(value: Any) -> bool:
    """Whether there is such a drift."""
    return isinstance(value, (int, float)) and not np.isnan(value)


def energy(runs: Sequence[Run]) -> list[Panel]:
    """T, U, their sum and h."""
    pairs = [
        (run, run.known[name]) for run in runs for name in ("T", "U", "energy", "h") if name in run.known
    ]
    return [panel_over_time("energies", pairs)] if pairs else []


def scalar(name: str) -> Callable[[Sequence[Run]], list[Panel]]:
    """The panel of one quantity over time."""

    def panels(runs: Sequence[Run]) -> list[Panel]:
        pairs = [(run, run.known[name]) for run in runs if name in run.known]
        return [panel_over_time(name, pairs)] if pairs else []

    return panels


def error(runs: Sequence[Run]) -> list[Panel]:
    """The estimated errors of coordinates and velocities, on a logarithmic scale."""
    units: dict[str, list[tuple[Run, Quantity]]] = {}
    for run in runs:
        for one in run.of("diagnostics/error/"):
            units.setdefault(one.unit, []).append((run, one))
    return [panel_over_time("estimated error", pairs, "y") for pairs in units.values()]


def spectrum(runs: Sequence[Run]) -> list[Panel]:
    """Amplitudes of the coordinates over frequency, through a Hann window."""
    curves: list[Curve] = []
    unit = ""
    for run in runs:
        unit = run.time.unit
        (t,), _ = together(run.result, [run.time])
        if len(t) < 8:
            raise UsageError(f"{run.result.name} has {len(t)} samples, too few for a spectrum")
        count = min(rows_of(run.result, run.time), LONGEST_SPECTRUM)
        steps = np.diff(run.result.read("t", slice(0, count)))
        usual = float(np.median(steps))
        even = int(np.argmin(np.append(np.abs(steps - usual) <= 1e-6 * abs(usual), False))) + 1
        window = np.hanning(even)
        frequencies = np.fft.rfftfreq(even, abs(usual))
        for one in run.of("q/")[:MOST_CURVES]:
            x = run.result.read(one.path, (slice(0, even), *one.index))
            amplitude = 2 * np.abs(np.fft.rfft((x - x.mean()) * window)) / window.sum()
            label = " ".join(part for part in (run.label, one.symbol) if part)
            curves.append(
                Curve(frequencies[1:], np.where(amplitude > 0, amplitude, np.nan)[1:], label, len(curves))
            )
    frequency = f"frequency (1/{unit_text(unit)})" if unit else "frequency"
    return [Panel("spectrum", frequency, "amplitude", tuple(curves), logarithmic="y")] if curves else []


@dataclass(frozen=True)
class What:
    """A word of ``--what``: how its panels are made, and the ``outputs`` that they need."""

    panels: Callable[[Sequence[Run]], list[Panel]]
    outputs: tuple[str, ...]
    meaning: str


def folder(title: str, path: str) -> Callable[[Sequence[Run]], list[Panel]]:
    """The panels of what lies in a folder."""
    return lambda runs: over(runs, title, path)


WHAT = {
    "q": What(folder("coordinates", "q/"), ("q",), "the coordinates over time"),
    "v": What(folder("velocities", "v/"), ("v",), "the velocities over time"),
    "p": What(folder("momenta", "diagnostics/p/"), ("p",), "the momenta over time"),
    "phase": What(phase, ("q", "v"), "phase portraits, velocity over coordinate"),
    "path": What(path, ("positions",), "the paths of the particles in space"),
    "positions": What(folder("positions", "positions/"), ("positions",), "their components over time"),
    "drift": What(drift, ("h", "p"), "the drift of what is conserved"),
    "energy": What(energy, ("T", "U", "energy", "h"), "T, U, T + U and h over time"),
    "action": What(scalar("action"), ("action",), "the action over time"),
    "ledger": What(folder("ledger", "diagnostics/ledger/"), ("ledger",), "balances of energy and momenta"),
    "error": What(error, (), "the estimated errors (--certify)"),
    "spectrum": What(spectrum, ("q",), "amplitudes of the coordinates over frequency"),
    "observables": What(folder("observables", "observables/"), ("observables",), "the observables over time"),
    "reactions": What(folder("reactions", "reactions/"), ("reactions",), "forces of constraint over time"),
    "multipliers": What(
        folder("multipliers", "multipliers/"), ("multipliers",), "Lagrange multipliers over time"
    ),
    "constraints": What(
        folder("constraints", "diagnostics/constraints/"), ("constraints",), "how far constraints are from 0"
    ),
    "conserved": What(
        folder("conserved quantities", "diagnostics/conserved/"), ("conserved",), "conserved quantities"
    ),
}  # fmt: skip
"""The words of ``--what`` for a motion."""
USUAL = ("q", "phase", "path", "drift")
"""The default plots."""
