"""``view``: a page that shows a system, and computes its motion where it is read."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import LagrangeError, SpecError, TooLarge, UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.attributes import finite
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.motion import Motion, read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.version import __version__

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.drawing.drawing import Drawing
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.native.program import Program
    from lagrange_cli.outputs.recording import Recording
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.target import Target

OUTPUTS = frozenset({"q", "v", "p", "h"})
SPAN = 10.0
"""How long a motion is whose file does not say it."""
FEWEST, MOST = 1001, 20001
"""Samples of a motion in the page."""
SAMPLES_A_STEP = 4
"""Of the motion as the file has it: enough to draw its path."""
NUMBERS = 2_000_000
"""Numbers in all samples of a page's motion."""
REPLAYED = "This page replays the motion that was computed when it was written."
PATIENCE = 5.0
"""Seconds that the motion may take before the page is written without its end."""
READING = 8_000_000
"""Steps of work for equations that are to be read: some 8 s."""
UNREADABLE = "The equations are too large to be shown here."
LARGEST = 60_000
"""Lines of LLVM IR in a page's program: the page stays below 400 kB, and is written in less than a minute."""
PROVEN = 20_000
"""Lines of a program with the proofs of its steps, beyond which these are left out: with more of them, the
page would no longer begin a motion within a frame."""
UNPROVEN = (
    "This page does not prove its steps, since its program would be too large: it may pass over a force that "
    "acts for a very short time. lagrange solve does not."
)
DRAWN = 4_000
"""Nodes of all that is drawn: a thousand rods, whose code takes some 10 s."""
UNDRAWN = "The drawing of this system is too large for a page."
RECORDED = 20_000
"""Numbers in a page that replays a motion."""
PLAYED = 200
"""Samples that should be among them."""


@dataclass(frozen=True)
class Page:
    """A page: its ``text``, whether it computes (``live``), and why not, where it does not."""

    text: str
    live: bool
    why: str = ""


@dataclass(frozen=True)
class Followed:
    """A motion as it is computed here: times (n,), q and v (n, degrees), and how it ended."""

    t: Array
    q: Array
    v: Array
    observed: Mapping[str, Array]
    message: str
    steps: int


def read_shown(content: bytes, filename: str, request: Request, stage: Stage = untimed) -> Motion:
    """The motion of a system file that a page shows; one without a stop time lasts for ``SPAN``.

    Raises ``SpecError`` and ``UsageError`` as ``read_motion`` does.
    """
    from lagrange_cli.run.derive import read_run

    spec, _ = read_run(content, filename, request.sizes, lambda spec, problems: None)
    if spec.solve.stop is None and "stop" not in {*request.times, *spec.solve.times}:
        request = replace(request, options=replace(request.options, stop=SPAN))
    return read_motion(content, filename, request, stage)


def view(motion: Motion, stage: Stage = untimed, members: Sequence[Mapping[str, Any]] = ()) -> Page:
    """The page of a system: it computes, unless something in the system is not for that.

    It can have ``members``, which are other values to begin with: ``{"label": ..., "values": {name: x}}``.

    Raises ``SpecError`` where no equations can be derived, and ``UsageError`` for members of a system whose
    page cannot compute.
    """
    motion = watched(motion)
    return page(motion, follow(motion, stage), stage, members)


def page(
    motion: Motion,
    followed: Followed,
    stage: Stage = untimed,
    members: Sequence[Mapping[str, Any]] = (),
    equations: str | None = None,
) -> Page:
    """The page of a motion that was ``watched`` and has been ``followed``; ``equations`` are HTML, which is
    derived if it is not given."""
    with stage("derive"):
        from lagrange_cli.run.derive import derive_system, located

        with located(motion.spec):
            residual = derive_system(motion.spec, resting=True)
    why = obstacle(motion, residual)
    with stage("compile"):
        program, recording, notice = programmed(motion, residual)
        drawing = drawn(motion, followed)
        shown = {"members": [*members], "conserved": [*recording.conserved], "notice": notice}
        why = why or too_large(program.text)
        if why and members:
            raise UsageError(f"the motions cannot be computed on a page: {why}")
        replays = why and f"{why} {REPLAYED}{cut_short(motion, followed)}"
        if why:
            shown |= {"members": [recorded(followed)], "notice": replays}
        text = assembled(motion, followed, drawing, None if why else program, shown, equations)
    return Page(text, not why, replays)


def programmed(motion: Motion, residual: Residual) -> tuple[Program, Recording, str]:
    """The program of a page, what becomes of its results, and what the page says of it: whether proofs of
    steps were too long."""
    from lagrange_cli.integrate.program import write_run

    compilation = motion.settings.compilation()
    program, recording = write_run(residual, compilation)
    if program.text.count("\n") <= PROVEN:
        return program, recording, ""
    shorter, recording = write_run(residual, replace(compilation, proven=False, unproven=True))
    return shorter, recording, UNPROVEN if shorter.text != program.text else ""


