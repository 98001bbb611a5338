"""``plot``: the usual plots of outputs of ``solve``, ``sweep`` and ``section``."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import near_match, shown
from lagrange_cli.figures.panels import Curve, Page, Panel
from lagrange_cli.figures.style import FORMATS
from lagrange_cli.outputs.catalog import OUTPUTS, PARTICLE_OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.plots import motions, sections, sweeps
from lagrange_cli.run.plots.motions import Run, What, opened
from lagrange_cli.run.plots.quantities import look_up, output_of, quantities, too_large
from lagrange_cli.run.request import HDF5, Request
from lagrange_cli.store.result import Result

if TYPE_CHECKING:
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.monitor import Monitor
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.store.target import Target

WORDS: dict[str, tuple[dict[str, What], tuple[str, ...]]] = {
    "motion": (motions.WHAT, motions.USUAL),
    "sweep": (sweeps.WHAT, sweeps.USUAL),
    "section": (sections.WHAT, sections.USUAL),
}
"""For each kind of output the words of ``--what``, and those that are drawn by default."""
ALL_WORDS = tuple(dict.fromkeys(word for words, _ in WORDS.values() for word in words))
PARTS = {"path": "particles", "positions": "particles"}
"""What a system lacks that has no such outputs, where it is not called like these."""
MOST_PANELS = 40
SMOOTH = 4001
"""Samples of a plotted motion: some hundred oscillations appear as smooth curves."""
MOST_NUMBERS = 1_000_000
"""Values of coordinates of a plotted motion, up to which it has more samples than its file asks for."""
SAME = 1e-12
"""Values that differ by less of the largest of them differ by rounding."""


@dataclass(frozen=True)
class PlotRequest:
    """The requested plots: words of ``--what``, or ``y`` over ``x``; by default the usual ones."""

    what: tuple[str, ...] = ()
    x: str | None = None
    y: tuple[str, ...] = ()


def drawn(request: Request, asked: PlotRequest) -> Request:
    """The request of a motion for a plot that may be without observables that are not defined."""
    return replace(request, drawn="observables" not in asked.what)


def outputs_for(asked: PlotRequest, *, has_particles: bool) -> tuple[str, ...]:
    """The outputs that a motion must have for a plot of its system file."""
    words = asked.what or (() if asked.y else motions.USUAL)
    found = {output for word in words if word in motions.WHAT for output in motions.WHAT[word].outputs}
    found |= {output for name in (asked.x or "", *asked.y) if (output := output_of(name))}
    found |= {"q", "v", "observables"}
    return tuple(one for one in OUTPUTS if one in found and (has_particles or one not in PARTICLE_OUTPUTS))


def finely_sampled(motion: Motion, request: Request) -> Request:
    """The request of a motion for a plot: a file that asks for few samples is sampled more finely, so that
    curves are smooth. The samples of the file are among them. What ``request`` says itself is kept."""
    asked, settings = request.options, motion.settings
    coordinates = max(1, len(motion.spec.coordinates))
    wanted = min(SMOOTH, MOST_NUMBERS // coordinates)
    factor = math.ceil((wanted - 1) / (settings.count - 1))
    if asked.samples is not None or "step" in request.times or factor <= 1:
        return request
    if motion.spec.solve.step is not None:
        return replace(request, times={**request.times, "step": repr(abs(settings.step) / factor)})
    return replace(request, options=replace(asked, samples=(settings.count - 1) * factor + 1))


def page_of(results: Sequence[Result], asked: PlotRequest) -> Page:
    """The page that shows ``results``, which must be of one kind.

    Raises ``UsageError`` for what cannot be drawn, with what to ask for.
    """
    kinds = {result.kind for result in results}
    if len(kinds) > 1:
        raise UsageError(
            f"a {' and a '.join(sorted(kinds))} cannot be drawn over each other: plot them separately"
        )
    several = len(results) > 1
    runs = [opened(one, stem(one.name) if several else "") for one in results]
    panels = across(runs, asked) if asked.y or asked.x else worded(runs, asked.what)
    if not panels:
        raise UsageError(f"{results[0].name} contains nothing to plot: solve again with --outputs q,v,h")
    if len(panels) > MOST_PANELS:
        raise UsageError(
            f"{len(panels)} panels are too many for a page (up to {MOST_PANELS}): see --what, --y"
        )
    titles = dict.fromkeys(one.title for one in results)
    return Page(", ".join(titles), tuple(panels), note_of(results))


def stem(name: str) -> str:
    """A run's name in a legend, which is no formula."""
    return Path(name).stem.replace("$", r"\$")


def note_of(results: Sequence[Result]) -> str:
    """How the runs ended, if not at their end, and from when on curves are pale."""
    notes = []
    for one in results:
        told = one.attributes
        if one.kind == "motion" and told.get("status") not in ("complete", "stopped"):
            notes.append(f"{Path(one.name).name}: {told.get('message', told.get('status', 'interrupted'))}")
        if (until := opened_until(one)) is not None:
            notes.append(f"pale where six digits can no longer be trusted, from t = {decimal(until)} on")
    return "; ".join(notes)


def opened_until(result: Result) -> float | None:
    """Up to when the motion can be trusted, where that is before its end."""
    until = Run(result, {}).trusted_until
    if until is None or "t" not in result.held or not result.held["t"].shape[0]:
        return None
    return until if until < float(result.read("t", -1)) else None


