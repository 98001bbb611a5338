"""``Board``: where threads that share an evaluation find their work."""

from __future__ import annotations

from enum import IntEnum

from lagrange_cli.native.state import LANES


class Board(IntEnum):
    """Places of integers on a board, where threads find work (``native.families.sharing``). What different
    threads write is on lines of the cache of its own."""

    HELPERS = 0
    """How many threads help."""
    YIELD = 1
    """The address of a function that offers the processor to others."""
    LEFT = LANES
    """The number of the evaluation, and that of its strips that are left."""
    HALT = 2 * LANES
    """What ends helping, if it is not 0."""
    TIME = 3 * LANES
    STATE = 3 * LANES + 1
    WORK = 3 * LANES + 2
    PART = 3 * LANES + 3
    COUNT = 3 * LANES + 4
    """What is computed: the arguments, which part of it, in how many strips."""
    ORDER = 3 * LANES + 5
    """The order of a series."""
    RATES = 3 * LANES + 5
    CHANGE = 3 * LANES + 6
    SPEED = 3 * LANES + 7
    """Further arguments of the end of a step: where rates are expected, and what is allowed."""
    STRIPS = 4 * LANES
    """How far each strip has come, each on lines of its own (``LINE``), and numbers that it leaves."""


LINE = 2 * LANES
"""Numbers on a board for each strip."""
