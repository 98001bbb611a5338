"""``check``: what kind of system a file describes, and what a run of it leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import derive_system, located
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.settings import ALL, default_outputs, resolve_method, resolve_outputs

if TYPE_CHECKING:
    from lagrange_cli.errors import Problem
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True)
class Classification:
    """A system with its equations of motion, and what is known of it before any run.

    ``skipped`` says what a run does not compute, ``engine`` how the equations are integrated, sentence by
    sentence. ``warnings`` are the places of the file where units contradict each other, and where rounding
    may decide whether two numbers are equal.
    """

    spec: Spec
    residual: Residual
    skipped: tuple[str, ...]
    engine: tuple[str, ...]
    warnings: tuple[Problem, ...]


def classify(spec: Spec, stage: Stage = untimed) -> Classification:
    """Derive the equations of motion of a system, and say what follows from them.

    Raises ``SpecError`` where none can be derived, or where the method of the file cannot follow them.
    """
    from lagrange_cli.integrate.convolutions import check_convolutions, foresee_convolutions
    from lagrange_cli.mechanics.omitted_work import engine, skipped

    method = resolve_method(spec.solve.method)
    with stage("derive"), located(spec):
        residual = derive_system(spec, foresee=lambda model: foresee_convolutions(model, method, DOUBLE))
        check_convolutions(residual, method, DOUBLE)
    warnings = (*contradicting_units(spec), *rounded_equalities(spec))
    return Classification(spec, residual, skipped(residual, left_out_of(spec)), engine(residual), warnings)


def contradicting_units(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each place of the file where units contradict each other."""
    from lagrange_cli.outputs.units import find_units
    from lagrange_cli.spec.source import Source

    conflicts = find_units(spec).conflicts
    if not conflicts:
        return ()
    source = Source(spec.filename, spec.text)
    return tuple(source.problem(one.place, one.message, one.hint) for one in conflicts)


def rounded_equalities(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each comparison of numbers by == or != that are not whole."""
    if "==" not in spec.text and "!=" not in spec.text:
        return ()
    from lagrange_cli.spec.equality import doubtful_equalities
    from lagrange_cli.spec.source import Source

    source, hint = Source(spec.filename, spec.text), "compare whole numbers, or write abs(a - b) < 1e-9"
    return tuple(
        source.problem(place, f"rounding may decide whether {comparison} holds", hint)
        for place, comparison in doubtful_equalities(spec)
    )


def left_out_of(spec: Spec) -> list[str]:
    """The outputs that the system has and that ``solve`` leaves out by default."""
    particles = spec.lagrangian is None
    has = resolve_outputs((ALL,), has_particles=particles)
    asked = resolve_outputs(spec.solve.outputs or default_outputs(spec), has_particles=particles)
    none = {name for name, row in OUTPUTS.items() if row.section and not getattr(spec, row.section)}
    return [name for name in OUTPUTS if name in has - asked - none]
