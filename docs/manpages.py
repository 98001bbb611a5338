"""Manual pages of the commands in roff, made of what click knows of them. Wheels install ``docs/man``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import click

from lagrange_cli.cli.main import COMMANDS, lagrange
from lagrange_cli.version import __version__

STATUSES = {
    "0": "success",
    "1": "a fault in lagrange itself",
    "2": "wrong usage",
    "3": "an error in the system file",
    "4": "the motion could not be continued, or printed and compiled equations differ",
    "5": "a file could not be read or written",
    "130": "interrupted; the results so far are kept",
}
VARIABLES = {
    "LAGRANGE_CACHE_DIR": "The folder of the cache of compiled programs.",
    "LAGRANGE_NO_CACHE": "If it is 1, the cache is not used.",
    "LAGRANGE_LIMITS": "Limits, as in seconds=60,memory=2000: the time of a command in seconds, its memory "
    "in MB, and others.",
    "LAGRANGE_DEBUG": "If it is 1, a fault in lagrange itself shows its traceback.",
}


def escaped(text: str) -> str:
    """Text as roff has it: no hyphen is a dash, no line begins with a request."""
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.MULTILINE)


def paragraphs(text: str | None) -> Iterator[str]:
    """Help text: filled paragraphs, and lists of commands as they are."""
    for part in (text or "").strip().split("\n\n"):
        lines = [line.strip() for line in part.splitlines()]
        if lines[0] == "\b":
            yield ".PP\n.RS 4\n.nf\n" + "\n".join(map(escaped, lines[1:])) + "\n.fi\n.RE"
        else:
            yield f".PP\n{escaped(' '.join(lines))}"


def value_of(option: click.Option) -> str:
    """What stands behind an option, if anything does: the same for every version of click."""
    if option.metavar is not None or option.is_flag or option.count:
        return option.metavar or ""
    choices = getattr(option.type, "choices", None)
    return "|".join(map(str, choices)) if choices else option.type.name.split()[0].upper()


def options(command: click.Command) -> Iterator[str]:
    """An entry for each option."""
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            value = value_of(parameter)
            shown = f" \\fI{escaped(value)}\\fR" if value else ""
            text = " ".join((parameter.help or "").split())
            yield f".TP\n\\fB{escaped(', '.join(parameter.opts))}\\fR{shown}\n{escaped(text)}"
    yield f".TP\n\\fB{escaped('-h, --help')}\\fR\nShow the help and exit."


def listed(entries: Mapping[str, str]) -> Iterator[str]:
    """Words with their meanings."""
    return (f".TP\n\\fB{escaped(word)}\\fR\n{escaped(text)}" for word, text in entries.items())


def page(name: str, purpose: str, command: click.Command) -> str:
    """The page of a command, ``lagrange`` or ``lagrange solve``."""
    arguments = [p.metavar or (p.name or "").upper() for p in command.params if isinstance(p, click.Argument)]
    group = isinstance(command, click.Group)
    usage = [*(["COMMAND"] if group else []), *arguments]
    title = name.replace(" ", "-")
    parts = [
        f'.TH "{escaped(title.upper())}" "1" "" "lagrange {__version__}" "lagrange manual"',
        f".SH NAME\n{escaped(title)} \\- {escaped(purpose.rstrip('.'))}",
        f".SH SYNOPSIS\n\\fB{escaped(name)}\\fR [\\fIOPTIONS\\fR] {escaped(' '.join(usage))}".rstrip(),
        ".SH DESCRIPTION",
        *paragraphs(command.help),
    ]
    if isinstance(command, click.Group):
        context = click.Context(command)
        inner = {each: command.get_command(context, each) for each in command.list_commands(context)}
        told = {each: one.get_short_help_str(200) for each, one in inner.items() if one is not None}
        parts += [".SH COMMANDS", *listed(COMMANDS if name == "lagrange" else told)]
    parts += [".SH OPTIONS", *options(command)]
    parts += [".SH EXIT STATUS", *listed(STATUSES), ".SH ENVIRONMENT", *listed(VARIABLES)]
    others = ["lagrange", *(f"lagrange-{each}" for each in COMMANDS)]
    also = ", ".join(f"\\fB{escaped(one)}\\fR(1)" for one in others if one != title)
    return "\n".join([*parts, f".SH SEE ALSO\n{also}", ""])


def pages() -> Iterator[tuple[str, str]]:
    """Every page, with the name of its file."""
    yield "lagrange.1", page("lagrange", "Lagrangian mechanics from a YAML file", lagrange)
    context = click.Context(lagrange)
    for name, purpose in COMMANDS.items():
        command = lagrange.get_command(context, name)
        assert command is not None
        yield f"lagrange-{name}.1", page(f"lagrange {name}", purpose, command)
