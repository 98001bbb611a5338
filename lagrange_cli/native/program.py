"""``Program``: the text of one system's machine code, and what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial, reduce
from operator import or_
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.mechanics.defect import Defect, defect, may_hide, terms_of
from lagrange_cli.mechanics.explicit import expanded
from lagrange_cli.mechanics.guards import Guard, Guarded, guarded
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switches import switches
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.native.interface import CUT, LANES, SIMPLE, STEPPING, Interface
from lagrange_cli.native.linear.blocks import UNROLLED
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import literal, operand
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.beside import BesideEmitter
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Written
from lagrange_cli.native.observation import write_prepare, write_values
from lagrange_cli.native.orders import lane_order
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.state import GuardRows, Role, StateLayout
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import SeriesProgram

if TYPE_CHECKING:
    from lagrange_cli.native.stepping.motion import Given

FEW_EVENTS = 64
"""Events of the largest system whose actions compiled code does."""
MOST_SERIES = 600
"""Series of the largest system that is followed in lanes.

The code of a larger one takes too long to compile, and single motions use vectors as well.
"""


@dataclass(frozen=True)
class Program(Interface):
    """LLVM IR of a system. Operations are counted by function, each as often as a call executes it."""

    text: str
    series: SeriesProgram
    operations: Mapping[str, int]
    hiding: bool
    """Whether steps are proven, of the motion or of its integrals."""


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
    integrands: Sequence[Node]
    """Those of quadratures that are followed, if any of them has to be proven."""
    watched: Sequence[Node]
    """The arguments of guards, likewise."""
    emitter: Callable[[], Emitter]
    """What is written with, where numbers are doubles."""
    in_two: bool
    """Whether steps to roots are (see ``stepping.guards``)."""


@dataclass(frozen=True)
class Motion:
    """The code that follows a motion, its doubles of ``%work``, the operations of its jet, and where that
    leaves the series (see ``Interface``)."""

    parts: Sequence[str]
    work: int
    operations: int
    series_at: tuple[int, int, int]


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
    integrands, watched = equations.integrands, equations.watched
    return proving_of(equations), proof_of(equations, integrands), proof_of(equations, watched)


def given_of(equations: Equations, work: int) -> Given:
    """What steps are made from; they work on so many doubles."""
    from lagrange_cli.native.stepping.motion import Given

    state, proving = equations.state, provings_of(equations)
    return Given(state, work, equations.tolerance, proving, equations.guards, equations.in_two)


def double(equations: Equations) -> Motion:
    """In doubles. ``@accelerate`` gives the rates at one state; from order 6 on there is ``@advance``."""
    from lagrange_cli.native.recurrences.compensated import compensated_expansion
    from lagrange_cli.native.recurrences.jet import write_jet
    from lagrange_cli.native.recurrences.layout import arrange
    from lagrange_cli.native.recurrences.rolled import Memory
    from lagrange_cli.native.stepping.doubles import stepper

    residual, series, order = equations.residual, equations.series, equations.order
    emitter, layout = equations.emitter(), arrange(series, order)
    expansion = compensated_expansion(
        emitter, residual, series, equations.constants, layout.width, layout.doubles
    )
    parts = [*tables("", order + 4), write_jet(Memory(expansion, emitter, layout))]
    work = LANES * -(-expansion.factorization.place // LANES)
    parts += expansion.factorization.functions
    degrees = equations.state.degrees
    if order >= STEPPING:
        parts.append(stepper(layout, given_of(equations, work)))
    parts.append(_accelerate(layout.width + degrees, len(layout.state) - degrees))
    return Motion(parts, work, emitter.operations, (0, 1, layout.width))


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
    stepping = stepper(rows, given_of(equations, work))
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
    factor: int | None = None,
) -> Program:
    """The program that advances ``residual`` with q's series to ``order``, in numbers of a ``kind``.

    ``@linearize`` computes the nodes ``linearized``, functions of q, v and the symbols ``accelerations``, if
    there are any. Cyclic momenta are stored in rows of the state if ``store_momenta``. Steps are
    ``proven`` where a force may hide, and wherever that is asked for. With a
    ``factor`` the program is that of a companion (see ``numbers.beside``). Raises ``TooLarge`` where the
    program has more instructions than can be compiled.
    """
    emitter: Callable[[], Emitter] = Emitter if factor is None else partial(BesideEmitter, factor)
    kind = emitter if kind is Emitter else kind
    model, constants, parts = residual.model, Constants(), kind().parts
    stored = [str(one.symbol.data) for one in residual.cyclic_momenta] if store_momenta else []
    smooth = guarded(residual, integrands) if order >= STEPPING else Guarded(residual, integrands)
    residual = smooth.residual
    stepping = order >= STEPPING
    changed, changes = changes_of(model) if stepping else ((), [])
    events, affected = events_of(model, smooth, parts) if stepping else ((), ())
    hides = proven or may_hide(residual) or may_hide(residual, smooth.integrands.values())
    hiding = stepping and hides
    proven = stepping and (proven or may_hide(residual))
    followed = [*smooth.integrands.values()] if hiding else []
    watched = [*(one.argument for one in smooth.guards), *smooth.events]
    doubtful = watched if stepping and (proven or may_hide(residual, watched)) else []
    hiding = hiding or bool(doubtful)
    named = {f"guard {i}": argument for i, argument in enumerate(watched)}
    integrands = {**named, **smooth.integrands, **dict.fromkeys(stored, residual.graph.zero)}
    series = lower(
        residual.graph, residual.variables, residual.model.q, residual.model.v, model.time,
        residual.residual, list(integrands.values()),
    )  # fmt: skip
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
        events=events,
        changed=changed,
        affected=affected,
        series_at=(0, 0, 0),
    )
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
        followed,
        doubtful,
        emitter,
        factor is not None,
    )
    made = (double if parts == 1 else double_double)(equations)
    symbols = [*model.q, *model.v]

    def values(
        name: str, symbols: Sequence[Node], nodes: Iterable[Node], *, at_one_time: bool = False
    ) -> tuple[str, int]:
        rows = interface.rows
        given = name, kind(), model.time, symbols, rows, [*nodes], constants
        return write_values(*given, at_one_time=at_one_time and parts > 1)

    observe, observing = values("observe", symbols, observed.values())
    texts = [*made.parts, observe]
    if linearized:
        texts.append(values("linearize", [*symbols, *accelerations], linearized)[0])
    if interface.events:
        texts.append(values("act", symbols, [*changes, *sizes_of(model)], at_one_time=True)[0])
    modes = [one.mode for one in smooth.guards]
    modes += [residual.graph.symbol(f"event {i}") for i in range(len(interface.events))]
    modes += [one.mode for one in smooth.rests]
    set_ones = {**model.parameters, **{str(mode.data): mode for mode in modes}}
    if factor is None:
        prepare, size = write_prepare(kind(), constants, set_ones)
    else:
        from lagrange_cli.native.companion import prepare_beside

        prepare, size = prepare_beside(constants, set_ones, factor)
    text = "\n".join([*texts, prepare])
    if hiding:
        from lagrange_cli.native.functions.elementary import definitions

        text += definitions(text)
    kind().body.allow(text.count(" = "))
    return Program(
        **{**interface.as_data(), "constants": size, "work": made.work, "series_at": made.series_at},
        text=text,
        series=series,
        hiding=hides,
        operations={"jet": made.operations, "observe": observing},
    )


def number_of(guard: Guard) -> int:
    """A switch's guard as ``Interface`` has it."""
    if guard.auxiliary is not None:
        return guard.auxiliary
    return CUT if guard.cut else SIMPLE


