"""From equations of motion to the program that follows them by a method."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.errors import TooLarge, UsageError
from lagrange_cli.expression.node import Node
from lagrange_cli.integrate.compilation import Compilation, portable_if_asked
from lagrange_cli.integrate.convolutions import check_convolutions
from lagrange_cli.integrate.methods.table import METHODS, MethodRow, Needs
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.mechanics.conserved.constancy import is_constant
from lagrange_cli.mechanics.contacts import without_contact_forces
from lagrange_cli.mechanics.defect import may_hide, shown_slowly
from lagrange_cli.mechanics.explicit import Linearization, linearize
from lagrange_cli.mechanics.guards.equations import edges_of
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.cuts import cuts
from lagrange_cli.mechanics.switching.switches import switches
from lagrange_cli.native.llvm.length import SHORTER
from lagrange_cli.native.members import SECTION
from lagrange_cli.native.orders import double_double_order, order_for
from lagrange_cli.native.program import Linearized, Program, Steps, write_program
from lagrange_cli.outputs.plan import Plan, make_plan
from lagrange_cli.outputs.recording import CUTS, EDGES, NARROW, SWITCHES, Recording
from lagrange_cli.records import replace

RATES = 2
"""The order of q's series that gives the accelerations alone."""


def write_run(residual: Residual, compilation: Compilation) -> tuple[Program, Recording]:
    """The program of ``residual`` for ``compilation``, and the datasets made of its results.

    A program for motions that are followed backward is for ``integrate.methods.backward``: it observes as any
    other does.

    Raises:
        TooLarge: where the code would be too large to be compiled.
    """
    method, precision = METHODS[compilation.method], compilation.precision
    check_convolutions(residual, compilation.method, precision)
    plan, original = make_plan(residual, compilation.outputs, compilation.lenient), residual
    if compilation.section == SECTION and is_constant(residual, residual.model.events[-1].argument):
        raise UsageError("no motion crosses this surface: its expression is conserved")
    if residual.multipliers and method.needs is Needs.SERIES:
        residual, plan = without_what_follows(residual, plan)
    if compilation.backward:
        from lagrange_cli.mechanics.backward import reversed_equations, reversed_integrands

        plan = replace(plan, integrands=reversed_integrands(residual, plan.integrands))
        residual = reversed_equations(residual)
    undetected = passed_over(residual, plan, method)
    try:
        program = program_of(residual, plan, compilation, original)
    except TooLarge as error:
        others = compilation.precision == DOUBLE and compilation.factor is None and not compilation.proven
        if others and method.needs is Needs.SERIES and not residual.model.constraints:
            raise
        raise type(error)(error.message, error.hint.replace(SHORTER, "")) from error
    if compilation.section == SECTION and not program.lanes:
        refuse_what_hides(residual)
    return portable_if_asked(program, compilation), replace(plan.recording, undetected=undetected)


def without_what_follows(residual: Residual, plan: Plan) -> tuple[Residual, Plan]:
    """The equations without coordinates that linear constraints give, where that saves work."""
    from lagrange_cli.native.elimination import reduced

    less = reduced(residual)
    if less is None:
        return residual, plan
    integrands = less.of(plan.integrands.values())
    return less.after, replace(plan, integrands=dict(zip(plan.integrands, integrands)))


def with_surface_followed(
    residual: Residual, integrands: Mapping[str, Node], compilation: Compilation
) -> tuple[Residual, Mapping[str, Node]]:
    """The last event's argument as the last integrand, in place of the event. In reversed time it has the
    other sign, so that it rises where it rises with t."""
    *others, surface = residual.model.events
    residual = replace(residual, model=replace(residual.model, events=tuple(others)))
    argument = -surface.argument if compilation.backward else surface.argument
    return residual, {**integrands, SECTION: argument}


def refuse_what_hides(residual: Residual) -> None:
    """Raise ``UsageError`` where zeros of the surface, the last event's argument, may hide within steps."""
    if may_hide(residual, [residual.model.events[-1].argument]):
        raise UsageError(
            "zeros of this expression may be missed, as it contains exp, tanh, sinh, cosh, high powers or "
            "quotients: write an expression without them that has the same zeros"
        )


def touches(residual: Residual) -> bool:
    """Whether a motion may come to the edge of a domain with no change of any sign."""
    if not residual.model.edges:
        return False
    from lagrange_cli.mechanics.switching.edges import touched

    return touched(residual)


def passed_over(residual: Residual, plan: Plan, method: MethodRow) -> tuple[str, ...]:
    """The features that steps of a method may miss, if they evaluate the equations at some points only."""
    if method.proves:
        return ()
    roots = without_contact_forces(residual)
    slowly = method.approaches and bool(shown_slowly(residual))
    narrow = (NARROW,) * (may_hide(residual, roots) and not slowly)
    if method.finds_events:
        return narrow + (EDGES,) * touches(residual)
    edges = (EDGES,) * bool(edges_of(residual))
    moving = switches([*residual.residual, *plan.integrands.values()], residual.variables)
    return narrow + (SWITCHES,) * bool(moving) + (CUTS,) * bool(cuts(residual.model)) + edges


def program_of(residual: Residual, plan: Plan, compilation: Compilation, observing: Residual) -> Program:
    """The program for the method, as text; what is observed follows the equations ``observing``."""
    needs, tolerance = METHODS[compilation.method].needs, compilation.tolerance

    def written(steps: Steps, linearized: Linearized | None = None) -> Program:
        return write_program(
            residual, steps, plan.integrands, plan.observed, observing=observing, linearized=linearized
        )

    if compilation.precision == DOUBLE_DOUBLE:
        from lagrange_cli.native.numbers.double_double import DoubleDouble

        order = double_double_order(tolerance)
        return written(Steps(order, tolerance, kind=DoubleDouble, proven=compilation.proven))
    inner, integrands = residual, plan.integrands
    if compilation.section == SECTION:
        inner, integrands = with_surface_followed(residual, plan.integrands, compilation)
    together = compilation.ensemble and not compilation.proven and not inner.model.events
    if together and needs is Needs.SERIES:
        from lagrange_cli.native.lanes import suits_lanes, with_lanes

        rates = Steps(RATES, store_momenta=True)
        program = write_program(inner, rates, integrands, plan.observed, observing=observing)
        if suits_lanes(program, inner, integrands.values()):
            return with_lanes(program, inner, tolerance, compilation.section)
    if needs is Needs.SERIES:
        order = order_for(tolerance) if compilation.order is None else compilation.order
        steps = Steps(
            order,
            tolerance,
            factor=compilation.factor,
            proven=compilation.proven,
            unproven=compilation.unproven,
            store_momenta=True,
        )
        return written(steps)
    if needs is Needs.STEPS:
        from lagrange_cli.native.rates.schemes import scheme_of

        scheme = compilation.method
        return written(Steps(scheme_of(scheme).order, tolerance, scheme))
    if needs is Needs.JACOBIAN:
        linear = linearize(residual)
        nodes = jacobian_nodes(residual, linear, plan)
        return written(Steps(RATES), Linearized(nodes, linear.accelerations))
    return written(Steps(RATES))


def jacobian_nodes(residual: Residual, linear: Linearization, plan: Plan) -> list[Any]:
    """dR/dq, dR/dv, M, and the integrands' derivatives by q and v, row by row."""
    graph, model = residual.graph, residual.model
    nodes = [
        entry
        for matrix in (linear.by_q, linear.by_v, residual.mass_matrix)
        for row in matrix
        for entry in row
    ]
    return nodes + [graph.diff(node, x) for node in plan.integrands.values() for x in (*model.q, *model.v)]
