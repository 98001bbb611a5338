"""A motion that ``--method auto`` would follow by Taylor series is tried first if it may be stiff.

Only damping makes it so: where energy is conserved, implicit steps would damp what they do not resolve. At
full precision steps of order 5 are too short anyway, so that runs without ``--tolerance`` are not tried. A
trial takes one Taylor step, or, where thousands would follow, some more of them; its result depends on
nothing but the motion (``integrate.stiffness``).
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.methods.table import STIFF
from lagrange_cli.records import replace
from lagrange_cli.run.motion import Motion, Prepare, import_the_rest
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.strength import with_proofs

if TYPE_CHECKING:
    from typing import Any

    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.stiffness import Stiffness
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec


def settled(
    motion: Motion, request: Request, stage: Stage, prepare: Prepare = prepare_run
) -> tuple[Motion, Prepare]:
    """A motion that may be stiff, with the method that suits it, and what prepares it: nothing that a trial
    has compiled is compiled again.

    What is wrong with a motion is left to the run to find.
    """
    spec = motion.spec
    series = with_proofs(spec, motion.settings, iter([motion.values]))
    meanwhile = partial(import_the_rest, request.format)
    if series.proven:
        return motion, prepare
    try:
        prepared = prepare(spec, series, stage, cached=request.cache, meanwhile=meanwhile)
        found = tried(prepared, motion, request, stage)
        if found is not None:
            implicit = replace(
                motion.settings, method=STIFF, tolerance=found.tolerance, chosen_because=said(found)
            )
            other = prepare(spec, implicit, stage, cached=request.cache)
            if not other.recording.undetected and found.repays(other.machine.program):
                return replace(motion, settings=implicit), keeping(prepare, implicit, other)
    except LagrangeError:
        return motion, prepare
    return motion, keeping(prepare, series, prepared)


def tried(prepared: Prepared, motion: Motion, request: Request, stage: Stage) -> Stiffness | None:
    """How stiff a motion is, if it is."""
    from lagrange_cli.integrate.stiffness import stiffness
    from lagrange_cli.integrate.times import Times

    settings = motion.settings
    times = Times(settings.start, settings.stop, settings.count, settings.step)
    with stage("integrate"):
        return stiffness(prepared, motion.values, times, request.threads)


def said(found: Stiffness) -> str:
    """Why implicit steps are chosen."""
    replaces = float(f"{found.replaces:.0e}")
    return f"the motion is stiff: at first a step replaces some {replaces:.0f} Taylor steps"


def keeping(prepare: Prepare, settings: Settings, prepared: Prepared) -> Prepare:
    """``prepare``, with what is prepared for these settings already."""

    def prepare_others(spec: Spec, asked: Settings, stage: Stage, **options: Any) -> Prepared:
        if asked == settings and options.keys() <= {"cached", "meanwhile"}:
            options.get("meanwhile", lambda: None)()
            return prepared
        return prepare(spec, asked, stage, **options)

    return prepare_others
