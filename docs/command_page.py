"""The page of the command line, from the commands' options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from textwrap import fill

import click
from manpages import value_of

from lagrange_cli.cli.main import COMMANDS, lagrange

WIDTH = 118
"""Characters in a line of a page."""

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


def overview(sections: dict[str, str]) -> str:
    """A table of the commands, with links to their sections."""
    rows = ["| command | what it does |", "|---|---|"]
    for name, text in sections.items():
        heading = text.partition("\n")[0].removeprefix("## ")
        anchor = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        rows.append(f"| [`lagrange {name}`](#{anchor}) | {COMMANDS[name]} |")
    return "\n".join(rows)


def page() -> str:
    """The whole page."""
    context = click.Context(lagrange)
    commands = {name: lagrange.get_command(context, name) for name in lagrange.list_commands(context)}
    sections = {name: section(name, command) for name, command in commands.items() if command is not None}
    return "\n\n".join(
        [
            "# The command line",
            paragraphs(lagrange.help),
            overview(sections),
            *sections.values(),
            EXIT_STATUS.rstrip(),
            "This page is made by `python docs/make.py`.\n",
        ]
    )
