"""``MotionCode``: the code that follows a motion, in doubles, in batches of these, or in double-double."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.defect import Defect, defect, shown_slowly, terms_of
from lagrange_cli.mechanics.explicit import expanded
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.interface import LANES, STEPPING
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.state import StateLayout, whole_vectors
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.program import SeriesProgram

if TYPE_CHECKING:
    from lagrange_cli.native.followed import FollowedEquations
    from lagrange_cli.native.stepping.given import Given
    from lagrange_cli.native.stepping.proof import Proving

BRIEF = "rates"
"""The function that computes rates for steps on these, where there is one beside that for series."""
RATES = 2
"""The order of q's series that gives the accelerations alone."""


@dataclass(frozen=True)
class Specification:
    """The specification of a motion: what is followed, its series to an order, and the
    tolerance of steps."""

    followed: FollowedEquations
    series: SeriesProgram
    state: StateLayout
    constants: Constants
    order: int
    tolerance: float
    guards: GuardRows | None
    emitter: Callable[[Function], Emitter]
    """The writers for doubles."""
    in_two: bool
    """Whether steps to roots are (see ``stepping.guards``)."""
    scheme: str = ""
    """The method of steps on rates (``rates.schemes``), if they are such ones: series give these alone."""

    @property
    def residual(self) -> Residual:
        """The equations that series are of."""
        return self.followed.smooth.residual

    @property
    def steps(self) -> bool:
        """Whether steps are taken by series."""
        return self.order >= STEPPING and not self.scheme

    @property
    def highest(self) -> int:
        """The order to which series are computed."""
        return highest(self.order, self.scheme, guarded=self.guards is not None)


def highest(order: int, scheme: str, *, guarded: bool) -> int:
    """The order to which series are computed: the ``order`` of steps by series. With a ``scheme``, steps take
    rates alone, but where they are ``guarded``, their callers look at more."""
    if scheme:
        return STEPPING + 1 if guarded else RATES
    return order


@dataclass(frozen=True)
class MotionCode:
    """The code that follows a motion, its doubles of ``%work``, the operations of its jet, and where that
    leaves the series (see ``Interface``)."""

    parts: Sequence[str]
    work: int
    operations: int
    series_at: tuple[int, int, int]


def motion_of(equations: Specification, parts: int) -> MotionCode:
    """The code in numbers of so many ``parts``."""
    return double(equations) if parts == 1 else double_double(equations)


def proof_of(equations: Specification, nodes: Sequence[Node]) -> Proving | None:
    """The proof of integrals of ``nodes``, if there are any."""
    residual = equations.residual
    if not nodes:
        return None
    accelerations, rows = expanded(residual, nodes)
    return proving(equations, Defect(accelerations, terms_of(rows, residual, accelerations)))


def proving(equations: Specification, left: Defect) -> Proving:
    """The proof of what is ``left`` of equations."""
    from lagrange_cli.native.stepping.equations_proof import EquationsProof

    return partial(EquationsProof, equations.residual, left, equations.constants, equations.followed.sums)


def provings_of(equations: Specification) -> Sequence[Proving | None]:
    """The proofs of the equations, of integrands, and of the arguments of guards; None for what is not
    proven."""
    more = equations.followed
    own = proving(equations, defect(equations.residual)) if more.proven else None
    return own, proof_of(equations, more.proven_too), proof_of(equations, more.doubtful)


def given_of(equations: Specification, work: int, project: str = "", parts: int = 1) -> Given:
    """The code for steps, which work on so many doubles, in numbers of so many ``parts``."""
    from lagrange_cli.native.stepping.given import Given

    given = equations.state, work, equations.tolerance, provings_of(equations), equations.guards
    more = equations.in_two, equations.followed.shown, project
    alike, sums = coupled(equations.residual), cancelling(equations, parts)
    return Given(*given, *more, timed=equations.residual.timed, coupled=alike, cancelling=sums)


def cancelling(equations: Specification, parts: int) -> str:
    """The text of ``@round_integrands``, if steps are taken and integrands are sums."""
    if not (equations.followed.quadratures and (equations.steps or equations.scheme)):
        return ""
    from lagrange_cli.native.stepping.integrand_errors import in_double_doubles, in_doubles

    given = equations.residual, equations.followed.quadratures, equations.state, equations.constants
    return in_doubles(*given, equations.emitter) if parts == 1 else in_double_doubles(*given)


