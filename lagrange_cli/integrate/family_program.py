"""The program and the outputs of a system whose families are not expanded (see ``families.system``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.impacts.resting import with_contacts
from lagrange_cli.families.polynomials import order_of_all
from lagrange_cli.families.switching.smooth import with_modes_in
from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.compilation import portable_if_asked
from lagrange_cli.integrate.families import narrow
from lagrange_cli.integrate.family_outputs import Described, FamilyPlanner
from lagrange_cli.integrate.family_quantities import Element, Quantities
from lagrange_cli.integrate.methods.equations import Equations
from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from lagrange_cli.native.families.floors import related, runs
from lagrange_cli.native.families.jets import WITHOUT_SERIES
from lagrange_cli.native.families.program import FamilyProgram
from lagrange_cli.native.families.vectors import DoubleVectors, Vectors, beside_doubles
from lagrange_cli.native.interface import STEPPING
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.orders import double_double_order, order_for
from lagrange_cli.native.program import Program
from lagrange_cli.outputs.plan import planned
from lagrange_cli.outputs.recording import NARROW, EventGroup, Recording
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation


def write_families(
    system: FamilySystem, compilation: Compilation, *, concise: bool = False
) -> tuple[Program, Recording]:
    """The program for ``compilation``, ``concise`` or as fast as it can be, and the datasets made of its
    results."""
    conserved = frozenset(system.conserved)
    alone = system.joints is not None and len(related(system.spec, fewest=2)) < len(runs(system.spec))
    if system.bodies or alone or system.driven_joints:  # what T does not depend on is not seen by its form
        from lagrange_cli.families.conserved.conservation import constants_of

        found = (one.quantity for one in constants_of(system).conserved)
        conserved |= {one for one in found if one.startswith("p_") or (one == "h" and system.driven_joints)}
    planner = FamilyPlanner(cast("Any", Described(system)), cast("Any", Quantities(system)), conserved)
    planned(planner, compilation.outputs, compilation.optional)
    observed = cast("dict[str, Element]", planner.observed)
    integrands = cast("dict[str, Element]", planner.integrands)
    needs, tolerance, order = METHODS[compilation.method].needs, compilation.tolerance, RATES
    kind: type[Vectors] = DoubleVectors if compilation.factor is None else beside_doubles(compilation.factor)
    if compilation.precision == DOUBLE_DOUBLE:
        from lagrange_cli.native.families.double_double import DoubleDoubleVectors

        order, kind = double_double_order(tolerance), DoubleDoubleVectors
    elif needs is Needs.SERIES:
        order = order_for(tolerance) if compilation.order is None else compilation.order
    scheme = compilation.method if needs is Needs.STEPS else ""
    hides = narrow(system, compilation.method)
    approaches = METHODS[compilation.method].approaches and not hides and narrow(system)
    proven = needs is Needs.SERIES and not compilation.unproven and (hides or compilation.proven)
    ends = order > RATES and compilation.order is None and not integrands and not proven
    followed = system
    if system.smooth is not None:
        followed, changed = with_modes_in(system, [*dict.fromkeys(one for one, _ in integrands.values())])
        integrands = {name: (changed[one], index) for name, (one, index) in integrands.items()}
    if order > RATES or scheme:
        followed = with_contacts(followed)
    if ends and system.smooth is None:
        order = int(min(order, max(STEPPING, order_of_all(followed))))
    if compilation.backward:
        from lagrange_cli.families.backward import Reversal

        reversal = Reversal(followed)
        followed, integrands = reversal.equations(), reversal.integrands(integrands)
    try:
        program = FamilyProgram(
            followed, observed, tolerance, order, sampled=system,
            scheme=scheme, kind=kind, factor=compilation.factor, proven=proven, integrands=integrands,
            concise=concise, approaches=approaches,
        ).written()  # fmt: skip
    except TooManyNumbers as error:
        if compilation.precision == DOUBLE and compilation.factor is None:
            raise
        raise TooManyNumbers(error.message, error.hint.replace(WITHOUT_SERIES, "")) from error
    constant = unbroken(system, conserved.intersection(observed)).union(planner.kept)
    events = planner.families("events", [*system.spec.events])
    at_events = {"q", "v"} if events else frozenset[str]()
    states = planned(FamilyPlanner(planner.residual, planner.energetics, conserved), at_events).states
    recording = Recording(
        coordinates=tuple(names_of(system.spec.coordinates)),
        states=tuple(planner.states),
        made=tuple(planner.made),
        conserved=tuple(name for name in observed if name in constant),
        undetected=(NARROW,) * (hides and not proven),
        events=tuple(EventGroup(one.name, one.shape, tuple(one.members)) for one in events),
        at_events=tuple(states),
    )
    return portable_if_asked(program, compilation), recording


def unbroken(system: FamilySystem, conserved: frozenset[str]) -> frozenset[str]:
    """What is conserved at events, too."""
    events = system.events
    if events is None or not events.changed.size or (events.keeps_energy and conserved <= {"h"}):
        return conserved
    from lagrange_cli.families.conserved.conservation import constants_of

    return conserved.intersection(one.quantity for one in constants_of(system).conserved if not one.breaks)


def compiled_accelerations(system: FamilySystem) -> Callable[[float, Array, Array, Array], Array]:
    """(t, q, v, parameters) -> accelerations, from the code that ``solve`` runs."""
    machine = compile_program(FamilyProgram(system, {}, FULL_PRECISION, RATES).written(), QUICK)

    def accelerations(t: float, q: Array, v: Array, parameters: Array) -> Array:
        rates = Equations.of(machine, parameters).rates(t, np.concatenate([q, v]))
        return rates[machine.program.state.v]

    return accelerations
