"""The tables of keys and of datasets in the pages, from those of the package."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.integrate.methods.table import METHODS, MethodRow, Needs
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.spec.bodies.keys import BODY
from lagrange_cli.spec.declarations import COORDINATE, PARAMETER
from lagrange_cli.spec.draw.keys import BOUNDS, CAMERA, DRAW
from lagrange_cli.spec.events.keys import ACTION, EVENT
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settings import SOLVE
from lagrange_cli.spec.transformations import TRANSFORMATION

TIMES = (
    "| `/t` | (n,) | sample times; the last is the stop time, even if the duration is not a multiple of "
    "`step`. If the motion ends earlier, for example at an event, the last is the sample time before the end,"
    " and the attribute [`final`](#attributes-of-the-root) has the state at the end | always |"
)
ERRORS = (
    "| `/diagnostics/error/q/NAME`, `/diagnostics/error/v/NAME` | (n,) | an estimate of the error of each"
    " sample of q and v, see [below](#error-estimates) | `--certify` |\n"
    "| `/diagnostics/error/as_run/q/NAME`, `/diagnostics/error/as_run/v/NAME` | (n,) | the same for the"
    " inputs as they are rounded to doubles | `--certify` |\n"
    "| `/diagnostics/error/multipliers/NAME`, `/diagnostics/error/reactions/PARTICLE`, and the same under"
    " `as_run` | as the dataset | likewise of multipliers and reactions | `--certify`, if these are"
    " outputs |"
)
CROSSINGS = (
    "| `/events/NAME/t`, `/events/NAME/q/...`, `/events/NAME/v/...` | (k,) | the times at which an event"
    " happened, and the state there, see [below](#events) | always, if the file has events |"
)
"""The rows of the datasets that are no outputs."""


def with_keys(text: str) -> str:
    """The page of the system file with the tables of its keys, and of those within other keys."""
    rows = []
    for row in SECTIONS.rows:
        words = " or ".join(f"`{word}`" for word in (row.key, row.alias) if word)
        rows.append(f"| {words} | {row.meaning} |")
    places = {
        "`parameters`, NAME": PARAMETER,
        "`coordinates`, NAME": COORDINATE,
        "`bodies`, NAME": BODY,
        "`events`, NAME": EVENT,
        "`events`, NAME, `action`": ACTION,
        "`draw`": DRAW,
        "`draw`, `camera`": CAMERA,
        "`draw`, `camera`, `bounds`": BOUNDS,
        "`transformations`, NAME": TRANSFORMATION,
        "`solve`": SOLVE,
    }
    inner = [
        f"| {place} | {' or '.join(f'`{word}`' for word in (row.key, row.alias) if word)} | {row.meaning} |"
        for place, table in places.items()
        for row in table.rows
    ]
    text = with_rows(text, "| key | meaning |", rows)
    return with_rows(text, "| in | key | meaning |", inner)


def with_outputs(text: str) -> str:
    """The page of the output file with the table of its datasets: those of the outputs, and three others."""
    rows = []
    for row in OUTPUTS.values():
        paths = ", ".join(f"`{path}`" for path in row.datasets.split())
        default = f" (default, if the file has `{row.section}`)" if row.section else " (default)"
        written_by = f"`{row.name}`{default if row.default else ''}"
        rows.append(f"| {paths} | {row.shape} | {row.meaning} | {written_by} |")
    return with_rows(text, "| path | shape | what | written by |", [TIMES, *rows, CROSSINGS, ERRORS])


ABLE: dict[str, Callable[[MethodRow], bool]] = {
    "events, impacts, switches": lambda row: row.finds_events,
    "constraints": lambda row: row.constrains,
    "detects narrow forces": lambda row: row.proves,
    "double-double": lambda row: DOUBLE_DOUBLE in row.tolerances,
    "can be resumed": lambda row: row.needs in (Needs.SERIES, Needs.STEPS),
}
"""What methods can do: the columns of their table."""


def with_methods(text: str) -> str:
    """The page of the methods with their table."""
    rows = []
    for name, row in METHODS.items():
        cells = " | ".join("yes" if can(row) else "no" for can in ABLE.values())
        rows.append(f"| `{name}` | {cells} |")
    return with_rows(text, f"| method | {' | '.join(ABLE)} |", rows)


def with_rows(text: str, head: str, rows: list[str]) -> str:
    """The page with these rows in the table that begins with ``head``."""
    start = text.index(f"\n{head}\n") + 1
    _, rule, *_ = text[start:].splitlines()
    stop = text.index("\n\n", start)
    return "\n".join([text[:start] + head, rule, *rows]) + text[stop:]
