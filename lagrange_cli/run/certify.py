"""Runs with a certificate: its requirements, and its companions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.integrate.methods.table import TAYLOR
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.store.layout import Series

ORDERS = 26, 32
"""Orders of the companions at full double precision, where that of the run is 29. Together they take twice
the time of the run."""
FINER = 1e-3
"""If the run's tolerance is above double precision, the companion's is smaller by this factor. It is then so
much more accurate that a second companion is not needed."""
JUDGED = frozenset({"q", "v", "multipliers", "reactions"})
"""Outputs whose errors are estimated; q and v are among them even where they are not asked for."""


@dataclass(frozen=True)
class Demand:
    """The requirements of a certificate: the number of ``digits``, and the ``target`` error.

    Both are relative to the largest absolute value of a coordinate so far.
    """

    digits: float
    target: float | None

    def attributes(self) -> dict[str, float]:
        """The attributes of the file that record the requirements."""
        return {"digits": self.digits, **({} if self.target is None else {"target_error": self.target})}


def companion_settings(settings: Settings) -> tuple[Settings, tuple[int, ...]]:
    """The settings of the companions, and the order of each.

    They use the Taylor method, with orders other than that of the run, and with a smaller tolerance unless
    the run is at full precision.
    """
    from lagrange_cli.native.orders import order_for

    tolerance = max(FULL_PRECISION, FINER * settings.tolerance)
    outputs = settings.outputs & JUDGED | {"q", "v"}
    chosen = replace(settings, method=TAYLOR, tolerance=tolerance, outputs=outputs)
    limit = order_for(tolerance)
    return chosen, ORDERS if tolerance <= FULL_PRECISION else (min(ORDERS[0], limit),)


def series_of_errors(plain: tuple[Series, ...], companion: tuple[Series, ...]) -> tuple[Series, ...]:
    """The datasets of a run that is certified: its own, then the error of each that the companion has."""
    from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER

    texts = {FOLDER: "estimated error of {}", AS_RUN: "estimated error of {}, for the inputs of the run"}
    return (
        *plain,
        *(
            replace(one, path=folder + one.path, long_name=text.format(one.long_name))
            for folder, text in texts.items()
            for one in companion
        ),
    )
