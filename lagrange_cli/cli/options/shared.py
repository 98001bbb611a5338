"""Arguments and options that several commands share, each written once as a decorator."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import click

from lagrange_cli.cli.options.completion import SYSTEMS, files, names
from lagrange_cli.decimals import decimal
from lagrange_cli.records import dataclass

SETTABLE = names("parameters", "coordinates")
"""Completes what ``--set`` takes."""

Command = TypeVar("Command", bound=Callable[..., Any])


class Number(click.FloatRange):
    """A number between ``min`` and ``max``, as far as they are given; finite unless ``infinite``."""

    name = "number"

    def __init__(self, *, infinite: bool = False, **bounds: Any) -> None:
        super().__init__(**bounds)
        self.infinite = infinite

    def _describe_range(self) -> str:
        return between(self).removeprefix(" of").strip()

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            found = float(super().convert(value, param, ctx))
        except click.BadParameter:
            self.fail(f"{str(value)!r} is not a number{between(self)}", param, ctx)
        if math.isnan(found) or (math.isinf(found) and not self.infinite):
            self.fail(f"{str(value)!r} is not a finite number", param, ctx)
        return found


class Integer(click.IntRange):
    """An integer between ``min`` and ``max``, as far as they are given."""

    name = "integer"

    def _describe_range(self) -> str:
        return between(self).removeprefix(" of").strip()

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        try:
            whole = "e" in str(value).lower() and float(value).is_integer()  # 1e6
            return super().convert(int(float(value)) if whole else value, param, ctx)
        except (click.BadParameter, ValueError):
            self.fail(f"{str(value)!r} is not a whole number{between(self)}", param, ctx)


def between(bounds: click.FloatRange | click.IntRange) -> str:
    """`` greater than 0``, `` of at least 1``, `` from 1 to 15`` or nothing."""
    if bounds.min is None:
        return ""
    if bounds.min_open:
        return f" greater than {decimal(bounds.min)}" + (
            "" if bounds.max is None else f", at most {decimal(bounds.max)}"
        )
    return (
        f" of at least {decimal(bounds.min)}"
        if bounds.max is None
        else f" from {decimal(bounds.min)} to {decimal(bounds.max)}"
    )


def parse_overrides(
    context: click.Context, parameter: click.Parameter, pairs: tuple[str, ...]
) -> dict[str, str]:
    """``("m=1", "theta=pi/2")`` as a mapping, in which each name has one value."""
    found: dict[str, str] = {}
    for name, value in parse_pairs(context, parameter, pairs):
        if name in found:
            message = f"'{name}' is given twice, as {found[name]} and as {value}: leave one out"
            raise click.BadParameter(message, context, parameter)
        found[name] = value
    return found


EXAMPLES = {
    "sizes": "--size N=50",
    "overrides": "--set m=0.5",
    "over": "--over omega=0:10:101",
    "random": "'--random theta=normal(0,0.1)'",
}
"""What a value of each such option may look like."""


def parse_pairs(
    context: click.Context, parameter: click.Parameter, pairs: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    """``("m=1", "theta=pi/2")`` as pairs of names and texts."""
    found = []
    for pair in pairs:
        name, equals, value = (part.strip() for part in pair.partition("="))
        if not (name and equals and value):
            example = EXAMPLES[parameter.name or ""]
            raise click.BadParameter(f"{pair!r} is not NAME=VALUE, as in {example}", context, parameter)
        if further := re.search(r",\s*([^\W\d]\w*(?:\[.*?\])?\s*=(?!=).*)", value):
            option = parameter.opts[0]
            pairs = (f"{name}={value[: further.start()]}", further[1])
            example = " ".join(f"{option} {shlex.quote(pair)}" for pair in pairs)
            raise click.BadParameter(f"give {option} for each name: {example}", context, parameter)
        found.append((name, value))
    return tuple(found)


def parse_outputs(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> tuple[str, ...] | None:
    """``"q, v,h"`` as a tuple of names; their meaning is checked with the system at hand."""
    if text is None:
        return None
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise click.BadParameter("expected a comma-separated list, as in --outputs q,v,h", context, parameter)
    if text.rstrip().endswith(","):
        hint = "write the list without spaces, as in --outputs q,v,h"
        raise click.BadParameter(f"{text!r} ends in a comma: {hint}", context, parameter)
    return names


@dataclass(frozen=True)
class Given:
    """The values of the options that all commands about systems have."""

    overrides: dict[str, str]
    sizes: dict[str, str]
    as_json: bool
    quiet: bool


SIZE = click.option(
    "--size",
    "sizes",
    metavar="NAME=N",
    multiple=True,
    callback=parse_overrides,
    shell_complete=names("sizes"),
    help="Change a size that the file declares, as in N=50; repeatable.",
)


def given_options(command: Command) -> Command:
    """The shared options as one ``given``."""
    return given_with(SIZE)(command)


def given_with(size: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """The shared options as one ``given``, with another option ``--size`` that gives ``sizes``."""

    def decorated(command: Command) -> Command:
        @wraps(command)
        def gathered(
            overrides: dict[str, str], sizes: dict[str, str], as_json: bool, quiet: bool, **own: Any
        ) -> Any:
            return command(given=Given(overrides, sizes, as_json, quiet), **own)

        options: Any = shared_options
        found: Command = options(gathered, size)
        return found

    return decorated


def system_argument(command: Command) -> Command:
    """One system file, or ``-`` for standard input, as ``system``."""
    return click.argument("system", metavar="SYSTEM.yaml", shell_complete=files(*SYSTEMS))(command)


def systems_argument(command: Command) -> Command:
    """One or more system files (``-``: standard input), as ``systems``."""
    return click.argument(
        "systems", metavar="SYSTEM.yaml...", nargs=-1, required=True, shell_complete=files(*SYSTEMS)
    )(command)


def shared_options(command: Command, size: Callable[[Command], Command] = SIZE) -> Command:
    """``--set`` as ``overrides``, ``--size`` as ``sizes``, ``--json`` as ``as_json``, and ``--quiet``."""
    for option in reversed(
        (
            click.option(
                "--set",
                "overrides",
                metavar="NAME=VALUE",
                multiple=True,
                callback=parse_overrides,
                shell_complete=SETTABLE,
                help="Change a parameter or an initial value (theta, theta_dot); repeatable. "
                "VALUE is a number or an expression in parameters and constant definitions.",
            ),
            size,
            click.option(
                "--json",
                "as_json",
                is_flag=True,
                help="Print one JSON object per system on standard output, and nothing else.",
            ),
            click.option(
                "--quiet", is_flag=True, help="Print errors only: no summary, progress or warnings."
            ),
        )
    ):
        command = option(command)
    return command
