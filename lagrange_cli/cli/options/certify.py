"""``solve --certify``: its options, the companions it needs, and its line in the summary."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.options.shared import Command
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import TAYLOR
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.cli.options.run import Request
    from lagrange_cli.integrate.certify.certificate import Certificate
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.spec.values import Values
    from lagrange_cli.store.layout import Series

DIGITS = 6.0
ORDERS = 26, 32
"""Orders of the companions at full double precision, where that of the run is 29. Together they take twice
the time of the run."""
BETTER = 1e-3
"""If the run's tolerance is above double precision, the companion's is smaller by this factor. It is then so
much more accurate that a second companion is not needed."""

OPTIONS = (
    click.option(
        "--certify",
        is_flag=True,
        help="Write an estimate of the error of every sample. Companion runs with other orders provide it.",
    ),
    click.option(
        "--digits",
        type=click.FloatRange(min=1, max=15),
        help="Report the time up to which every coordinate has this many correct digits, relative to its "
        f"largest value so far (implies --certify) [{DIGITS:g}].",
    ),
    click.option(
        "--target-error",
        type=float,
        metavar="ERROR",
        help="End the run, with exit status 4, when the estimated error of a coordinate exceeds this "
        "fraction of its largest value so far (implies --certify).",
    ),
)


@dataclass(frozen=True)
class Demand:
    """The requirements of a certificate: the number of ``digits``, and the ``target`` error."""

    digits: float
    target: float | None

    def options_given(self) -> dict[str, str]:
        """The options that say so, as ``Request`` has the others."""
        target = {} if self.target is None else {"target-error": f"--target-error {self.target:g}"}
        return {"digits": f"--certify --digits {self.digits:g}", **target}

    def attributes(self) -> dict[str, float]:
        """The attributes of the file that record the requirements."""
        return {
            "digits": self.digits,
            **({} if self.target is None else {"target_error": self.target}),
        }


def certify_options(command: Command) -> Command:
    """``--certify``, ``--digits`` and ``--target-error`` as one ``demand``: None where none is given."""

    @wraps(command)
    def gathered(
        certify: bool, digits: float | None, target_error: float | None, request: Request, **given: Any
    ) -> Any:
        demand = None
        if target_error is not None and not target_error > 0:
            raise UsageError(f"the target error must be a positive number, not {target_error:g}")
        if certify or digits is not None or target_error is not None:
            demand = Demand(DIGITS if digits is None else digits, target_error)
            if request.resume:
                raise UsageError("a run with --certify writes no checkpoints: leave out --resume")
        return command(request=request, demand=demand, **given)

    decorated: Any = gathered
    for option in reversed(OPTIONS):
        decorated = option(decorated)
    return decorated  # type: ignore[no-any-return]


def companion_settings(settings: Settings) -> tuple[Settings, tuple[int, ...]]:
    """The settings of the companions: the Taylor method, with orders other than that of the run, and with a
    smaller tolerance unless the run is at full precision."""
    from lagrange_cli.native.program import order_for

    tolerance = max(FULL_PRECISION, BETTER * settings.tolerance)
    chosen = replace(settings, method=TAYLOR, tolerance=tolerance, outputs=frozenset({"q", "v"}))
    limit = order_for(tolerance)
    return chosen, ORDERS if tolerance <= FULL_PRECISION else (min(ORDERS[0], limit),)


def series_of_errors(plain: tuple[Series, ...], companion: tuple[Series, ...]) -> tuple[Series, ...]:
    """The datasets of a run that is certified: its own, then the error of each that the companion has."""
    from lagrange_cli.integrate.certify.certificate import FOLDER

    return (
        *plain,
        *(
            replace(one, path=FOLDER + one.path, long_name=f"estimated error of {one.long_name}")
            for one in companion
        ),
    )


def certificate_of(
    demand: Demand | None, companions: Sequence[Prepared], values: Values, times: Times
) -> AbstractContextManager[Certificate | None]:
    """The certificate asked for, if one is."""
    if demand is None:
        return nullcontext()
    from lagrange_cli.integrate.certify.certificate import Certificate

    return Certificate(companions, values, times, demand.digits, demand.target)


def certified_shown(outcome: Outcome, demand: Demand | None) -> list[str]:
    """The line of the summary."""
    if demand is None:
        return []
    return [
        f"  certified: {demand.digits:g} digits up to t = {outcome.trusted_until:.10g}, "
        f"error at the end {outcome.error:.1e}"
    ]
