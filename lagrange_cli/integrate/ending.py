"""How a motion ended: an enum whose values are sentences for the user, and the state there."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any

from lagrange_cli.records import dataclass


class Ending(Enum):
    """Why a motion ended; the value is the sentence shown to the user."""

    COMPLETE = "reached the end"
    STOPPED = "stopped"
    SINGULAR_MASS_MATRIX = "singular mass matrix"
    ILL_CONDITIONED = "the mass matrix is too ill-conditioned"
    STEP_UNDERFLOW = (
        "the step size fell below the resolution of time "
        "(a collision, a singularity, or a discontinuity of the force at which the motion sticks)"
    )
    TOUCHING = "a force has the root of something, such as a depth, that is known to too few digits to go on,"
    CRAWLING = "the motion changes faster and faster: its steps become shorter without end"
    STUCK = (
        "thousands of steps together hardly lead on, and no coordinate moves by more than the tolerance "
        "(a discontinuity of the force at which the motion sticks)"
    )
    NOT_A_NUMBER = "the equations of motion gave a value that is not a finite number"
    OVERFLOW = "a coordinate or a velocity exceeds the largest double, 1.8e308,"
    METHOD_FAILED = "the method could not meet its tolerance"
    RECURRING = "an event occurs again and again at the same time"
    IDLE = "an impact without any speed changes nothing, and happens again and again,"
    DRAGGED = "infinitely many impacts happen, each of which changes a velocity however slow it is,"
    TOO_MANY_EVENTS = "more events than the limit allows"
    TARGET_MISSED = "the target error can no longer be met"
    INTERRUPTED = "interrupted"
    NO_CROSSING = "the search for a further crossing ended"
    OFF_CONSTRAINTS = "no state near the one set by an action satisfies the constraints"
    NO_MASS = "a mass is no longer greater than 0"
    CUT = "an energy or a constraint jumps with the angle atan2(y, x), by 2 pi where y = 0 and x < 0,"
    EDGE = "an expression of the file has no value beyond this place"
    UNDETERMINED = (
        "several forces of friction hold what is joined: how much each of them takes is undetermined,"
    )
    JUMP = "an action would make an energy jump"
    INCONSISTENT = "no motion begins at the initial values"
    TOO_LONG = "powers of steps exceed the largest double, 1.8e308, as the stop time is so large,"

    def way_out(self, *, at_start: bool = False) -> str:
        """A way out for the user, also for a failure ``at_start``; empty if nothing is wrong."""
        before = "start from another state" if at_start else "end the run before it with --stop"
        return WAYS_OUT.get(self, "").format(before=before)

    @property
    def status(self) -> str:
        """The word for the output file: ``complete``, ``stopped``, ``interrupted`` or ``failed``."""
        if self in (Ending.COMPLETE, Ending.STOPPED):
            return "complete" if self is Ending.COMPLETE else "stopped"
        return "interrupted" if self is Ending.INTERRUPTED else "failed"


DONE = ("complete", "stopped")
"""The words for motions that cannot be continued."""
WAYS_OUT = {
    Ending.SINGULAR_MASS_MATRIX: "{before}, or use other coordinates or parameters",
    Ending.ILL_CONDITIONED: "use other coordinates, such as amplitudes of orthogonal functions in place of "
    "those of powers, or --precision double-double for conditions up to 1e+30",
    Ending.STEP_UNDERFLOW: "{before}, or smooth the singularity",
    Ending.TOUCHING: "try another --method, such as DOP853, or {before}",
    Ending.STUCK: "{before}, smooth the discontinuity, or try another --method",
    Ending.CRAWLING: "{before}, or smooth the singularity",
    Ending.NOT_A_NUMBER: "{before}; look for an overflow, a division by zero, or a "
    "root or logarithm of a negative number",
    Ending.OVERFLOW: "{before}",
    Ending.TOO_LONG: "end the run earlier with --stop",
    Ending.RECURRING: "let its action move the state away from it, or end the run before it with --stop",
    Ending.IDLE: "let its action reduce the speed, so that bodies may rest on each other, or {before}",
    Ending.DRAGGED: "let the action change velocities in proportion to the speed of the impact, the rate of "
    "its 'when', or {before}",
    Ending.TOO_MANY_EVENTS: "LAGRANGE_LIMITS=events=NUMBER raises it",
    Ending.NO_CROSSING: "ask for fewer --crossings, or end the motion with --stop",
    Ending.OFF_CONSTRAINTS: "let the action set values that satisfy the constraints, or velocities alone",
    Ending.NO_MASS: "let the action keep all masses greater than 0, or end the run before it with --stop",
    Ending.CUT: "use that angle as a coordinate, write energies and constraints that do not jump there, "
    "or {before}",
    Ending.UNDETERMINED: "write friction against the same velocity with the same norm, "
    "put a spring in place of what joins them, or {before}",
    Ending.JUMP: "let the action set values with which both sides are equal where the condition changes",
    Ending.EDGE: "{before}",
    Ending.METHOD_FAILED: "try another --method, or a looser --tolerance",
}


@dataclass(frozen=True)
class Finished:
    """The end of a motion at an event."""

    ending: Ending
    detail: str = ""


@dataclass(frozen=True)
class State:
    """The state of a motion at time ``t``: coordinates and velocities, both by coordinate."""

    t: float
    q: Mapping[str, float]
    v: Mapping[str, float]

    def as_data(self) -> dict[str, Any]:
        """The fields in terms of JSON."""
        return {"t": self.t, "q": dict(self.q), "v": dict(self.v)}
