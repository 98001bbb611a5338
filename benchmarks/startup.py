"""What a user waits for at the shell: whole processes, against those that only import what is needed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

from benchmarks.report import ROOT, Requirement, conclude, in_turns, markdown_table, parser

PACKAGES = ("click", "PyYAML", "numpy", "h5py", "llvmlite", "sympy")


@dataclass(frozen=True)
class Command:
    """A command of ``lagrange``, what must be imported for it, and how many times that it may take."""

    arguments: tuple[str, ...]
    imports: str
    limit: float | None = None

    @property
    def shown(self) -> str:
        """As a user types it."""
        return " ".join(("lagrange", *(each for each in self.arguments if each not in HOUSEKEEPING)))

    @property
    def floor(self) -> str:
        """The script that only imports."""
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


def seconds_of(arguments: tuple[str, ...], folder: Path) -> float:
    """How long a Python process with these arguments takes, from its start to its end."""
    cache = {"LAGRANGE_CACHE_DIR": str(folder / "cache"), "LAGRANGE_NO_CACHE": ""}
    environment = {**os.environ, **cache, "PYTHONPATH": str(ROOT)}
    began = time.perf_counter()
    subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - began


def measure(runs: int) -> dict[str, float]:
    """The median of the seconds of each command and of each floor, by what is shown of it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(ROOT / "systems", folder / "systems")
        processes: dict[str, tuple[str, ...]] = {command.floor: ("-c", command.floor) for command in COMMANDS}
        processes |= {command.shown: ("-m", "lagrange_cli", *command.arguments) for command in COMMANDS}
        tasks = {shown: partial(seconds_of, arguments, folder) for shown, arguments in processes.items()}
        in_turns(tasks, 1)  # so that files are in memory, bytecode and compiled programs on disk
        return {shown: median(seconds) for shown, seconds in in_turns(tasks, runs).items()}


def main() -> int:
    """Measure, print, and say by the exit status whether the figures are reached."""
    options = parser(__doc__, runs=15).parse_args()
    seconds = measure(options.runs)
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
    table = markdown_table(("command", "ms", "floor", "ms", "ratio"), rows)
    requirements = [
        Requirement(f"{each.shown}: times its floor", ratio, "<=", each.limit)
        for each, ratio in ratios.items()
        if each.limit is not None
    ]
    return conclude([table], requirements, PACKAGES)


if __name__ == "__main__":
    sys.exit(main())
