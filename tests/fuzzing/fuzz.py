"""Runs the commands on system files of every kind: ``python -m tests.fuzzing.fuzz [--minutes 60]``.

It mutates the shipped systems, the files of ``tests/fuzzing/corpus`` and those that ``grammar`` makes. The
mutation is guided by coverage, by atheris (``pip install '.[fuzz]'``): inputs that reach new code are kept in
the corpus and mutated further. Each input goes through ``check``, ``equations`` and ``solve`` in one process.
It is a finding, and is written to the folder of findings with its error, if

- a command ends with a traceback, or with an exit status that is not documented,
- a command does not end within 5 seconds of processor time (it is interrupted as by Ctrl-C after 4, because
  a file may ask for a lot of work), or takes 1 GB of memory,
- a file other than the output is written, or another program is started.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import io
import json
import os
import pkgutil
import random
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import FrameType
from typing import Any

from tests.fuzzing import grammar

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "tests" / "fuzzing" / "fuzz_corpus.tar.xz"
"""Inputs of earlier runs that reach different code: the initial corpus."""
SEEDS = (ROOT / "systems", ROOT / "tests" / "fuzzing" / "corpus")
PATIENCE, SECONDS = 4, 12
"""Seconds of processor time after which a command is interrupted, and within which it must end."""
AGAIN = 0.01
"""Seconds after which an interrupt is repeated that nothing would have come of."""
MEGABYTES = 1024
LONGEST = 8000
ROUND = 1000
"""Inputs for one process, so that memory which libraries never release does not accumulate."""
COMMANDS = (
    ("check",),
    ("check", "--json"),
    ("equations",),
    ("solve", "--stop", "0.01", "--samples", "3", "--force", "-o", "out.h5", "--outputs", "all"),
)
DOCUMENTED, INTERRUPTED = (0, 2, 3, 4, 5, 130), 130
SAFE = ("out.h5", ".out.h5.", os.devnull)
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
FORBIDDEN = ("os.system", "os.exec", "os.posix_spawn", "os.fork", "subprocess.Popen", "socket.connect",
             "os.mkdir", "os.symlink", "os.link", "os.chmod", "shutil.rmtree")  # fmt: skip

PARSER = "sympy_parser.py"
"""Where sympy runs the texts that it is given, also in a sum with an expression."""


class Hang(BaseException):
    """A command took too long; no command catches this."""


class Finding(Exception):
    """What must not happen."""


class Guard:
    """Notes what the interpreter does to files and processes while ``watching``.

    A hook is called many times and never leaves a process: it is there from the first ``watching`` on, so
    that other tests are not slowed.
    """

    def __init__(self) -> None:
        self.on = self.hooked = False
        self.seen: list[str] = []

    @contextmanager
    def watching(self) -> Iterator[None]:
        if not self.hooked:
            sys.addaudithook(self._note)
        before = sys.dont_write_bytecode
        # modules that a command is the first to import are compiled; Python would write what it compiles
        self.on = self.hooked = sys.dont_write_bytecode = True
        try:
            yield
        finally:
            self.on, sys.dont_write_bytecode = False, before

    def _note(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.on:
            return
        if event == "open":
            name, _, flags = arguments
            if isinstance(name, (str, bytes)) and isinstance(flags, int) and flags & WRITING:
                self._note_file(os.fsdecode(name))
        elif event in ("os.remove", "os.rename", "os.truncate"):
            self._note_file(os.fsdecode(arguments[0]))
        elif event.startswith(FORBIDDEN):
            self.seen.append(event)
        elif event == "compile" and sys._getframe(1).f_code.co_filename.endswith(PARSER):
            self.seen.append(f"sympy runs {arguments[0]!r}")

    def _note_file(self, name: str) -> None:
        if not os.path.basename(name).startswith(SAFE[:2]) and name != SAFE[2]:
            self.seen.append(f"file {name}")


GUARD = Guard()


def feed(content: bytes, commands: tuple[tuple[str, ...], ...] = COMMANDS) -> list[int]:
    """The exit status of each command on this system file, in the folder of this process.

    Raises ``Finding``.
    """
    import h5py  # noqa: F401  # looks for the kind of processor, by a program, when it is loaded

    from lagrange_cli.cli.main import main

    Path("input.yaml").write_bytes(content)
    found = []
    for command in commands:
        out, errors = Stream(), Stream()
        with redirect_stdout(out), redirect_stderr(errors), limited():
            try:
                with GUARD.watching():
                    status = main([*command, "input.yaml"])
            except Hang as error:
                raise Finding(f"{command[0]}: more than {SECONDS} s\n{traceback.format_exc()}") from error
        said = errors.getvalue()
        if status not in DOCUMENTED or "Traceback" in said:
            raise Finding(f"{command[0]}: exit status {status}\n{said}")
        if status and not said.strip():
            raise Finding(f"{command[0]}: exit status {status} without a word")
        if GUARD.seen:
            seen, GUARD.seen = GUARD.seen, []
            raise Finding(f"{command[0]}: {seen}")
        left = set(os.listdir()) - {"input.yaml", "out.h5"}
        if left:
            raise Finding(f"{command[0]}: left {sorted(left)}")
        found.append(status)
        if status == 3:  # the same file is as wrong for the other commands
            break
    return found


class Stream(io.TextIOWrapper):
    """Text that is kept in memory; what insists on a descriptor gets that of standard error."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", write_through=True)

    def fileno(self) -> int:
        return 2

    def getvalue(self) -> str:
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined, no-any-return]