def cut_short(motion: Motion, followed: Followed) -> str:
    """What a page that replays says of a motion that was not computed to its end; else nothing."""
    t, stop = followed.t, motion.settings.stop
    if followed.message or (len(t) and t[-1] == stop):
        return ""
    reached = float(t[-1]) if len(t) else motion.settings.start
    how = "lagrange solve computes all of it, and lagrange view shows its output."
    return f" It ends at t = {reached:.6g}, which was reached in {PATIENCE:g} s: {how}"


def assembled(
    motion: Motion,
    followed: Followed,
    drawing: Drawing | None,
    program: Program | None,
    more: Mapping[str, Any],
    equations: str | None = None,
) -> str:
    """The page's text: one without a ``program`` replays."""
    from concurrent.futures import ThreadPoolExecutor

    from lagrange_cli.page.document import document
    from lagrange_cli.page.engine import engine

    points = () if drawing is None else drawing.nodes
    sizes = () if drawing is None else drawing.sizes
    free = () if drawing is None else drawing.free
    with ThreadPoolExecutor(1) as other:  # LLVM compiles while sympy derives
        compiled = other.submit(engine, motion.spec, program, points, sizes, free)
        text = written(motion.spec) if equations is None else equations
    data = described(motion, drawing, followed) | {"engine": compiled.result(), **more}
    if drawing is None:
        data["notice"] = " ".join(filter(None, (data["notice"], UNDRAWN)))
    return document(finite(data), text)


def write(page: Page, target: Target) -> int:
    """Write the page to its file; how many bytes it has. Raises ``FileError``."""
    from lagrange_cli.store.target import unwritable

    content = page.text.encode("utf-8", "replace")
    with target.claimed():
        try:
            target.temporary.write_bytes(content)
        except OSError as error:
            target.discard()
            raise unwritable(target.shown, error) from error
        target.publish()
    return len(content)


def watched(motion: Motion) -> Motion:
    """The motion with what a page shows of it as its outputs."""
    settings = replace(shown_settings(motion.settings), outputs=OUTPUTS, optional=frozenset())
    return replace(motion, settings=settings)


def shown_settings(settings: Settings) -> Settings:
    """Those of a motion in doubles, by the Taylor method."""
    from lagrange_cli.integrate.methods.table import METHODS, TAYLOR
    from lagrange_cli.integrate.precision import DOUBLE

    if settings.method == TAYLOR and settings.precision == DOUBLE:
        return settings
    tolerance = METHODS[TAYLOR].tolerances[DOUBLE][1]
    return replace(settings, method=TAYLOR, precision=DOUBLE, tolerance=tolerance)


def obstacle(motion: Motion, residual: Residual) -> str:
    """Why a page cannot compute the motion, as a sentence; empty where it can."""
    if motion.settings.backward:
        return "This motion is followed backward in time."
    if residual.multipliers and any(one.changes for one in residual.model.events):
        return "Actions of events in a system with constraints are computed by lagrange solve only."
    return ""


def too_large(program: str) -> str:
    """Why a program is not for a page, as a sentence; empty where it is."""
    lines = program.count("\n")
    if lines <= LARGEST:
        return ""
    return f"This system's program of {lines} instructions is too large for a page (at most {LARGEST})."


def follow(motion: Motion, stage: Stage = untimed) -> Followed:
    """The motion, as far as it goes in ``PATIENCE`` seconds."""
    import numpy as np

    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.prepare import prepare_run

    settings = motion.settings
    prepared = prepare_run(motion.spec, settings, stage, cached=True)
    paths = {kind: [one.path for one in prepared.recording.states if one.path[0] == kind] for kind in "qv"}
    found: dict[str, list[Array]] = {"t": [], "q": [], "v": []}
    observed: dict[str, list[Array]] = {}

    def emit(chunk: dict[str, np.ndarray]) -> None:
        count = len(chunk["t"])
        found["t"].append(chunk["t"].copy())
        for kind, listed in paths.items():
            found[kind].append(np.concatenate([chunk[path].reshape(count, -1) for path in listed], axis=1))
        for dataset in prepared.recording.made:
            columns = chunk[dataset.path].reshape(count, -1).T
            for name, column in zip(dataset.sources, columns):
                observed.setdefault(name, []).append(column.copy())

    until = time.monotonic() + PATIENCE
    times = Times(settings.start, settings.stop, settings.count, settings.step)
    with stage("integrate"):
        outcome = integrate(
            prepared, motion.values, times, emit, lambda: time.monotonic() > until, explain=motion.cause
        )
    n = len(motion.spec.coordinates)

    def joined(kind: str) -> Array:
        return np.concatenate([np.empty((0, n)), *found[kind]])

    status = outcome.ending.status
    return Followed(
        np.concatenate([np.empty(0), *found["t"]]),
        joined("q"),
        joined("v"),
        {name: np.concatenate(parts) for name, parts in observed.items()},
        "" if status in ("complete", "interrupted") else outcome.message,
        outcome.steps,
    )


