"""Write docs/cli.md from the commands: ``python docs/make_cli.py``. A test fails when they differ."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from lagrange_cli.cli.main import lagrange

PAGE = Path(__file__).with_name("cli.md")

EXIT_STATUS = """## Exit status

| status | meaning |
|---|---|
| 0 | done |
| 1 | a fault of lagrange itself; please report it (`LAGRANGE_DEBUG=1` shows where it happened) |
| 2 | wrong usage: an option, its value, a `--set` of an unknown name |
| 3 | the system file is wrong; every mistake is shown with its place and a way out |
| 4 | the motion could not be continued (what was computed is kept), or `--verify` found a difference |
| 5 | a file could not be read or written |
| 130 | interrupted (what was computed is kept; a second Ctrl-C gives up at once) |

With several systems: the highest of theirs; the others still run. Results go to standard output; progress (on
a terminal only), warnings and errors to standard error. With `--json` a system that fails has an object of
its own too: `name`, `status` ("failed"), `message` and `exit_code`. In JSON a number that does not exist,
as the drift of an h that is not conserved, is `null`. A reader that hangs up (`| head -1`) does not disturb
the work.
"""


def paragraphs(text: str | None) -> str:
    """Help text as Markdown: paragraphs on one line each, lists of commands as code."""
    parts = []
    for part in (text or "").strip().split("\n\n"):
        lines = [line.strip() for line in part.splitlines()]
        if lines[0] == "\b":
            parts.append("```sh\n" + "\n".join(lines[1:]) + "\n```")
        else:
            parts.append(" ".join(lines))
    return "\n\n".join(parts)


def options(command: click.Command) -> Iterator[str]:
    """The rows of the table of options."""
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            metavar = parameter.metavar
            if metavar is None and not parameter.is_flag:
                choices = getattr(parameter.type, "choices", None)
                metavar = "|".join(map(str, choices)) if choices else parameter.type.name.split()[0].upper()
            names = ", ".join(f"`{name}`" for name in parameter.opts)
            value = f" `{metavar}`" if metavar else ""
            cell = f"{names}{value} | {' '.join((parameter.help or '').split())}"
            yield f"| {cell.replace('|', chr(92) + '|').replace(chr(92) + '| ', '| ', 1)} |"


def section(name: str, command: click.Command) -> str:
    """One command's part of the page."""
    arguments = [p.metavar or (p.name or "").upper() for p in command.params if isinstance(p, click.Argument)]
    usage = " ".join(["lagrange", name, "[OPTIONS]", *arguments])
    table = ["| option | |", "|---|---|", *options(command)]
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
            "(This page is made by `python docs/make_cli.py`.)",
            paragraphs(lagrange.help),
            *(section(name, command) for name, command in commands.items() if command is not None),
            EXIT_STATUS,
        ]
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
