"""``Progress``: the state of a run from which another run continues to the same bits."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Generic, TypeVar

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import State
from lagrange_cli.integrate.events import Happened, kept_at_once
from lagrange_cli.integrate.method import MethodChange, Snapshot
from lagrange_cli.integrate.methods.table import METHODS, STIFF, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.interface import Interface
from lagrange_cli.records import dataclass, field, fields_of

T = TypeVar("T")

CHANGES = "changes"
"""The name of changes of the method."""
RARELY = 50
"""A checkpoint is not written before this many times the duration of the last one have passed."""


@dataclass(frozen=True)
class Progress:
    """The state of a run besides its emitted samples: the method's snapshot, the ``first`` values of the
    observed quantities, the ``drift`` of conserved ones, the ``size`` of the terms of h, the last sample,
    ``final``, the initial values of balances with the changes by actions of events, ``base``, what
    ``happened`` at each event, and the datasets with ``unknown`` samples and the ``extent`` of the motion, as
    in ``Outcome``."""

    snapshot: Snapshot
    first: Mapping[str, float]
    drift: Mapping[str, float]
    size: float
    final: State | None
    base: Mapping[str, float] = field(default_factory=dict)
    happened: tuple[Happened, ...] = ()
    unknown: Mapping[str, float] = field(default_factory=dict)
    extent: float = 0.0

    def as_data(self) -> dict[str, Any]:
        """All but the memory, in terms of JSON (with NaN and infinities)."""
        snapshot = self.snapshot
        return {
            "t": snapshot.t,
            "steps": snapshot.steps,
            "samples": snapshot.samples,
            "limited": snapshot.limited,
            "first": dict(self.first),
            "drift": dict(self.drift),
            "size": self.size,
            **({"base": dict(self.base)} if self.base else {}),
            "final": None if self.final is None else self.final.as_data(),
            **({"events": [one.as_data() for one in self.happened]} if self.happened else {}),
            **({"actions": list(snapshot.actions)} if snapshot.actions else {}),
            **({"singular": list(snapshot.singular)} if snapshot.singular else {}),
            **({CHANGES: changes_as_data(snapshot.changes)} if snapshot.changes else {}),
            **({"unknown": dict(self.unknown)} if self.unknown else {}),
            **({"extent": self.extent} if self.extent else {}),
        }

    @classmethod
    def from_data(
        cls,
        data: Any,
        arrays: Mapping[str, Array],
        program: Interface,
        conserved: Iterable[str],
        times: Times,
    ) -> Progress:
        """What ``as_data`` and the ``arrays`` of the snapshot gave, for a run through ``times`` that
        ``program`` has followed to there; raises ``ValueError`` where it is nothing of the kind."""
        try:
            t, steps, samples = float(data["t"]), int(data["steps"]), int(data["samples"])
            first, drift = ({str(k): float(x) for k, x in data[name].items()} for name in ("first", "drift"))
            base, unknown = (
                {str(k): float(x) for k, x in data.get(name, {}).items()} for name in ("base", "unknown")
            )
            size, limited = float(data["size"]), bool(data["limited"])
            extent = float(data.get("extent", 0.0))
            final = None if data["final"] is None else State(**data["final"])
            happened = tuple(Happened(*one) for one in data.get("events", ()))
            changes = changes_in(data)
            actions, singular = (tuple(map(float, data.get(name, ()))) for name in ("actions", "singular"))
            kept = kept_at_once(len(happened))
            list(map(int, (*actions[:1], *actions[kept:])))  # these are whole numbers
        except (KeyError, TypeError, AttributeError, OverflowError) as error:
            raise ValueError("no progress") from error
        memory, marks = arrays.get("memory"), tuple(arrays.get("marks", ()))
        if memory is None or any(
            one.shape != (program.inner.memory,) or one.dtype != np.float64 for one in (memory, *marks)
        ):
            raise ValueError("not of this program")
        within = min(times.start, times.stop) <= t <= max(times.start, times.stop)
        within &= abs(float(memory[program.inner.time])) == abs(t)  # backward it is -t
        if not within or steps < 0 or not 0 <= samples <= times.count:
            raise ValueError("not of this run")
        if list(first) != list(program.quantities if samples else ()) or list(drift) != list(conserved):
            raise ValueError("of other quantities")
        if base and list(base) != list(first):
            raise ValueError("of other quantities")
        if len(happened) != len(program.events) or (happened and len(actions) < kept):
            raise ValueError("of other events")
        snapshot = Snapshot(memory, t, steps, samples, limited, actions, marks, singular, changes)
        return cls(snapshot, first, drift, size, final, base, happened, unknown, extent)


def changes_as_data(changes: Iterable[MethodChange]) -> list[dict[str, Any]]:
    """Changes of the method in terms of JSON."""
    return [{name: getattr(one, name) for name in fields_of(MethodChange)} for one in changes]


def changes_in(data: Any) -> tuple[MethodChange, ...]:
    """The changes of the method in what ``Progress.as_data`` gave; raises ``ValueError``."""
    try:
        changes = tuple(MethodChange(**one) for one in data.get(CHANGES, ()))
        steps, known = [one.steps for one in changes], all(one.method in (TAYLOR, STIFF) for one in changes)
        known = known and all(METHODS[STIFF].tolerances[DOUBLE][0] <= one.tolerance < 1.0 for one in changes)
    except (TypeError, AttributeError) as error:
        raise ValueError("no changes of a method") from error
    if steps != sorted(steps) or not known:
        raise ValueError("no changes of a method")
    return changes


class Schedule:
    """Says when a checkpoint is due: every so many ``seconds`` of wall time, and after so much ``work``
    (steps, or members that have ended)."""

    def __init__(self, seconds: float, work: float, done: int = 0) -> None:
        self._seconds, self._work = seconds, work
        self._next, self._most = time.monotonic() + seconds, done + work

    def due(self, done: int) -> bool:
        """Whether a checkpoint is due after this amount of work."""
        return done >= self._most or time.monotonic() >= self._next

    def kept(self, done: int, began: float) -> None:
        """Restart the counts after a checkpoint whose writing ``began`` at this time."""
        now = time.monotonic()
        self._next = now + max(self._seconds, RARELY * (now - began))
        self._most = done + self._work


class Checkpointing(Generic[T]):
    """Where a run begins (None: at the start), and what is done with its progress when a checkpoint is
    due."""

    def __init__(self, begin: T | None, clock: Schedule, write: Callable[[T], None]) -> None:
        self.begin, self._clock, self._write = begin, clock, write
        self.due = clock.due

    def beginning(self, begin: T | None) -> Checkpointing[T]:
        """The same for a run that begins elsewhere, or at the start."""
        return Checkpointing(begin, self._clock, self._write)

    def keep(self, progress: T, done: int) -> None:
        """Write a checkpoint after this amount of work."""
        began = time.monotonic()
        self._write(progress)
        self._clock.kept(done, began)


UNKEPT: Checkpointing[Any] = Checkpointing(None, Schedule(math.inf, math.inf), lambda progress: None)
"""No checkpoint is ever due, and none is written."""
