"""``Suite``: a measurement, its command line, and its section of docs/benchmarks.md."""

from __future__ import annotations

import argparse
import inspect
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks import ROOT
from benchmarks.harness.report import Report, replaced_section, version_of

DOCUMENT = ROOT / "docs" / "benchmarks.md"


class NotInstalled(Exception):
    """A program that a suite needs is not installed; the message says which, and how to install it."""


@dataclass(frozen=True)
class Suite:
    """A benchmark: ``measure`` takes its options and returns a report.

    ``name`` is also the name of its section in docs/benchmarks.md. ``packages`` are those whose versions are
    reported, ``runs`` is the default number of turns, and ``quick`` the help text of ``--quick``, where there
    is such an option. A suite that draws random numbers has ``--seed``. One that takes long has ``parts``,
    and ``--only`` for those whose name has a text.
    """

    name: str
    measure: Callable[[Namespace], Report]
    packages: tuple[str, ...]
    runs: int
    quick: str | None = None
    draws: bool = False
    parts: tuple[str, ...] = ()

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Measure and print; the exit status is 1 if a requirement is not met."""
        parser = self.parser()
        options = parser.parse_args(arguments)
        if self.parts and options.only:
            if not any(options.only in part for part in self.parts):
                parser.error(f"no part has '{options.only}' in its name: there are {', '.join(self.parts)}")
            if options.write:
                parser.error("--write needs all parts: leave --only out")
        try:
            return 1 if self.run(options).missed else 0
        except NotInstalled as error:
            print(error, file=sys.stderr)
            return 1

    def run(self, options: Namespace) -> Report:
        """Measure, print and, with ``--write``, write the section of the document.

        Raises ``NotInstalled`` where a program is missing.
        """
        if missing := [package for package in self.packages if version_of(package) is None]:
            raise NotInstalled(f"{self.name} needs {', '.join(missing)}: pip install '.[bench]'")
        report = self.measure(options)
        text = report.text(self.packages)
        print(text, flush=True)
        if options.write:
            document = DOCUMENT.read_text(encoding="utf-8")
            DOCUMENT.write_text(replaced_section(document, self.name, text), encoding="utf-8")
        return report

    def parser(self) -> argparse.ArgumentParser:
        """The command line."""
        described = inspect.getdoc(sys.modules[self.measure.__module__])
        made = argparse.ArgumentParser(prog=f"python -m benchmarks.{self.name}", description=described)
        made.add_argument(
            "--runs",
            type=positive,
            default=self.runs,
            help=f"number of turns of which medians are taken [{self.runs}]",
        )
        made.add_argument("--write", action="store_true", help="write the results to docs/benchmarks.md")
        if self.quick is not None:
            made.add_argument("--quick", action="store_true", help=self.quick)
        if self.parts:
            named = f"only the parts whose name has this text, of {', '.join(self.parts)}"
            made.add_argument("--only", default="", metavar="TEXT", help=named)
        if self.draws:
            made.add_argument("--seed", type=int, default=1, help="the seed of the random numbers [1]")
        return made


def positive(text: str) -> int:
    """A number of turns."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least one run is needed")
    return number
