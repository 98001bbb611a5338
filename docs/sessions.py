"""Blocks of pages that are run in their order, as if they were pasted; what they print is put behind them."""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

RENEWED = "--renew" in sys.argv
"""Whether what depends on the machine, such as times, is written anew as well."""

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(
    r"^```(?P<language>sh|python)\n(?P<code>.*?)^```\n(?:\n```text\n(?P<shown>.*?)^```\n)?",
    re.MULTILINE | re.DOTALL,
)
"""A block that is run, and, where a ``text`` block follows at once, what it prints."""

VARYING = re.compile(
    r"(?<=^  (?:taylor|DOP853)) .*|(?<=: )(?:taylor|DOP853) at .*|(?<=\S) {2,}(?=\S)"
    r"|\d+(?= steps)|\d+(?= kB)|\d\.\de[-+]?\d+|\d+\.\d{3}(?= s|[,)])",
    re.MULTILINE,
)
"""What depends on the machine: steps, drifts, seconds, a row of ``bench`` with the width of its columns,
and the method that it recommends; and the size of a page."""

MISTAKE = re.compile(r"\S+:\d+:\d+: ")
"""How the output of a command begins that is shown for a mistake in a file."""


class Session:
    """A shell in an empty directory with the shipped systems, in which the blocks of a page are run in order.

    ``python3 -m venv ...`` of an installing line is taken as done, and so is what ``pip`` installs if the
    present environment has it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.copytree(ROOT / "systems", folder / "systems")
        commands = folder / ".commands"
        commands.mkdir()
        for name, content in (
            ("lagrange", f'exec "{sys.executable}" -m lagrange_cli "$@"'),
            ("python", f'exec "{sys.executable}" "$@"'),
            ("pip", f'exec "{sys.executable}" "{ROOT / "docs" / "present.py"}" "$@"'),
        ):
            (commands / name).write_text(f"#!/bin/sh\n{content}\n")
            (commands / name).chmod(0o755)
        self.environment = {
            **os.environ,
            "PATH": os.pathsep.join([str(commands), os.environ["PATH"]]),
            "PYTHONPATH": str(ROOT),
            "LAGRANGE_CACHE_DIR": str(folder / ".commands" / "cache"),
        }

    def run(self, language: str, code: str) -> subprocess.CompletedProcess[str]:
        """Run a block of ``sh`` or ``python``; its output has both streams."""
        if language == "sh":
            code = "\n".join(map(installed, code.splitlines()))
        command = ["bash", "-c", code] if language == "sh" else ["python", "-c", code]
        return subprocess.run(
            command,
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )


def installed(line: str) -> str:
    """A line without making and activating the environment; README's test line is ``.ci/run``'s to run."""
    if "pytest" in line or "bin/activate" in line:
        return ""
    if line.startswith("python3 -m venv"):
        line = line.partition(" && ")[2]
    return line.replace(".venv/bin/", "")


def run_sessions(text: str) -> str:
    """A page with its blocks run afresh, and what they print in the ``text`` blocks that follow them.

    Raises ``RuntimeError`` where one fails that does not show a mistake.
    """
    with tempfile.TemporaryDirectory() as name:
        session = Session(Path(name))

        def rerun(block: re.Match[str]) -> str:
            language, code, shown = block["language"], block["code"], block["shown"]
            run = session.run(language, code)
            printed = run.stdout
            if run.returncode != 0 and not MISTAKE.match(printed):
                raise RuntimeError(f"{code}ends with status {run.returncode}:\n{printed}")
            if shown is None:
                return block[0]
            return block[0][: block.start("shown") - block.start()] + steady(printed, shown) + "```\n"

        return BLOCK.sub(rerun, text)


def run_together(text: str) -> str:
    """A page with its ``python`` blocks run in one process, one after the other, in an empty directory with
    the shipped systems."""
    names: dict[str, object] = {"__name__": "__main__"}
    before = os.getcwd()

    def rerun(block: re.Match[str]) -> str:
        printed = io.StringIO()
        with redirect_stdout(printed):
            exec(compile(block["code"], "a block of the page", "exec"), names)
        if block["shown"] is None:
            assert not printed.getvalue(), f"{block['code']}prints something that the page does not show"
            return block[0]
        return f"{block[0][: block.start('shown') - block.start()]}{printed.getvalue()}```\n"

    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "systems", Path(folder) / "systems")
        os.chdir(folder)
        try:
            return BLOCK.sub(rerun, text)
        finally:
            os.chdir(before)


def steady(new: str, old: str) -> str:
    """The new text, but with the old lines wherever only what depends on the machine has changed."""
    if RENEWED:
        return new
    if masked(new) == masked(old):
        return old
    known = {masked(line): line for line in old.splitlines()}
    lines = [masked(line) for line in new.splitlines()]
    return "".join(
        f"{known.get(key, line) if lines.count(key) == 1 else line}\n"
        for key, line in zip(lines, new.splitlines())
    )


def masked(text: str) -> str:
    """A page without what depends on the machine."""
    return VARYING.sub("...", text)
