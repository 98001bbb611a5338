"""Which contender to take for the error that is wanted."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.contest.contest import Result
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Choice:
    """The contender to take for an error, None where none reaches it; and why."""

    result: Result | None
    because: str


def choose(results: Sequence[Result], wanted: float) -> Choice:
    """The fastest whose error is at most ``wanted``."""
    known = [(each.seconds, each.error, each) for each in results if each.seconds and each.error is not None]
    reaching = sorted((row for row in known if row[1] <= wanted), key=lambda row: row[0])
    if not reaching:
        if not known:
            return Choice(None, "no contender came to the end")
        error, nearest = min(((row[1], row[2].contender) for row in known), key=lambda row: row[0])
        return Choice(None, f"none reaches it; {nearest} comes nearest, with {error:.1e}")
    seconds, _, best = reaching[0]
    if len(reaching) == 1:
        return Choice(best, "no other reaches it")
    because = f"the fastest of {len(reaching)} that reach it"
    others = [row for row in reaching if row[2].contender.method != best.contender.method]
    if not others:
        return Choice(best, f"{because}, and no other method does")
    times = others[0][0] / seconds
    digits = 1 if times < 10 else 0
    return Choice(best, f"{because}; {others[0][2].contender} takes {times:.{digits}f} times as long")
