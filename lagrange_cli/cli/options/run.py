"""What the commands that integrate share: their options, and the steps from a system to its output."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import lagrange_cli
from lagrange_cli.cli.completion.offers import comma_list, files, word
from lagrange_cli.cli.console import INTERRUPTED, STANDARD_INPUT, stem
from lagrange_cli.cli.options.shared import Command, parse_outputs, shared_options
from lagrange_cli.cli.source import derive_system, located
from lagrange_cli.errors import MotionError, UsageError
from lagrange_cli.integrate.methods.table import METHODS, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS, OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.formats import ENDINGS, HDF5
from lagrange_cli.run.settings import ALL, DEFAULT_SAMPLES, resolve_settings
from lagrange_cli.run.times import TIMES, with_times
from lagrange_cli.spec.spec import SolveDefaults, has_units

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.run.timings import Stopwatch
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.layout import Series
    from lagrange_cli.store.target import Target

EXIT_STATUS = {"complete": 0, "stopped": 0, "failed": MotionError.exit_code, "interrupted": INTERRUPTED}
"""The exit status for each way a motion can end; what was computed is written in every case."""

STANDARD_OUTPUT = "-"

SECONDS, COUNT = 10.0, 10**8
"""Seconds, and steps or members, between two checkpoints."""

OPTIONS = (
    click.option("--start", metavar="TIME", help="The time at which the motion begins [0]."),
    click.option(
        "--stop",
        metavar="TIME",
        help="The time at which the motion ends: a number, or an expression in parameters (10*2*pi/omega). "
        "If it is before the start, the motion is integrated backward.",
    ),
    click.option(
        "--samples", type=int, help=f"The number of samples, evenly spaced over the run [{DEFAULT_SAMPLES}]."
    ),
    click.option(
        "--step",
        metavar="TIME",
        help="The time between samples, in place of their number. The last sample is at the stop time.",
    ),
    click.option(
        "--tolerance", type=float, help="The relative error per step [full double precision; scipy: 1e-10]."
    ),
    click.option(
        "--method",
        metavar="NAME",
        shell_complete=word(METHODS),
        help=f"The integration method: one of {', '.join(METHODS)} [{TAYLOR}].",
    ),
    click.option(
        "--resume",
        is_flag=True,
        help="Continue an earlier run that was killed or interrupted, or extend one to a later --stop. The "
        "result has the same bytes as that of an uninterrupted run. Without an earlier run, start at the "
        "beginning.",
    ),
    click.option(
        "--checkpoint",
        type=click.FloatRange(min=0),
        default=SECONDS,
        help=f"The time in seconds between the checkpoints from which --resume continues [{SECONDS:g}].",
    ),
    click.option(
        "--checkpoint-count",
        type=click.IntRange(min=1),
        default=COUNT,
        help=f"Also write a checkpoint after this many steps (sweep: members) [{COUNT}].",
    ),
    click.option(
        "--force",
        is_flag=True,
        help="Replace any existing output. By default, only the result of a short run of the same command "
        "is replaced.",
    ),
    click.option(
        "--no-cache",
        is_flag=True,
        help="Do not use the cache of compiled programs ('lagrange cache --help').",
    ),
    click.option("--timings", is_flag=True, help="Print how long each stage took."),
)


@dataclass(frozen=True)
class Request:
    """What the command line asks of every system."""

    options: SolveDefaults
    times: dict[str, str]
    overrides: dict[str, str]
    sizes: dict[str, str]
    output: str | None
    force: bool
    cache: bool
    timings: bool
    as_json: bool
    quiet: bool
    resume: bool
    checkpoint: float
    checkpoint_count: int
    precision: str = DOUBLE
    portable: bool = False
    format: str = HDF5

    @property
    def streams(self) -> bool:
        """Whether the result goes to standard output."""
        return self.output == STANDARD_OUTPUT

    def settings(self, spec: Spec, parameters: Mapping[str, float]) -> Settings:
        """How the run of ``spec`` with these parameters is asked for."""
        exact = self.portable or self.precision != DOUBLE
        asked = with_times(self.options, self.times, spec, parameters, exact=exact)
        return resolve_settings(spec, asked, self.precision, self.portable)

    def options_given(self) -> dict[str, str]:
        """The options that the result depends on, as they are shown, by what they set."""
        given: dict[str, object] = {**self.times}
        given |= {name: getattr(self.options, name) for name in ("samples", "method", "tolerance")}
        given["outputs"] = None if self.options.outputs is None else ",".join(self.options.outputs)
        given["precision"] = None if self.precision == DOUBLE else self.precision
        given["format"] = self.format
        shown = {name: f"--{name} {value}" for name, value in given.items() if value is not None}
        if self.portable:
            shown["portable"] = "--portable"
        for option, pairs in (("set", self.overrides), ("size", self.sizes)):
            shown |= {f"{option} {name}": f"--{option} {name}={text}" for name, text in pairs.items()}
        return shown


def run_options(output: str, outputs: str) -> Callable[[Command], Command]:
    """The options of every command that integrates; the command gets them as one ``request``.

    ``output`` and ``outputs`` are the help of the options of these names.
    """

    def decorate(command: Command) -> Command:
        @wraps(command)
        def gathered(
            output: str | None, force: bool, no_cache: bool, timings: bool, overrides: dict[str, str],
            sizes: dict[str, str], as_json: bool, quiet: bool, resume: bool, checkpoint: float,
            checkpoint_count: int, **given: Any,
        ) -> Any:  # fmt: skip
            names = ("samples", "method", "tolerance", "outputs")
            times = {name: text for name in TIMES if (text := given.pop(name)) is not None}
            options = SolveDefaults(**{name: given.pop(name) for name in names})
            if resume and force:
                raise UsageError("--resume keeps the earlier run, --force discards it: give one of them")
            request = Request(
                options, times, overrides, sizes, output, force, not no_cache, timings, as_json, quiet,
                resume, checkpoint, checkpoint_count,
            )  # fmt: skip
            return command(request=request, **given)

        decorated: Any = shared_options(gathered)
        for option in (
            *reversed(OPTIONS),
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


def output_name(system: str, output: str | None, suffix: str = "", format: str = HDF5) -> str:
    """The file a system is written to."""
    return f"{stem(system)}{suffix}{ENDINGS[format]}" if output is None else output


def find_output(system: str, name: str, request: Request, options: Mapping[str, str]) -> Target:
    """The output, checked before any work is done for it; ``options`` are those that the command has beyond
    the request's."""
    from lagrange_cli.store.find_target import find_target
    from lagrange_cli.store.notes import Origin
    from lagrange_cli.store.target import Target

    if name == STANDARD_OUTPUT and request.format == HDF5:
        raise UsageError("HDF5 cannot go to standard output: add --format csv, or give --output a name")
    if name == STANDARD_OUTPUT:
        return Target("to standard output", Path(name), force=True)
    made_by = None
    if system != STANDARD_INPUT:
        given = {**options, **request.options_given()}
        made_by = Origin(os.path.realpath(system), given, time.monotonic(), request.cache)
    if os.path.isfile(name) and os.path.isfile(system) and os.path.samefile(name, system):
        raise UsageError(f"{name} is the system file itself: give --output another name")
    return find_target(name, force=request.force, resume=request.resume, origin=made_by)


