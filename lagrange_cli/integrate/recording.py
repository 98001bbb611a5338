"""``Recording``: which datasets a run writes, and how each is made from what compiled code computes."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Series = Mapping[str, Array]
    """Rows by name, each of shape (c,): observed quantities, or quadratures."""


class Making(Enum):
    """How a dataset is made from its ``sources``, names of observed quantities unless it says otherwise."""

    SUM = "sum"
    VECTOR = "vector"  # the components
    BALANCE = "balance"  # x - x(0) - the quadrature that goes by the dataset's path, where there is one
    INTEGRAL = "integral"  # the quadrature alone


@dataclass(frozen=True)
class Dataset:
    """One series of the output: its path, the shape of one sample, what it is, and how it is made."""

    path: str
    shape: tuple[int, ...]
    long_name: str
    making: Making = Making.SUM
    sources: tuple[str, ...] = ()

    def make(self, observed: Series, integrals: Series, first: Mapping[str, float]) -> Array:
        """Its samples (c, *shape); ``first`` holds the observed quantities at the start."""
        if self.making is Making.INTEGRAL:
            return integrals[self.path]
        if self.making is Making.VECTOR:
            import numpy as np

            return np.stack([observed[name] for name in self.sources], axis=1)
        total = observed[self.sources[0]]
        if self.making is Making.BALANCE:
            total = total - first[self.sources[0]]
            return total - integrals[self.path] if self.path in integrals else total
        for name in self.sources[1:]:
            total = total + observed[name]
        return total


@dataclass(frozen=True)
class Recording:
    """The datasets beyond ``t``, in the file's order: ``states`` (``q``, ``v``) by coordinate, and ``made``.

    ``conserved`` names the observed quantities that every motion keeps.
    """

    coordinates: tuple[str, ...]
    states: tuple[str, ...]
    made: tuple[Dataset, ...]
    conserved: tuple[str, ...]

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """Every dataset but ``t``, in the file's order."""
        kinds = {"q": "coordinate {}", "v": "velocity d{}/dt"}
        return (
            *(
                Dataset(f"{kind}/{name}", (), kinds[kind].format(name))
                for kind in self.states
                for name in self.coordinates
            ),
            *self.made,
        )

    def as_data(self) -> dict[str, Any]:
        """All of it in terms of JSON."""
        made = [[d.path, d.shape, d.long_name, d.making.value, d.sources] for d in self.made]
        return {
            "coordinates": self.coordinates, "states": self.states, "made": made, "conserved": self.conserved
        }  # fmt: skip

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Recording:
        """What ``as_data`` gave, after JSON."""
        made = tuple(
            Dataset(path, tuple(shape), long_name, Making(making), tuple(sources))
            for path, shape, long_name, making, sources in data["made"]
        )
        return cls(tuple(data["coordinates"]), tuple(data["states"]), made, tuple(data["conserved"]))
