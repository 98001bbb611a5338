"""``Times``: the interval of a motion and the instants at which it is sampled."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Times:
    """``count`` samples at ``start + i*step``, the last of them at ``stop``, where the motion ends.

    Where that is before ``start``, ``step`` is negative.
    """

    start: float
    stop: float
    count: int
    step: float

    @property
    def backward(self) -> bool:
        """Whether the motion is integrated backward in time."""
        return self.stop < self.start

    def part(self, t: float) -> float:
        """The part of the motion before ``t``."""
        return (t - self.start) / (self.stop - self.start)

    def chunk(self, first: int, size: int) -> NDArray[np.float64]:
        """Sample times ``first`` .. ``first + size - 1``, fewer at the end."""
        times = np.arange(first, min(first + size, self.count), dtype=np.float64)
        times *= self.step
        times += self.start
        if first < self.count <= first + size:
            times[-1] = self.stop
        return times
