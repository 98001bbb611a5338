"""The motion that a page shows: as its file has it, for a while, and as far as it can be computed at once."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.motion import Motion, read_motion
from lagrange_cli.run.request import Request

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.drawing.along import Along
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.run.settings.settings import Settings

OUTPUTS = frozenset({"q", "v", "p", "h"})
SPAN = 10.0
"""The duration of a motion whose file gives none."""
PATIENCE = 5.0
"""Seconds that the motion may take before the page is written without its end."""


@dataclass(frozen=True)
class ViewedMotion:
    """A motion as it is computed here: times (n,), q and v (n, degrees), and how it ended; ``along`` are its
    parameters where actions have set some."""

    t: Array
    q: Array
    v: Array
    observed: Mapping[str, Array]
    message: str
    steps: int
    along: Along | None = None


def read_shown(content: bytes, filename: str, request: Request, stage: Stage = untimed) -> Motion:
    """The motion of a system file that a page shows; one without a stop time lasts for ``SPAN``.

    Raises ``SpecError`` and ``UsageError`` as ``read_motion`` does.
    """
    from lagrange_cli.run.derive import read_run

    spec, _ = read_run(content, filename, request.sizes, lambda spec, problems: None)
    if spec.solve.stop is None and "stop" not in {*request.times, *spec.solve.times}:
        request = replace(request, options=replace(request.options, stop=SPAN))
    return read_motion(content, filename, request, stage)


def watched(motion: Motion) -> Motion:
    """The motion with what a page shows of it as its outputs."""
    settings = replace(shown_settings(motion.settings), outputs=OUTPUTS, optional=frozenset())
    return replace(motion, settings=settings)


def shown_settings(settings: Settings) -> Settings:
    """The settings of a motion in doubles, by the Taylor method."""
    from lagrange_cli.integrate.methods.table import METHODS, TAYLOR
    from lagrange_cli.integrate.precision import DOUBLE

    if settings.method == TAYLOR and settings.precision == DOUBLE:
        return settings
    tolerance = METHODS[TAYLOR].tolerances[DOUBLE][1]
    return replace(settings, method=TAYLOR, precision=DOUBLE, tolerance=tolerance)


def follow(motion: Motion, stage: Stage = untimed) -> ViewedMotion:
    """The motion, as far as it goes in ``PATIENCE`` seconds."""
    import numpy as np

    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.prepare import prepare_run

    settings = motion.settings
    prepared = prepare_run(motion.spec, settings, stage, cached=True)
    paths = {kind: [one.path for one in prepared.recording.states if one.path[0] == kind] for kind in "qv"}
    found: dict[str, list[Array]] = {"t": [], "q": [], "v": []}
    observed: dict[str, list[Array]] = {}
    crossed: dict[str, list[Array]] = {}

    def emit(chunk: dict[str, np.ndarray]) -> None:
        count = len(chunk["t"])
        found["t"].append(chunk["t"].copy())
        for kind, listed in paths.items():
            found[kind].append(np.concatenate([chunk[path].reshape(count, -1) for path in listed], axis=1))
        for dataset in prepared.recording.made:
            columns = chunk[dataset.path].reshape(count, -1).T
            for name, column in zip(dataset.sources, columns):
                observed.setdefault(name, []).append(column.copy())

    def emit_events(chunk: dict[str, np.ndarray]) -> None:
        for path, rows in chunk.items():
            crossed.setdefault(path, []).append(rows.copy())

    until = time.monotonic() + PATIENCE
    times = Times(settings.start, settings.stop, settings.count, settings.step)
    with stage("integrate"):
        outcome = integrate(
            prepared, motion.values, times, emit, lambda: time.monotonic() > until, explain=motion.cause,
            emit_events=emit_events,
        )  # fmt: skip
    n = len(motion.spec.coordinates)

    def joined(kind: str) -> Array:
        return np.concatenate([np.empty((0, n)), *found[kind]])

    status = outcome.ending.status
    return ViewedMotion(
        np.concatenate([np.empty(0), *found["t"]]),
        joined("q"),
        joined("v"),
        {name: np.concatenate(parts) for name, parts in observed.items()},
        "" if status in ("complete", "interrupted") else outcome.message,
        outcome.steps,
        along_of(motion, {path: np.concatenate(parts) for path, parts in crossed.items()}),
    )


def along_of(motion: Motion, crossed: Mapping[str, Array]) -> Along | None:
    """The parameters along a motion with these crossings; None where no action sets any."""
    from lagrange_cli.run.jumps import parameters_set

    if not parameters_set(motion.spec):
        return None
    from lagrange_cli.run.set_parameters import parameters_along

    return parameters_along(crossed.get, motion.spec, motion.values.parameters)
