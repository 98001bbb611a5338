"""``Monitor``: the progress and messages of a run for its caller, and how it is interrupted."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

from lagrange_cli.records import dataclass

Stage = Callable[[str], AbstractContextManager[None]]
"""A context for a stage of the work (``timings.STAGES`` and ``timings.PARTS``)."""
Interrupted = Callable[[], bool]
"""Asked several times a second; True ends the run, which keeps what has been computed."""


class Progress(Protocol):
    """Shows how far a run has come."""

    def show(self, reached: float, /) -> None:
        """The run has reached this time, or so many members have ended: said several times a second."""

    def clear(self) -> None:
        """There is nothing more to show."""


class Silence:
    """``Progress`` that is not shown."""

    def show(self, reached: float, /) -> None:
        """Nothing is shown."""

    def clear(self) -> None:
        """Nothing was shown."""


def untimed(name: str) -> AbstractContextManager[None]:
    """A stage that is not reported."""
    return nullcontext()


def uninterrupted() -> AbstractContextManager[Interrupted]:
    """A context in which nothing interrupts a run, but what raises an exception."""
    return nullcontext(lambda: False)


def ignore(message: str) -> None:
    """A message that is not shown."""


def watched(progress: Progress, interrupted: Interrupted) -> Callable[[float], bool]:
    """Receives the progress of a run, and decides whether to stop."""

    def report(reached: float) -> bool:
        progress.show(reached)
        return interrupted()

    return report


@dataclass(frozen=True)
class Monitor:
    """``stage`` is entered for each stage of the work, ``tell`` given what the user should know, and ``warn``
    what cannot wait until the work has ended.

    When the integration begins, ``progress`` makes what is told how far it has come, and ``interrupts`` the
    context in which it works, which gives what is asked whether to stop.
    """

    stage: Stage = untimed
    progress: Callable[[], Progress] = Silence
    tell: Callable[[str], None] = ignore
    interrupts: Callable[[], AbstractContextManager[Interrupted]] = uninterrupted
    warn: Callable[[str], None] = ignore


SILENT = Monitor()
"""For runs whose progress is not shown."""
