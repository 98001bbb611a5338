"""``Method``: what every integration method must do, and what it returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import NO_EVENTS, EventSink
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.native.interface import Interface
    from lagrange_cli.spec.values import Values

Interrupt = Callable[[float], bool]
"""Called with the time reached, several times a second; returns True to stop there."""
Accept = Callable[[Array, Array], None]
"""Takes sample times (c,) and states (rows, c), with rows q, v and integrals. The arrays are valid until the
next call; whoever needs them longer must copy them."""


@dataclass(frozen=True)
class Start:
    """How a motion begins: its ``parameters`` (P,), and its ``state`` (rows,) of q, v and zeros for the
    integrals at the first of the ``times``."""

    parameters: Array
    state: Array
    times: Times

    @classmethod
    def of(cls, program: Interface, values: Values, times: Times) -> Start:
        """With these ``values``, and their remainders if they have any."""
        given = [values] if values.remainder is None else [values, values.remainder]
        parameters = np.array(
            [one.parameters[name] for one in given for name in program.parameters], np.float64
        )
        parts = [part for one in given for part in (one.q, one.v, np.zeros(len(program.integrals)))]
        return cls(parameters, np.concatenate(parts), times)


class Unfit(ValueError):
    """A snapshot that does not belong to this motion."""


@dataclass(frozen=True)
class MethodChange:
    """From a time on, after so many steps, a motion is followed by another ``method`` with its own
    ``tolerance``: a step of ``Radau`` there replaces so many Taylor steps. Before it, rates were evaluated
    ``beyond`` the number of steps so often."""

    t: float
    steps: int
    method: str
    tolerance: float
    replaces: float
    beyond: int = 0


@dataclass(frozen=True)
class Snapshot:
    """What a method needs to continue a motion from time ``t`` with the same bits.

    ``memory`` is its whole state, except ``actions``, the state of the actions of events. So far it has taken
    ``steps`` steps and handed over ``samples`` samples. Unless the steps were ``limited`` by the stop time, a
    motion that stops later takes the same steps. ``marks`` are memories of earlier times, from which a
    singular configuration is passed; it has passed others at the times ``singular``. The memory is that of
    the last method of the ``changes``, if there are any.
    """

    memory: Array
    t: float
    steps: int
    samples: int
    limited: bool = False
    actions: tuple[float, ...] = ()
    marks: tuple[Array, ...] = ()
    singular: tuple[float, ...] = ()
    changes: tuple[MethodChange, ...] = ()

    @property
    def arrays(self) -> dict[str, Array]:
        """``memory`` and ``marks``, by these names."""
        return {"memory": self.memory, **({"marks": np.array(self.marks)} if self.marks else {})}


@dataclass(frozen=True)
class Cause:
    """The reason in the system file for the end of a motion, as a sentence, and its time. The way out is that
    of the ``ending``, if there is one in place of that of the motion."""

    text: str
    t: float
    ending: Ending | None = None


@dataclass(frozen=True)
class End:
    """Why a method stopped, at which time and state (q, v), after how many steps and evaluations, and the
    snapshot that the motion can be continued from, if there is one. Where the motion could not go on,
    ``accelerations`` (n,) are those there, and ``cause`` is what stopped it, as far as they are known."""

    ending: Ending
    t: float
    state: Array
    steps: int
    evaluations: int
    detail: str = ""
    snapshot: Snapshot | None = None
    accelerations: Array = field(default_factory=lambda: np.zeros(0))
    cause: Cause | None = None
    projections: int = 0
    """How often the state was moved back to the constraints."""
    singular: tuple[float, ...] = ()
    """When the motion has passed singular configurations."""
    threads: int = 1
    """How many have shared the work."""
    changes: tuple[MethodChange, ...] = ()
    """When the motion has changed its method."""


@dataclass(frozen=True)
class CheckpointSink:
    """The snapshot that a method begins with (None: at the start), and what takes its snapshots.

    ``due`` is called several times a second with the number of steps. When it returns True, all samples so
    far are handed over, and ``keep`` is given a snapshot. ``ends`` is given the snapshot that a longer motion
    can be continued from, if there is one, when the samples up to it have been handed over.

    If ``every`` is not 0, ``due`` and then ``interrupt`` are also called at each multiple of so many steps. A
    motion that is ended there ends at the same step in every run, however fast the machine is.
    """

    begin: Snapshot | None
    due: Callable[[int], bool]
    keep: Callable[[Snapshot], None]
    ends: Callable[[Snapshot], None] | None = None
    every: int = 0


NO_CHECKPOINTS = CheckpointSink(None, lambda steps: False, lambda snapshot: None)


@dataclass(frozen=True)
class Observer:
    """What observes a motion. ``samples`` is given full chunks of samples, and at the end of the motion those
    that are left, for whatever reason it ends; ``events`` is given what happens before them. ``interrupt`` is
    called with the time several times a second; when it returns True, the motion ends there."""

    samples: Accept = lambda times, states: None
    interrupt: Interrupt = lambda t: False
    events: EventSink = NO_EVENTS
    checkpoints: CheckpointSink = NO_CHECKPOINTS


UNOBSERVED = Observer()


class Method(Protocol):
    """A way to follow a motion."""

    def follow(self, start: Start, observer: Observer = UNOBSERVED, threads: int | None = 1) -> End:
        """Follow the motion from its ``start``.

        A method without snapshots ignores the ``observer``'s ``checkpoints``, and one that finds no events is
        not used where there are any. So many ``threads`` may share the work, None for one on each processor;
        the bits do not depend on them.
        """
        ...
