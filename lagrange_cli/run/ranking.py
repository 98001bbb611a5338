"""The ranking of methods as a table, as an object for JSON, and as curves to draw."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.integrate.methods.table import TAYLOR
from lagrange_cli.native.interface import HIGHEST_ORDER
from lagrange_cli.records import fields_of
from lagrange_cli.run.source import count_of
from lagrange_cli.work_precision.recommend import choose

if TYPE_CHECKING:
    from lagrange_cli.run.bench import Ranking
    from lagrange_cli.work_precision.figure import Picture
    from lagrange_cli.work_precision.measure import Result

HEADER = ("method", "tolerance", "steps", "evaluations", "ms", "error", "drift of h")


def as_text(ranking: Ranking) -> str:
    """The table, the reference for errors, and the recommendation."""
    reference = ranking.reference
    times = reference.times
    lines = [
        f"{ranking.name}: {count_of(ranking.degrees, 'degree')} of freedom, "
        f"t = {decimal(times.start)} to {decimal(times.stop)}, {times.count} samples",
        f"  reference: Taylor series of order {HIGHEST_ORDER}, {count_of(reference.steps, 'step')}; "
        f"its error is about {scientific(reference.error)}",
    ]
    if reference.reason:
        lines.append(
            f"  compared up to t = {decimal(times.stop)}, instead of {decimal(reference.asked)}: "
            f"{reference.reason}"
        )
    best = choose(ranking.results, ranking.wanted)
    chosen = "none" if best.result is None else str(best.result.contender)
    recommended = f"  for an error of {decimal(ranking.wanted)}: {chosen} ({best.because})"
    return "\n".join([*lines, "", *aligned([HEADER, *map(row, ranking.results)]), "", recommended])


def row(result: Result) -> tuple[str, ...]:
    """A line of the table; what has no figures has its reason in their place."""
    named = (result.contender.method, decimal(result.contender.tolerance, 2))
    if result.seconds is None or result.error is None:
        return (*named, f"{result.status}: {result.message}" if result.status != "cut" else result.message)
    bound = "<= " if result.bounded else ""
    return (
        *named,
        str(result.steps),
        str(result.evaluations),
        f"{1e3 * result.seconds:.2f}",
        f"{bound}{scientific(result.error)}",
        "-" if result.h_drift is None else scientific(result.h_drift),
    )


def aligned(rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    """Lines of columns: names to the left, figures to the right, a reason over what is left of the line."""
    whole = [each for each in rows if len(each) == len(rows[0])]
    widths = [max(len(each[k]) for each in whole) for k in range(len(rows[0]))]
    widths[:2] = [max(len(each[k]) for each in rows) for k in range(2)]
    for each in rows:
        name, *figures = each
        cells = [name.ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(figures, widths[1:]))]
        if len(each) < len(widths):
            cells[-1] = each[-1]
        yield "  " + "  ".join(cells).rstrip()


def as_object(ranking: Ranking) -> dict[str, Any]:
    """All of it for ``--json``."""
    reference, best = ranking.reference, choose(ranking.results, ranking.wanted)
    chosen = best.result
    return {
        "name": ranking.name,
        "degrees_of_freedom": ranking.degrees,
        "start": reference.times.start,
        "stop": reference.times.stop,
        "asked_stop": reference.asked,
        "samples": reference.times.count,
        "reference": {
            "method": TAYLOR,
            "order": HIGHEST_ORDER,
            "steps": reference.steps,
            "error": reference.error,
            "shortened_because": reference.reason or None,
        },
        "contenders": [as_row(result) for result in ranking.results],
        "wanted_error": ranking.wanted,
        "recommended": None if chosen is None else as_row(chosen),
        "because": best.because,
    }


def as_row(result: Result) -> dict[str, Any]:
    """One contender; ``error_is_bound`` where its error is below that of the reference."""
    figures = {
        name: getattr(result, name) for name in fields_of(result) if name not in ("contender", "bounded")
    }
    named = {"method": result.contender.method, "tolerance": result.contender.tolerance}
    return {**named, **figures, "error_is_bound": result.bounded}


def curves_of(ranking: Ranking) -> Picture:
    """The curves of the methods, as far as they have figures."""
    from lagrange_cli.work_precision.figure import Curve, Picture, Point

    def point(result: Result) -> Point:
        return Point(result.error or 0.0, result.seconds or 0.0, result.bounded)

    by_method: dict[str, list[Point]] = {}
    for each in ranking.results:
        if each.status == "complete":
            by_method.setdefault(each.contender.method, []).append(point(each))
    best = choose(ranking.results, ranking.wanted).result
    times = ranking.reference.times
    return Picture(
        title=f"{ranking.name}, t = {decimal(times.start)} to {decimal(times.stop)}",
        error_label="largest error of q, relative to its size",
        curves=tuple(Curve(name, tuple(points)) for name, points in by_method.items()),
        floor=ranking.reference.error,
        wanted=ranking.wanted,
        chosen=None if best is None else point(best),
    )
