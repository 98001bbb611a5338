"""``Outcome``: the result of a run, and its figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.integrate.ending import Ending, State
from lagrange_cli.integrate.events import Happened
from lagrange_cli.integrate.method import MethodChange
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.integrate.checkpoint import Progress


@dataclass(frozen=True)
class Estimated:
    """The error of a run by estimate, of the problem as it is written: the time up to which it can be
    trusted, and the error at the end (see ``integrate.certify.certificate``). Then the same of the problem as
    it is run; where roundings of inputs prevail, the names of the ``rounded`` ones; and whether the problem
    as it is written stays at an equilibrium that the run leaves."""

    trusted_until: float
    error: float
    trusted_until_as_run: float
    error_as_run: float
    rounded: tuple[str, ...] | None = None
    staying: bool = False


@dataclass(frozen=True)
class Outcome:
    """The result of a run.

    ``t`` is the time that the motion reached. ``steps`` and ``evaluations`` (of the equations of motion, or
    of their whole series) count the work. ``h_drift`` is max |h - h(0)| over the samples if h should be
    conserved, else None, ``h_size`` the size of the terms of h, and ``h_rounding`` what rounding of the last
    sample changes of h, 0 if unknown, or if the drift is small beside the size. ``p_drift`` is the drift of
    each conserved momentum, by coordinate. What actions of events have added to them is no drift.
    ``undetected``, ``left_out`` and ``undefined`` are those of the ``Recording``, ``unknown`` the datasets
    with samples that are not finite, and the time of the first of these. ``happened`` has the record of each
    event, by name.
    ``progress`` is the state from which an interrupted run, or a longer one, can continue. ``final`` is the
    state at ``t``; of a complete or certified run it is the last sample. ``estimated`` is the error, if an
    estimate was requested. The state was moved back to constraints by so many ``projections``, and passed
    ``singular`` configurations at these times. So many ``threads`` have shared the work. ``extent`` is the
    largest coordinate or velocity of the samples, of a method whose errors are ``absolute``. ``changes`` says
    when the motion has changed its method."""

    ending: Ending
    message: str
    t: float
    steps: int
    evaluations: int
    h_drift: float | None
    p_drift: Mapping[str, float]
    h_size: float = 0.0
    h_rounding: float = 0.0
    undetected: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    undefined: tuple[str, ...] = ()
    unknown: Mapping[str, float] = field(default_factory=dict)
    happened: Mapping[str, Happened] = field(default_factory=dict)
    progress: Progress | None = None
    estimated: Estimated | None = None
    final: State | None = None
    projections: int = 0
    singular: tuple[float, ...] = ()
    threads: int = 1
    extent: float = 0.0
    changes: tuple[MethodChange, ...] = ()
