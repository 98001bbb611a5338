"""Contenders on the same pendulums, in turns: their medians, and a table of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from statistics import median

from benchmarks.contenders import Measurement
from benchmarks.report import in_own_process, in_turns, markdown_table

PACKAGES = ("llvmlite", "numpy", "scipy", "sympy", "heyoka")


def compare(contenders: Mapping[str, Callable[[], Measurement]], runs: int) -> dict[str, Measurement]:
    """The medians of ``runs`` measurements of each contender, each made in a process of its own."""
    tasks = {name: partial(in_own_process, measure) for name, measure in contenders.items()}
    return {name: medians(measured) for name, measured in in_turns(tasks, runs).items()}


def medians(measured: list[Measurement]) -> Measurement:
    """The median of the seconds; steps and errors are the same in every run."""
    return Measurement(
        prepare=median(each.prepare for each in measured),
        run=median(each.run for each in measured),
        steps=measured[0].steps,
        energy_error=max(each.energy_error for each in measured),
    )


def comparison_table(measured: Mapping[str, Measurement], ours: str) -> str:
    """One line a contender, with how many times as long as ``ours`` it takes."""
    reference = measured[ours]
    return markdown_table(
        ("", "prepare, ms", "times ours", "run, ms", "times ours", "steps", "energy error"),
        [
            (
                name,
                f"{1e3 * each.prepare:.0f}",
                f"{each.prepare / reference.prepare:.1f}",
                f"{1e3 * each.run:.1f}",
                f"{each.run / reference.run:.1f}",
                str(each.steps),
                f"{each.energy_error:.1e}",
            )
            for name, each in measured.items()
        ],
    )
