"""``Program``: the text of one system's machine code, and what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.explicit import at_a_state
from lagrange_cli.mechanics.explicit import unknowns as unknowns_of
from lagrange_cli.mechanics.guards.holding import at_a_held_state
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.saturation import saturated_each
from lagrange_cli.mechanics.switching.switches import one_sided
from lagrange_cli.model.model import Model
from lagrange_cli.native.events import changes_of, events_of, masses_of, number_of, sizes_of
from lagrange_cli.native.followed import followed
from lagrange_cli.native.interface import STEPPING, Interface
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.motions import Specification, motion_of
from lagrange_cli.native.numbers.beside import BesideEmitter, RoundedEmitter
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Written
from lagrange_cli.native.observation import write_prepare, write_values
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.expansion import MULTIPLIERS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.program import SeriesProgram

if TYPE_CHECKING:
    from lagrange_cli.native.numbers.double_double import DoubleDouble

Make: TypeAlias = "Callable[[Function], Written[Any]]"


@dataclass(frozen=True)
class Program(Interface):
    """LLVM IR of a system. Operations are counted by function, each as often as a call executes it."""

    text: str
    series: SeriesProgram
    operations: Mapping[str, int]
    hiding: bool
    """Whether steps are proven, of the motion or of its integrals."""
    tables: int = 0
    """The length of tables in the text, which take hardly any time to compile."""
    loops: bool = False
    """Whether its time is that of loops over members of families."""


def write_program(
    residual: Residual,
    order: int,
    integrands: Mapping[str, Node],
    observed: Mapping[str, Node],
    linearized: Sequence[Node] = (),
    accelerations: Sequence[Node] = (),
    tolerance: float = 2.0**-52,
    store_momenta: bool = False,
    kind: type[Emitter] | type[DoubleDouble] = Emitter,
    proven: bool = False,
    unproven: bool = False,
    factor: int | None = None,
    observing: Residual | None = None,
    scheme: str = "",
) -> Program:
    """The program that advances ``residual`` with q's series to ``order``, in numbers of a ``kind``.

    ``@linearize`` computes the nodes ``linearized``, functions of q, v and the symbols ``accelerations``, if
    there are any. Cyclic momenta are stored in rows of the state if ``store_momenta``. Steps are
    ``proven`` where a force may hide, and wherever that is asked for, unless forces are not linear in
    multipliers, or the program is to be ``unproven``. With a ``factor`` the program is that of a companion
    (see ``numbers.beside``). Accelerations and multipliers in what is ``observed`` are those of the equations
    ``observing``, by default ``residual``. Raises ``TooLarge`` where the program has more instructions than
    can be compiled. Steps of a ``scheme`` are taken on rates (``stepping.schemes``), instead of series.
    """
    emitter: Callable[[Function], Emitter] = Emitter
    if factor is not None:
        emitter = partial(BesideEmitter, factor=factor)
    parts = kind.parts
    make: Make = emitter if kind is Emitter else kind
    sampling: Make = make if factor is None else partial(RoundedEmitter, factor=factor)
    observing = observing or residual
    seen = one_sided(residual.graph, [*observed.values()], residual.variables)
    sampled = saturated_each(residual.graph, seen, residual.variables)
    unknowns, quantities = at_a_held_state(observing, sampled) or at_a_state(observing, sampled)
    model, constants = whole(residual, observing), Constants()
    stepping = order >= STEPPING or bool(scheme)
    more = followed(
        residual,
        integrands,
        stepping=stepping,
        store_momenta=store_momenta,
        proven=proven,
        unproven=unproven or bool(scheme),
    )
    smooth = more.smooth
    residual = smooth.residual
    changed, changes = changes_of(model) if stepping else ((), [])
    events, affected = events_of(model, smooth, parts) if stepping else ((), ())
    masses = masses_of(model) if stepping else {}
    closes = stepping and bool(changes) and bool(observing.multipliers)
    apart = parts == 1 and stepping and not scheme
    series = residual.series([*more.integrands.values()], len(more.arguments), apart=apart)
    series = replace(series, stored=more.stored)
    interface = Interface(
        order=order,
        degrees=len(model.q),
        parameters=tuple(model.parameters),
        integrals=tuple(more.integrands)[len(more.arguments) :],
        stored=more.stored,
        observed=tuple(observed),
        constants=0,
        work=0,
        lanes=0,
        parts=parts,
        given=parts if factor is None else 2,
        guards=tuple(number_of(one) for one in smooth.guards),
        limits=tuple(j for j, one in enumerate(smooth.guards) if one.limit is not None),
        vectors=tuple((j, len(one.vector.parts)) for j, one in enumerate(smooth.guards) if one.vector),
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
        strips=0,
        board=0,
    )
    if scheme:
        from lagrange_cli.native.stepping.schemes import scheme_of

        interface = replace(interface, carried=scheme_of(scheme).carried(interface.inner))
    rows = interface.rows_of_guards if interface.guarded else None
    given = more, series, interface.inner, constants, order, tolerance, rows
    equations = Specification(*given, emitter, factor is not None, scheme)
    made = motion_of(equations, parts)
    symbols = [*model.q, *model.v]

    def values(
        name: str, symbols: Sequence[Node], nodes: Iterable[Node], kind: Make = make, **more: Any
    ) -> tuple[str, int]:
        rows = interface.rows
        return write_values(name, kind, model.time, symbols, rows, [*nodes], constants, **more)

    observe, operations = values("observe", symbols, quantities, sampling, unknowns=unknowns)
    texts = [*made.parts, observe]
    if residual.bent:
        at = model.time, [*residual.state_q, *residual.state_v], interface.inner.width
        own = [*residual.multipliers]
        written = partial(write_values, at_one_time=parts > 1, unknowns=unknowns_of(residual))
        texts.append(written(MULTIPLIERS, make, *at, own, constants)[0])
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
    if factor is None:
        prepare, size = write_prepare(make, constants, set_ones)
    else:
        from lagrange_cli.native.companion import prepare_beside

        prepare, size = prepare_beside(constants, set_ones, factor)
    text = "\n".join([*texts, prepare])
    if more.hiding:
        from lagrange_cli.native.functions.elementary import definitions

        text += definitions(text)
    length.allow(text.count(" = "), parts)
    return Program(
        **{**interface.as_data(), "constants": size, "work": made.work, "series_at": made.series_at},
        text=text,
        series=series,
        hiding=more.hides,
        operations={"jet": made.operations, "observe": operations},
    )


def whole(residual: Residual, observing: Residual) -> Model[Node]:
    """The model of the state: with the coordinates that follow from others, as they are in ``observing``."""
    if not residual.dependent:
        return residual.model
    changes = {event.name: event.changes for event in observing.model.events}
    events = tuple(replace(event, changes=changes[event.name]) for event in residual.model.events)
    return replace(observing.model, events=events)
