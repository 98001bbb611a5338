"""The commands of two checkouts in turns, to see whether a change has made anything slower:

    python -m benchmarks.tools.versions --before ../other-checkout

The motions are those of the suites ``integration``, ``chain``, ``ensemble`` and ``startup``. Each command is
a process of its own, with compiled programs in a cache that the checkout has for itself. Of the first three
suites the seconds of the integration count, as ``--json`` gives them, of ``startup`` those of the whole
process. Sections of a system file that one of the versions does not know are left out for both. A system that
one of them cannot read even so is skipped, and so is a command that one of them refuses. A line reports each.

The table has the medians of all turns, and ratios after / before of the medians and of the quickest runs. The
exit status is 1 if both ratios of a command exceed the limit.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

from benchmarks import ROOT
from benchmarks.harness.processes import OURS, run_process
from benchmarks.harness.report import markdown_table
from benchmarks.harness.turns import in_turns
from benchmarks.suites import chain, integration, startup

RUNS, LIMIT = 9, 1.03
MEMBERS = 2000
UNKNOWN = re.compile(r":\d+:1: unknown key '(\w+)'")
"""What is said of a section that a version does not know."""


class NotRead(Exception):
    """A version refuses a system or a command; the message is what it says."""


@dataclass(frozen=True)
class Command:
    """A command of the shell, by a short name, and whether its whole process counts."""

    name: str
    arguments: tuple[str, ...]
    whole: bool = False


def commands() -> list[Command]:
    """Those of every suite."""
    found = []

    def solve(name: str, system: str, stop: float, *more: str) -> None:
        file = f"systems/{system}.yaml"
        sampled = ("--stop", repr(stop), "--samples", "101", "--json", "--force")
        found.append(Command(name, ("solve", file, *sampled, *more)))

    for comparison in integration.COMPARISONS:
        solve(f"integration: {comparison.title}", comparison.motion.system, comparison.motion.stop)
    for size, seconds in chain.SECONDS.items():
        solve(f"chain: N = {size}", "n_pendulum", seconds, "--size", f"N={size}")
    swept = ("sweep", "systems/double_pendulum.yaml", "--stop", "10", "--jobs", "1", "--json", "--force")
    drawn = [
        word for name in ("theta1=normal(2,0.1)", "theta2=normal(2.5,0.1)") for word in ("--random", name)
    ]
    found.append(Command(f"ensemble: {MEMBERS} members", (*swept, *drawn, "--members", str(MEMBERS))))
    for each in startup.COMMANDS:
        found.append(Command(f"startup: {each.shown}", each.arguments, whole=True))
    return found


def seconds_of(command: Command, processor: bool, root: Path, folder: Path) -> float:
    """One run with the package of a checkout; its ``processor`` time, if that is asked for."""
    environment = {
        "PYTHONPATH": str(root),
        "LAGRANGE_CACHE_DIR": str(folder / "cache"),
        "LAGRANGE_NO_CACHE": "",
        "PYTHONDONTWRITEBYTECODE": "",  # to compile every module is not what an installed package does
    }
    ended = run_process((*OURS, *command.arguments), folder, environment)
    if ended.status:
        raise NotRead(f"{command.name} is refused by {root}: {ended.errors.splitlines()[0]}")
    if processor:
        return ended.processor
    return ended.seconds if command.whole else float(json.loads(ended.printed)["seconds"]["integrate"])


def system_of(command: Command) -> str:
    """The path of the system file in its arguments; empty where there is none."""
    return next((one for one in command.arguments if one.endswith(".yaml")), "")


def given_to_both(system: str, places: Mapping[str, tuple[Path, Path]]) -> list[str]:
    """Write a system file to both folders; the sections that are left out, which not both versions know.

    Raises ``NotRead`` where that is not all that one of them refuses.
    """
    text, left_out = (ROOT / system).read_text(encoding="utf-8"), list[str]()
    for root, folder in places.values():
        file = folder / system
        file.write_text(text, encoding="utf-8")
        while said := refusal(system, root, folder):
            keys = UNKNOWN.findall(said)
            if not keys:
                raise NotRead(f"{system} is not read by {root}: {said.splitlines()[0]}")
            left_out += keys
            for key in keys:
                text = re.sub(rf"^{key}:.*\n(?:[ \t].*\n)*", "", text, flags=re.MULTILINE)
            file.write_text(text, encoding="utf-8")
    for _, folder in places.values():
        (folder / system).write_text(text, encoding="utf-8")
    return left_out


def refusal(system: str, root: Path, folder: Path) -> str:
    """What a version says that refuses a system; empty where it reads it."""
    ended = run_process((*OURS, "check", system), folder, {"PYTHONPATH": str(root)})
    return ended.errors if ended.status else ""


def main() -> int:
    """Run the commands in turns and print the table."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks.tools.versions",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--before", type=Path, required=True, help="a checkout of the earlier version")
    made.add_argument("--after", type=Path, default=ROOT, help="one of the later version [this checkout]")
    made.add_argument("--runs", type=int, default=RUNS, help=f"number of turns [{RUNS}]")
    made.add_argument("--processor", action="store_true", help="processor time of whole processes")
    made.add_argument("--only", default="", metavar="TEXT", help="only commands whose name has this text")
    options = made.parse_args()
    rows, slower = [], 0
    with tempfile.TemporaryDirectory() as folder:
        places = {}
        for which in ("before", "after"):
            root = getattr(options, which).resolve()
            places[which] = root, Path(folder, which)
            places[which][1].joinpath("systems").mkdir(parents=True)
        chosen = [command for command in commands() if options.only in command.name]
        unread = set[str]()
        for system in dict.fromkeys(filter(None, map(system_of, chosen))):
            try:
                if left_out := given_to_both(system, places):
                    print(f"{system}: without {', '.join(left_out)}, which not both versions know")
            except NotRead as error:
                print(f"{error}; skipped")
                unread.add(system)
        for command in chosen:
            if system_of(command) in unread:
                continue
            tasks: dict[str, Callable[[], float]] = {
                which: partial(seconds_of, command, options.processor, *place)
                for which, place in places.items()
            }
            try:
                in_turns(tasks, 2)  # so that everything is compiled, and at LLVM's highest level
                found = in_turns(tasks, options.runs)
            except NotRead as error:
                print(f"{error}; skipped")
                continue
            before, after = (median(found[which]) for which in places)
            quickest = min(found["after"]) / min(found["before"])
            slower += after / before > LIMIT and quickest > LIMIT
            rows.append(
                (
                    command.name,
                    *(f"{1e3 * each:.1f}" for each in (before, after)),
                    *(f"{each:.3f}" for each in (after / before, quickest)),
                )
            )
            print(" | ".join(rows[-1]), flush=True)
    head = ("command", "before, ms", "after, ms", "ratio of medians", "ratio of quickest")
    print(markdown_table(head, rows))
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
