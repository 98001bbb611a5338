"""``view``: a page that shows a system, and computes its motion in the browser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.attributes import finite
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.view.content import described, drawn, recorded, written
from lagrange_cli.run.view.motion import PATIENCE, ViewedMotion, follow, watched

if TYPE_CHECKING:
    from lagrange_cli.drawing.drawing import Drawing
    from lagrange_cli.families.description import FamilySystem
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.native.program import Program
    from lagrange_cli.outputs.recording import Recording
    from lagrange_cli.store.target import Target

REPLAYED = "This page replays the motion that was computed when it was written."
LARGEST = 60_000
"""Lines of LLVM IR in a page's program: the page stays below 400 kB, and is written in less than a minute."""
PROVEN = 20_000
"""Lines of a program with the proofs of its steps, beyond which these are left out: with more of them, the
page would no longer begin a motion within a frame."""
UNPROVEN = (
    "This page does not prove its steps, since its program would be too large: it may pass over a force that "
    "acts for a very short time. lagrange solve does not."
)
UNDRAWN = "The drawing of this system is too large for a page."


@dataclass(frozen=True)
class Page:
    """A page: its ``text``, whether it computes (``live``), and if not, why."""

    text: str
    live: bool
    why: str = ""


def view(motion: Motion, stage: Stage = untimed, members: Sequence[Mapping[str, Any]] = ()) -> Page:
    """The page of a system: it computes, unless the system has something that pages cannot compute.

    It can have ``members``, which are other values to begin with: ``{"label": ..., "values": {name: x}}``.

    Raises ``SpecError`` where no equations can be derived, and ``UsageError`` for members of a system whose
    page cannot compute.
    """
    motion = watched(motion)
    return page(motion, follow(motion, stage), stage, members)


def page(
    motion: Motion,
    followed: ViewedMotion,
    stage: Stage = untimed,
    members: Sequence[Mapping[str, Any]] = (),
    equations: str | None = None,
) -> Page:
    """The page of a motion that was ``watched`` and has been ``followed``; ``equations`` are HTML, which is
    derived if it is not given."""
    with stage("derive"):
        derived = equations_of(motion)
    why = obstacle(motion, derived)
    with stage("compile"):
        program, recording, notice = programmed(motion, derived)
        drawing = drawn(motion, followed)
        shown = {"members": [*members], "conserved": [*recording.conserved], "notice": notice}
        why = why or sliding(program) or bound(program) or beginning(program) or too_large(program.text)
        if why and members:
            raise UsageError(f"the motions cannot be computed on a page: {why}")
        replays = why and f"{why} {REPLAYED}{cut_short(motion, followed)}"
        if why:
            shown |= {"members": [recorded(followed)], "notice": replays}
    with stage("print" if equations is None else "compile"):
        text = assembled(motion, followed, drawing, None if why else program, shown, equations)
    return Page(text, not why, replays)


def equations_of(motion: Motion) -> FamilySystem | Residual:
    """The equations of motion: those that ``solve`` takes, but that whoever moves a slider may make any
    coefficient 0."""
    from lagrange_cli.integrate.families import family_run
    from lagrange_cli.run.derive import derive_system, located

    with located(motion.spec):
        system = family_run(motion.spec, motion.settings.compilation())
        if system is not None:
            return system
        return derive_system(replace(motion.spec, faint=tuple(motion.spec.all_constraints)), resting=True)


def programmed(motion: Motion, derived: FamilySystem | Residual) -> tuple[Program, Recording, str]:
    """The program of a page, what becomes of its results, and what the page says of it: whether proofs of
    steps were too long."""
    from lagrange_cli.families.description import FamilySystem
    from lagrange_cli.integrate.family_program import write_families
    from lagrange_cli.integrate.program import write_run

    compilation = motion.settings.compilation()
    if isinstance(derived, FamilySystem):
        return *write_families(derived, compilation, concise=True), ""
    program, recording = write_run(derived, compilation)
    if program.text.count("\n") <= PROVEN:
        return program, recording, ""
    shorter, recording = write_run(derived, replace(compilation, proven=False, unproven=True))
    return shorter, recording, UNPROVEN if shorter.text != program.text else ""


