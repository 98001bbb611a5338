"""``--method auto``: the method that suits a system.

A Taylor series costs the square of its order for every term of a sum, a step of ias15 some 15 evaluations.
So where every coordinate has many terms, as where all bodies attract each other, ias15 is faster at the same
error (docs/benchmarks.md). Everything else is followed by Taylor series.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from lagrange_cli.integrate.methods.table import MANY_BODIES, TAYLOR

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

FEWEST = 60
"""Coordinates below which a system is followed by Taylor series."""
TERMS = 4
"""Terms of sums for each coordinate from which on ias15 is faster: 25 bodies in space."""


def chosen_method(spec: Spec, outputs: Collection[str]) -> tuple[str, str]:
    """The method, and why it is not that of Taylor series (empty if it is)."""
    count = len(spec.coordinates)
    if count < FEWEST or not spec.families.get("coordinates"):
        return TAYLOR, ""
    from lagrange_cli.families.size import terms_of

    terms = terms_of(spec)
    if terms < TERMS * count:
        return TAYLOR, ""
    from lagrange_cli.integrate.families import suits

    if not suits(spec, outputs):
        return TAYLOR, ""
    return MANY_BODIES, f"its sums have {terms} terms for {count} coordinates"
