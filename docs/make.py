"""Write what the commands say into the pages: ``python docs/make.py``. A test fails when they differ.

``docs/cli.md`` and the manual pages in ``docs/man`` are made whole, from the commands' options. The tables of
keys and of datasets in ``docs/system-file.md`` and ``docs/output-file.md`` are made from the tables of the
package. In the other pages the blocks of ``sh`` and ``python`` are run in their order, as if they were
pasted, and the ``text`` block after one is what it prints.
``--renew`` renews times and step counts as well, which are otherwise kept where nothing else has changed.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from textwrap import fill

import click

sys.path.insert(0, str(Path(__file__).resolve().parent))
from manpages import pages, value_of

from lagrange_cli.cli.main import lagrange
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.spec.bodies.keys import BODY
from lagrange_cli.spec.declarations import COORDINATE, PARAMETER
from lagrange_cli.spec.draw.keys import BOUNDS, CAMERA, DRAW
from lagrange_cli.spec.events.keys import ACTION, EVENT
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settings import SOLVE
from lagrange_cli.spec.transformations import TRANSFORMATION

RENEWED = "--renew" in sys.argv
"""Whether what depends on the machine, such as times, is written anew as well."""

ROOT = Path(__file__).resolve().parent.parent
WIDTH = 118
"""Characters in a line of a page."""
PAGES = ("tutorial", "howto", "theory", "plot", "animate")
SESSIONS = (ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in PAGES))
RECIPES = ROOT / "docs" / "python.md"
BLOCK = re.compile(
    r"^```(?P<language>sh|python)\n(?P<code>.*?)^```\n(?:\n```text\n(?P<shown>.*?)^```\n)?",
    re.MULTILINE | re.DOTALL,
)
"""A block that is run, and, where a ``text`` block follows at once, what it prints."""

VARYING = re.compile(
    r"(?<=^  (?:taylor|DOP853)) .*|(?<=: taylor at ).*|(?<=\S) {2,}(?=\S)"
    r"|\d+(?= steps)|\d+(?= kB)|\d\.\de[-+]\d\d|\d+\.\d{3}(?= s|[,)])",
    re.MULTILINE,
)
"""What depends on the machine: steps, drifts, seconds, a row of ``bench`` with the width of its columns; and
the size of a page."""

MISTAKE = re.compile(r"\S+:\d+:\d+: ")
"""How the output of a command begins that is shown for a mistake in a file."""

TIMES = (
    "| `/t` | (n,) | sample times; the last is the stop time, even if the duration is not a multiple of "
    "`step` | always |"
)
ERRORS = (
    "| `/diagnostics/error/q/NAME`, `/diagnostics/error/v/NAME` | (n,) | an estimate of the error of each"
    " sample of q and v, see [below](#error-estimates) | `--certify` |\n"
    "| `/diagnostics/error/as_run/q/NAME`, `/diagnostics/error/as_run/v/NAME` | (n,) | the same for the"
    " inputs as they are rounded to doubles | `--certify` |\n"
    "| `/diagnostics/error/multipliers/NAME`, `/diagnostics/error/reactions/PARTICLE`, and the same under"
    " `as_run` | as the dataset | likewise of multipliers and reactions | `--certify`, if these are"
    " outputs |"
)
CROSSINGS = (
    "| `/events/NAME/t`, `/events/NAME/q/...`, `/events/NAME/v/...` | (k,) | the times at which an event"
    " happened, and the state there, see [below](#events) | always, if the file has events |"
)
"""The rows of the datasets that are no outputs."""

EXIT_STATUS = """## Exit status and output streams

Every command ends with one of these exit statuses:

| status | meaning |
|---|---|
| 0 | success |
| 1 | a fault in lagrange itself; please report it (`LAGRANGE_DEBUG=1` shows the traceback) |
| 2 | wrong usage: an option, its value, or an unknown name in `--set` |
| 3 | an error in the system file; every mistake is reported with its place and a way to correct it |
| 4 | the motion could not be continued (the results so far are kept), or `--verify` found a difference |
| 5 | a file could not be read or written |
| 130 | interrupted; the results so far are kept, and `--resume` continues (a second Ctrl-C quits at once) |

With several systems, the exit status is the highest of theirs. An error in one system does not stop the
others.

Ctrl-C in the first hundredths of a second, before lagrange's own code runs, is handled by Python, which
may show a traceback.

Results are written to standard output. Progress (on a terminal only), warnings and errors are written to
standard error. The commands may be used in a pipe that closes early, as with `| head -1`.

With `--json`, a system that fails has an object too, with `name`, `status` ("failed"), `message` and
`exit_code`. A number that does not exist, such as the drift of an h that is not conserved, is `null`.

