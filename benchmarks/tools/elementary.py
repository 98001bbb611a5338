"""The elementary functions of lagrange and of the C library: time per double and compilation time.

    python -m benchmarks.tools.elementary

Each is applied to an array that stays in the cache. The time is that of throughput, the least of many runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.functions.elementary import FUNCTIONS
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from tests.support.calls import compiled, over_columns, text

COUNT, RUNS = 800, 400
LANES = (1, 8)
RANDOM = np.random.default_rng(1)
LIBRARY = {"sin_cos": ("sin", "cos"), "exp": ("exp",), "log": ("log",), "pow": ("pow",)}
ARGUMENTS = {
    "sin_cos": (RANDOM.uniform(-3, 3, COUNT),),
    "exp": (RANDOM.uniform(-5, 5, COUNT),),
    "log": (RANDOM.uniform(0.1, 10, COUNT),),
    "pow": (RANDOM.uniform(0.1, 10, COUNT), RANDOM.uniform(-3, 3, COUNT)),
}


def library(name: str, lanes: int) -> str:
    """A program that calls the C library's functions for what ``name`` computes."""

    def write(f: Function, values: Sequence[Real]) -> list[Real]:
        return [f.function(one, *values) for one in LIBRARY[name]]

    return over_columns(write, len(ARGUMENTS[name]), lanes)


def least(function: Callable[[], object], runs: int) -> float:
    """The least of the seconds that ``function`` takes."""
    best = float("inf")
    for _ in range(runs):
        began = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - began)
    return best


def measure(program: str, results: int, arguments: Sequence[np.ndarray]) -> tuple[float, float]:
    """(nanoseconds for one double, milliseconds to compile), without what an empty loop takes of both."""
    run = compiled(program, results)
    empty = compiled(over_columns(lambda _, values: [values[0]] * results, len(arguments), 8), results)
    spent = least(lambda: run(*arguments), RUNS) - least(lambda: empty(*arguments), RUNS)
    return 1e9 * spent / COUNT, 1e3 * least(lambda: compile_text(program, 1), 5)


def main() -> None:
    """Print the table."""
    print(f"{'':10}{'lanes':>6}{'lagrange, ns':>14}{'C library':>12}{'compile, ms':>14}{'C library':>12}")
    for name, arguments in ARGUMENTS.items():
        for lanes in LANES:
            extra = FUNCTIONS[name].arguments - len(arguments)
            results = FUNCTIONS[name].results
            ours = measure(text(name, lanes), results, [*arguments, *[np.zeros(COUNT)] * extra])
            theirs = measure(library(name, lanes), results, arguments)
            print(f"{name:10}{lanes:6}{ours[0]:14.1f}{theirs[0]:12.1f}{ours[1]:14.1f}{theirs[1]:12.1f}")


if __name__ == "__main__":
    main()
