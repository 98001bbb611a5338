"""The limit on the text of a function, so that LLVM compiles it in bounded time and memory."""

from __future__ import annotations

from lagrange_cli.errors import TooLarge
from lagrange_cli.limits import way_out, whole

MOST_INSTRUCTIONS = whole("instructions")
SHORTER = "choose a method whose code is shorter: --method DOP853, "
"""A way out for systems without constraints: the others need the Taylor method."""
WAY_OUT = "write a smaller system, " + SHORTER + way_out("instructions")


def allow(instructions: int, cost: int = 1) -> None:
    """Raises ``TooLarge`` where so many, each of which takes ``cost`` times as long, cannot be compiled."""
    if instructions * cost > MOST_INSTRUCTIONS:
        raise TooLarge(f"the machine code has more than {MOST_INSTRUCTIONS // cost} instructions", WAY_OUT)
