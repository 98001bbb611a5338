"""The comparison of methods and tolerances: the time and the error of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.records import dataclass
from lagrange_cli.work_precision.trajectory import follow

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.spec.values import Values
    from lagrange_cli.work_precision.reference import Reference


@dataclass(frozen=True)
class Contender:
    """A method at a tolerance."""

    method: str
    tolerance: float

    def __str__(self) -> str:
        return f"{self.method} at {decimal(self.tolerance, 2)}"


@dataclass(frozen=True)
class Result:
    """The result of a contender; ``message`` gives the reason where the status is not ``complete``.

    ``seconds`` is the median over ``runs``. ``error`` is the largest error of q, relative to its size. If it
    is less than that of the reference, it is replaced by the latter, and ``bounded`` is true.
    """

    contender: Contender
    status: str  # complete, failed, cut (its budget was used up), refused, skipped
    message: str = ""
    steps: int | None = None
    evaluations: int | None = None
    seconds: float | None = None
    runs: int = 0
    error: float | None = None
    bounded: bool = False
    h_drift: float | None = None


@dataclass(frozen=True)
class Rules:
    """The number of runs of a contender after its first one, and the seconds that all its runs may take."""

    runs: int
    budget: float


def measure_all(
    entries: Mapping[str, Sequence[float]],
    prepare: Callable[[Contender], Prepared],
    values: Values,
    reference: Reference,
    rules: Rules,
    interrupted: Callable[[], bool],
) -> Iterator[Result]:
    """The results of every method, one tolerance after the other, beginning with the coarsest.

    Once a method exceeds its budget, its finer tolerances are skipped.
    """
    for method, tolerances in entries.items():
        slow: Contender | None = None
        for tolerance in sorted(tolerances, reverse=True):
            contender = Contender(method, tolerance)
            if slow is not None:
                yield Result(contender, "skipped", f"{slow} already exceeded the budget")
                continue
            try:
                prepared = prepare(contender)
            except LagrangeError as error:
                yield Result(contender, "refused", str(error))
                continue
            result = measure(contender, prepared, values, reference, rules, interrupted)
            if interrupted():
                return
            slow = contender if result.status == "cut" else None
            yield result


def measure(
    contender: Contender,
    prepared: Prepared,
    values: Values,
    reference: Reference,
    rules: Rules,
    interrupted: Callable[[], bool],
) -> Result:
    """The contender's error from a first run, and its time from further runs that fit into the budget.

    If none fits, the time is that of the first run.
    """
    first = follow(prepared, values, reference.times, rules.budget, interrupted)
    outcome = first.outcome
    if outcome.ending is not Ending.COMPLETE:
        cut = outcome.ending is Ending.INTERRUPTED
        late = f"stopped after {decimal(rules.budget)} s (--budget) at t = {decimal(outcome.t, 3)}"
        message = late if cut else outcome.message
        return Result(
            contender, "cut" if cut else "failed", message, outcome.steps, outcome.evaluations,
            h_drift=outcome.h_drift,
        )  # fmt: skip
    seconds, spent = list[float](), first.seconds
    while len(seconds) < rules.runs and spent + first.seconds <= rules.budget and not interrupted():
        seconds.append(follow(prepared, values, reference.times, rules.budget, interrupted).seconds)
        spent += seconds[-1]
    error = reference.error_of(first.q)
    return Result(
        contender,
        "complete",
        steps=outcome.steps,
        evaluations=outcome.evaluations,
        seconds=median(seconds or [first.seconds]),
        runs=len(seconds) or 1,
        error=max(error, reference.error),
        bounded=error < reference.error,
        h_drift=outcome.h_drift,
    )
