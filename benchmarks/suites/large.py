"""One second of a chain of many pendulums as a whole command, with empty caches."""

from __future__ import annotations

import sys
from argparse import Namespace
from statistics import median

from benchmarks.harness.processes import OURS, PROGRAMS, shell
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite

SPEEDUP = 6
SECONDS = {100: 3, 1000: 5}
"""That so many pendulums may take."""


def ours(count: int) -> str:
    """Our command, as it is shown."""
    return f"lagrange solve systems/n_pendulum.yaml --size N={count} --stop 1 --no-cache"


HEYOKA = "heyoka + h5py, compact mode, N = 20"
COMMANDS: dict[str, tuple[str, ...]] = {
    **{ours(count): (*OURS, *ours(count).split()[1:], "--force") for count in (20, 50, 100, 1000)},
    HEYOKA: (str(PROGRAMS / "heyoka_n_pendulum.py"), "20"),
}


def measure(options: Namespace) -> Report:
    """Every command's seconds."""
    with shell() as place:
        ended = place.in_turns(COMMANDS, options.runs)
    seconds = {name: median(each.seconds for each in runs) for name, runs in ended.items()}
    rows = [(name, f"{each:.2f}", f"{seconds[HEYOKA] / each:.1f}") for name, each in seconds.items()]
    return Report(
        (markdown_table(("command", "s", "speed relative to heyoka"), rows),),
        (
            Requirement(
                "heyoka, N = 20: time relative to lagrange, N = 20",
                seconds[HEYOKA] / seconds[ours(20)],
                ">=",
                SPEEDUP,
            ),
            Requirement(
                "heyoka, N = 20: time relative to lagrange, N = 50",
                seconds[HEYOKA] / seconds[ours(50)],
                ">=",
                1,
            ),
            *(
                Requirement(f"lagrange, N = {count}: seconds", seconds[ours(count)], "<=", most)
                for count, most in SECONDS.items()
            ),
        ),
    )


SUITE = Suite("large", measure, packages=("llvmlite", "numpy", "h5py", "heyoka"), runs=5)

if __name__ == "__main__":
    sys.exit(SUITE.main())