def cut_short(motion: Motion, followed: ViewedMotion) -> str:
    """What a page that replays says of a motion that was not computed to its end; else nothing."""
    t, stop = followed.t, motion.settings.stop
    if followed.message or (len(t) and t[-1] == stop):
        return ""
    reached = float(t[-1]) if len(t) else motion.settings.start
    how = "lagrange solve computes all of it, and lagrange view shows its output."
    return f" It ends at t = {decimal(reached)}, which was reached in {decimal(PATIENCE)} s: {how}"


def assembled(
    motion: Motion,
    followed: ViewedMotion,
    drawing: Drawing | None,
    program: Program | None,
    more: Mapping[str, Any],
    equations: str | None = None,
) -> str:
    """The page's text: one without a ``program`` replays."""
    from concurrent.futures import ThreadPoolExecutor

    from lagrange_cli.page.document import document
    from lagrange_cli.page.engine import engine

    with ThreadPoolExecutor(1) as other:  # LLVM compiles while sympy derives
        compiled = other.submit(engine, motion.spec, program, drawing)
        text = written(motion.spec) if equations is None else equations
    data = described(motion, drawing, followed) | {"engine": compiled.result(), **more}
    if drawing is None:
        data["notice"] = " ".join(filter(None, (data["notice"], UNDRAWN)))
    return document(finite(data), text)


def write(page: Page, target: Target) -> int:
    """Write the page to its file; how many bytes it has. Raises ``FileError``."""
    content = page.text.encode("utf-8", "replace")
    with target.filled() as path:
        path.write_bytes(content)
    return len(content)


def obstacle(motion: Motion, derived: FamilySystem | Residual) -> str:
    """Why a page cannot compute the motion, as a sentence; empty where it can."""
    from lagrange_cli.mechanics.residual import Residual

    if motion.settings.backward:
        return "This motion is followed backward in time."
    if isinstance(derived, Residual):
        bound, touching = bool(derived.multipliers), coupled(derived)
    else:
        bound, touching = derived.bonds is not None, derived.coupled is not None
    if bound and motion.spec.acts:
        return "Actions of events in a system with constraints are computed by lagrange solve only."
    if touching:
        return "Impacts of bodies that may rest on each other are computed by lagrange solve only."
    return ""


def coupled(derived: Residual) -> bool:
    """Whether one contact at which the motion may rest pushes what touches at another one. (Two walls of one
    coordinate do not touch it together.)"""
    model = derived.model
    reads = [
        frozenset(k for k, q in enumerate(model.q) if model.events[one.event].argument.symbols & q.symbols)
        for one in derived.contacts
    ]
    pushes = [frozenset(one.direction.places) for one in derived.contacts]
    return any(
        pushed & read and not (len(pushed) == 1 and read == pushed)
        for i, pushed in enumerate(pushes)
        for j, read in enumerate(reads)
        if i != j
    )


def sliding(program: Program) -> str:
    """Why a page cannot follow friction along a vector, as a sentence; empty if there is none."""
    from lagrange_cli.native.guards import EXPLICIT

    holds = any(program.guards[j] >= 0 or program.guards[j] == EXPLICIT for j, _ in program.vectors)
    return "Friction against a vector is computed by lagrange solve only." if holds else ""


def bound(program: Program) -> str:
    """Why a page cannot follow friction that constraints bind together, as a sentence; empty if there is
    none."""
    rows = program.rows_of_guards
    if rows.bound:
        return "Friction of many members beside constraints is computed by lagrange solve only."
    holding = sum(bool(one.multiplier) and not one.parts and one.event < 0 for one in rows.guards)
    if not program.constraints or holding < 2 or holding + program.constraints <= rows.degrees:
        return ""
    return "Friction that may hold more than constraints leave free is computed by lagrange solve only."


def beginning(program: Program) -> str:
    """Why a page cannot follow forces that begin as a root does, as those of elastic contact; empty if there
    are none."""
    from lagrange_cli.native.guards import ROOTS

    if not any(ROOTS.get(one, (False, 0))[1] for one in program.guards):
        return ""
    return "Forces such as max(0, s)^(3/2), which begin as a root does, are computed by lagrange solve only."


def too_large(program: str) -> str:
    """Why a page cannot run a program, as a sentence; empty if it can."""
    lines = program.count("\n")
    if lines <= LARGEST:
        return ""
    return f"This system's program of {lines} instructions is too large for a page (at most {LARGEST})."
