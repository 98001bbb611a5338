"""Ten seconds of the double pendulum as a whole command, from the prompt to the file, with full caches.

It also gives the error of the motion at its end.
"""

from __future__ import annotations

import json
import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median

import h5py
import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.processes import OURS, PROGRAMS, shell
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process
from benchmarks.motions.motion import DOUBLE_PENDULUM
from benchmarks.peers import engine

STOP = 10
NAMES = ("theta1", "theta2")
LAGRANGE = f"lagrange solve systems/double_pendulum.yaml --stop {STOP}"
SCIPY, MECHANICS_DSL, HEYOKA = "sympy + scipy + h5py", "mechanicsdsl run", "heyoka + h5py"
COMMANDS: dict[str, tuple[str, ...]] = {
    LAGRANGE: (*OURS, *LAGRANGE.split()[1:], "--force"),
    HEYOKA: (str(PROGRAMS / "heyoka_double_pendulum.py"),),
    SCIPY: (str(PROGRAMS / "scipy_double_pendulum.py"),),
    MECHANICS_DSL: (
        *("-m", "mechanics_dsl.cli", "run", str(PROGRAMS / "double_pendulum.mdsl")),
        *("--t-span", f"0,{STOP}", "--points", "1001", "--output", "mechanics_dsl.json"),
    ),
}


def exact_end() -> NDArray[np.float64]:
    """q, then v, by heyoka in quadruple precision."""
    motion = replace(DOUBLE_PENDULUM, stop=float(STOP), samples=2)
    by_heyoka = engine("heyoka", motion, form="by hand", quadruple=True, compact_mode=True)
    return by_heyoka.follow(motion.initial).states[:, -1].astype(np.float64)


def end_in_hdf5(file: Path) -> NDArray[np.float64]:
    """The last q, then v."""
    with h5py.File(file) as opened:
        return np.array([opened[f"{kind}/{name}"][-1] for kind in "qv" for name in NAMES])


def end_in_json(file: Path) -> NDArray[np.float64]:
    """The last q, then v; mechanicsdsl has each coordinate followed by its velocity."""
    ends = np.array(json.loads(file.read_text(encoding="utf-8"))["y"])[:, -1]
    return np.concatenate([ends[::2], ends[1::2]])


WRITTEN: dict[str, tuple[str, Callable[[Path], NDArray[np.float64]]]] = {
    LAGRANGE: ("double_pendulum.h5", end_in_hdf5),
    HEYOKA: ("heyoka.h5", end_in_hdf5),
    SCIPY: ("scipy.h5", end_in_hdf5),
    MECHANICS_DSL: ("mechanics_dsl.json", end_in_json),
}


def measure(options: Namespace) -> Report:
    """Every command's seconds, and the error of what it wrote."""
    exact = in_own_process(exact_end)
    with shell() as place:
        ended = place.in_turns(COMMANDS, options.runs)
        errors = {
            name: float(np.max(np.abs(read(place.folder / file) - exact)))
            for name, (file, read) in WRITTEN.items()
        }
    seconds = {name: median(each.seconds for each in runs) for name, runs in ended.items()}
    ours, error = seconds[LAGRANGE], errors[LAGRANGE]
    rows = [
        (name, f"{1e3 * each:.0f}", f"{each / ours:.1f}", f"{errors[name]:.1e}")
        for name, each in seconds.items()
    ]
    table = markdown_table(("command", "ms", "relative to lagrange", f"error at {STOP} s"), rows)
    return Report(
        (table,),
        (
            Requirement(f"{SCIPY}: time relative to lagrange", seconds[SCIPY] / ours, ">=", 10),
            Requirement("error of lagrange relative to scipy", error / errors[SCIPY], "<=", 1),
            Requirement(
                f"{MECHANICS_DSL}: time relative to lagrange", seconds[MECHANICS_DSL] / ours, ">=", 20
            ),
            Requirement(
                f"error of {MECHANICS_DSL} relative to lagrange", errors[MECHANICS_DSL] / error, ">=", 1e4
            ),
            Requirement(f"{HEYOKA}: time relative to lagrange", seconds[HEYOKA] / ours, ">=", 2.5),
        ),
    )


SUITE = Suite(
    "shell", measure, packages=("numpy", "h5py", "scipy", "sympy", "heyoka", "mechanicsdsl-core"), runs=9
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
