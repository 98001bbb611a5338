"""The double pendulum over 1000 s from rest at (2.0, 2.5) rad, to full double precision: the integration
itself."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial

from benchmarks.contenders import Measurement, equations_by_hand, heyoka, lagrange, sympy_and_scipy
from benchmarks.engines import PACKAGES, compare, comparison_table
from benchmarks.pendulums import Pendulums
from benchmarks.report import Requirement, conclude, parser

DOUBLE_PENDULUM = Pendulums(angles=(2.0, 2.5), stop=1000.0)
SPEEDUP = 100
REPEATS = 5
SHORT = 10
"""By how much ``--quick`` shortens the slow contender's motion."""

OURS, SLOW = "lagrange", "sympy lambdify + scipy DOP853"


def main() -> int:
    """Measure, print, and say by the exit status whether the figures are reached."""
    made = parser(__doc__, runs=5)
    made.add_argument(
        "--quick",
        action="store_true",
        help="follow DOP853 over 100 s and multiply its time and steps by 10 (its error is that of 100 s)",
    )
    options = made.parse_args()
    factor = SHORT if options.quick else 1
    measured = compare(
        {
            OURS: partial(lagrange, DOUBLE_PENDULUM, REPEATS),
            SLOW: partial(sympy_and_scipy, replace(DOUBLE_PENDULUM, stop=DOUBLE_PENDULUM.stop / factor)),
            "heyoka, its lagrangian()": partial(heyoka, DOUBLE_PENDULUM, REPEATS),
            "heyoka, its lagrangian(), compact mode": partial(
                heyoka, DOUBLE_PENDULUM, REPEATS, compact_mode=True
            ),
            "heyoka, equations by hand": partial(
                heyoka, DOUBLE_PENDULUM, REPEATS, equations=equations_by_hand
            ),
            "heyoka, equations by hand, compact mode": partial(
                heyoka, DOUBLE_PENDULUM, REPEATS, equations=equations_by_hand, compact_mode=True
            ),
        },
        options.runs,
    )
    measured[SLOW] = lengthened(measured[SLOW], factor)
    ours, slow = measured[OURS], measured[SLOW]
    requirements = [
        Requirement(f"{SLOW}: times our run", slow.run / ours.run, ">=", SPEEDUP),
        Requirement("our energy error over that of DOP853", ours.energy_error / slow.energy_error, "<", 1),
    ]
    return conclude([comparison_table(measured, OURS)], requirements, PACKAGES)


def lengthened(measurement: Measurement, factor: int) -> Measurement:
    """What a motion ``factor`` times as long would take."""
    return replace(measurement, run=factor * measurement.run, steps=factor * measurement.steps)


if __name__ == "__main__":
    sys.exit(main())
