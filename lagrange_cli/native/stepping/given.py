"""``Given``: what steps are written from, in each kind of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.native.stepping.proof import Proving
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.stepping.coupling import Coupling


@dataclass(frozen=True)
class Given:
    """What a motion is: its state, its doubles of ``%work``, its tolerance, what its steps, its integrals and
    the arguments of its guards are proven by, and its guards, if it has any; and whether the first step to a
    root after another one is taken ``in_two``, as for companions."""

    state: StateLayout
    work: int
    tolerance: float
    proving: Sequence[Proving | None]
    guards: GuardRows | None
    in_two: bool = False
    shown: tuple[int, int] = (0, 0)
    """So many integrals behind those of guards' arguments are those of multipliers, and so many more of sums;
    they have no say."""
    project: str = ""
    """The text of ``@project``, if there are constraints."""
    timed: bool = False
    """Whether equations depend on t."""
    floors: str = ""
    """The text of ``@floors(constants, state, floors)``, if velocities are not all measured by themselves
    alone; it computes what is then at ``Lengths.floor``."""
    related: Sequence[tuple[int, int]] = ()
    """The first coordinate and the number of those of each family, if velocities of its members are measured
    by the fastest one, too (``related``); and those of integrals, whose numbers go on behind these."""
    approach: str = ""
    """The text of ``@approach(constants, t, state, bounds, h)``, if forces have poles: by what part
    that which is 0 there may become less within a step, if coordinates are no farther from a straight motion
    than the bounds. Where velocities count as well, the bounds of all rows are followed by how far they get
    from where the step begins to its end (``rates.approaching``)."""
    coupling: Coupling | None = None
    """Which rates depend on which coordinates, for implicit steps."""
    rates: str = "jet"
    """The function that computes rates, for steps on these."""
    near: NearPlaces | None = None
    """Where ``%work`` tells which guards have series, if those that nothing can come of in a step have none
    (see ``GuardSearch``)."""
    alone: bool = False
    """Whether ``@act_alone`` gives what one event's action sets."""
    idle: Sequence[slice[int, int, None]] = ()
    """Places of the state that steps never change, in order."""
    coupled: Sequence[tuple[int, int]] = ()
    """The first coordinate and the number of those whose accelerations are found together: none is known to
    less than the rounding error of the largest one."""
    static: str = ""
    """The text of ``@allow_static(constants, state, errors)``, if forces may cancel at rest
    (``static_forces``)."""
    directions: str = ""
    """The text of ``@allow_directions(constants, state, errors)``, if forces have the directions of
    differences of velocities, which may be small."""
    cancelling: str = ""
    """The text of ``@round_integrands`` (``integrand_errors``), if integrands are sums of terms."""
    jointed: bool = False
    """Whether joints have several coordinates each, whose accelerations are found together."""

    @property
    def texts(self) -> Sequence[str]:
        """The texts of all functions that are given."""
        return (
            self.project, self.floors, self.static, self.directions, self.approach, self.cancelling,
        )  # fmt: skip
