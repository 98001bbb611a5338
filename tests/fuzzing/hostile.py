"""How long small files can keep the commands busy: ``python -m tests.fuzzing.hostile --files 300 --seed 1``.

Each file of ``growth`` and ``grammar`` goes through ``check``, ``equations`` in some form and
format, and ``solve``, each a process of its own whose processor time and memory are measured. The slowest and
the largest are printed. What ends in a traceback, by a signal, with an undocumented exit status or beyond the
bounds is printed, too, and its file written to the folder ``findings``. A motion may take any number of
steps: it is interrupted after a while, and must then say how far it has come.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

from tests.fuzzing import grammar, growth

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTED = (0, 2, 3, 4, 5)
FORMS = ("lagrange", "explicit", "hamilton", "matrix", "reactions", "vakonomic")
FORMATS = ("text", "unicode", "latex", "json", "python")
SECONDS, MEGABYTES = 60, 2000
"""What no command may need, of processor time and memory, to finish or refuse."""
PATIENCE = 40
"""Seconds of processor time after which a motion is interrupted."""


@dataclass(frozen=True, order=True)
class Measured:
    """One command on one file: ``seconds`` of processor time, ``megabytes`` at its largest."""

    seconds: float
    megabytes: float
    status: int
    command: str
    name: str
    said: str

    @property
    def is_bad(self) -> bool:
        """Whether it ended as no command may."""
        return (
            (self.status not in DOCUMENTED and not self.is_under_way)
            or "Traceback" in self.said
            or "please report" in self.said
            or (self.status != 0 and not self.said.strip())
            or self.seconds > SECONDS
            or self.megabytes > MEGABYTES
        )

    @property
    def is_under_way(self) -> bool:
        """Whether it was a motion that was interrupted."""
        return self.status == 130 and "interrupted at t = " in self.said


def files(count: int, seed: int) -> Iterator[tuple[str, str]]:
    """Names and texts: three of four from ``growth``."""
    source = Random(seed)
    for number in range(count):
        kind, text = ("grammar", grammar.system(source)) if number % 4 == 3 else growth.system(source)
        yield f"{number:03}-{kind}", text


def commands(source: Random) -> list[list[str]]:
    """The commands of one file."""
    shown = ["--form", source.choice(FORMS), "--format", source.choice(FORMATS)]
    solving = ["solve", "--stop", "0.001", "--samples", "2", "--no-cache", "--force", "-o", "out.h5"]
    if source.random() < 0.3:
        solving += ["--method", source.choice(("DOP853", "Radau", "LSODA", "BDF"))]
    elif source.random() < 0.2:
        solving += ["--precision", "double-double"]
    if source.random() < 0.3:
        solving += ["--outputs", "all"]
    return [["check"], ["equations", *shown], solving]


def measure(command: list[str], name: str, folder: Path) -> Measured:
    """Run one command in ``folder``."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (2 * SECONDS, 2 * SECONDS))
        resource.setrlimit(resource.RLIMIT_AS, (6_000_000_000, 6_000_000_000))

    program = [sys.executable, "-m", "lagrange_cli", *command, "input.yaml"]
    with (folder / "said").open("w+b") as said:
        process = subprocess.Popen(
            program, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=said, preexec_fn=limited
        )
        waited, used = wait(process.pid)
        process.returncode = status = os.waitstatus_to_exitcode(waited)
        said.seek(0)
        text = said.read().decode(errors="replace")
    seconds = used.ru_utime + used.ru_stime
    return Measured(seconds, used.ru_maxrss / 1024, status, " ".join(command), name, text)


def wait(pid: int) -> tuple[int, resource.struct_rusage]:
    """How a process ended, and what it used; it is interrupted when it has used ``PATIENCE`` seconds."""
    patient = True
    while True:
        ended, waited, used = os.wait4(pid, os.WNOHANG if patient else 0)
        if ended:
            return waited, used
        if processor_time(pid) > PATIENCE:
            os.kill(pid, signal.SIGINT)
            patient = False
        time.sleep(0.05)


def processor_time(pid: int) -> float:
    """Seconds of processor time that a process has used so far, as Linux tells."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run(count: int, seed: int, findings: Path | None = None) -> list[Measured]:
    """Everything measured, a line for each file."""
    found: list[Measured] = []
    source = Random(seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name, text in files(count, seed):
            (folder / "input.yaml").write_text(text, errors="replace")
            began = time.monotonic()
            mine = [measure(command, name, folder) for command in commands(source)]
            found += mine
            line = "  ".join(f"{one.status} {one.seconds:.1f} s {one.megabytes:.0f} MB" for one in mine)
            print(f"{name}: {line} ({time.monotonic() - began:.0f} s)", flush=True)
            if findings is not None and any(one.is_bad for one in mine):
                findings.mkdir(exist_ok=True)
                (findings / f"{seed}-{name}.yaml").write_text(text, errors="replace")
                (findings / f"{seed}-{name}.txt").write_text("\n\n".join(map(repr, mine)))
    return found


def main() -> int:
    """Measure, and say what was slowest and largest; 1 where something ended as no command may."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzzing.hostile")
    parser.add_argument("--files", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--findings", type=Path, default=Path("findings"))
    given = parser.parse_args()
    found = run(given.files, given.seed, given.findings)
    for title, ordered in (
        ("slowest", sorted(found, key=lambda one: -one.seconds)),
        ("largest", sorted(found, key=lambda one: -one.megabytes)),
    ):
        print(f"{title}:")
        for one in ordered[:5]:
            used = f"{one.seconds:.1f} s, {one.megabytes:.0f} MB, status {one.status}"
            print(f"  {used}: {one.command} {one.name}")
    bad = [one for one in found if one.is_bad]
    for one in bad:
        print(f"BAD {one.name}: {one.command}: status {one.status}, {one.seconds:.1f} s\n{one.said[-500:]}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
