"""Roots in the forces of families: the modes whose arguments they have, as those of contacts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain
from lagrange_cli.mechanics.guards.guard import Rooted
from lagrange_cli.mechanics.guards.modes import rooted
from lagrange_cli.records import replace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places
    from lagrange_cli.families.switching.silencing import Use
    from lagrange_cli.families.switching.switched import Switched


def roots_of(
    switched: Switched, numbers: Mapping[Use, Places], turned: Mapping[Use, NDArray[np.bool_]]
) -> dict[int, Rooted]:
    """The roots in forces, by the ``numbers`` of their modes; of members that have the opposite of what
    decides these, being ``turned``, the side is not known."""
    uses = dict[tuple[Domain, Node], Rooted]()
    for total in switched.totals:
        for term in switched.merged(total):
            for one in switched.followed([term.node]):
                found, use = rooted(*one.arguments), (term.domain, one.arguments[0])
                if found is not None:
                    uses[use] = found.joined(uses.get(use))
    modes = dict[int, Rooted]()
    for use, found in uses.items():
        found = replace(found, side=0) if use in turned else found
        for mode in numbers[use].tolist():
            modes[mode] = found.joined(modes.get(mode))
    return modes
