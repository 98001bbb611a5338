"""``--timings``: where the time of a run went."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.run.timings import STAGES

NOTES = {
    "import": "loading Python modules",
    "parse": "reading and checking the system file",
    "derive": "deriving the equations of motion, and writing the program",
    "compile": "waiting for the compiler, which runs while modules are loaded",
    "cache": "looking for a compiled program, and storing a new one",
    "integrate": "integrating the motion",
    "write": "writing the output",
}


def as_table(seconds: Mapping[str, float], start: float, *, cached: bool) -> str:
    """A line for each stage that took place, in seconds; ``start`` is what passed before the first."""
    skipped = {"derive", "compile"} if cached else set()
    notes = NOTES | {"cache": "found the compiled program"} if cached else NOTES
    rows = [("start", start, "starting Python, reading the command line")]
    rows += [(name, seconds[name], notes[name]) for name in STAGES if name not in skipped]
    rows += [("total", start + seconds["total"], "")]
    names = {"cache": "cache hit"} if cached else {}
    return "\n".join(
        f"  {names.get(name, name):<10}{spent:8.3f} s  {note}".rstrip() for name, spent, note in rows
    )
