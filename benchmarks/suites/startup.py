"""The time of whole commands, relative to processes that only do the necessary imports."""

from __future__ import annotations

import sys
from argparse import Namespace
from dataclasses import dataclass
from statistics import median

from benchmarks.harness.processes import OURS, shell
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite


@dataclass(frozen=True)
class Command:
    """A command of ``lagrange``, the imports it needs, and how many times the time of these it may take."""

    arguments: tuple[str, ...]
    imports: str
    limit: float | None = None

    @property
    def shown(self) -> str:
        """The command as a user types it."""
        return " ".join(("lagrange", *(each for each in self.arguments if each not in HOUSEKEEPING)))

    @property
    def floor(self) -> str:
        """The script that only does the imports."""
        return f"import {self.imports}"


HOUSEKEEPING = ("--force",)
TO_SOLVE, TO_DERIVE = "click, yaml, numpy, h5py", "sympy, click, yaml"
COMMANDS = (
    Command(("--help",), "click", 2),
    Command(("solve", "systems/pendulum.yaml", *HOUSEKEEPING), TO_SOLVE, 1.6),
    Command(("solve", "systems/pendulum.yaml", "--no-cache", *HOUSEKEEPING), TO_SOLVE, 3),
    Command(("solve", "systems/double_pendulum.yaml", *HOUSEKEEPING), TO_SOLVE),
    Command(("solve", "systems/double_pendulum.yaml", "--no-cache", *HOUSEKEEPING), TO_SOLVE, 3),
    Command(("equations", "systems/pendulum.yaml"), TO_DERIVE, 2),
    Command(("equations", "systems/double_pendulum.yaml"), TO_DERIVE),
)


def measure(options: Namespace) -> Report:
    """Each command and the process that only does its imports."""
    processes: dict[str, tuple[str, ...]] = {command.floor: ("-c", command.floor) for command in COMMANDS}
    processes |= {command.shown: (*OURS, *command.arguments) for command in COMMANDS}
    with shell() as place:
        ended = place.in_turns(processes, options.runs)
    seconds = {shown: median(each.seconds for each in runs) for shown, runs in ended.items()}
    ratios = {each: seconds[each.shown] / seconds[each.floor] for each in COMMANDS}
    rows = [
        (
            each.shown,
            f"{1e3 * seconds[each.shown]:.0f}",
            f'python -c "{each.floor}"',
            f"{1e3 * seconds[each.floor]:.0f}",
            f"{ratio:.2f}",
        )
        for each, ratio in ratios.items()
    ]
    requirements = [
        Requirement(f"{each.shown}: time relative to the imports", ratio, "<=", each.limit)
        for each, ratio in ratios.items()
        if each.limit is not None
    ]
    table = markdown_table(("command", "ms", "imports only", "ms", "ratio"), rows)
    return Report((table,), tuple(requirements))


SUITE = Suite("startup", measure, packages=("click", "PyYAML", "numpy", "h5py", "llvmlite", "sympy"), runs=15)

if __name__ == "__main__":
    sys.exit(SUITE.main())
