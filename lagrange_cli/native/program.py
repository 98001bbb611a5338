"""``Program``: the text of one system's machine code, and what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.defect import Defect, defect, may_hide, terms_of
from lagrange_cli.mechanics.explicit import at_a_state, expanded
from lagrange_cli.mechanics.explicit import unknowns as unknowns_of
from lagrange_cli.mechanics.guards import Guarded, guarded
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.saturation import saturated_each
from lagrange_cli.mechanics.switches import one_sided
from lagrange_cli.native.events import changes_of, events_of, masses_of, number_of, sizes_of
from lagrange_cli.native.interface import LANES, STEPPING, Interface
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.beside import BesideEmitter
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Written
from lagrange_cli.native.observation import write_prepare, write_values
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.expansion import MULTIPLIERS
from lagrange_cli.native.state import GuardRows, StateLayout
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.program import SeriesProgram

if TYPE_CHECKING:
    from lagrange_cli.native.recurrences.layout_batches import Tables
    from lagrange_cli.native.stepping.motion import Given

RATES = 2
"""The order of q's series that gives the accelerations alone."""
BATCHED = 100
"""Convolutions from which on series are computed in batches."""


@dataclass(frozen=True)
class Program(Interface):
    """LLVM IR of a system. Operations are counted by function, each as often as a call executes it."""

    text: str
    series: SeriesProgram
    operations: Mapping[str, int]
    hiding: bool
    """Whether steps are proven, of the motion or of its integrals."""
    tables: int = 0
    """How much of the text are tables, which take hardly any time to compile."""


@dataclass(frozen=True)
class Equations:
    """What a motion follows: series, their order, the tolerance of steps, and whether these are proven."""

    residual: Residual
    series: SeriesProgram
    state: StateLayout
    constants: Constants
    order: int
    tolerance: float
    proven: bool
    guards: GuardRows | None
    multipliers: int
    """So many integrals, behind those of guards' arguments, show the multipliers' series to proofs."""
    integrands: Sequence[Node]
    """Those of quadratures that are followed, if any of them has to be proven."""
    arguments: Sequence[Node]
    """The arguments of guards, likewise."""
    emitter: Callable[[], Emitter]
    """What is written with, where numbers are doubles."""
    in_two: bool
    """Whether steps to roots are (see ``stepping.guards``)."""
    collocated: bool = False
    """Whether steps are polynomials through rates (``stepping.radau``); series give the rates alone."""

    @property
    def highest(self) -> int:
        """The order to which series are computed."""
        return RATES if self.collocated else self.order


@dataclass(frozen=True)
class Motion:
    """The code that follows a motion, its doubles of ``%work``, the operations of its jet, and where that
    leaves the series (see ``Interface``)."""

    parts: Sequence[str]
    work: int
    operations: int
    series_at: tuple[int, int, int]
    tables: Tables | None = None
    """Those of batches, if it is written for these."""


def proving_of(equations: Equations) -> tuple[Residual, Defect, Constants] | None:
    """What steps are proven by, if they are."""
    residual = equations.residual
    return (residual, defect(residual), equations.constants) if equations.proven else None


def proof_of(equations: Equations, nodes: Sequence[Node]) -> tuple[Residual, Defect, Constants] | None:
    """What integrals of ``nodes`` are proven by, if there are any."""
    residual = equations.residual
    if not nodes:
        return None
    accelerations, rows = expanded(residual, nodes)
    return residual, Defect(accelerations, terms_of(rows, residual, accelerations)), equations.constants


def provings_of(equations: Equations) -> Sequence[tuple[Residual, Defect, Constants] | None]:
    """Of the equations, of integrands, and of what guards watch."""
    integrands, arguments = equations.integrands, equations.arguments
    return proving_of(equations), proof_of(equations, integrands), proof_of(equations, arguments)


def given_of(equations: Equations, work: int, project: str = "") -> Given:
    """What steps are made from; they work on so many doubles."""
    from lagrange_cli.native.stepping.motion import Given

    state, proving, multipliers = equations.state, provings_of(equations), equations.multipliers
    given = state, work, equations.tolerance, proving, equations.guards, equations.in_two
    return Given(*given, multipliers, project, equations.residual.timed)


