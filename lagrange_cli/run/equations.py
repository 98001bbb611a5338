"""``equations``: the equations of motion as people read them, and their comparison with the compiled ones."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import derive_system, located
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.limits import Work
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.verify import Verification

FORMATS = ("text", "unicode", "latex", "json", "python")
MOTION, SPAN, PATIENCE = 8, 10.0, 2.0
"""States along the motion that are compared; its end if the file gives none; the seconds that it may take."""
FORMS = ("lagrange", "explicit", "hamilton", "matrix")


@dataclass(frozen=True)
class Derived:
    """The equations of motion of a system, derived by computer algebra; ``work`` bounds what is done with
    them."""

    spec: Spec
    equations: Equations
    work: Work

    @contextmanager
    def bounded(self) -> Iterator[None]:
        """A context for work on them; raises ``SpecError`` where it is too much."""
        from lagrange_cli.symbolic.work import counting

        with located(self.spec), counting(self.work):
            yield


def derive(spec: Spec, stage: Stage = untimed) -> Derived:
    """Derive the equations of motion, to be read.

    Raises ``SpecError`` where there are none, or they are too large.
    """
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.expression.symbolic import SympyAlgebra
    from lagrange_cli.limits import Work
    from lagrange_cli.mechanics.jumps import refuse_jumps
    from lagrange_cli.model.build import build_model
    from lagrange_cli.symbolic.derive import derive_equations
    from lagrange_cli.symbolic.work import counting

    check_printed(spec)
    work = Work()
    with stage("derive"), located(spec), counting(work):
        if re.search(r"\b(where|sign)\b", spec.text):
            refuse_jumps(build_model(spec, GraphAlgebra()))
        return Derived(spec, derive_equations(build_model(spec, SympyAlgebra())), work)


def check_printed(spec: Spec) -> None:
    """Raise ``SpecError`` for a system too large for its equations to be read, before any work is done."""
    from lagrange_cli.limits import way_out, whole
    from lagrange_cli.model.largest import largest_expression
    from lagrange_cli.spec.source import Source

    found = largest_expression(spec)
    if found is not None and found.size > whole("printed"):
        raise Source(spec.filename, spec.text).error(
            found.place,
            f"this expression has {found.size} terms and factors with its definitions written out: more than "
            f"'equations' prints ({whole('printed')})",
            f"'check' and 'solve' may work nevertheless, {way_out('printed')}",
        )


def as_data(derived: Derived, form: str, parameters: dict[str, float]) -> dict[str, Any]:
    """The equations in terms of JSON; ``form`` is one of ``FORMS``."""
    from lagrange_cli.symbolic.data import as_data

    with derived.bounded():
        return as_data(derived.equations, form, parameters)


def as_written(derived: Derived, format_: str, form: str, parameters: dict[str, float]) -> str:
    """The equations in one of the ``FORMATS`` other than JSON; ``form`` is one of ``FORMS``."""
    with derived.bounded():
        if format_ == "python":
            from lagrange_cli.symbolic.source import as_python

            return as_python(derived.equations, form, parameters)
        from lagrange_cli.symbolic.latex import as_latex
        from lagrange_cli.symbolic.layouts import as_text, as_unicode

        return {"text": as_text, "unicode": as_unicode, "latex": as_latex}[format_](derived.equations, form)


def verify_system(derived: Derived, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations with the compiled ones, and with the file differentiated directly, near
    the start, along the motion and beside branches; only this needs the compiler."""
    from lagrange_cli.integrate.single_state import compiled_values
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.direct import Direct, directly
    from lagrange_cli.symbolic.states import State, sides
    from lagrange_cli.symbolic.verify import verify

    spec = derived.spec
    values = resolve_values(spec, dict(overrides))
    residual = derive_system(spec)

    def direct(state: State, accelerations: Sequence[Any], exact: bool) -> Direct:
        return directly(spec, state.parameters, state.t, state.q, state.v, accelerations, exact)

    parameters = dict(values.parameters)
    start = State(parameters, spec.solve.start or 0.0, tuple(values.q), tuple(values.v))
    reached = [State(parameters, t, q, v, "along the motion") for t, q, v in along(spec, values)]
    others = [*reached, *sides(residual.model, [start, *reached])]
    return verify(derived.equations, compiled_values(residual), start, others, direct)


def along(spec: Spec, values: Values) -> list[tuple[float, tuple[float, ...], tuple[float, ...]]]:
    """t, q and v at some times of the motion, as far as it goes in ``PATIENCE`` seconds; none if there is no
    motion."""
    import time

    import numpy as np

    from lagrange_cli.errors import LagrangeError, UsageError
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.records import replace
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
