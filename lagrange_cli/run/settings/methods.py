"""Which method integrates, what it can follow, and its tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import suggest
from lagrange_cli.integrate.methods.table import AUTO, METHODS, MethodRow
from lagrange_cli.integrate.precision import DOUBLE

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

LOOSEST_TOLERANCE = 0.1


def abilities(spec: Spec) -> Iterator[tuple[str, Callable[[MethodRow], bool]]]:
    """Features of a system that not every method supports, and whether a method supports them."""
    if spec.all_constraints:
        from lagrange_cli.spec.bodies.norms import norms

        norm = len(norms(spec.bodies)) == len(spec.all_constraints)
        what = (
            "a system with quaternions, whose norms are constraints," if norm else "a system with constraints"
        )
        yield what, lambda row: row.constrains
    if spec.events:
        yield "a system with events", lambda row: row.finds_events


def resolve_method(name: str | None) -> str:
    """The method's proper name, from upper or lower case; ``AUTO`` if none is given."""
    return proper_name(AUTO if name is None else name, (AUTO, *METHODS))


def proper_name(name: str, methods: Sequence[str]) -> str:
    """The one of these methods that is meant, in upper or lower case."""
    for method in methods:
        if method.lower() == name.lower():
            return method
    raise UsageError(f"unknown method {name!r}; {suggest(name, methods)}")


def either(names: Sequence[str]) -> str:
    """``a, b or c``."""
    return " or ".join(one for one in (", ".join(names[:-1]), names[-1]) if one)


def check_method(method: str, option: str, can: Callable[[MethodRow], bool]) -> None:
    """Refuse an option that a method cannot be used with, and say which it can."""
    able = able_to(can)
    if method not in able:
        raise UsageError(f"{option} needs method {either(able)}, not {method}: add --method {able[0]}")


def able_to(can: Callable[[MethodRow], bool]) -> list[str]:
    """The methods that can do something."""
    return [name for name, row in METHODS.items() if can(row)]


def resolve_tolerance(tolerance: float | None, method: str, precision: str = DOUBLE) -> float:
    """The tolerance asked for, if the method can take it; else the method's default."""
    tightest, default = METHODS[method].tolerances[precision]
    if tolerance is None:
        return default
    if not tightest <= tolerance <= LOOSEST_TOLERANCE:
        raise UsageError(
            f"the tolerance {decimal(tolerance)} is out of range; "
            f"{method} takes {decimal(tightest, 3)} to {decimal(LOOSEST_TOLERANCE)}"
        )
    return tolerance
