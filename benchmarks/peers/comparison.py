"""Engines on the same motion, in turns: their medians, and a table of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np

from benchmarks.harness.report import markdown_table
from benchmarks.harness.turns import in_own_process, in_turns, timed
from benchmarks.motions.motion import Motion
from benchmarks.peers import Maker


@dataclass(frozen=True)
class Measurement:
    """Seconds to prepare and to integrate, the steps taken, and the largest relative energy error."""

    prepare: float
    run: float
    steps: float
    energy_error: float


def measured(make: Maker, motion: Motion, repeats: int) -> Measurement:
    """An engine over runs from ``repeats`` nearby starts: the seconds of the quickest, since what else goes
    on in the machine only adds to them, the median of the errors, and the steps of the first."""
    engine = make(motion)
    runs = [timed(partial(engine.follow, start)) for start in motion.starts(repeats)]
    errors = [np.max(np.abs(motion.energy_errors(course.states))) for _, course in runs]
    return Measurement(
        engine.prepare,
        run=min(seconds for seconds, _ in runs),
        steps=runs[0][1].steps,
        energy_error=float(median(errors)),
    )


def compare(contenders: Mapping[str, tuple[Maker, Motion, int]], turns: int) -> dict[str, Measurement]:
    """The medians of so many measurements of each contender (the arguments of ``measured``), each made in a
    process of its own."""
    tasks = {name: partial(in_own_process, measured, *each) for name, each in contenders.items()}
    return {name: medians(results) for name, results in in_turns(tasks, turns).items()}


def medians(results: list[Measurement]) -> Measurement:
    """The median of the seconds; steps and errors are the same in every turn."""
    return Measurement(
        prepare=median(each.prepare for each in results),
        run=median(each.run for each in results),
        steps=results[0].steps,
        energy_error=max(each.energy_error for each in results),
    )


def comparison_table(results: Mapping[str, Measurement], ours: str) -> str:
    """One row for each program, with its times relative to ``ours``."""
    reference = results[ours]
    return markdown_table(
        ("", "prepare, ms", "relative", "run, ms", "relative", "steps", "energy error"),
        [
            (
                name,
                f"{1e3 * each.prepare:.0f}",
                f"{each.prepare / reference.prepare:.1f}",
                f"{1e3 * each.run:.1f}",
                f"{each.run / reference.run:.1f}",
                f"{each.steps:.0f}",
                f"{each.energy_error:.1e}",
            )
            for name, each in results.items()
        ],
    )