def events_of(
    model: Model[Node], smooth: Guarded, parts: int
) -> tuple[tuple[tuple[int, int, int], ...], tuple[tuple[int, int], ...]]:
    """The model's events as ``Interface`` has them, and which arguments simple actions change.

    An action is simple if nothing but events may have to be chosen anew, and not its own.
    """
    rests = {one.event: one.auxiliary for one in smooth.rests}
    few = not rests and not smooth.guards and parts == 1 and len(model.events) <= FEW_EVENTS
    symbols = dict(zip(model.coordinates, model.q))
    symbols |= {velocity_name(name): v for name, v in zip(model.coordinates, model.v)}
    symbols |= dict(model.parameters)
    found, affected = list[tuple[int, int, int]](), list[tuple[int, int]]()
    for i, event in enumerate(model.events):
        bits = reduce(or_, (symbols[name].symbols for name in event.changes), 0)
        simple = bool(event.changes) and few and not event.argument.symbols & bits
        acts = Role.CHANGE if simple else Role.ACTION
        role = acts if event.stops or event.changes else Role.RECORD
        found.append((event.direction, int(role), rests.get(i, -1)))
        if simple:
            affected += [(i, k) for k, one in enumerate(model.events) if one.argument.symbols & bits]
    return tuple(found), tuple(affected)


