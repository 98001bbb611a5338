"""All benchmarks, one after the other: ``python -m benchmarks``; at the end, the figures that are not
reached."""

from __future__ import annotations

import argparse
import sys

from benchmarks import (
    brouwer,
    certified,
    chain,
    derivation,
    doubledouble,
    ensemble,
    integration,
    large,
    portable,
    samples,
    shell,
    startup,
    workprecision,
)
from benchmarks.report import required_table

MODULES = (
    startup, shell, large, derivation, integration, workprecision, chain, ensemble, samples, brouwer,
    doubledouble, portable, certified,
)  # fmt: skip
BENCHMARKS = tuple(module.BENCHMARK for module in MODULES)


def main() -> int:
    """Run them; the exit status is 1 if a figure is not reached."""
    made = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    made.add_argument("--quick", action="store_true", help="run each as quickly as it can be")
    made.add_argument("--write", action="store_true", help="renew docs/benchmarks.md")
    options = made.parse_args()
    missed = []
    for benchmark in BENCHMARKS:
        print(f"\n## {benchmark.name}\n", flush=True)
        quick = ["--quick"] if options.quick and benchmark.quick is not None else []
        write = ["--write"] if options.write else []
        missed += benchmark.run(benchmark.parser().parse_args([*quick, *write])).missed
    print("\n## Not reached\n", required_table(missed) if missed else "nothing", sep="\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
