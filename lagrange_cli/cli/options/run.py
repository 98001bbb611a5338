"""The options of the commands that integrate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any

import click

from lagrange_cli.cli.options.completion import comma_list, expression, files, word
from lagrange_cli.cli.options.shared import Command, Integer, Number, parse_outputs, shared_options
from lagrange_cli.cli.output import Invocation
from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import AUTO, METHODS
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE_COST, PRECISIONS
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS, OUTPUTS
from lagrange_cli.run.request import COUNT, FORMATS, SECONDS, TIMES, Request
from lagrange_cli.run.settings.outputs import ALL
from lagrange_cli.run.settings.samples import DEFAULT_SAMPLES
from lagrange_cli.spec.spec import SolveDefaults

OPTIONS: Mapping[str, Callable[[Command], Command]] = {
    "start": click.option(
        "--start",
        metavar="TIME",
        shell_complete=expression("parameters"),
        help="The time at which the motion begins [0].",
    ),
    "stop": click.option(
        "--stop",
        metavar="TIME",
        shell_complete=expression("parameters"),
        help="The time at which the motion ends: a number, or an expression in parameters (10*2*pi/omega). "
        "If it is before the start, the motion is integrated backward.",
    ),
    "samples": click.option(
        "--samples",
        type=Integer(),
        help=f"The number of samples, evenly spaced over the run [{DEFAULT_SAMPLES}].",
    ),
    "step": click.option(
        "--step",
        metavar="TIME",
        shell_complete=expression("parameters"),
        help="The time between samples, in place of their number. The last sample is at the stop time.",
    ),
    "tolerance": click.option(
        "--tolerance",
        type=Number(),
        help="The relative error per step [full double precision; DOP853, Radau, scipy: 1e-10].",
    ),
    "method": click.option(
        "--method",
        metavar="NAME",
        shell_complete=word((AUTO, *METHODS)),
        help=f"The integration method: one of {', '.join((AUTO, *METHODS))} [{AUTO}].",
    ),
    "proven": click.option(
        "--proven",
        is_flag=True,
        help="Prove for every step that its series satisfies the equations throughout the step. By default "
        "this is done only for systems in which a step might pass over a narrow force.",
    ),
    "project-initial": click.option(
        "--project-initial",
        "projected",
        is_flag=True,
        help="Move the initial state to the nearest one that satisfies the constraints, however far that is. "
        "Without it, values are moved by 1e-6 of their scale at most.",
    ),
    "resume": click.option(
        "--resume",
        is_flag=True,
        help="Continue an earlier run that was killed or interrupted; 'lagrange solve' also extends one to a "
        "later --stop. The result has the same bytes as that of an uninterrupted run. Without an earlier "
        "run, start at the beginning.",
    ),
    "checkpoint": click.option(
        "--checkpoint",
        type=Number(min=0, infinite=True),
        default=SECONDS,
        help="The time in seconds between the checkpoints from which --resume continues "
        f"[{decimal(SECONDS)}].",
    ),
    "checkpoint-count": click.option(
        "--checkpoint-count",
        type=Integer(min=1),
        default=COUNT,
        help=f"Also write a checkpoint after this many steps (sweep: members) [{COUNT}].",
    ),
    "force": click.option(
        "--force",
        is_flag=True,
        help="Replace any existing output. By default, only the result of a short run of the same command "
        "is replaced.",
    ),
    "no-cache": click.option(
        "--no-cache",
        is_flag=True,
        help="Do not use the cache of compiled programs ('lagrange cache --help').",
    ),
    "timings": click.option("--timings", is_flag=True, help="Print how long each stage took."),
}
"""By name."""


precision_option = click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    default=DOUBLE,
    help="The arithmetic: double has about 16 digits; double-double has 31 and takes "
    f"{DOUBLE_DOUBLE_COST} times as long [{DOUBLE}].",
)
format_option = click.option(
    "--format",
    "asked_format",
    type=click.Choice(FORMATS),
    help="The format of the output [csv if the name of the output ends in .csv, else hdf5].",
)


def run_options(output: str, outputs: str, without: Sequence[str] = ()) -> Callable[[Command], Command]:
    """The options of every command that integrates; the command gets them as one ``asked``.

    ``output`` and ``outputs`` are the help of the options of these names. A command may be ``without`` some.
    """

    def decorate(command: Command) -> Command:
        @wraps(command)
        def gathered(
            output: str | None, force: bool, no_cache: bool, timings: bool, overrides: dict[str, str],
            sizes: dict[str, str], as_json: bool, quiet: bool, resume: bool = False,
            checkpoint: float = SECONDS, checkpoint_count: int = COUNT, proven: bool = False,
            projected: bool = False, **given: Any,
        ) -> Any:  # fmt: skip
            names = ("samples", "method", "tolerance", "outputs")
            times = {name: text for name in TIMES if (text := given.pop(name, None)) is not None}
            options = SolveDefaults(**{name: given.pop(name, None) for name in names})
            if resume and force:
                raise UsageError("--resume keeps the earlier run, --force discards it: give one of them")
            request = Request(
                options,
                times,
                overrides,
                sizes,
                cache=not no_cache,
                resume=resume,
                checkpoint=checkpoint,
                checkpoint_count=checkpoint_count,
                proven=proven,
                projected=projected,
            )
            asked = Invocation(request, output, force=force, as_json=as_json, quiet=quiet, timings=timings)
            return command(asked=asked, **given)

        decorated: Any = shared_options(gathered)
        for option in (
            *(option for name, option in reversed([*OPTIONS.items()]) if name not in without),
            click.option(
                "--outputs",
                metavar="LIST",
                callback=parse_outputs,
                shell_complete=comma_list((*OUTPUTS, ALL)),
                help=outputs,
            ),
            click.option("-o", "--output", metavar="FILE.h5", shell_complete=files(), help=output),
        ):
            decorated = option(decorated)
        return decorated  # type: ignore[no-any-return]

    return decorate


def list_of_outputs() -> str:
    """For the help of ``--outputs``."""
    default = f"{','.join(DEFAULT_OUTPUTS)}, and observables if the file declares any"
    return (
        f"a comma-separated list of {', '.join(OUTPUTS)}, or all [{default}]. The ledgers are the balances "
        "of work and energy, and of force and momentum"
    )
