"""``Steps``: what steps are made of in one kind of numbers, for the loop of ``@advance``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.acceptance import Allowance, Bounds
from lagrange_cli.native.stepping.guards import GuardCode
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.records import dataclass

STRAIGHT = 4
"""So close to a critical point that the coefficients from here on consist of rounding errors only."""


@dataclass(frozen=True)
class Now:
    """Where a step begins: t and its low part, the length of the step before it, and the unit of time of the
    series' coefficients."""

    t: Real
    low: Real
    previous: Real
    unit: Real


class Steps(ABC):
    """What steps are made of in one kind of numbers."""

    state: StateLayout
    bounds: Bounds
    guards: GuardCode | None
    """What guards need, if there are any."""
    refined: bool
    """Whether a step to a root is followed by a much shorter one, since roots are found in doubles."""
    in_two: bool
    """Whether the first step to a root after another one is taken in two, as for companions."""
    quadratures: Quadratures | None
    """What integrals need, if there are any that may ask for shorter steps than the motion's."""

    @abstractmethod
    def functions(self) -> list[str]:
        """The functions that its instructions call."""

    @abstractmethod
    def forget(self, f: Function) -> None:
        """Remove what is left of other series: done first, and after a step that was not accepted."""

    @abstractmethod
    def expand(self, f: Function, now: Now) -> tuple[Now, Bit]:
        """Compute the series, perhaps in a unit of its own; whether the mass matrix is regular."""

    @abstractmethod
    def choose(self, f: Function, now: Now, fail: Callable[[], None]) -> tuple[Now, Real, Bit]:
        """The step by its series, perhaps in another unit, and whether all coefficients are finite; ``fail``
        if so many are not that there is none."""

    @abstractmethod
    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        """The step, or a shorter one, where what its series may not show has been looked for; ``free``: no
        critical point is near."""

    @abstractmethod
    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        """When a guard is due in a step of ``h``, which one, and how much of the step is known
        (``guards.GuardCode``)."""

    @abstractmethod
    def straighten(self, f: Function) -> None:
        """Set the coefficients from ``STRAIGHT`` on to 0."""

    @abstractmethod
    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        """Write the samples from ``index`` on that lie within ``h``: the index of the first one beyond."""

    @abstractmethod
    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        """Go to the end of the step, and write down what is expected there: the place farthest from 0."""

    constrained: bool
    """Whether there are constraints."""

    @abstractmethod
    def project(self, f: Function) -> None:
        """Move the state back to the constraints, if there are any and it is not there."""

    @abstractmethod
    def agree(self, f: Function, now: Now, uneven: Real, slack: Real, unexplained: Bit, floor: Real) -> Bit:
        """Whether the accelerations are those expected (``acceptance.accepted``)."""

    @abstractmethod
    def rough(self, f: Function, now: Now, h: Real) -> Bit:
        """Whether the integrals' series do not hold all through the step of ``h`` just taken."""

    @abstractmethod
    def surprising(self, f: Function, now: Now, h: Real) -> Bit:
        """Whether the integrands are not those expected after a step of ``h``."""

    @abstractmethod
    def resume(self, f: Function, before: Now) -> None:
        """Compute the series of the step before once more."""

    @abstractmethod
    def part(self, f: Function, before: Now, h: Real, samples: tuple[Integer, Integer]) -> None:
        """Compute the integrals of the step before by parts (``quadratures``), also at its samples: from the
        one to before the other; or some of it, if it is ``halted``."""

    @abstractmethod
    def halted(self, f: Function) -> Bit:
        """Whether ``part`` is to leave its step."""