def double(equations: Equations) -> Motion:
    """In doubles. ``@accelerate`` gives the rates at one state; from order 6 on there is ``@advance``."""
    from lagrange_cli.native.recurrences.compensated import compensated_expansion
    from lagrange_cli.native.recurrences.jet import write_jet
    from lagrange_cli.native.recurrences.layout import arrange
    from lagrange_cli.native.recurrences.rolled import Memory
    from lagrange_cli.native.stepping.doubles import lengths_of, stepper

    residual, series, order = equations.residual, equations.series, equations.highest
    emitter, layout = equations.emitter(), arrange(series, order)
    expansion = compensated_expansion(
        emitter, residual, series, equations.constants, layout.width, layout.doubles
    )
    parts = [*numbers("", order + 4), write_jet(Memory(expansion, emitter, layout))]
    work = LANES * -(-expansion.factorization.place // LANES)
    parts += expansion.factorization.functions
    degrees = equations.state.degrees
    if equations.collocated:
        from lagrange_cli.native.stepping.radau import on_rates

        work, steps = on_rates(lengths_of(layout, degrees), given_of(equations, work))
        parts.append(steps)
    elif order >= STEPPING:
        project = ""
        if residual.multipliers:
            from lagrange_cli.native.stepping.projection import in_doubles

            project = in_doubles(residual, equations.state, equations.constants, equations.emitter())
        parts.append(stepper(layout, given_of(equations, work, project)))
    parts.append(_accelerate(layout.width + degrees, len(layout.state) - degrees))
    return Motion(parts, work, emitter.operations, (0, 1, layout.width))


def batched(equations: Equations) -> Motion | None:
    """In doubles, by loops over members; None where the system is not large, or not of the kind."""
    from lagrange_cli.native.recurrences.batched import write_batched_jet
    from lagrange_cli.native.recurrences.layout_batches import Tables
    from lagrange_cli.native.recurrences.tables_batches import Misfit, arrange
    from lagrange_cli.native.stepping.batches import accelerate, lengths_of, stepper

    residual, series, order = equations.residual, equations.series, equations.highest
    if not suits_batches(equations):
        return None
    try:
        blocks = arrange(residual, series, order)
        tables = Tables(equations.constants)
        jet, operations = write_batched_jet(residual, blocks, tables, equations.state.width)
    except Misfit:
        return None
    degrees = equations.state.degrees
    parts, work = [*numbers("", order + 4), jet], blocks.doubles
    if equations.collocated:
        from lagrange_cli.native.stepping.radau import on_rates

        work, steps = on_rates(lengths_of(blocks, degrees), given_of(equations, work))
        parts.append(steps)
    elif order >= STEPPING:
        parts.append(stepper(blocks, given_of(equations, work)))
    parts.append(accelerate(blocks, degrees))
    return Motion(parts, work, operations, (0, 0, 0), tables)


def suits_batches(equations: Equations) -> bool:
    """Whether the series of a system are many, and its masses constant and diagonal."""
    proven = any(provings_of(equations))
    return (
        equations.series.convolutions >= BATCHED
        and equations.residual.separate
        and not (equations.guards or equations.in_two or proven)
    )


def double_double(equations: Equations) -> Motion:
    """In double-double."""
    from lagrange_cli.native.functions.double_double import functions
    from lagrange_cli.native.numbers.double_double import operations
    from lagrange_cli.native.recurrences.in_memory import write_jet
    from lagrange_cli.native.recurrences.layout_rows import arrange
    from lagrange_cli.native.stepping.double_doubles import stepper

    rows = arrange(equations.series, equations.order, equations.state.width)
    jet, work, count = write_jet(equations.residual, rows, equations.constants)
    work = LANES * -(-work // LANES)
    project = ""
    if equations.residual.multipliers:
        from lagrange_cli.native.stepping.projection import in_double_doubles

        project = in_double_doubles(equations.residual, equations.state, equations.constants)
    stepping = stepper(rows, given_of(equations, work, project))
    parts = [*operations(), *functions(), jet, *stepping]
    return Motion(parts, work, count, (LANES, 2 * rows.beyond, 1))


def write_program(
    residual: Residual,
    order: int,
    integrands: Mapping[str, Node],
    observed: Mapping[str, Node],
    linearized: Sequence[Node] = (),
    accelerations: Sequence[Node] = (),
    tolerance: float = 2.0**-52,
    store_momenta: bool = False,
    kind: Callable[[], Written[Any]] = Emitter,
    proven: bool = False,
    unproven: bool = False,
    factor: int | None = None,
    observing: Residual | None = None,
    collocated: bool = False,
) -> Program:
    """The program that advances ``residual`` with q's series to ``order``, in numbers of a ``kind``.

    ``@linearize`` computes the nodes ``linearized``, functions of q, v and the symbols ``accelerations``, if
    there are any. Cyclic momenta are stored in rows of the state if ``store_momenta``. Steps are
    ``proven`` where a force may hide, and wherever that is asked for, unless forces are not linear in
    multipliers, or the program is to be ``unproven``. With a ``factor`` the program is that of a companion
    (see ``numbers.beside``). Accelerations and multipliers in what is ``observed`` are those of the equations
    ``observing``, by default ``residual``. Raises ``TooLarge`` where the program has more instructions than
    can be compiled. Steps that are ``collocated`` are polynomials through rates, of that order, instead of
    series.
    """
    emitter: Callable[[], Emitter] = Emitter if factor is None else partial(BesideEmitter, factor)
    kind = emitter if kind is Emitter else kind
    observing = observing or residual
    seen = one_sided(residual.graph, [*observed.values()], residual.variables)
    sampled = saturated_each(residual.graph, seen, residual.variables)
    unknowns, quantities = at_a_state(observing, sampled)
    model, constants, parts = residual.model, Constants(), kind().parts
    stored = [str(one.symbol.data) for one in residual.cyclic_momenta] if store_momenta else []
    integrands = dict(
        zip(integrands, saturated_each(residual.graph, [*integrands.values()], residual.variables))
    )
    stepping = order >= STEPPING and not collocated
    smooth = guarded(residual, integrands) if stepping else Guarded(residual, integrands)
    residual = smooth.residual
    changed, changes = changes_of(model) if stepping else ((), [])
    events, affected = events_of(model, smooth, parts) if stepping else ((), ())
    masses = masses_of(model) if stepping else {}
    closes = stepping and bool(changes) and bool(observing.multipliers)
    hides = proven or may_hide(residual) or may_hide(residual, smooth.integrands.values())
    # Newton's method does not tell how far multipliers may be off
    provable = stepping and not (residual.bent or unproven)
    hiding = provable and hides
    proven = provable and (proven or may_hide(residual))
    followed = [*smooth.integrands.values()] if hiding else []
    arguments = [*(one.argument for one in smooth.guards), *smooth.events, *smooth.limits, *smooth.breaks]
    doubtful = arguments if provable and (proven or may_hide(residual, arguments)) else []
    hiding = hiding or bool(doubtful)
    named = {f"guard {i}": argument for i, argument in enumerate(arguments)}
    shown = {str(one.data): one for one in residual.multipliers} if hiding else {}
    integrands = {**named, **shown, **smooth.integrands, **dict.fromkeys(stored, residual.graph.zero)}
    series = residual.series([*integrands.values()], len(named), apart=parts == 1 and stepping)
    series = replace(series, stored=len(stored))
    interface = Interface(
        order=order,
        degrees=len(model.q),
        parameters=tuple(model.parameters),
        integrals=tuple(integrands),
        stored=len(stored),
        observed=tuple(observed),
        constants=0,
        work=0,
        lanes=0,
        parts=parts,
        given=parts if factor is None else 2,
        guards=tuple(number_of(one) for one in smooth.guards),
        limits=tuple(j for j, one in enumerate(smooth.guards) if one.limit is not None),
        events=events,
        changed=changed,
        affected=affected,
        masses=tuple(masses),
        constraints=len(observing.multipliers),
        pattern=tuple((j, k) for j, row in enumerate(observing.unpushed.entries) for k in row)
        if closes
        else (),
        series_at=(0, 0, 0),
        carried=0,
    )
    if collocated:
        from lagrange_cli.native.stepping.radau import carried

        interface = replace(interface, carried=carried(interface.inner))
    rows = interface.rows_of_guards if interface.guarded else None
    equations = Equations(
        residual,
        series,
        interface.inner,
        constants,
        order,
        tolerance,
        proven,
        rows,
        len(shown),
        followed,
        doubtful,
        emitter,
        factor is not None,
        collocated,
    )
    made = (parts == 1 and batched(equations)) or (double if parts == 1 else double_double)(equations)
    symbols = [*model.q, *model.v]

    def values(name: str, symbols: Sequence[Node], nodes: Iterable[Node], **more: Any) -> tuple[str, int]:
        rows = interface.rows
        return write_values(name, kind(), model.time, symbols, rows, [*nodes], constants, **more)

    batches, scratch = made.tables, None
    if batches is not None and unknowns is None:
        from lagrange_cli.native.observation_batches import Scratch, batched_values

        scratch = Scratch()
        observe, operations = batched_values("observe", model.time, symbols, quantities, batches, scratch)
    else:
        observe, operations = values("observe", symbols, quantities, unknowns=unknowns)
    texts = [*made.parts, observe]
    if residual.bent:
        given = residual.model.time, [*residual.model.q, *residual.model.v], interface.inner.width
        own = [*residual.multipliers]
        written = partial(write_values, at_one_time=parts > 1, unknowns=unknowns_of(residual))
        texts.append(written(MULTIPLIERS, kind(), *given, own, constants)[0])
    if linearized:
        texts.append(values("linearize", [*symbols, *accelerations], linearized)[0])
    if interface.events:
        nodes = [*changes, *sizes_of(model), *masses.values()]
        texts.append(values("act", symbols, nodes, at_one_time=parts > 1)[0])
    if closes:
        held, zero = Constraints(model), residual.graph.zero
        places = [one.expression if one.holonomic else zero for one in model.constraints]
        entries = [entry for row in observing.unpushed.entries for entry in row.values()]
        texts.append(
            values("constrain", symbols, [*places, *held.speeds, *entries], at_one_time=parts > 1)[0]
        )
    modes = [one.mode for one in smooth.guards]
    modes += [residual.graph.symbol(f"event {i}") for i in range(len(interface.events))]
    modes += [one.mode for one in smooth.rests]
    set_ones = {**model.parameters, **{str(mode.data): mode for mode in modes}}
    if scratch is not None and batches is not None:
        from lagrange_cli.native.observation_batches import batched_prepare

        prepare, size = batched_prepare(set_ones, batches, scratch)
    elif factor is None:
        prepare, size = write_prepare(kind(), constants, set_ones)
    else:
        from lagrange_cli.native.companion import prepare_beside

        prepare, size = prepare_beside(constants, set_ones, factor)
    text = "\n".join([*texts, prepare])
    listed = "" if batches is None else batches.text()
    text += listed
    if hiding or batches is not None:
        from lagrange_cli.native.functions.elementary import definitions

        text += definitions(text)
    kind().body.allow(text.count(" = "))
    return Program(
        **{**interface.as_data(), "constants": size, "work": made.work, "series_at": made.series_at},
        text=text,
        series=series,
        hiding=hides,
        tables=len(listed),
        operations={"jet": made.operations, "observe": operations},
    )


def _accelerate(first: int, rates: int) -> str:
    """Rates of the velocities and integrals at one state, whose low parts are zeros: ``%work[first]`` and on.
    It returns 0 where the mass matrix is singular."""
    given = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %out"
    f = Function(f"define i64 @accelerate({given}) #0")
    constants, state, work = (f.pointer(f"%{name}") for name in ("constants", "state", "work"))
    regular = f.call(Bit, "jet", constants, Real(f, "%t"), state, work)
    with f.loop(0, rates, tested=False) as i:
        f.store(f.load(work, i + first), "%out", i)
    f.give(regular.to_integer())
    return f.text()