def unheard(frame: FrameType | None) -> bool:
    """Whether what is raised there is ignored: in a finalizer, where weak references hear of what is gone, or
    as hypothesis hears of garbage."""
    while frame is not None and frame.f_code.co_name not in ("__del__", "gc_callback"):
        if frame.f_globals.get("__name__") in ("weakref", "_weakrefset"):
            return True
        frame = frame.f_back
    return frame is not None


@contextmanager
def limited() -> Iterator[None]:
    """A context in which Ctrl-C is pressed after a while, and that ends with ``Hang`` soon after."""
    rings = 0

    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal rings
        if unheard(frame):
            signal.setitimer(signal.ITIMER_PROF, AGAIN, SECONDS - PATIENCE)
            return
        rings += 1
        handler = signal.getsignal(signal.SIGINT)
        if rings > 1 or not callable(handler):
            raise Hang
        handler(signal.SIGINT, frame)

    before = signal.signal(signal.SIGPROF, ring)
    # what is started in the background has Ctrl-C ignored
    interrupts = signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE, SECONDS - PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        signal.signal(signal.SIGINT, interrupts)


def mutate(data: bytes, source: random.Random) -> bytes:
    """Another input: a new one from the grammar, or this one damaged."""
    if source.random() < 0.15:
        return grammar.system(source).encode(errors="replace")
    text = data.decode(errors="replace")
    for _ in range(source.choice((1, 1, 2, 4))):
        text = grammar.damaged(source, text)
    return text.encode(errors="replace")


def fuzz(findings: Path, corpus: list[str], seed: int, seconds: int) -> None:
    """One round in this process: inputs, until there have been so many or the time is over."""
    import atheris

    with atheris.instrument_imports(include=["lagrange_cli"]):
        import lagrange_cli

        for module in pkgutil.walk_packages(lagrange_cli.__path__, "lagrange_cli."):
            if not module.name.startswith(("lagrange_cli.work_precision", "lagrange_cli.__main__")):
                importlib.import_module(module.name)
    count = long = 0

    def one(data: bytes) -> None:
        nonlocal count, long
        count += 1
        (findings / "current").write_bytes(data)
        try:
            long += INTERRUPTED in feed(data)
        except Finding as error:
            note(findings, data, str(error))
        (findings / f"count-{seed}").write_text(f"{count} {long}")

    def other(data: bytes, most: int, number: int) -> bytes:
        source = random.Random(number)
        mutated = atheris.Mutate(data, most) if source.random() < 0.2 else mutate(data, source)
        return bytes(mutated[:most])

    options = [
        f"-seed={seed}", f"-runs={ROUND}", f"-max_total_time={seconds}", f"-max_len={LONGEST}",
        "-timeout=120",
        "-report_slow_units=120",
        f"-rss_limit_mb={MEGABYTES}", f"-artifact_prefix={findings}/", "-verbosity=0", "-len_control=0",
    ]  # fmt: skip
    atheris.Setup([sys.argv[0], *options, *corpus], one, custom_mutator=other)
    atheris.Fuzz()


