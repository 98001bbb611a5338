"""The integration methods: a row for each, with what it needs of compiled code and what it can do.

A new method is a row and a module of this package with a function ``follower``, as in ``taylor``.
"""

from __future__ import annotations

from enum import Enum

from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.records import dataclass


class Needs(Enum):
    """What the program of a method must provide."""

    SERIES = "series"  # whole steps: Taylor series of q, with the control of their size
    STEPS = "steps"  # whole steps: polynomials through accelerations, with the control of their size
    RATES = "rates"  # the accelerations
    JACOBIAN = "jacobian"  # and their derivatives by q and q_dot


@dataclass(frozen=True)
class MethodRow:
    """A method: its ``name`` in ``--method``, and the ``module`` that is imported when it is used.

    ``tolerances`` are, for each precision that it can compute in, its tightest one and its default. The
    steps of one that ``proves`` them do not pass over forces that act for a short time only. A ``portable``
    method gives the same bits on every machine. A ``parallel`` one spends its time in compiled code, so that
    several motions are followed at once. Whether a run can be resumed is no property of the row: a method
    that gives no snapshots is started again. One that ``constrains`` keeps motions to constraints. Errors of
    one that is ``absolute`` are relative to 1 + the size of a coordinate or velocity. One that ``approaches``
    most narrow forces by steps that become shorter does not miss these (``mechanics.approach``).
    """

    name: str
    module: str
    needs: Needs
    tolerances: dict[str, tuple[float, float]]
    proves: bool = False
    portable: bool = False
    parallel: bool = False
    finds_events: bool = False
    constrains: bool = False
    absolute: bool = False
    approaches: bool = False


TAYLOR = "taylor"
"""The project's own method."""
MANY_BODIES = "ias15"
"""The one for sums of many terms."""
MODERATE = "DOP853"
"""The one for moderate accuracy."""
STIFF = "Radau"
"""The one for stiff motions."""
AUTO = "auto"
"""The default: what suits the system (``run.choice``) and the motion (``run.trial``)."""
OF_SCIPY = {DOUBLE: (100 * FULL_PRECISION, 1e-10)}
"""scipy's methods raise smaller relative tolerances to this one, with a warning."""

METHODS = {
    row.name: row
    for row in (
        MethodRow(
            TAYLOR,
            "taylor",
            Needs.SERIES,
            # it pays about twice for full double precision, not ten times
            {DOUBLE: (1e-16, FULL_PRECISION), DOUBLE_DOUBLE: (FULL_DOUBLE_DOUBLE / 4, FULL_DOUBLE_DOUBLE)},
            proves=True,
            portable=True,
            parallel=True,
            finds_events=True,
            constrains=True,
        ),
        MethodRow(
            MANY_BODIES,
            "taylor",
            Needs.STEPS,
            {DOUBLE: (FULL_PRECISION, FULL_PRECISION)},
            portable=True,
            parallel=True,
            finds_events=True,
            constrains=True,
        ),
        *(
            MethodRow(
                name,
                "taylor",
                Needs.STEPS,
                OF_SCIPY,
                portable=True,
                parallel=True,
                finds_events=True,
                constrains=True,
                absolute=True,
                approaches=name == STIFF,
            )
            for name in (MODERATE, STIFF)
        ),
        MethodRow("BDF", "scipy", Needs.JACOBIAN, OF_SCIPY, absolute=True),
        MethodRow("LSODA", "scipy", Needs.JACOBIAN, OF_SCIPY, absolute=True),
    )
}