def worded(runs: Sequence[Run], what: Sequence[str], option: str = "--what") -> list[Panel]:
    """The panels of words of ``option``; raises ``UsageError`` for a word that means nothing here."""
    words, usual = WORDS[runs[0].result.kind]
    panels: list[Panel] = []
    for word in what or usual:
        if word not in words:
            if word in ALL_WORDS:
                raise UsageError(
                    f"{option} {word}: not for a {runs[0].result.kind}; known: {', '.join(words)}"
                )
            near = near_match(word, list(words))
            hint = f"did you mean {near}?" if near else f"known: {', '.join(words)}"
            if option == "--what" and (word in quantities(runs[0].result) or output_of(word)):
                hint = f"--y {word} draws this quantity"
            raise UsageError(f"{option} {shown(word)}: there is no such plot; {hint}")
        made = words[word].panels(runs)
        if not made and what:
            raise UsageError(missing(runs[0], word, words[word], option))
        panels += made
    if what:
        return panels
    return [one for one in panels if not at_rest(one)] or panels


def at_rest(panel: Panel) -> bool:
    """Whether a phase portrait or a path is a single point, up to rounding."""
    curves = [one for one in panel.items if isinstance(one, Curve)]
    if not curves or len(curves) < len(panel.items):
        return False
    if panel.equal:
        curves = [one for one in curves if not (one.points and len(one.x) == 1)]  # what stands
    if any(one.points for one in curves):
        return False
    return all(
        constant(values)
        for one in curves
        for values in ((one.x, one.y, one.z) if panel.equal else (one.x,))
        if values is not None
    )


def constant(values: np.ndarray) -> bool:
    """Whether values differ by no more than rounding. A single one says nothing about motion."""
    known = values[np.isfinite(values)]
    return len(known) > 1 and bool(np.ptp(known) <= SAME * np.abs(known).max())


def missing(run: Run, word: str, what: What, option: str) -> str:
    """The hint where an output lacks datasets for a plot."""
    if word == "error":
        return f"{option} error: {run.result.name} has no estimated errors: solve again with --certify"
    if run.result.solved_for_this:
        return f"{option} {word}: {run.result.title} has no {PARTS.get(word, word)}"
    if large := too_large(run.result, what.outputs):
        return f"{option} {word}: in {run.result.name}, {large}; read it with h5py"
    needed = ",".join(what.outputs)
    if run.result.kind == "section":
        return f"{option} {word}: {run.result.name} does not contain it"
    command = "sweep" if run.result.kind == "sweep" else "solve"
    return f"{option} {word}: {run.result.name} does not contain it: {command} again with --outputs {needed}"


def across(runs: Sequence[Run], asked: PlotRequest) -> list[Panel]:
    """``--y`` over ``--x``, which is t by default."""
    kind = runs[0].result.kind
    x = asked.x or "t"
    if not asked.y:
        raise UsageError("--x needs --y: the quantity over it")
    panels = []
    for y in asked.y:
        own = []
        for run in runs:
            one, other = look_up(run.result, run.known, x, "--x"), look_up(run.result, run.known, y, "--y")
            own.append((run, one.name, other.name))
        run, one_name, other_name = own[0]
        if kind == "sweep":
            panels += [sweeps.across_members(*each) for each in own]
        elif kind == "section":
            panels.append(sections.across([each for each, *_ in own], one_name, other_name, ""))
        elif x == "t" and kind == "motion":
            panels.append(
                motions.panel_over_time(
                    run.known[other_name].symbol, [(run, run.known[n]) for run, _, n in own]
                )
            )
        else:
            panels.append(motions.across([each for each, *_ in own], one_name, other_name, ""))
    return panels


def check_format(name: str) -> str:
    """The format of a picture, which its ending says; raises ``UsageError`` for any other ending."""
    suffix = Path(name).suffix.lower()
    if suffix not in FORMATS:
        raise UsageError(f"--output {name}: the name must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    return suffix


def write(picture: bytes, target: Target) -> None:
    """Write a picture to its file, whole or not at all; raises ``FileError`` where that fails."""
    with target.filled() as path:
        path.write_bytes(picture)


@contextmanager
def solved(
    motion: Motion, request: Request, demand: Demand | None, monitor: Monitor
) -> Iterator[tuple[Result, Outcome]]:
    """The motion of a system file as the result that ``solve`` would write, and how it ended.

    Raises ``KeyboardInterrupt`` if it was interrupted: who presses Ctrl-C waits for no picture.
    """
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.run.attributes import units_of
    from lagrange_cli.run.memory import follow, save
    from lagrange_cli.run.motion import prepare_all
    from lagrange_cli.run.prepare import prepare_run
    from lagrange_cli.store.find_target import find_target

    name = motion.spec.filename
    units = units_of(motion.spec, monitor.tell)
    prepare = prepare_run
    if demand is None and motion.may_be_stiff:
        from lagrange_cli.run.trial import settled

        motion, prepare = settled(motion, request, monitor.stage)
    ready = prepare_all(motion, request, demand, monitor.stage, prepare)
    followed = follow(ready, units, monitor, demand)
    if followed.outcome.ending is Ending.INTERRUPTED:
        raise KeyboardInterrupt
    with tempfile.TemporaryDirectory(prefix="lagrange-") as folder:
        target = find_target(str(Path(folder) / f"{Path(name).stem}.h5"), force=True)
        save(followed, target, HDF5)
        with Result(str(target.path)) as result:
            result.name, result.solved_for_this = name, True
            yield result, followed.outcome
