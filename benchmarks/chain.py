"""A chain of ten pendulums, written out by hand, over 10 s: from the file to compiled code, and the run."""

from __future__ import annotations

import sys
from functools import partial

from benchmarks.contenders import heyoka, lagrange
from benchmarks.engines import PACKAGES, compare, comparison_table
from benchmarks.pendulums import Pendulums
from benchmarks.report import Requirement, conclude, parser

CHAIN = Pendulums(angles=tuple(round(2.0 + 0.1 * i, 1) for i in range(10)), stop=10.0)
SPEEDUP = 5
ENERGY_ERROR = 1e-12
REPEATS = 5

OURS, PEER = "lagrange", "heyoka, compact mode"


def main() -> int:
    """Measure, print, and say by the exit status whether the figures are reached."""
    options = parser(__doc__, runs=7).parse_args()
    measured = compare(
        {OURS: partial(lagrange, CHAIN, REPEATS), PEER: partial(heyoka, CHAIN, REPEATS, compact_mode=True)},
        options.runs,
    )
    ours, peer = measured[OURS], measured[PEER]
    requirements = [
        Requirement("our preparation over heyoka's", ours.prepare / peer.prepare, "<", 1),
        Requirement("heyoka's run over ours", peer.run / ours.run, ">=", SPEEDUP),
        Requirement("our relative energy error", ours.energy_error, "<=", ENERGY_ERROR),
    ]
    return conclude([comparison_table(measured, OURS)], requirements, PACKAGES)


if __name__ == "__main__":
    sys.exit(main())
