"""Where the members of a group stand that have one label, and so are written alike."""

from __future__ import annotations

from typing import Any

import numpy as np

from lagrange_cli.families.groups import Group


def axes_of(group: Group, label: int) -> dict[str, int]:
    """Along which axis each index of the members with a label runs."""
    places = places_of(group, label)
    found: dict[str, int] = {}
    chosen = np.flatnonzero(group.labels == label)
    for name, values in group.indices.items():
        for axis, own in enumerate(places):
            if axis not in found.values() and np.array_equal(own, values[chosen]):
                found[name] = axis
                break
    return found


def places_of(group: Group, label: int) -> tuple[Any, ...]:
    """The indices of the members with a label, axis by axis."""
    if not group.family.shape:
        return ()
    chosen = np.flatnonzero(group.labels == label)
    places = chosen if group.places is None else group.places[chosen]
    return np.unravel_index(places, group.family.shape)
