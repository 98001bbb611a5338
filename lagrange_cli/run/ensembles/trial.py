"""Some members of a sweep are tried before ``--method auto`` follows all of them by explicit steps.

Explicit steps are taken for eight members at once (unless there are events), implicit ones for each member
alone. So the members that are stiff have to be worth that: all steps of the members tried are counted
(``integrate.stiffness.of_many``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.records import replace
from lagrange_cli.run.ensembles.ensemble import Ensemble
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.strength import with_proofs
from lagrange_cli.run.trial import with_implicit

if TYPE_CHECKING:
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.run.request import Request

TRIED = 5
"""Members that are tried, from the first to the last one."""


def settled(ensemble: Ensemble, request: Request, stage: Stage) -> Ensemble:
    """An ensemble whose members may be stiff, with the method that suits them."""
    spec, values, settings = ensemble.spec, ensemble.values, ensemble.settings
    explicit = with_proofs(spec, settings, values.several())
    if explicit.proven:
        return ensemble
    from lagrange_cli.integrate.stiffness import first_trial, of_many
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.native.interface import LANES

    try:
        prepared = prepare_run(spec, explicit, stage, cached=request.cache)
    except LagrangeError:  # which is reported where all members are prepared
        return ensemble
    times = Times(settings.start, settings.stop, 2, settings.stop - settings.start)
    last = values.members - 1
    members = dict.fromkeys(last * k // max(1, TRIED - 1) for k in range(TRIED))
    with stage("integrate"):
        listed = [
            None if trial is None else trial.judgement(settings.tolerance)
            for one in members
            if one not in values.refused
            for trial in [first_trial(prepared, values.of(one), times)]
        ]
    found = of_many(listed, 1 if spec.events else min(LANES, values.members))
    if found is None:
        return ensemble
    chosen = with_implicit(settings, found)
    try:
        implicit = prepare_run(spec, chosen, stage, cached=request.cache)
    except LagrangeError:
        return ensemble
    if implicit.recording.undetected or not found.repays(implicit.machine.program):
        return ensemble
    return replace(ensemble, settings=chosen)
