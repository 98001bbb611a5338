"""``Located``: the points of families, whose places are arrays: one expression for all members alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.arrays import Array
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.values import Described, FamilyValues
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True, eq=False)
class Located:
    """``axes`` has the places of all points, a total for each component, in terms of a ``system``."""

    system: Described
    axes: tuple[Total, ...]

    @property
    def count(self) -> int:
        """How many points there are."""
        return self.axes[0].count

    def at(self, t: Array, q: Array, parameters: Mapping[str, float]) -> Array:
        """All points (points, dimension, samples) at the times ``t`` (samples,) with ``q`` (samples, n)."""
        given = listed(self.system.spec, parameters)
        values = FamilyValues(self.system, t, q.T, np.zeros_like(q.T), given)
        return np.stack([values.of(one) for one in self.axes], axis=1)


def listed(spec: Spec, parameters: Mapping[str, float]) -> Array:
    """The parameters' values in the order of the file."""
    return np.array([parameters[name] for name in names_of(spec.parameters)], dtype=np.float64)