`LAGRANGE_LIMITS=seconds=60,memory=2000` limits the time of a command in seconds and its memory in MB. When
the time is over, the command is interrupted (status 130). If it needs more memory, it ends with status 4.
These and the other [limits](security.md#the-limits) are meant for system files from elsewhere.

## Platforms

lagrange is developed and tested on Linux, on x86-64 processors and in part on emulated ARM64 ones. Windows
and macOS have not been tried on real machines. The tests imitate what Python lacks there, such as signals,
locks and limits. They check that each command works, and that the object code for these platforms refers to
nothing but their C libraries. LLVM's loader on these platforms, their file systems, and Ctrl-C in a Windows
console are not tested at all. The limit of the memory works on Linux only.
"""


def paragraphs(text: str | None) -> str:
    """Help text as Markdown: wrapped paragraphs, and lists of commands as code."""
    parts = []
    for part in (text or "").strip().split("\n\n"):
        lines = [line.strip() for line in part.splitlines()]
        if lines[0] == "\b":
            parts.append("```sh\n" + "\n".join(lines[1:]) + "\n```")
        else:
            parts.append(fill(" ".join(lines), WIDTH, break_long_words=False, break_on_hyphens=False))
    return "\n\n".join(parts)


def options(command: click.Command) -> Iterator[str]:
    """The rows of the table of options."""
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            metavar = value_of(parameter)
            names = ", ".join(f"`{name}`" for name in parameter.opts)
            value = f" `{metavar}`" if metavar else ""
            cell = f"{names}{value} | {' '.join((parameter.help or '').split())}"
            yield f"| {cell.replace('|', chr(92) + '|').replace(chr(92) + '| ', '| ', 1)} |"


def section(name: str, command: click.Command) -> str:
    """One command's part of the page; a group's is followed by those of its commands."""
    if isinstance(command, click.Group):
        inner = (section(f"{name} {each}", one) for each, one in command.commands.items())
        return "\n\n".join([f"## lagrange {name} COMMAND", paragraphs(command.help), *inner])
    arguments = [p.metavar or (p.name or "").upper() for p in command.params if isinstance(p, click.Argument)]
    usage = " ".join(["lagrange", name, "[OPTIONS]", *arguments])
    table = ["| option | effect |", "|---|---|", *options(command)]
    return "\n\n".join(
        [f"## {usage}", paragraphs(command.help), *(["\n".join(table)] if len(table) > 2 else [])]
    )


def page() -> str:
    """The whole page."""
    context = click.Context(lagrange)
    commands = {name: lagrange.get_command(context, name) for name in lagrange.list_commands(context)}
    return "\n\n".join(
        [
            "# The command line",
            "(This page is made by `python docs/make.py`.)",
            paragraphs(lagrange.help),
            *(section(name, command) for name, command in commands.items() if command is not None),
            EXIT_STATUS,
        ]
    )


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


def made() -> Iterator[tuple[Path, str]]:
    """Every page that is made, wholly or in part, with what it should say."""
    yield ROOT / "docs" / "cli.md", page()
    for name, text in pages():
        yield ROOT / "docs" / "man" / name, text
    for path in SESSIONS:
        yield path, run_sessions(path.read_text(encoding="utf-8"))
    yield RECIPES, run_together(RECIPES.read_text(encoding="utf-8"))
    for name, made_in in (("system-file.md", with_keys), ("output-file.md", with_outputs)):
        path = ROOT / "docs" / name
        yield path, made_in(path.read_text(encoding="utf-8"))


def with_keys(text: str) -> str:
    """The page of the system file with the tables of its keys, and of those within other keys."""
    rows = []
    for row in SECTIONS.rows:
        words = " or ".join(f"`{word}`" for word in (row.key, row.alias) if word)
        rows.append(f"| {words} | {row.meaning} |")
    places = {
        "`parameters`, NAME": PARAMETER,
        "`coordinates`, NAME": COORDINATE,
        "`bodies`, NAME": BODY,
        "`events`, NAME": EVENT,
        "`events`, NAME, `action`": ACTION,
        "`draw`": DRAW,
        "`draw`, `camera`": CAMERA,
        "`draw`, `camera`, `bounds`": BOUNDS,
        "`transformations`, NAME": TRANSFORMATION,
        "`solve`": SOLVE,
    }
    inner = [
        f"| {place} | {' or '.join(f'`{word}`' for word in (row.key, row.alias) if word)} | {row.meaning} |"
        for place, table in places.items()
        for row in table.rows
    ]
    text = with_rows(text, "| key | meaning |", rows)
    return with_rows(text, "| in | key | meaning |", inner)


def with_outputs(text: str) -> str:
    """The page of the output file with the table of its datasets: those of the outputs, and three others."""
    rows = []
    for row in OUTPUTS.values():
        paths = ", ".join(f"`{path}`" for path in row.datasets.split())
        default = f" (default, if the file has `{row.section}`)" if row.section else " (default)"
        written_by = f"`{row.name}`{default if row.default else ''}"
        rows.append(f"| {paths} | {row.shape} | {row.meaning} | {written_by} |")
    return with_rows(text, "| path | shape | what | written by |", [TIMES, *rows, CROSSINGS, ERRORS])


def with_rows(text: str, head: str, rows: list[str]) -> str:
    """The page with these rows in the table that begins with ``head``."""
    start = text.index(f"\n{head}\n") + 1
    _, rule, *_ = text[start:].splitlines()
    stop = text.index("\n\n", start)
    return "\n".join([text[:start] + head, rule, *rows]) + text[stop:]


def masked(text: str) -> str:
    """A page without what depends on the machine."""
    return VARYING.sub("...", text)


if __name__ == "__main__":
    for path, text in made():
        if RENEWED or not path.exists() or masked(path.read_text(encoding="utf-8")) != masked(text):
            path.write_text(text, encoding="utf-8")
