"""``Prepared``: a system ready to be followed, for any values of its parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.outputs.recording import Dataset, Recording
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.native.compilation.machine import Machine


@dataclass(frozen=True)
class Prepared:
    """A system compiled for one method, tolerance and set of outputs; parameters' values come later.

    ``backward`` tells that its motions end before they start, ``cached`` that the code was compiled on an
    earlier run.
    """

    recording: Recording
    machine: Machine
    method: str
    tolerance: float
    follower: Method
    backward: bool = False
    cached: bool = False

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """Every dataset of the output but ``t``, in order."""
        return self.recording.datasets
