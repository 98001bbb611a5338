"""Difficult motions, each judged right, refused or wrong: ``python -m benchmarks.stress``.

Every scene runs in a process of its own with limits of time and memory. So do its reference and the other
programs. All scenes take about fifteen minutes, those of --quick less than one.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from benchmarks.stress.judge import judge
from benchmarks.stress.page import line, write_page
from benchmarks.stress.scenes import SCENES


def main() -> int:
    """Run the scenes; the exit status is 1 if one is wrong."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks.stress", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    made.add_argument("--quick", action="store_true", help="run the fast scenes only, without other programs")
    made.add_argument("--scenes", nargs="+", metavar="NAME", help="run only these scenes")
    made.add_argument("--no-peers", action="store_true", help="do not run other programs")
    made.add_argument("--jobs", type=int, default=2, help="number of scenes that run at the same time [2]")
    made.add_argument("--write", action="store_true", help="write docs/stability.md and its figures")
    options = made.parse_args()
    if unknown := {*(options.scenes or ())} - {scene.name for scene in SCENES}:
        made.error(f"no such scene: {', '.join(sorted(unknown))}")
    chosen = [
        scene
        for scene in SCENES
        if (scene.name in options.scenes if options.scenes else scene.quick or not options.quick)
    ]
    results = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        follow = partial(judge, folder=Path(folder), peers=not (options.quick or options.no_peers))
        for judged in pool.map(follow, chosen):
            results.append(judged)
            print(line(judged), flush=True)
    if options.write:
        write_page(results)
    counts = {
        verdict: sum(r.verdict == verdict for r in results) for verdict in ("right", "refused", "wrong")
    }
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return 1 if counts["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
