"""All benchmarks, one after the other, or those named. At the end, the requirements that are not met."""

from __future__ import annotations

import argparse
import sys

from benchmarks.harness.report import Requirement, required_table
from benchmarks.harness.suite import NotInstalled
from benchmarks.suites import SUITES, suite


def main() -> int:
    """Run them; the exit status is 1 if a requirement is not met."""
    if len(sys.argv) > 1 and sys.argv[1] in SUITES:
        return suite(sys.argv[1]).main(sys.argv[2:])
    listed = "\n".join(f"  {name:15}{what}" for name, what in SUITES.items())
    made = argparse.ArgumentParser(
        prog="python -m benchmarks",
        usage="%(prog)s [NAME] [options]",
        description=f"{__doc__}\n\n{listed}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--list", action="store_true", help="list the benchmarks, and run none")
    made.add_argument(
        "--quick", action="store_true", help="measure less, where a benchmark has such an option"
    )
    made.add_argument("--write", action="store_true", help="write the results to docs/benchmarks.md")
    options = made.parse_args()
    if options.list:
        print(listed)
        return 0
    missed: list[Requirement] = []
    absent = False
    for name in SUITES:
        print(f"\n## {name}\n", flush=True)
        one = suite(name)
        quick = ["--quick"] if options.quick and one.quick is not None else []
        write = ["--write"] if options.write else []
        try:
            missed += one.run(one.parser().parse_args([*quick, *write])).missed
        except NotInstalled as error:
            print(error)
            absent = True
    print("\n## Requirements not met\n", required_table(missed) if missed else "none", sep="\n")
    return 1 if missed or absent else 0


if __name__ == "__main__":
    sys.exit(main())
