"""The options that choose the members of an ensemble."""

from __future__ import annotations

from functools import wraps
from typing import Any

import click

from lagrange_cli.cli.options.completion import files
from lagrange_cli.cli.options.shared import SETTABLE, Command, Integer, parse_pairs

OPTIONS = (
    click.option(
        "--over",
        metavar="NAME=VALUES",
        multiple=True,
        callback=parse_pairs,
        shell_complete=SETTABLE,
        help="Sweep NAME over START:STOP:COUNT (both ends included), log:START:STOP:COUNT or a list such as "
        "1,2,5. Repeat it for a grid of all combinations. NAME is a parameter or an initial value (theta, "
        "theta_dot). Values may be expressions in parameters and constant definitions.",
    ),
    click.option(
        "--random",
        metavar="NAME=DISTRIBUTION",
        multiple=True,
        callback=parse_pairs,
        shell_complete=SETTABLE,
        help="Draw NAME from normal(mean,deviation), uniform(low,high), lognormal(median,sigma) or "
        "loguniform(low,high); repeatable.",
    ),
    click.option(
        "--members", type=Integer(min=1), help="The number of draws of --random, at each grid point."
    ),
    click.option(
        "--seed",
        type=Integer(min=0),
        default=0,
        help="The seed of the random numbers: the same seed gives the same numbers [0].",
    ),
    click.option(
        "--table",
        metavar="FILE.csv",
        shell_complete=files("csv"),
        help="Run one motion for each row of a CSV file. The first line has the names, as in "
        "m,theta,theta_dot.",
    ),
    click.option(
        "--jobs",
        type=Integer(min=1),
        help="The number of processors to use [all]. The results do not depend on it.",
    ),
)


def draw_options(command: Command) -> Command:
    """``--over``, ``--random``, ``--members``, ``--seed`` and ``--table`` as ``draws``, and ``--jobs``."""

    @wraps(command)
    def gathered(
        over: tuple[tuple[str, str], ...],
        random: tuple[tuple[str, str], ...],
        members: int | None,
        seed: int,
        table: str | None,
        **given: Any,
    ) -> Any:
        from lagrange_cli.run.ensembles.draws import Draws

        return command(draws=Draws(over, random, table, members, seed), **given)

    decorated: Any = gathered
    for option in reversed(OPTIONS):
        decorated = option(decorated)
    return decorated  # type: ignore[no-any-return]
