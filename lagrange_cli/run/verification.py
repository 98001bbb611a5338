"""``equations --verify``: the printed equations of motion beside the compiled ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import LagrangeError
from lagrange_cli.records import replace
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.equations import FORMS, Derived
from lagrange_cli.run.family_equations import DerivedFamilies, Printed, by_members

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.symbolic.verify import Verification

MOTION, SPAN, PATIENCE = 8, 10.0, 2.0
"""States along the motion that are compared; its end if the file gives none; the seconds that it may take."""


def verify_printed(derived: Printed, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations with the compiled ones."""
    if isinstance(derived, DerivedFamilies):
        return verify_families(derived, overrides)
    with by_members(derived.spec, FORMS[0], derived.coordinates):
        return verify_system(derived, overrides)


def verify_system(derived: Derived, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations with the compiled ones, and with the file differentiated directly, near
    the start, along the motion and on both sides of switches and poles; only this needs the compiler."""
    from lagrange_cli.integrate.single_state import compiled_values
    from lagrange_cli.run.coordinates import start_in
    from lagrange_cli.run.start import consistent_values
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.direct import Direct, directly
    from lagrange_cli.symbolic.states import State, admissible, sides, singular, undecided
    from lagrange_cli.symbolic.verify import verify

    if derived.original is None:
        given = resolve_values(derived.spec, overrides)
        spec, values, _ = consistent_values(derived.spec, given, derived.spec.solve.start or 0.0, overrides)
    else:
        spec, values = start_in(derived.original, derived.spec, overrides)
    spec = spec.independent
    residual = derive_system(spec)

    def direct(state: State, a: Sequence[Any], multipliers: Sequence[Any], exact: bool) -> Direct:
        return directly(spec, state.parameters, state.t, state.q, state.v, a, multipliers, exact)

    def bound(state: State) -> State | None:
        found = admissible(spec, state)
        return None if found is not None and regular and singular(spec, found) else found

    parameters = dict(values.parameters)
    start = State(parameters, spec.solve.start or 0.0, tuple(values.q), tuple(values.v))
    regular = not singular(spec, start)
    moving = (State(parameters, t, q, v, "along the motion") for t, q, v in along(spec, values))
    reached = [one for state in moving if (one := bound(state)) is not None]  # events may set parameters
    others = [one for one in reached if not undecided(residual.model, one)]
    others += sides(residual.model, [start, *reached], bound)
    return verify(derived.equations, compiled_values(residual), start, others, direct, bound)


def along(spec: Spec, values: Values) -> list[tuple[float, tuple[float, ...], tuple[float, ...]]]:
    """t, q and v at some times of the motion, as far as it goes in ``PATIENCE`` seconds; none if there is no
    motion."""
    import time

    import numpy as np

    from lagrange_cli.errors import UsageError
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.prepare import prepare_run
    from lagrange_cli.run.request import Request
    from lagrange_cli.spec.spec import SolveDefaults

    found: list[tuple[float, tuple[float, ...], tuple[float, ...]]] = []

    def emit(chunk: dict[str, np.ndarray]) -> None:
        rows = [
            np.concatenate([chunk[path][i].reshape(-1) for path in paths]) for i in range(len(chunk["t"]))
        ]
        for t, row in zip(chunk["t"].tolist(), rows):
            state = row.tolist()
            found.append((t, tuple(state[: len(values.q)]), tuple(state[len(values.q) :])))

    options = SolveDefaults(samples=MOTION + 1, outputs=("q", "v"), method="taylor")
    try:
        try:
            settings = Request(options=options).settings(spec, values.parameters)
        except UsageError:
            settings = Request(options=replace(options, stop=SPAN)).settings(spec, values.parameters)
        prepared = prepare_run(spec, settings, cached=True)
        paths = [dataset.path for dataset in prepared.recording.states]
        until = time.monotonic() + PATIENCE
        times = Times(settings.start, settings.stop, settings.count, settings.step)
        integrate(prepared, values, times, emit, lambda: time.monotonic() > until)
    except LagrangeError:
        return []
    return [one for one in found[1:] if all(map(math.isfinite, (*one[1], *one[2])))]


def verify_families(derived: DerivedFamilies, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations, read back, with those of the system and with the compiled ones."""
    from lagrange_cli.integrate.family_program import compiled_accelerations
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.families.verify import verify

    system, start = derived.system, resolve_values(derived.system.spec, overrides)
    compiled = None if derived.spec.constrained else compiled_accelerations(system)
    return verify(system, derived.equations, compiled, start, derived.spec)
