"""``--certify`` and its options."""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.options.shared import Command, Number
from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError

if TYPE_CHECKING:
    from lagrange_cli.cli.output import Invocation
    from lagrange_cli.run.certify import Demand

DIGITS = 6.0

OPTIONS = (
    click.option(
        "--certify",
        is_flag=True,
        help="Write an estimate of the error of every sample: its distance from the exact motion of the "
        "system as written. Companion runs with other orders and roundings provide it.",
    ),
    click.option(
        "--digits",
        type=Number(min=1, max=15),
        help="Report the time up to which every coordinate has this many correct digits by this estimate, "
        f"relative to its largest value so far (implies --certify) [{decimal(DIGITS)}].",
    ),
    click.option(
        "--target-error",
        type=Number(),
        metavar="ERROR",
        help="End the run, with exit status 4, when the estimated error of a coordinate exceeds this "
        "fraction of its largest value so far (implies --certify).",
    ),
)


def certify_options(command: Command) -> Command:
    """``--certify``, ``--digits`` and ``--target-error`` as one ``demand``: None where none is given."""

    @wraps(command)
    def gathered(
        certify: bool, digits: float | None, target_error: float | None, asked: Invocation | None = None,
        **given: Any,
    ) -> Any:  # fmt: skip
        demand = None
        if target_error is not None and not target_error > 0:
            raise UsageError(f"the target error must be a positive number, not {decimal(target_error)}")
        if certify or digits is not None or target_error is not None:
            from lagrange_cli.run.certify import Demand

            demand = Demand(DIGITS if digits is None else digits, target_error)
            if asked is not None and asked.request.resume:
                raise UsageError(
                    "a run with --certify writes no checkpoints: --force in place of --resume starts it again"
                )
        return command(demand=demand, **({} if asked is None else {"asked": asked}), **given)

    decorated: Any = gathered
    for option in reversed(OPTIONS):
        decorated = option(decorated)
    return decorated  # type: ignore[no-any-return]


def options_given(demand: Demand | None) -> dict[str, str]:
    """The options of an error estimate as they were given, by what they set."""
    if demand is None:
        return {}
    target = {} if demand.target is None else {"target-error": f"--target-error {decimal(demand.target)}"}
    return {"digits": f"--certify --digits {decimal(demand.digits)}", **target}