def double(equations: Specification) -> MotionCode:
    """In doubles. ``@accelerate`` gives the rates at one state; from order 6 on there is ``@advance``."""
    from lagrange_cli.native.rates.schemes import on_rates, scheme_of
    from lagrange_cli.native.recurrences.jet import write_jet
    from lagrange_cli.native.recurrences.layout import arrange
    from lagrange_cli.native.stepping import static_forces
    from lagrange_cli.native.stepping.advance import advance
    from lagrange_cli.native.stepping.coupling import of_residual
    from lagrange_cli.native.stepping.doubles import DoubleSteps, accelerate
    from lagrange_cli.native.stepping.lengths import side_by_side
    from lagrange_cli.native.stepping.related import related

    residual, series, order = equations.residual, equations.series, equations.highest
    layout = arrange(series, order)
    jet, work, operations = write_jet(residual, series, equations.constants, equations.emitter, layout)
    project = ""
    if residual.bound and (equations.steps or equations.scheme):
        from lagrange_cli.native.stepping.projection import in_doubles

        project = in_doubles(residual, equations.state, equations.constants, equations.emitter)
    lengths, steps = side_by_side(equations.state.degrees, equations.state.rows, order), list[str]()
    made = equations.state, equations.constants, equations.emitter
    static = static_forces.in_doubles(residual, *made) if equations.steps or equations.scheme else ""
    if equations.scheme:
        room, name = work, "jet"
        if equations.guards:
            short, given = arrange(series, RATES), (equations.constants, equations.emitter)
            brief, room, operations = write_jet(residual, series, *given, short, BRIEF, alone=False)
            name, jet = BRIEF, jet + brief
        families = related(residual.model, fewest=2) + related_integrals(equations)
        rates = replace(given_of(equations, room, project), rates=name, related=families, static=static)
        if scheme_of(equations.scheme).implicit and (listed := shown_slowly(residual)):
            from lagrange_cli.native.rates.approaching import approach

            rates = replace(rates, approach=approach(residual, listed, *made))
        work, text = on_rates(equations.scheme, rates, partial(of_residual, residual), work)
        steps.append(text)
    elif equations.steps:
        families = related(residual.model)
        if families:
            floor = whole_vectors(work)
            work = floor + whole_vectors(lengths.width)
            lengths = replace(lengths, floor=floor)
            families += related_integrals(equations)
        own = replace(given_of(equations, work, project), related=families, static=static)
        steps.append(advance(DoubleSteps(lengths, own)))
    parts = [*numbers("", order + 4), jet, *steps, accelerate(lengths)]
    return MotionCode(parts, work, operations, (0, 1, layout.width))


def coupled(residual: Residual) -> list[tuple[int, int]]:
    """The first coordinate, and the number, of those whose accelerations are found together."""
    degrees = len(residual.model.q)
    own = [[i for i in block if i < degrees] for block in residual.blocks]  # without multipliers
    return [(min(one), max(one) + 1 - min(one)) for one in own if len(one) > 1]


def related_integrals(equations: Specification) -> list[tuple[int, int]]:
    """The first integral of each family of some, and their number (``stepping.related``)."""
    from lagrange_cli.native.stepping.related import of_names

    return of_names(equations.followed.integrands, equations.state.integrals.start - equations.state.degrees)


def double_double(equations: Specification) -> MotionCode:
    """In double-double."""
    from lagrange_cli.native.functions.double_double import functions
    from lagrange_cli.native.numbers.double_double import operations
    from lagrange_cli.native.recurrences.in_memory import write_jet
    from lagrange_cli.native.recurrences.layout_rows import arrange
    from lagrange_cli.native.stepping import static_forces
    from lagrange_cli.native.stepping.double_doubles import lengths_of, stepper

    rows = arrange(equations.series, equations.order, equations.state.width)
    jet, work, count = write_jet(equations.residual, rows, equations.constants)
    work, least = (whole_vectors(one) for one in (work, rows.width))
    work += least  # what velocities are measured by at least
    project = ""
    if equations.residual.bound:
        from lagrange_cli.native.stepping.projection import in_double_doubles

        project = in_double_doubles(equations.residual, equations.state, equations.constants)
    static = static_forces.in_double_doubles(equations.residual, equations.state, equations.constants)
    given = given_of(equations, work, project, parts=2)
    given = replace(given, related=related_integrals(equations), static=static)
    stepping = stepper(lengths_of(rows, given), rows.beyond, given)
    parts = [*operations(), *functions(), jet, *stepping]
    return MotionCode(parts, work, count, (LANES, 2 * rows.beyond, 1))