def changes_of(model: Model[Node]) -> tuple[tuple[tuple[int, int], ...], list[Node]]:
    """What events change: each event with the place of a name among coordinates, velocities and parameters;
    and the new values."""
    names = [*model.coordinates, *map(velocity_name, model.coordinates), *model.parameters]
    places = {name: i for i, name in enumerate(names)}
    found = [(i, name, node) for i, event in enumerate(model.events) for name, node in event.changes.items()]
    return tuple((i, places[name]) for i, name, _ in found), [node for *_, node in found]


def sizes_of(model: Model[Node]) -> list[Node]:
    """How large the terms of each event's argument are, and those of its rate but for accelerations: what
    their rounding is measured by."""
    graph, found = graph_of(model), list[Node]()
    for event in model.events:
        slopes = [graph.diff(event.argument, x) for x in (*model.q, *model.v, model.time)]
        values = (*model.q, *model.v, model.time)
        rates = (*model.v, *(graph.zero for _ in model.v), graph.one)
        for factors in (values, rates):
            found.append(graph.sum([(graph.absolute(s * x), 1.0) for s, x in zip(slopes, factors)]))
    return found


def suits_lanes(program: Program, residual: Residual, integrands: Iterable[Node] = ()) -> bool:
    """Whether its motions are followed eight at once: not where a force may hide, or a switch changes."""
    if (
        program.hiding
        or residual.model.events
        or switches([*residual.residual, *integrands], residual.variables)
    ):
        return False
    largest = max((len(block) for block in residual.blocks), default=0)
    unrolled = UNROLLED["definite" if residual.definite else "general"]
    return len(program.series.series) <= MOST_SERIES and largest <= unrolled


def with_lanes(program: Program, residual: Residual, tolerance: float, section: str = "") -> Program:
    """``program`` with ``@follow``, which takes members to their ends (see ``stepping.ensemble``), or through
    a ``section`` (see ``stepping.crossings``)."""
    from lagrange_cli.native.functions.elementary import definitions
    from lagrange_cli.native.numbers.lanes import LaneEmitter
    from lagrange_cli.native.recurrences.compensated import compensated_expansion
    from lagrange_cli.native.recurrences.layout_lanes import arrange_lanes
    from lagrange_cli.native.recurrences.paired import Memory, write_paired_jet
    from lagrange_cli.native.stepping.ensemble import Pack, follow

    order, constants, series = lane_order(tolerance), Constants(), program.series
    emitter, layout, width = LaneEmitter(), arrange_lanes(series, order), program.state.width
    expansion = compensated_expansion(emitter, residual, series, constants, width, 0)
    jet = write_paired_jet(Memory(expansion, emitter, layout))
    parameters = residual.model.parameters
    prepare, size = write_prepare(Emitter(), constants, parameters, "internal void @prepare_lane")
    pack = Pack(
        program.degrees, program.rows, width, layout.span, size, layout.vectors, program.state.quadratures
    )
    given = order, tolerance, len(program.parameters)
    if section:
        from lagrange_cli.native.stepping.crossings import follow_section

        stepping, pack = follow_section(pack, *given, section)
    else:
        stepping = follow(pack, *given)
    text = "\n".join([*tables("lane_", order + 3), prepare, jet, stepping])
    text = "\n".join([program.text, text, definitions(text)])
    emitter.allow(text.count(" = "))
    return replace(program, text=text, lanes=LANES * pack.places["size"])


def tables(prefix: str, size: int) -> list[str]:
    """The numbers that stages of a loop need."""
    rows = {"numbers": range(size), "reciprocals": [0.0, *(1.0 / m for m in range(1, size))]}
    listed = {name: [f"double {operand(literal(x))}" for x in row] for name, row in rows.items()}
    return [
        f"@{prefix}{name} = private constant [{len(row)} x double] [{', '.join(row)}]"
        for name, row in listed.items()
    ]


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
