"""What the benchmarks share: taking turns, medians, tables, and on what it was measured."""

from __future__ import annotations

import argparse
import datetime
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

import lagrange_cli

K = TypeVar("K")
T = TypeVar("T")

ROOT = Path(__file__).resolve().parent.parent
"""The checkout, which is what is measured."""


@dataclass(frozen=True)
class Requirement:
    """A figure that must be reached, and what was measured: ``value`` must be ``relation`` ``bound``."""

    what: str
    value: float
    relation: str
    bound: float

    @property
    def met(self) -> bool:
        """Whether it is reached; one that is not a number is not."""
        holds = {
            "<": self.value < self.bound,
            "<=": self.value <= self.bound,
            ">=": self.value >= self.bound,
        }
        return holds[self.relation]


def in_turns(tasks: Mapping[K, Callable[[], T]], turns: int) -> dict[K, list[T]]:
    """Run every task once, then every one again, ``turns`` times; the results by task, in order."""
    results: dict[K, list[T]] = {name: [] for name in tasks}
    for _ in range(turns):
        for name, task in tasks.items():
            results[name].append(task())
    return results


def in_own_process(function: Callable[..., T], *arguments: object) -> T:
    """``function(*arguments)`` in a process of its own, where nothing is warm and nothing is cached."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, its columns aligned for reading as plain text too."""
    lines = [list(header), *map(list, rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(header))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in lines
    )


def required_table(requirements: Iterable[Requirement]) -> str:
    """The figures that must be reached, what was measured, and whether they are."""
    return markdown_table(
        ("figure", "measured", "required", "met"),
        [
            (each.what, f"{each.value:.3g}", f"{each.relation} {each.bound:g}", "yes" if each.met else "NO")
            for each in requirements
        ],
    )


def machine(*packages: str) -> str:
    """The processor, the system, the versions of what is measured and the date, in three lines."""
    versions = [f"Python {platform.python_version()}", f"lagrange-cli {lagrange_cli.__version__}"]
    versions += [f"{package} {version_of(package)}" for package in packages]
    system = f"{os.cpu_count()} processors, {platform.system()} {platform.machine()}"
    return "\n".join((f"{processor()}; {system}", ", ".join(versions), datetime.date.today().isoformat()))


def version_of(package: str) -> str:
    """The version that is installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "(not installed)"


def processor() -> str:
    """The processor's name, as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown processor")


def parser(description: str | None, runs: int) -> argparse.ArgumentParser:
    """The command line of a benchmark: ``--runs``."""
    made = argparse.ArgumentParser(description=description)
    made.add_argument("--runs", type=positive, default=runs, help=f"turns that medians are over [{runs}]")
    return made


def positive(text: str) -> int:
    """A number of turns."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least one run is needed")
    return number


def conclude(tables: Iterable[str], requirements: Sequence[Requirement], packages: Iterable[str]) -> int:
    """Print everything; the exit status is 1 if a figure is not reached."""
    print(*tables, required_table(requirements), machine(*packages), sep="\n\n")
    return 0 if all(each.met for each in requirements) else 1
