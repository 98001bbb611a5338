"""All benchmarks, one after the other: ``python -m benchmarks``. At the end it lists the requirements that
are not met."""

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
    """Run them; the exit status is 1 if a requirement is not met."""
    made = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    made.add_argument(
        "--quick", action="store_true", help="measure less, where a benchmark has such an option"
    )
    made.add_argument("--write", action="store_true", help="write the results to docs/benchmarks.md")
    options = made.parse_args()
    missed = []
    for benchmark in BENCHMARKS:
        print(f"\n## {benchmark.name}\n", flush=True)
        quick = ["--quick"] if options.quick and benchmark.quick is not None else []
        write = ["--write"] if options.write else []
        missed += benchmark.run(benchmark.parser().parse_args([*quick, *write])).missed
    print("\n## Requirements not met\n", required_table(missed) if missed else "none", sep="\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
