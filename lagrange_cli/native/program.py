"""``Program``: the text of one system's machine code, and what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.explicit import at_a_state
from lagrange_cli.mechanics.explicit import unknowns as unknowns_of
from lagrange_cli.mechanics.guards.guard import Guarded
from lagrange_cli.mechanics.guards.holding import at_a_held_state
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.saturation import saturated_each
from lagrange_cli.mechanics.switching.switches import one_sided
from lagrange_cli.model.model import Model
from lagrange_cli.native.events import (
    changes_of,
    events_of,
    jumping_of,
    left_by,
    masses_of,
    number_of,
    rates_of,
    reached_by,
    sizes_of,
)
from lagrange_cli.native.followed import FollowedEquations, followed
from lagrange_cli.native.guards import LOOSE
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
from lagrange_cli.native.stepping.pushing import push
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


@dataclass(frozen=True)
class Steps:
    """How a program steps: with q's series to an ``order`` within a ``tolerance``, in numbers of a ``kind``,
    or by a ``scheme`` on rates (``rates.schemes``).

    Cyclic momenta are stored in rows of the state if ``store_momenta``. Steps are ``proven`` where a force
    may hide, and wherever that is asked for, unless forces are not linear in multipliers, or the program is
    to be ``unproven``. With a ``factor`` the program is that of a companion (see ``numbers.beside``).
    """

    order: int
    tolerance: float = 2.0**-52
    scheme: str = ""
    kind: type[Emitter] | type[DoubleDouble] = Emitter
    factor: int | None = None
    proven: bool = False
    unproven: bool = False
    store_momenta: bool = False

    @property
    def any(self) -> bool:
        """Whether steps are taken at all: series of a lower order give rates alone."""
        return self.order >= STEPPING or bool(self.scheme)

    @property
    def emitter(self) -> Callable[[Function], Emitter]:
        """The writers for doubles."""
        return Emitter if self.factor is None else partial(BesideEmitter, factor=self.factor)

    @property
    def make(self) -> Make:
        """The writers for numbers of the kind."""
        return self.emitter if self.kind is Emitter else self.kind

    @property
    def sampling(self) -> Make:
        """The writers for what is observed."""
        return self.make if self.factor is None else partial(RoundedEmitter, factor=self.factor)


@dataclass(frozen=True)
class Linearized:
    """What ``@linearize`` computes: ``nodes``, functions of q, v and the symbols ``accelerations``."""

    nodes: Sequence[Node]
    accelerations: Sequence[Node]


def write_program(
    residual: Residual,
    steps: Steps,
    integrands: Mapping[str, Node],
    observed: Mapping[str, Node],
    *,
    observing: Residual | None = None,
    linearized: Linearized | None = None,
) -> Program:
    """The program that advances ``residual`` by ``steps``, with quadratures of ``integrands``.

    Accelerations and multipliers in what is ``observed`` are those of the equations ``observing``, by default
    ``residual``. Raises ``TooLarge`` where the program has more instructions than can be compiled.
    """
    observing = observing or residual
    seen = one_sided(residual.graph, [*observed.values()], residual.variables)
    sampled = saturated_each(residual.graph, seen, residual.variables)
    unknowns, quantities = at_a_held_state(observing, sampled) or at_a_state(observing, sampled)
    model, constants = whole(residual, observing), Constants()
    more = followed(
        residual,
        integrands,
        stepping=steps.any,
        store_momenta=steps.store_momenta,
        proven=steps.proven,
        unproven=steps.unproven or bool(steps.scheme),
    )
    residual = more.smooth.residual
    interface = interface_of(model, more, steps, observing, tuple(observed))
    at_one_time = interface.parts > 1
    apart = steps.any and not (steps.scheme or at_one_time)
    series = residual.series([*more.integrands.values()], len(more.arguments), apart=apart)
    series = replace(series, stored=more.stored)
    rows = interface.rows_of_guards if interface.guarded else None
    given = more, series, interface.inner, constants, steps.order, steps.tolerance, rows
    equations = Specification(*given, steps.emitter, steps.factor is not None, steps.scheme)
    made = motion_of(equations, interface.parts)
    texts = [*made.parts]

    def values(
        name: str,
        nodes: Iterable[Node],
        symbols: Sequence[Node] = (*model.q, *model.v),
        rows: int = interface.rows,
        make: Make = steps.make,
        **how: Any,
    ) -> int:
        text, operations = write_values(name, make, model.time, symbols, rows, [*nodes], constants, **how)
        texts.append(text)
        return operations

    operations = values("observe", quantities, make=steps.sampling, unknowns=unknowns)
    if residual.bent:
        state, own = (*residual.state_q, *residual.state_v), unknowns_of(residual)
        width = interface.inner.width
        values(MULTIPLIERS, residual.multipliers, state, width, at_one_time=at_one_time, unknowns=own)
    if linearized:
        values("linearize", linearized.nodes, (*model.q, *model.v, *linearized.accelerations))
    if interface.events:
        nodes = [*changes_of(model)[1], *sizes_of(model), *left_by(model, interface.bounces)]
        nodes += masses_of(model).values()
        values("act", nodes, at_one_time=at_one_time)
    if any(kind != LOOSE for *_, kind in interface.slowing.values()):
        values("speeds", rates_of(model, interface.slowing), at_one_time=at_one_time)
    if interface.joined:
        texts.append(push(interface.rows_of_guards, interface.inner))
    if interface.changed and observing.multipliers:
        values("constrain", constrained(model, observing), at_one_time=at_one_time)
    prepare, size = write_settings(model, more.smooth, len(interface.events), constants, steps)
    text = "\n".join([*texts, prepare])
    if residual.surplus:
        from lagrange_cli.native.linear.dependent import called_in

        text += called_in(text)
    if more.hiding:
        from lagrange_cli.native.functions.elementary import definitions

        text += definitions(text)
    length.allow(text.count(" = "), interface.parts)
    return Program(
        **{
            **interface.as_data(), "constants": size, "work": made.work, "single": made.work,
            "series_at": made.series_at,
        },
        text=text,
        series=series,
        hiding=more.hides,
        operations={"jet": made.operations, "observe": operations},
    )  # fmt: skip


def interface_of(
    model: Model[Node], more: FollowedEquations, steps: Steps, observing: Residual, observed: tuple[str, ...]
) -> Interface:
    """What callers of the program must know; its sizes of work and constants are known once it is written."""
    smooth, parts = more.smooth, steps.kind.parts
    changed = changes_of(model)[0] if steps.any else ()
    events, affected = events_of(model, smooth, parts) if steps.any else ((), ())
    reached, masses = reached_by(model, events), tuple(masses_of(model)) if steps.any else ()
    entries = observing.unpushed.entries if changed and observing.multipliers else ()
    interface = Interface(
        order=steps.order,
        degrees=len(model.q),
        parameters=tuple(model.parameters),
        integrals=tuple(more.integrands)[len(more.arguments) :],
        stored=more.stored,
        observed=observed,
        constants=0,
        work=0,
        single=0,
        lanes=0,
        parts=parts,
        given=parts if steps.factor is None else 2,
        guards=tuple(number_of(one) for one in smooth.guards),
        silent=smooth.silent,
        limits=tuple(j for j, one in enumerate(smooth.guards) if one.limit is not None),
        vectors=tuple(
            (j, tuple(map(model.v.index, one.vector.pivots)))
            for j, one in enumerate(smooth.guards)
            if one.vector
        ),
        events=events,
        changed=changed,
        affected=affected,
        jumping=jumping_of(model) if steps.any else (),
        reached=reached,
        joined=tuple(range(len(model.q))) if reached and not masses else (),
        masses=masses,
        constraints=len(observing.multipliers),
        pattern=tuple((j, k) for j, row in enumerate(entries) for k in row),
        series_at=(0, 0, 0),
        carried=0,
        strips=0,
        board=0,
    )
    if not steps.scheme:
        return interface
    from lagrange_cli.native.rates.schemes import scheme_of

    return replace(interface, carried=scheme_of(steps.scheme).carried(interface.inner))


def constrained(model: Model[Node], observing: Residual) -> Iterator[Node]:
    """Constraints, their rates, and the entries of the equations' matrix; zeros for those on velocities."""
    yield from (one.expression if one.holonomic else observing.graph.zero for one in model.constraints)
    yield from Constraints(model).speeds
    for row in observing.unpushed.entries:
        yield from row.values()


def write_settings(
    model: Model[Node], smooth: Guarded, events: int, constants: Constants, steps: Steps
) -> tuple[str, int]:
    """``@prepare``, and the number of constants: from the values of parameters, and the modes of guards,
    events and resting contacts."""
    modes = [one.mode for one in smooth.guards]
    modes += [smooth.residual.graph.symbol(f"event {i}") for i in range(events)]
    modes += [one.mode for one in smooth.rests]
    given = {**model.parameters, **{str(mode.data): mode for mode in modes}}
    if steps.factor is None:
        return write_prepare(steps.make, constants, given)
    from lagrange_cli.native.companion import prepare_beside

    return prepare_beside(constants, given, steps.factor)


def whole(residual: Residual, observing: Residual) -> Model[Node]:
    """The model of the state: with the coordinates that follow from others, as they are in ``observing``."""
    if not residual.dependent:
        return residual.model
    changes = {event.name: event.changes for event in observing.model.events}
    events = tuple(replace(event, changes=changes[event.name]) for event in residual.model.events)
    return replace(observing.model, events=events)