def prepare_run(
    spec: Spec,
    settings: Settings,
    watch: Stopwatch,
    *,
    cached: bool,
    ensemble: bool = False,
    order: int | None = None,
    meanwhile: Callable[[], object],
) -> Prepared:
    """What the run needs in compiled form, from an earlier run if ``cached`` and there is one; ``meanwhile``
    loads what it needs from there on."""
    with watch.stage("import"):
        from lagrange_cli.integrate.prepare import prepare_system
        from lagrange_cli.native.compilation.cache import find_cache
    with located(spec):
        return prepare_system(
            spec,
            partial(derive_system, exact=settings.precision != DOUBLE, portable=settings.portable),
            find_cache(wanted=cached),
            settings.compilation(ensemble=ensemble, order=order),
            stage=watch.stage,
            meanwhile=meanwhile,
        )


def units_of(spec: Spec) -> Mapping[str, str]:
    """The units of datasets by path; a file without any unit does not even import what finds them."""
    if not has_units(spec):
        return {}
    from lagrange_cli.outputs.units import find_units

    return find_units(spec).texts


def series_of(units: Mapping[str, str], prepared: Prepared) -> tuple[Series, ...]:
    """The datasets of the run, with their units."""
    from lagrange_cli.store.layout import Series

    found = [
        Series(
            dataset.path,
            dataset.shape,
            units.get(dataset.path, ""),
            dataset.long_name,
            dataset.axes,
            dataset.components,
        )
        for dataset in prepared.datasets
        if dataset.path != "t"
    ]
    if prepared.machine.program.parts > 1:
        from lagrange_cli.integrate.samples import LOW

        text = "low part of {}, to be added to /{}"
        found += [
            replace(one, path=LOW + one.path, long_name=text.format(one.long_name, one.path)) for one in found
        ]
    return tuple(found)


def origin(
    spec: Spec, settings: Settings, parameters: dict[str, float], initial: Any, sampled: bool = True
) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file; ``initial`` stands for the initial state, or
    many."""
    import json

    names = ("start", "stop", "count", "step") if sampled else ("start", "stop")
    asked = {name: getattr(settings, name) for name in names}
    return {
        "generator": f"lagrange-cli {lagrange_cli.__version__}",
        "name": spec.name,
        "spec": spec.text,
        "parameters": json.dumps(parameters),
        **({"sizes": json.dumps(dict(spec.sizes))} if spec.sizes else {}),
        "method": settings.method,
        "tolerance": settings.tolerance,
        **({} if settings.precision == DOUBLE else {"precision": settings.precision}),
        **({"portable": 1} if settings.portable else {}),
        "run": json.dumps({**asked, "outputs": sorted(settings.outputs), "initial": initial}),
    }
