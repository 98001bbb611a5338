"""``EnsembleOutcome``: how the members of an ensemble ended, and the figures of the run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import Happened
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from numpy.typing import NDArray

ENDINGS = tuple(Ending)
STATUS = f"S{max(len(ending.status) for ending in ENDINGS)}"
"""numpy's name for the type of a member's status."""
UNFINISHED = ENDINGS.index(Ending.INTERRUPTED)
"""The place in ``ENDINGS`` of members that were interrupted, or never begun."""


@dataclass(frozen=True)
class EnsembleOutcome:
    """The result of an ensemble.

    ``endings`` (members,) are places in ``ENDINGS``, ``failed`` the first member that could not be followed
    to its end, and how that went; drifts are the largest of all members, and ``undetected``, ``left_out`` and
    ``undefined`` as in ``Outcome``. ``unknown`` are the datasets with samples that are not finite: the first
    member that has any, and the time of its first. ``doubtful`` are events with a warning: the first such
    member, and what happened to it.
    """

    endings: NDArray[np.int8]
    failed: tuple[int, str] | None
    steps: int
    h_drift: float | None
    p_drift: Mapping[str, float]
    undetected: tuple[str, ...] = ()
    unknown: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    doubtful: Mapping[str, tuple[int, Happened]] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    undefined: tuple[str, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """All but the endings, in terms of JSON (with NaN and infinities)."""
        drifts = {"h_drift": self.h_drift, "p_drift": dict(self.p_drift)}
        unknown = {path: list(one) for path, one in self.unknown.items()}
        doubtful = {name: [member, *one.as_data()] for name, (member, one) in self.doubtful.items()}
        return {
            "failed": self.failed,
            "steps": self.steps,
            **drifts,
            **({"unknown": unknown} if unknown else {}),
            **({"doubtful": doubtful} if doubtful else {}),
        }

    @classmethod
    def from_data(cls, data: Any, endings: Array | None, members: int) -> EnsembleOutcome:
        """The inverse of ``as_data``, for this number of members; raises ``ValueError`` if the data are not
        valid."""
        if endings is None or endings.dtype != np.int8 or endings.shape != (members,):
            raise ValueError("of other members")
        if ((endings < 0) | (endings >= len(ENDINGS))).any():
            raise ValueError("no endings")
        try:
            failed, h = data["failed"], data["h_drift"]
            return cls(
                endings.copy(),
                None if failed is None else (int(failed[0]), str(failed[1])),
                int(data["steps"]),
                None if h is None else float(h),
                {str(name): float(x) for name, x in data["p_drift"].items()},
                unknown={
                    str(path): (int(member), float(t))
                    for path, (member, t) in data.get("unknown", {}).items()
                },
                doubtful={
                    str(name): (int(member), Happened(*one))
                    for name, (member, *one) in data.get("doubtful", {}).items()
                },
            )
        except (KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
            raise ValueError("no outcome") from error

    def count(self, status: str) -> int:
        """The number of members with this status."""
        return sum(int((self.endings == i).sum()) for i, one in enumerate(ENDINGS) if one.status == status)

    @property
    def status(self) -> str:
        """``interrupted`` if some members were not integrated, ``failed`` if some failed, ``complete``."""
        return next((one for one in ("interrupted", "failed") if self.count(one)), "complete")
