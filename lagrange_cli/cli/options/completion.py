"""What the shell offers when a user presses Tab: files, words of comma lists, names in a system file.

The shell runs the command with ``_LAGRANGE_COMPLETE`` set, at every Tab: so little is imported, and errors
are not reported.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from lagrange_cli.spec.nodes import Node

SYSTEMS = ("yaml", "yml")
"""The endings of system files."""
LARGEST = 200_000
"""The largest system file, in bytes, that is searched for names."""

Complete = Callable[[click.Context, click.Parameter, str], "list[CompletionItem[str]]"]


def item(value: str) -> CompletionItem[str]:
    """Something that is offered as it is."""
    from click.shell_completion import CompletionItem

    return CompletionItem(value)


def files(*endings: str) -> Complete:
    """Files with these endings, and directories; all files if there are none of these."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type="file", endings=endings)]

    return complete


def word(words: Iterable[str]) -> Complete:
    """One of the words, in any case of letters."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        return [item(one) for one in words if one.lower().startswith(incomplete.lower())]

    return complete


def comma_list(words: Iterable[str]) -> Complete:
    """The next word of a comma list, of those that it does not have yet."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        before, comma, last = incomplete.rpartition(",")
        given = before.split(",")
        left = (one for one in words if one not in given and one.lower().startswith(last.lower()))
        return [item(before + comma + one) for one in left]

    return complete


def names(*sections: str) -> Complete:
    """``NAME=`` for the names in these sections of the system file on the command line. What has several
    values ends in ``[``; a coordinate stands for its velocity, too."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        found: dict[str, None] = {}
        for system in systems_typed() if "=" not in incomplete else ():
            with suppress(Exception):
                found |= dict.fromkeys(names_in(system, sections))
        return [item(name) for name in found if name.startswith(incomplete)]

    return complete


def expression(*sections: str) -> Complete:
    """An expression, whose last word is one of the names in these sections."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        typed = re.search(r"(?<!\w)([^\W\d]\w*)?$", incomplete)
        if typed is None:  # a number
            return []
        before = incomplete[: typed.start()]
        found = names(*sections)(context, parameter, incomplete[len(before) :])
        return [item(before + one.value.removesuffix("=")) for one in found]

    return complete


def systems_typed() -> Iterator[str]:
    """The system files on the command line. (click has parsed it no further than to the option whose value
    is missing.)"""
    from click.shell_completion import split_arg_string

    for text in split_arg_string(os.environ.get("COMP_WORDS", "")):
        path = os.path.expanduser(text)
        if path.endswith(SYSTEMS) and os.path.isfile(path):
            yield path


def names_in(system: str, sections: Sequence[str]) -> Iterator[str]:
    """The beginnings of ``NAME=VALUE`` that a system file allows."""
    from lagrange_cli.spec.nodes import Mapping, Sequence, compose, decode
    from lagrange_cli.spec.problems import Problems

    with open(system, "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        return
    source = decode(content, system)
    root = compose(source, Problems(source))
    for key, node in root.entries if isinstance(root, Mapping) else ():
        if key.text not in sections:
            continue
        entries: Iterable[tuple[str, Node | None]] = ()
        if isinstance(node, Mapping):
            entries = ((name.text, value) for name, value in node.entries)
        elif isinstance(node, Sequence):
            entries = ((name.text, None) for name in node.items if hasattr(name, "text"))
        for name, value in entries:
            family, bracket, _ = name.partition("[")
            end = "[" if bracket or isinstance(value, Sequence) else "="
            yield family + end
            if key.text == "coordinates":
                yield f"{family}_dot{end}"
