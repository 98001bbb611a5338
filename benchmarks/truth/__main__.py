"""Motions whose truth is known, each judged right, refused or wrong: ``python -m benchmarks.truth``.

Every run draws new numbers, unless --seed repeats those of an earlier one. Every case is a system file with a
closed form, or an integral, of its motion. It is run with `lagrange solve`, as members of `lagrange sweep`
and with `--precision double-double`.
"""

from __future__ import annotations

import argparse
import secrets
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from benchmarks.truth.drawing import DRAWS, FAMILIES, cases
from benchmarks.truth.judge import REFUSED, RIGHT, VERDICTS, WRONG, Verdict, judge
from benchmarks.truth.running import MODES

REFUSALS = 0.02
"""The largest share of cases that may be refused."""


def main() -> int:
    """Run the cases; the exit status is 1 if any is wrong, or too many are refused."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks.truth", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    made.add_argument("--seed", type=int, help="the seed of the random numbers [a new one]")
    made.add_argument("--draws", type=int, default=DRAWS, help=f"cases of each kind [{DRAWS}]")
    made.add_argument(
        "--only", nargs="+", default=[], metavar="NAME",
        help=f"run only these families ({', '.join(FAMILIES)}), kinds or cases",
    )  # fmt: skip
    made.add_argument("--modes", default=",".join(MODES), help="a comma-separated list [all three]")
    made.add_argument("--keep", metavar="DIR", help="write the files of all cases to this folder")
    made.add_argument("--shell", action="store_true", help="run each command in a process of its own")
    made.add_argument("--all", action="store_true", help="print the right ones, too")
    options = made.parse_args()
    modes = options.modes.split(",")
    if unknown := {*modes} - {*MODES}:
        made.error(f"no such mode: {', '.join(sorted(unknown))}")
    seed = secrets.randbelow(10**6) if options.seed is None else options.seed
    print(f"seed {seed}", flush=True)
    found: list[Verdict] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for case in cases(seed, options.draws, options.only):
            for verdict in judge(case, modes, folder, shell=options.shell):
                found.append(verdict)
                if options.all or verdict.verdict != RIGHT:
                    print(line(verdict), flush=True)
    if not found:
        made.error("no such family, kind or case")
    for verdict in found:
        if verdict.verdict == WRONG:
            print(f"\n--- {line(verdict)}\n--stop {verdict.case.stop} --samples {verdict.case.samples}"
                  f" --outputs {','.join(verdict.case.outputs)}\n{verdict.case.text}")  # fmt: skip
    print(table(found), f"seed {seed}", sep="\n")
    counts = Counter(each.verdict for each in found)
    return 1 if counts[WRONG] or counts[REFUSED] > REFUSALS * len(found) else 0


def line(verdict: Verdict) -> str:
    """A verdict in one line."""
    case = verdict.case
    return (
        f"{verdict.verdict:8}{verdict.mode:14}{case.family}/{case.name}: {verdict.because or verdict.error}"
    )


def table(found: Sequence[Verdict]) -> str:
    """Right, refused and wrong by family and mode."""
    modes = [mode for mode in MODES if any(each.mode == mode for each in found)]
    rows = [["", *modes]]
    for family in [*dict.fromkeys(each.case.family for each in found), "all"]:
        row = [family]
        for mode in modes:
            here = [each for each in found if each.mode == mode and family in (each.case.family, "all")]
            counts = Counter(each.verdict for each in here)
            row.append(" / ".join(str(counts[verdict]) for verdict in VERDICTS))
        rows.append(row)
    refused = sum(each.verdict == REFUSED for each in found) / len(found)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows]
    return "\n".join(["", "right / refused / wrong", *lines, f"refused: {refused:.1%}"])


if __name__ == "__main__":
    sys.exit(main())
