"""The recommendation: the fastest method and tolerance for a required error."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.decimals import scientific
from lagrange_cli.records import dataclass
from lagrange_cli.work_precision.measure import Result


@dataclass(frozen=True)
class Choice:
    """The recommended contender, None where none reaches the required error; and the reason."""

    result: Result | None
    because: str


def choose(results: Sequence[Result], wanted: float) -> Choice:
    """The fastest contender whose error is at most ``wanted``."""
    known = [(each.seconds, each.error, each) for each in results if each.seconds and each.error is not None]
    reaching = sorted((row for row in known if row[1] <= wanted), key=lambda row: row[0])
    if not reaching:
        if not known:
            return Choice(None, "no method reached the end")
        error, nearest = min(((row[1], row[2].contender) for row in known), key=lambda row: row[0])
        return Choice(
            None, f"no method reaches this accuracy; the smallest error is {scientific(error)}, of {nearest}"
        )
    seconds, _, best = reaching[0]
    if len(reaching) == 1:
        return Choice(best, "the only one with this accuracy")
    because = f"the fastest of {len(reaching)} with this accuracy"
    others = [row for row in reaching if row[2].contender.method != best.contender.method]
    if not others:
        return Choice(best, f"{because}, all of the same method")
    times = others[0][0] / seconds
    digits = 1 if times < 10 else 0
    return Choice(best, f"{because}; {others[0][2].contender} takes {times:.{digits}f} times as long")