def drawn(motion: Motion, followed: Followed) -> Drawing | None:
    """What is drawn, with bounds that hold the motion; None where that would be too much.

    Raises ``SpecError`` for numbers of the section ``draw`` that make no sense.
    """
    from lagrange_cli.drawing.draw import draw
    from lagrange_cli.drawing.evaluate import extent, fitted
    from lagrange_cli.expression.node import reachable

    parameters = motion.values.parameters
    try:
        drawing = draw(motion.spec, motion.values, motion.settings.start)
        if len(reachable(drawing.nodes)) > DRAWN:
            return None
        return fitted(drawing, extent(drawing, followed.t, followed.q, parameters), parameters)
    except TooLarge:
        return None
    except SpecError:
        if motion.spec.draw is not None:
            raise
        return None


def described(motion: Motion, drawing: Drawing | None, followed: Followed) -> dict[str, Any]:
    """What a page says of a system and shows of its motion, in terms of JSON."""
    spec, values, settings = motion.spec, motion.values, motion.settings
    units = units_of(spec)
    numbers = 4 * len(spec.coordinates) + 4 + (0 if drawing is None else len(drawing.nodes))
    most = max(FEWEST // 4, min(MOST, NUMBERS // numbers))
    count = max(settings.count, FEWEST, SAMPLES_A_STEP * followed.steps)
    return {
        "name": spec.name,
        "description": spec.description,
        "file": spec.filename.replace("\\", "/").rpartition("/")[2],
        "text": spec.text,
        "generator": f"lagrange {__version__}",
        "time": {
            "start": settings.start,
            "stop": settings.stop,
            "count": min(count, most),
            "steps": max(1, followed.steps),
            "unit": units.get("t", ""),
        },
        "parameters": [
            {
                "name": one.name,
                "value": values.parameters[one.name],
                "unit": units.get(f"parameters/{one.name}", one.unit),
                "description": one.description,
                "expression": expression_of(one.value),
            }
            for one in spec.parameters
        ],
        "coordinates": [
            {
                "name": one.name,
                "q": values.q[k],
                "v": values.v[k],
                "unit": units.get(f"q/{family(one.name)}", one.unit),
                "unitOfVelocity": units.get(f"v/{family(one.name)}", ""),
                "unitOfMomentum": units.get(f"diagnostics/p/{family(one.name)}", ""),
                "description": one.description,
                "expressions": [expression_of(one.initial), expression_of(one.velocity)],
                "reach": [largest(followed.q[:, k]), largest(followed.v[:, k])],
            }
            for k, one in enumerate(spec.coordinates)
        ],
        "velocities": [velocity_name(one.name) for one in spec.coordinates],
        "unitOfEnergy": units.get("diagnostics/h", ""),
        "constraints": list(spec.all_constraints),
        "message": followed.message,
        "drawing": None if drawing is None else drawing.data(),
    }


def expression_of(expression: Any) -> str:
    """The text of an expression in parameters; empty for a number, or where there is none."""
    if expression is None:
        return ""
    with suppress(ValueError):
        float(expression.text)
        return ""
    return str(expression.text)


def family(name: str) -> str:
    """``theta`` for ``theta[3]``."""
    return name.partition("[")[0]


def largest(column: Array) -> float:
    """The largest magnitude of finite numbers."""
    import numpy as np

    known = np.abs(column[np.isfinite(column)])
    return float(known.max()) if len(known) else 0.0


def units_of(spec: Spec) -> Mapping[str, str]:
    """Units by path."""
    from lagrange_cli.outputs.units import find_units

    return find_units(spec).texts


def recorded(followed: Followed) -> dict[str, Any]:
    """The samples of a motion for a page that replays it: every so many of them, and of many coordinates
    without the momenta."""
    import numpy as np

    from lagrange_cli.page.packed import packed

    observed = dict(followed.observed)
    rows = [followed.t, *followed.q.T, *followed.v.T]
    if (len(rows) + len(observed)) * PLAYED > RECORDED:
        observed = {name: row for name, row in observed.items() if name == "h"}
    rows += observed.values()
    each = max(1, math.ceil(len(followed.t) * len(rows) / RECORDED))
    places = np.unique(np.r_[0 : len(followed.t) : each, max(0, len(followed.t) - 1)])
    table = np.array([row[places] for row in rows], dtype="<f8")
    return {
        "label": "",
        "count": table.shape[1],
        "observed": list(observed),
        "rows": packed(table.tobytes()),
    }


def written(spec: Spec) -> str:
    """The equations as HTML; a sentence where they are too large."""
    from html import escape

    from lagrange_cli.run.equations import as_page, derive

    try:
        return as_page(derive(spec, most=READING))
    except LagrangeError as error:
        large = isinstance(error, TooLarge) or isinstance(error.__cause__, TooLarge)
        return f"<p>{UNREADABLE if large else escape(str(error).splitlines()[0])}</p>"
