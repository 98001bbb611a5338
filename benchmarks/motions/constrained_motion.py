"""``ConstrainedMotion``: a system file with constraints, and how long it is followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from benchmarks import ROOT
from benchmarks.motions.motion import shipped
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values, resolve_values


@dataclass(frozen=True)
class ConstrainedMotion:
    """A file of ``benchmarks/motions/constrained/``, or one that is shipped; with families of ``size``
    members."""

    system: str
    stop: float
    size: int | None = None

    @cached_property
    def spec(self) -> Spec:
        """The system file."""
        path = ROOT / "benchmarks" / "motions" / "constrained" / f"{self.system}.yaml"
        text = path.read_text(encoding="utf-8") if path.exists() else shipped(self.system)
        return read_spec(text, self.system, {} if self.size is None else {"N": str(self.size)})

    @cached_property
    def values(self) -> Values:
        """Parameters and the initial state."""
        return resolve_values(self.spec)


SQUEEZER = ConstrainedMotion("andrews_squeezer", 0.03)
PENDULUM_PERIOD = 6.69997566437045
"""4 K(sin(1/2))."""
PENDULUM = ConstrainedMotion("pendulum", 100_000 * PENDULUM_PERIOD)
FOUR_BAR = ConstrainedMotion("four_bar", 1000.0)
FREE_TOP = ConstrainedMotion("free_top", 628_319.0)
"""A million turns."""


def chain(size: int, stop: float) -> ConstrainedMotion:
    """``size`` bobs on rods in Cartesian coordinates, from rest as ``n_pendulum`` is."""
    return ConstrainedMotion("chain", stop, size)


def angles(size: int, stop: float) -> ConstrainedMotion:
    """The same in angles, without constraints."""
    return ConstrainedMotion("n_pendulum", stop, size)
