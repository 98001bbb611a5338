"""A motion that ``--method auto`` would follow by explicit steps is tried first if it may be stiff.

Only damping makes it so: where energy is conserved, implicit steps would damp what they do not resolve. At
full precision steps of order 5 are too short anyway, so that runs without ``--tolerance`` are not tried. A
trial takes one step of the method chosen for the system, mostly a Taylor step, or, where thousands would
follow, some more of them; its result depends on nothing but the motion (``integrate.stiffness``). On the way
there are further ones (``integrate.changing``).
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.methods.table import STIFF, TAYLOR
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
    """A motion that may be stiff, with the method that suits it at first, and what prepares it so that it
    changes where another one is better: nothing that a trial has compiled is compiled again.

    What is wrong with a motion is left to the run to find.
    """
    spec, asked = motion.spec, motion.settings
    explicit = with_proofs(spec, asked.without_implicit, iter([motion.values]))
    if explicit.proven:
        return motion, prepare
    meanwhile = partial(import_the_rest, request.format)
    chosen = asked
    made: dict[tuple[str, float], Prepared | None] = {}

    def prepared(method: str, tolerance: float) -> Prepared | None:
        """What a method is prepared with; None if it may not be used."""
        if (method, tolerance) not in made:
            own = replace(explicit, method=method, tolerance=tolerance)
            options = {} if made else {"meanwhile": meanwhile}
            try:
                found = prepare(spec, own, stage, cached=request.cache, **options)
            except LagrangeError:
                return made.setdefault((method, tolerance), None)
            missed = method == STIFF and found.recording.undetected
            made[method, tolerance] = None if missed else found
        return made[method, tolerance]

    begun = prepared(asked.method, asked.tolerance)
    if begun is None or begun.machine.program.parts > 1:
        return motion, prepare if begun is None else keeping(prepare, asked, begun)
    if not asked.as_before:
        found = tried(begun, motion, request, stage)
        other = None if found is None else prepared(STIFF, found.tolerance)
        if found is not None and other is not None and found.repays(other.machine.program):
            chosen = with_implicit(asked, found)
            begun = other
    if begun.machine.program.events:
        return replace(motion, settings=chosen), keeping(prepare, chosen, begun)
    from lagrange_cli.integrate.changing import Changing, alike

    def fitting(method: str, tolerance: float) -> Prepared | None:
        """The same, if states of the two are alike."""
        other = prepared(method, tolerance)
        return other if other and alike(begun.machine.program, other.machine.program) else None

    follower = Changing((chosen.method, chosen.tolerance), (explicit.method, explicit.tolerance), fitting)
    return replace(motion, settings=chosen), keeping(prepare, chosen, replace(begun, follower=follower))


def tried(prepared: Prepared, motion: Motion, request: Request, stage: Stage) -> Stiffness | None:
    """How stiff a motion is, if it is."""
    from lagrange_cli.integrate.stiffness import stiffness
    from lagrange_cli.integrate.times import Times

    settings = motion.settings
    times = Times(settings.start, settings.stop, settings.count, settings.step)
    with stage("integrate"):
        return stiffness(prepared, motion.values, times, request.threads)


def with_implicit(asked: Settings, found: Stiffness) -> Settings:
    """The settings with the implicit steps that are chosen, and why."""
    replaces, others = float(f"{found.replaces:.0e}"), in_words(asked.method)
    because = f"the motion is stiff: at first a step replaces some {replaces:.0f} {others}"
    chosen = replace(asked, method=STIFF, tolerance=found.tolerance, explicit=asked.method)
    return replace(chosen, chosen_because=because)


def in_words(method: str) -> str:
    """Steps of a method."""
    return "Taylor steps" if method == TAYLOR else f"steps of {method}"


def keeping(prepare: Prepare, settings: Settings, prepared: Prepared) -> Prepare:
    """``prepare``, with what is prepared for these settings already."""

    def prepare_others(spec: Spec, asked: Settings, stage: Stage, **options: Any) -> Prepared:
        if asked == settings and options.keys() <= {"cached", "meanwhile"}:
            options.get("meanwhile", lambda: None)()
            return prepared
        return prepare(spec, asked, stage, **options)

    return prepare_others
