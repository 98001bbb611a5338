"""Tables of places: what members of families have in common, found for all of them at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places


def in_groups(counts: Places) -> tuple[Places, Places]:
    """For each member of groups that have so many, side by side: its group, and its number in this."""
    owners = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)


def met(rows: Places, others: Places) -> tuple[Places, Places]:
    """All pairs of places at which two tables have the same number."""
    order = np.argsort(others, kind="stable")
    left, right = (np.searchsorted(others[order], rows, side) for side in ("left", "right"))
    owners, within = in_groups(right - left)
    return owners, order[left[owners] + within]


def count_met(rows: Places, others: Places) -> int:
    """How many of these pairs there are."""
    ordered = np.sort(others)
    left, right = (np.searchsorted(ordered, rows, side) for side in ("left", "right"))
    return int((right - left).sum())


def found_in(keys: Places, wanted: Places) -> tuple[Places, NDArray[np.bool_]]:
    """Where these are among ``keys``, in order and at least one, and whether they are."""
    at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return at, keys[at] == wanted
