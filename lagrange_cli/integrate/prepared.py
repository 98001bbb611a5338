"""``Prepared``: a system ready to be followed, for any values of its parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.outputs.recording import Dataset, Recording
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.native.compilation.machine import Machine


@dataclass(frozen=True)
class Prepared:
    """A system that is compiled as ``compilation`` says; the values of its parameters come later.

    ``cached`` tells that the code was compiled on an earlier run.
    """

    recording: Recording
    machine: Machine
    compilation: Compilation
    follower: Method
    cached: bool = False

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """Every dataset of the output but ``t``, in order."""
        return self.recording.datasets
