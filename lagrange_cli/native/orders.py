"""The order of q's series that a tolerance asks for."""

from __future__ import annotations

import math

from lagrange_cli.native.interface import HIGHEST_ORDER

HIGHEST_DOUBLE_DOUBLE = 56


def order_for(tolerance: float) -> int:
    """In doubles: half as high again as Jorba and Zou's (2005, sec. 3.1).

    They count operations, which grow with the order's square. Here most of them are done side by side, and
    the time of an order is mostly that of its longest chain: longer steps of a higher order are cheaper, the
    more so the coarser the tolerance (docs/engine.md). A tolerance far below double precision makes steps
    shorter instead, and so the rounding of their sum less.
    """
    return min(HIGHEST_ORDER, math.ceil(10.9 - 0.5 * math.log(tolerance)))


def double_double_order(tolerance: float) -> int:
    """In double-double: as in doubles, three quarters of the logarithm of the tolerance."""
    return min(HIGHEST_DOUBLE_DOUBLE, 5 + math.ceil(-0.75 * math.log(tolerance)))


def lane_order(tolerance: float) -> int:
    """With a motion in each lane: a little above Jorba and Zou's, lower than that of single motions.

    With eight motions at once it is operations that take time, as they assume, and not chains of them.
    """
    return min(HIGHEST_ORDER, 2 + max(4, math.ceil(-0.6 * math.log(tolerance))))
