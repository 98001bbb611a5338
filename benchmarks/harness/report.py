"""The report of a benchmark: tables, requirements, and the machine and versions that were measured."""

from __future__ import annotations

import datetime
import os
import platform
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from textwrap import fill

import lagrange_cli

WIDTH = 118
"""Characters in a line of the documents."""


@dataclass(frozen=True)
class Requirement:
    """A requirement and what was measured: ``value`` must be ``relation`` ``bound``."""

    what: str
    value: float
    relation: str
    bound: float

    @property
    def met(self) -> bool:
        """Whether the requirement is met; nan meets none."""
        holds = {"<": self.value < self.bound, "<=": self.value <= self.bound, ">=": self.value >= self.bound}
        return holds[self.relation]


@dataclass(frozen=True)
class Report:
    """Markdown, most of it tables, and the requirements, if there are any."""

    parts: tuple[str, ...]
    requirements: tuple[Requirement, ...] = ()

    @property
    def missed(self) -> tuple[Requirement, ...]:
        """The requirements that are not met."""
        return tuple(each for each in self.requirements if not each.met)

    def text(self, packages: Iterable[str]) -> str:
        """The whole report, which ends with the machine and the versions of ``packages``."""
        required = (required_table(self.requirements),) if self.requirements else ()
        return "\n\n".join((*self.parts, *required, machine(*packages)))


def replaced_section(document: str, name: str, text: str) -> str:
    """The document with ``text`` between its lines ``<!-- name -->`` and ``<!-- end of name -->``.

    Raises:
        ValueError: it has no such lines.
    """
    first, last = f"<!-- {name} -->\n", f"<!-- end of {name} -->\n"
    before, found, rest = document.partition(first)
    _, ended, after = rest.partition(last)
    if not (found and ended):
        raise ValueError(f"the document has no section {name!r}")
    return f"{before}{first}\n{text}\n\n{last}{after}"


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, its columns aligned for reading as plain text too."""
    lines = [list(header), *map(list, rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(header))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in lines
    )


def required_table(requirements: Iterable[Requirement]) -> str:
    """A table of the requirements, what was measured, and whether they are met."""
    return markdown_table(
        ("requirement", "measured", "required", "met"),
        [
            (each.what, f"{each.value:.3g}", f"{each.relation} {each.bound:g}", "yes" if each.met else "NO")
            for each in requirements
        ],
    )


def machine(*packages: str) -> str:
    """The processor and operating system, the versions and the date, a paragraph of lines."""
    versions = [f"Python {platform.python_version()}", f"lagrange-cli {lagrange_cli.__version__}"]
    versions += [f"{package} {version_of(package) or '(not installed)'}" for package in packages]
    system = f"{os.cpu_count()} processors, {platform.system()} {platform.machine()}"
    return "\n".join(
        (f"{processor()}; {system}", fill(", ".join(versions), WIDTH), datetime.date.today().isoformat())
    )


def version_of(package: str) -> str | None:
    """The version that is installed, if any."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def processor() -> str:
    """The processor's name, as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown processor")
