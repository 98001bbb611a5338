"""What the user is told about the start of a motion."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.run.start import Begin

MOST_TOLD = 8
"""Values that are named."""


def notes(begin: Begin) -> Iterator[str]:
    """The messages about the start."""
    if begin.normalized:
        lengths = [
            f"{body} (its length was {decimal(length, 9)})" for body, length in begin.normalized.items()
        ]
        noun, rates = ("quaternion", "its rates") if len(lengths) == 1 else ("quaternions", "their rates")
        moved = [
            f"{name} {decimal(old, 9)} -> {decimal(new, 9)}" for name, (old, new, _) in begin.moved.items()
        ]
        yield (
            f"initial {noun} of {in_short(lengths)} normalized, and {rates} divided by that length, which "
            f"keeps the angular velocity: {in_short(moved)}"
        )
    elif begin.moved:
        shown = [
            f"{name} {decimal(old, 9)} by {scientific(by)}" for name, (old, _, by) in begin.moved.items()
        ]
        yield f"initial values moved to satisfy {begin.by}: {in_short(shown)}"
    if begin.found:
        shown = [f"{name} = {decimal(value, 9)}" for name, value in begin.found.items()]
        yield f"initial values found from {begin.by}: {in_short(shown)}"
    if begin.redundant:
        noun, verb = ("constraint", "depends") if len(begin.redundant) == 1 else ("constraints", "depend")
        but = (
            f" (up to {scientific(begin.rest, 0)} of its size, which is taken for rounding)"
            if begin.rest
            else ""
        )
        yield (
            f"warning: the {noun} {in_short(begin.redundant)} {verb} on the others{but}: the multipliers of "
            f"{in_short(begin.undetermined)} are not unique, and the ones of least norm are written; the "
            "motion is unique"
        )
    if begin.singular:
        one = len(begin.singular) == 1
        noun, verb, whose = ("constraint", "depends", "its") if one else ("constraints", "depend", "their")
        yield (
            f"warning: the {noun} {in_short(begin.singular)} {verb} on the others at the start, or {whose} "
            "derivatives are 0 there: a singular configuration, from which the motion may not be unique"
        )


def in_short(words: Collection[str]) -> str:
    """The first of them."""
    listed = [*words]
    more = len(listed) - MOST_TOLD
    return ", ".join(listed[:MOST_TOLD]) + (f" and {more} more" if more > 0 else "")
