"""10^8 samples of the pendulum written to disk: time and memory, relative to h5py alone.

h5py writes the same amount of numbers that it already has in memory.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path
from statistics import median

from benchmarks.harness.processes import OURS, PROGRAMS, Ended, Shell, shell
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns

SAMPLES, FEWER = 10**8 + 1, 10**7 + 1
MEMORY, SLOWER = 300, 1.5
"""Megabytes, and times the seconds of h5py alone."""
LAGRANGE = "lagrange solve systems/pendulum.yaml --stop 1000"
H5PY = "h5py alone"


def measure(options: Namespace) -> Report:
    """Both in turns, in a folder within the current one, which should be on disk."""
    samples = str(FEWER if options.quick else SAMPLES)
    commands = {
        LAGRANGE: (*OURS, *LAGRANGE.split()[1:], "--samples", samples, "--output", "samples.h5"),
        H5PY: (str(PROGRAMS / "write_samples.py"), samples, "samples.h5"),
    }
    with shell(Path.cwd()) as place:
        place.run(*OURS, *LAGRANGE.split()[1:])  # so that it is compiled
        tasks = {
            name: lambda arguments=arguments: written(place, arguments)
            for name, arguments in commands.items()
        }
        ended = in_turns(tasks, options.runs)
    seconds = {name: median(each.seconds for each in runs) for name, runs in ended.items()}
    memory = {name: max(each.memory for each in runs) / 1e6 for name, runs in ended.items()}
    rows = [
        (name, f"{each:.2f}", f"{each / seconds[H5PY]:.2f}", f"{memory[name]:.0f}")
        for name, each in seconds.items()
    ]
    return Report(
        (markdown_table((f"{samples} samples", "s", "relative to h5py", "memory, MB"), rows),),
        (
            Requirement("peak memory of lagrange, MB", memory[LAGRANGE], "<=", MEMORY),
            Requirement(
                "time of lagrange relative to h5py alone", seconds[LAGRANGE] / seconds[H5PY], "<=", SLOWER
            ),
        ),
    )


def written(place: Shell, arguments: tuple[str, ...]) -> Ended:
    """Run it, and remove what it wrote."""
    ended = place.run(*arguments)
    (place.folder / "samples.h5").unlink()
    return ended


SUITE = Suite("samples", measure, packages=("numpy", "h5py"), runs=3, quick="10^7 samples only")

if __name__ == "__main__":
    sys.exit(SUITE.main())