def kept_inputs() -> dict[str, bytes]:
    """The inputs of ``KEPT`` by name."""
    with tarfile.open(KEPT) as archive:
        opened = {each.name: archive.extractfile(each) for each in archive}
        return {os.path.basename(name): file.read() for name, file in opened.items() if file is not None}


def note(findings: Path, data: bytes, what: str) -> None:
    """Write a finding, one file for each kind."""
    lines = [line.strip() for line in what.strip().splitlines()]
    places = [line for line in lines if line.startswith("File ") and "lagrange_cli" in line]
    kind = f"{lines[0]} {lines[-1][:40]} {places[-1:]}"
    name = hashlib.sha256(kind.encode()).hexdigest()[:12]
    if not (findings / f"{name}.yaml").exists():
        (findings / f"{name}.yaml").write_bytes(data)
        (findings / f"{name}.txt").write_text(what)
        print(f"finding {name}: {kind}", file=sys.stderr, flush=True)


def main() -> int:
    """Run rounds until the time is used up, each in a process of its own."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzzing.fuzz",
        description=(__doc__ or "").partition("\n\n")[2],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--minutes", type=float, default=60, help="duration in minutes [60]")
    parser.add_argument(
        "--corpus", type=Path, default=Path("corpus"), help="folder of inputs that reach new code"
    )
    parser.add_argument("--findings", type=Path, default=Path("findings"), help="folder of findings")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers [1]")
    parser.add_argument("--round", type=float, help=argparse.SUPPRESS)
    given = parser.parse_args()
    findings, corpus = given.findings.resolve(), given.corpus.resolve()
    if given.round is not None:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            fuzz(findings, [str(corpus), *map(str, SEEDS)], given.seed, int(given.round))
        return 0
    findings.mkdir(exist_ok=True)
    if not corpus.exists():
        corpus.mkdir()
        for name, data in kept_inputs().items():
            (corpus / name).write_bytes(data)
    began, rounds = time.monotonic(), 0
    environment = {
        **os.environ,
        "LAGRANGE_DEBUG": "1",
        "LAGRANGE_NO_CACHE": "1",
        "PYTHONPATH": str(ROOT),
        "PYTHONWARNINGS": "error::RuntimeWarning",
    }
    while (left := 60 * given.minutes - (time.monotonic() - began)) > 1:
        seed, rounds = given.seed + rounds, rounds + 1
        command = [sys.executable, "-m", "tests.fuzzing.fuzz", "--round", str(int(left)), "--seed", str(seed),
                   "--corpus", str(corpus), "--findings", str(findings)]  # fmt: skip
        status = subprocess.run(command, env=environment, check=False).returncode
        if status and (findings / "current").exists():
            data = (findings / "current").read_bytes()
            note(
                findings, data, f"the process ended with status {status}: {hashlib.sha256(data).hexdigest()}"
            )
        print(json.dumps(summary(findings, corpus, began, rounds)), flush=True)
    return 1 if any(findings.glob("*.yaml")) else 0


def summary(findings: Path, corpus: Path, began: float, rounds: int) -> dict[str, float]:
    """Counts of the rounds so far."""
    counts = [tuple(map(int, file.read_text().split())) for file in findings.glob("count-*")]
    return {
        "minutes": round((time.monotonic() - began) / 60, 1),
        "rounds": rounds,
        "inputs": sum(count for count, _ in counts),
        "asked to end": sum(long for _, long in counts),
        "kept": len(os.listdir(corpus)),
        "findings": len(list(findings.glob("*.yaml"))),
    }


if __name__ == "__main__":
    sys.exit(main())
