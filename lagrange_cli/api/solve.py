"""``solve``: follow a motion, and have it as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.api.given import Value, Values, check_lengths, count_of, demand_of, request_of
from lagrange_cli.api.kept import keep
from lagrange_cli.api.motion import Motion
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.warned import warn
from lagrange_cli.api.words import in_python, python_words
from lagrange_cli.errors import Interrupted, MotionError, UsageError
from lagrange_cli.integrate.precision import DOUBLE, PRECISIONS
from lagrange_cli.run.attributes import WARNING, notes
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.memory import follow
from lagrange_cli.run.monitor import Monitor, untimed
from lagrange_cli.run.motion import prepare_all, read_motion

if TYPE_CHECKING:
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.request import Request

MONITOR = Monitor(interrupts=partial(Interrupts, alone=True), warn=warn)
"""Ctrl-C ends a run between two steps; nothing else is heeded."""


@in_python
def solve(
    system: System,
    *,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
    start: Value | None = None,
    stop: Value | None = None,
    samples: int | None = None,
    step: Value | None = None,
    tolerance: float | None = None,
    method: str | None = None,
    outputs: str | Iterable[str] | None = None,
    precision: str = DOUBLE,
    portable: bool = False,
    proven: bool = False,
    project_initial: bool = False,
    certify: bool = False,
    digits: float | None = None,
    target_error: float | None = None,
    cache: bool = True,
    threads: int | None = None,
) -> Motion:
    """Follow the motion of a system.

    The system is read and its equations are compiled once. A later call, with any numbers, costs about a
    millisecond besides the integration. Any number of threads may call it at the same time.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    set : mapping, optional
        Parameters and initial values by name, as numbers or expressions: ``{"l": 2, "theta": "pi/2",
        "theta_dot": 0}``. A sequence has the values of a family.
    size : mapping, optional
        Sizes by name: ``{"N": 50}``.
    start, stop, step : float or str, optional
        When the motion begins and ends, and the time between samples, as numbers or expressions in
        parameters; by default those of the file.
    samples : int, optional
        The number of samples, in place of ``step``.
    tolerance : float, optional
        The relative error per step; by default full double precision.
    method : str, optional
        The integration method; by default ``auto``.
    outputs : sequence of str, optional
        What is computed: ``["q", "v", "energy"]``, or ``"all"``.
    precision : {"double", "double-double"}
        The arithmetic.
    portable, proven, project_initial : bool
        As the options of the command.
    certify : bool
        Whether the error of every sample is estimated.
    digits, target_error : float, optional
        As the options of the command; each implies ``certify``.
    cache : bool
        Whether programs compiled by earlier processes may be used.
    threads : int, optional
        How many threads share the work of one large system; by default one for each processor. The results
        do not depend on it.

    Returns
    -------
    Motion
        Everything that was computed; its ``status`` is ``complete`` or ``stopped``.

    Raises
    ------
    SpecError
        The system is wrong.
    UsageError
        An argument is wrong.
    FileError
        The file cannot be read.
    MotionError
        The motion could not go on. Its attribute ``result`` has the motion so far; its status is ``failed``.
    Interrupted
        Ctrl-C was pressed. It is a ``KeyboardInterrupt``, so that a loop of runs ends; its attribute
        ``result`` has the motion so far, with the status ``interrupted``.

    Warns
    -----
    LagrangeWarning
        The warnings that the command prints.
    """
    request = request_of(
        set=set,
        size=size,
        times={"start": start, "stop": stop, "step": step},
        samples=samples,
        tolerance=tolerance,
        method=method,
        outputs=outputs,
        precision=precision,
        portable=portable,
        proven=proven,
        project_initial=project_initial,
        cache=cache,
        threads=None if threads is None else count_of("threads", threads),
    )
    demand = demand_of(certify, digits, target_error)
    check_precision(request, demand)
    content, filename = content_of(system)
    kept = keep(content, filename, request.sizes)
    found = read_motion(content, filename, request, read=kept.read, begin_at=kept.begin_at)
    check_lengths(found.spec, set)
    prepare = kept.prepare
    if demand is None and found.may_be_stiff:
        from lagrange_cli.run.trial import settled

        found, prepare = settled(found, request, untimed, kept.prepare)
    ready = prepare_all(found, request, demand, untimed, prepare, kept.check)
    units, told = kept.units(found.spec)
    followed = follow(ready, units, MONITOR, demand)
    motion = Motion(followed, units, tuple(map(python_words, (*told, *notes(found, followed.outcome)))))
    for note in motion.notes:
        if WARNING in note:
            warn(note)
    return ended_well(motion)


def check_precision(request: Request, demand: Demand | None) -> None:
    """Raise ``UsageError`` for an unknown precision, or for one that has no certificate."""
    if request.precision not in PRECISIONS:
        known = " or ".join(map(repr, PRECISIONS))
        raise UsageError(f"precision is {known}, not {request.precision!r:.60}")
    if demand is not None and (request.precision != DOUBLE or request.portable):
        other = "portable" if request.portable else f"precision {request.precision}"
        raise UsageError(f"certify and {other} cannot be combined: leave out one of the two")


def ended_well(motion: Motion) -> Motion:
    """The motion, if it has reached its end; otherwise an exception is raised that contains it."""
    if motion.status == "failed":
        failed = MotionError(f"{motion.name}: {motion.message}")
        failed.result = motion
        raise failed
    if motion.status == "interrupted":
        interrupted = Interrupted(f"{motion.name}: {motion.message}")
        interrupted.result = motion
        raise interrupted
    return motion
