"""``@proven``: whether the series of a step satisfy the equations of motion throughout the step.

The series of q are polynomials of t, and those of v and of the accelerations their derivatives. Put into the
equations they leave a *defect*, an analytic function of t whose coefficients are 0 up to the order n of the
accelerations. Where a term of it differs from its start by at most D for all complex times within r,
coefficient m of it is at most D / r^m (Cauchy's estimate), so that for h = r / k what is beyond order n is at
most D k^-(n + 1) / (1 - 1/k) up to time h. D is found by enclosing q, v, a and t in disks, and evaluating the
term over these (``recurrences.disk``). No term of the equations is passed over, however narrow. This is done
for several k at once, and each term takes the k that suits it best: a small one if it is negligible all
around, a large one if it is large. (Enclosures of Taylor series over a step: G. F. Corliss and R. Rihm,
Validating an a priori enclosure using high-order Taylor series, 1996; N. S. Nedialkov, K. R. Jackson and G.
F. Corliss, Appl. Math. Comput. 105, 21, 1999.)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from math import inf, log, log2
from typing import TypeAlias

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Pointer, Real
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.steps import Now
from lagrange_cli.records import dataclass

RATIOS = 1.125, 1.4, 1.8, 2.4, 3.2, 4.0, 5.5, 8.0
"""The radii of the disks of time, as multiples of the step."""
SHORTER, REGAINED, LEAST = 0.7, 1.5, 2.0**-60
"""A step of which nothing is known is tried again so many times as long, or as the step before; down to this
part of what the series suggests, below which there is none."""
FAR = 4.0
"""A step so many times as long as the one before is tried as it is: a narrow force may be left behind."""
EXPECTED, SMALLEST = 0.97, 0.4
"""Of what the bound of its defect says of a step that is not proven this part is tried, and no less than this
part of the step: where exponentials grow, a bound grows faster than any power."""
WIDER = 1 + 2.0**-40
"""A margin larger than the rounding error of radii."""
HEAD = (
    "define internal double @{}(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, "
    "double %h, double %unit, double %beyond) #0"
)
"""The function, in the ``unit`` of time that the series have; ``beyond`` is the first order of the
accelerations that they do not reach. It gives the part of the step ``h`` that may be proven: 1 if it is, 0
where it cannot tell."""


@dataclass(frozen=True)
class Margins:
    """What a proof takes from the steps, of which ``name`` is the function's.

    What rests may be moved by ``nothing``; low parts of the state are ``low`` doubles behind. A number has
    ``parts`` doubles, of which the first is looked at. A defect cannot be distinguished from rounding up to
    the fraction ``small`` of the accelerations, their change, and what changes the velocity within a step.
    """

    lengths: Lengths
    low: int
    nothing: float
    small: float
    parts: int = 1
    integrals: tuple[int, int] = (0, 0)
    """The first row and the number of integrals whose integrands the terms are, if it is not the equations
    that are looked at."""
    multipliers: tuple[int, int] = (0, 0)
    """The first row and the number of the integrals of constraints' multipliers."""
    name: str = "proven"

    def negligible(self, f: Function, h: Real) -> Real:
        """What moves what rests by nothing, as an acceleration."""
        return self.nothing / (h * f.function("maxnum", h, 1.0))


class Proof(ABC):
    """What ``@proven`` is written from."""

    margins: Margins

    @abstractmethod
    def function(self) -> Function:
        """The function."""

    @property
    def name(self) -> str:
        """Its name."""
        return self.margins.name


Proving: TypeAlias = "Callable[[Margins], Proof]"
"""What gives a proof for certain steps."""


def proven(
    f: Function,
    proofs: Sequence[Proof],
    now: Now,
    h: Real,
    left: Real,
    free: Bit,
    places: tuple[Pointer, Pointer],
    beyond: Real,
) -> Real:
    """The step ``h``, of which no more than what is ``left`` is needed, or as much of it as is proven by all
    ``proofs``; 0 if nothing is. In front of a critical point (not ``free``) steps are parts of one that was
    proven."""
    before = f.select(now.previous > 0.0, now.previous * REGAINED, h)
    near = h < now.previous * FAR  # then proofs are why the step before was shorter
    length = f.variable(f.select(near, f.smaller(h, before), h))
    with f.when(free), f.section() as sound, f.forever():
        needed = f.smaller(length.get(), left)
        given = f.pointer("%constants"), now.t + now.low, *places, needed, now.unit, beyond
        part = f.variable(f.constant(1.0))
        for one in proofs:
            with f.when(part.get() >= 1.0):
                part.set(f.call(Real, one.name, *given))
        with f.when(part.get() >= 1.0):
            sound.leave()
        unknown = f.smaller(needed * SHORTER, before)
        length.set(f.select(part.get() > 0.0, needed * part.get(), unknown))
        with f.when(~(length.get() > f.smaller(h, left) * LEAST)):
            length.set(f.constant(0.0))
            sound.leave()
    return length.get()


def radii(f: Function, h: Real) -> Real:
    """The radii of disks around 0 that reach beyond ``h``."""
    return f.splat(h, LANES) * f.vector([k * WIDER for k in RATIOS])


def weights_of(disks: Disks) -> Real:
    """What the radius of a term is multiplied by: k^-n / (1 - 1/k), beyond order n."""
    f = disks.f
    logarithms, sums = f.vector([-log(k) for k in RATIOS]), f.vector([k / (k - 1) for k in RATIOS])
    return disks.exp(logarithms * f.splat(Real(f, "%beyond"), LANES)) * sums


def least(disks: Disks, radius: Real, weights: Real) -> Real:
    """The bound of a term's part of the defect, by the k that suits it best."""
    bound, unlimited = radius * weights, disks.all(float("inf"))
    # what is not a number is not known
    return disks.f.reduce("fmin", disks.f.select(bound < unlimited, bound, unlimited))


def expected(f: Function, excess: Real, order: int) -> Real:
    """The part of a step that may be proven, if the bounds of defects are at most ``excess`` times what is
    allowed: they grow like h^(n + 1) with series up to an ``order`` n + 1."""
    part = 1.0 / excess
    for _ in range(round(log2(order))):
        part = f.function("sqrt", part)
    part = f.select(part > 0.0, f.larger(part * EXPECTED, SMALLEST), part)
    return f.select(excess <= 1.0, f.constant(1.0), part)


def exceeded(f: Function, excess: Real, total: Real, allowed: Real) -> Real:
    """The larger one of an excess and that of a ``total`` of bounds; infinite where this is not known."""
    own = f.select(total <= allowed, f.constant(0.0), total / allowed)
    return f.select(own <= excess, excess, f.select(own < inf, own, f.constant(inf)))
