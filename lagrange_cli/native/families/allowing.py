"""What the steps of a program allow because of rounding; what writes it is imported where there is any
(``allowances``)."""

from __future__ import annotations

from lagrange_cli.native.families.preparation import Preparation
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DoubleDouble
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import replace


class Allowing(Preparation):
    """These functions."""

    def static(self) -> str:
        """``@allow_static``, if forces may cancel at rest; its arrays are the next ones."""
        if self.system.passes or (self.modes is not None and self.modes.vectors):
            return ""  # steps as short as time resolves would pass where motions stop
        if self.rounded is None and self.shaken is None:
            return ""
        from lagrange_cli.native.families.allowances import of_joints, where_diagonal

        if self.shaken is not None:
            return of_joints(self, self.shaken, replace(self.setting(RATES), kind=DoubleVectors), self.unit)
        assert self.rounded is not None
        return where_diagonal(self, self.rounded, self.unit)

    def cancelled(self) -> str:
        """``@round_integrands``, if there are integrands with errors that are known."""
        if self.cancelling is None:
            return ""
        from lagrange_cli.native.families.allowances import of_integrands

        return of_integrands(self, self.cancelling, self.unit)

    @property
    def unit(self) -> float:
        """The relative rounding error of the numbers."""
        return (Emitter if self.kind.parts == 1 else DoubleDouble).unit

    def directions(self, state: StateLayout) -> str:
        """``@allow_directions``, where friction acts along differences of velocities. (Steps on rates measure
        these errors.)"""
        if self.scheme or self.blurred is None or self.kind is not DoubleVectors:
            return ""
        from lagrange_cli.native.families.allowances import allow_directions

        return allow_directions(self, self.blurred, state)
