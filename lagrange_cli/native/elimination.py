"""Whether steps take less work where constraints have been solved for coordinates beforehand."""

from __future__ import annotations

from lagrange_cli.mechanics.constrained.elimination import Elimination, eliminated
from lagrange_cli.mechanics.residual import Residual


def reduced(residual: Residual) -> Elimination | None:
    """The equations without the coordinates that constraints give; None where that saves nothing."""
    return eliminated(residual, 1000)
