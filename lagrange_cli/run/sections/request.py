"""``SectionRequest``: the request for a section, and the motions and settings that follow from it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import AUTO, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.limits import whole
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.domains import within_domain
from lagrange_cli.run.ensembles.ensemble import Cut, Ensemble, families_of, with_common_times
from lagrange_cli.run.ensembles.start import consistent_ensemble
from lagrange_cli.run.settings.methods import check_method, resolve_method
from lagrange_cli.spec.surface import with_surface

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.run.ensembles.members import Members
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.ensemble import EnsembleValues, Number
    from lagrange_cli.spec.spec import Spec

DIRECTIONS = {"rising": 1, "falling": -1, "either": 0}
CROSSINGS = 1000
"""The number of crossings of each motion, by default."""
FAR = 1e300
"""A stop time that no motion reaches, for what needs a number."""


@dataclass(frozen=True)
class SectionRequest:
    """The request for a section: the surface ``where``, or the period ``every``, as expressions; the
    ``direction`` in which the surface is crossed; and how many ``crossings`` of each motion are kept."""

    where: str = ""
    every: str = ""
    direction: str = "rising"
    crossings: int = CROSSINGS


def make_section(spec: Spec, members: Members | None, request: Request, asked: SectionRequest) -> Ensemble:
    """The motions of a section: those of ``members``, or the one that the file has, and the settings.

    Raises ``UsageError`` where the request makes no sense, or a value is out of range.
    """
    from lagrange_cli.integrate.ensemble.method import Section
    from lagrange_cli.run.ensembles.members import Members
    from lagrange_cli.spec.ensemble import EnsembleValues, resolve_ensemble
    from lagrange_cli.spec.values import resolve_long_values, resolve_values

    if members is not None and request.precision != DOUBLE:
        raise UsageError(f"--precision {request.precision} follows one motion: leave out the others")
    if members is None:
        members = Members({}, {})
        resolve = resolve_values if request.precision == DOUBLE else resolve_long_values
        one = resolve(spec, request.overrides)
        values = EnsembleValues(1, one.parameters, one.q, one.v, one.times, remainder=one.remainder)
    else:
        values = resolve_ensemble(spec, request.overrides, members.columns)
    spec, values = with_start_only(spec, values, request)
    settings = settings_of(spec, values, request)
    given = {*request.overrides, *members.columns}
    spec, values, notes = consistent_ensemble(spec, values, settings.start, given, forced=request.projected)
    values = values.without(values.otherwise)
    values = within_domain(spec, values, settings.start)
    if asked.where:
        direction = DIRECTIONS[asked.direction]
        spec = with_surface(spec, asked.where, direction)
        kept = Section(asked.crossings, direction, None, whole("patience"))
    else:
        kept = Section(asked.crossings, periods=periods(asked.every, spec, values))
    cut = Cut(asked.where, asked.every, asked.direction, kept)
    return Ensemble(spec, members, values, settings, True, families_of(spec), cut, notes)


def with_start_only(spec: Spec, values: EnsembleValues, request: Request) -> tuple[Spec, EnsembleValues]:
    """The system without those times of its ``solve`` that have no meaning for a section."""
    kept = {name: time for name, time in values.times.items() if name == "start"}
    solve = replace(
        spec.solve,
        stop=FAR,
        step=None,
        samples=None,
        times={name: one for name, one in spec.solve.times.items() if name == "start"},
    )
    spec, values = replace(spec, solve=solve), replace(values, times=kept)
    return (with_common_times(spec, values, request) if kept else spec), values


def settings_of(spec: Spec, values: EnsembleValues, request: Request) -> Settings:
    """The settings of all motions; they stop at no time if none is asked for."""
    method = resolve_method(request.options.method or spec.solve.method)
    method = TAYLOR if method == AUTO else method
    check_method(method, "a section", lambda row: row.finds_events)
    request = replace(request, options=replace(request.options, method=method))
    settings = request.settings(spec, values.common)
    stop = settings.stop if "stop" in request.times else math.inf
    return replace(settings, stop=stop, step=math.nan)


def periods(text: str, spec: Spec, values: EnsembleValues) -> np.ndarray:
    """The period of each member: an expression in parameters and definitions. Raises ``UsageError``."""
    import numpy as np

    from lagrange_cli.expression.build import NoMember
    from lagrange_cli.expression.columns import ColumnAlgebra
    from lagrange_cli.expression.parse import parse
    from lagrange_cli.expression.syntax import ExpressionError
    from lagrange_cli.run.times import check_names
    from lagrange_cli.spec.constants import builder
    from lagrange_cli.spec.ensemble import plain

    algebra = ColumnAlgebra(values.members)

    def scope(name: str) -> Any:
        if name not in values.parameters:
            raise NoMember
        value = values.parameters[name]
        return value if isinstance(value, float) else algebra.column(value)

    try:
        tree = parse(text)
        check_names(tree, spec, values.parameters)
        with np.errstate(all="ignore"):
            found: Number = plain(algebra.finite(tree, builder([tree], spec, scope, algebra).build(tree)))
    except ExpressionError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise UsageError(f"--every {text}: {error.message}{hint}") from error
    made = np.array(np.broadcast_to(found, values.members), dtype=np.float64)
    wrong = algebra.failed | ~(made > 0.0)
    if wrong.any():
        member = int(wrong.argmax())
        place = f" for member {member}" if values.members > 1 else ""
        raise UsageError(f"--every {text}: a period is a positive number, not {decimal(made[member])}{place}")
    return made
