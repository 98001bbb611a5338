"""What ``sweep`` and ``section`` share: progress and interrupts, and the messages at the end."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.stored import Stored
from lagrange_cli.api.warned import warn
from lagrange_cli.api.words import python_words
from lagrange_cli.errors import Interrupted
from lagrange_cli.run.attributes import doubt_of_all
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import Monitor

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.run.ensembles.ensemble import Ensemble

S = TypeVar("S", bound=Stored)
WARNING = "warning: "
SIDE_BY_SIDE = ("integrate", "write")
"""The stages that threads may be in at the same time."""


def stage(name: str) -> AbstractContextManager[Any]:
    """One thread at a time derives and compiles."""
    return nullcontext() if name in SIDE_BY_SIDE else WORKING


def watching(told: list[str]) -> Monitor:
    """What notes messages, and is interrupted by Ctrl-C."""
    return Monitor(stage, tell=told.append, interrupts=partial(Interrupts, alone=True), warn=warn)


def noted(told: Sequence[str], ensemble: Ensemble, outcome: EnsembleOutcome) -> tuple[str, ...]:
    """The messages of the command besides its summary."""
    warning = doubt_of_all(outcome, ensemble.settings)
    doubt = [] if warning is None else [f"{ensemble.spec.name}: {WARNING}{warning}"]
    return tuple(map(python_words, (*told, *doubt)))


def ended(found: S, outcome: EnsembleOutcome, message: str) -> S:
    """The result, with its warnings; an interrupt is raised with the result.

    Called by a function that a user calls.
    """
    message = python_words(message)
    failing = [f"{found.name}: {message}"] if outcome.status == "failed" else []
    for note in [*failing, *(one for one in found.notes if WARNING in one)]:
        warn(note)
    if outcome.status == "interrupted":
        interrupted = Interrupted(f"{found.name}: {message}")
        interrupted.result = found
        raise interrupted
    return found
