"""``write_double_double_program``: the program of a system in double-double."""

from __future__ import annotations

import math
from collections.abc import Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.model.model import Model
from lagrange_cli.native.functions.double_double import functions
from lagrange_cli.native.linear.lu import linear_solver
from lagrange_cli.native.numbers.double_double import DoubleDoubleBody, Pair, convolve, operations
from lagrange_cli.native.program import ATTRIBUTES, GLOBALS, Program
from lagrange_cli.native.recurrences.evaluation import DECLARATIONS, Constants
from lagrange_cli.native.recurrences.evaluation_double_double import Values
from lagrange_cli.native.recurrences.in_memory import Jet
from lagrange_cli.native.recurrences.layout_rows import arrange
from lagrange_cli.native.state import LANES, StateLayout
from lagrange_cli.native.stepping.advance_double_double import DoubleDoubleStepper
from lagrange_cli.series.lowering import lower

TOLERANCE = 2.0**-104
"""The tolerance that is asked for where none is given."""
HIGHEST_ORDER = 56

MORE_DECLARATIONS = "\n".join(f"declare double @llvm.{name}.f64(double)" for name in ("log2", "exp2"))


def order_for(tolerance: float) -> int:
    """The order of q's series: as in double precision, three quarters of the logarithm of the tolerance."""
    return min(HIGHEST_ORDER, 5 + math.ceil(-0.75 * math.log(tolerance)))


def write_double_double_program(
    residual: Residual,
    order: int,
    integrands: Mapping[str, Node],
    observed: Mapping[str, Node],
    tolerance: float = TOLERANCE,
) -> Program:
    """The program that advances ``residual`` with q's series to ``order``; its samples have low parts."""
    model = residual.model
    constants = Constants()
    series = lower(
        residual.graph, residual.variables, model.q, model.v, model.time,
        residual.residual, list(integrands.values()),
    )  # fmt: skip
    degrees = len(model.q)
    state = StateLayout(degrees, len(integrands))
    rows = arrange(series, residual, order, state.width)
    jet = Jet(residual, rows, constants)
    parts = [*operations(), *functions(), convolve(rows.beyond), linear_solver(), jet.write()]
    parts += DoubleDoubleStepper(rows, tolerance).functions()
    observe = observation(model, list(observed.values()), constants, state.rows)
    parts += [observe, preparation(model, constants)]
    return Program(
        text="\n".join([DECLARATIONS, MORE_DECLARATIONS, GLOBALS, *parts, ATTRIBUTES]),
        order=order,
        degrees=degrees,
        parameters=tuple(model.parameters),
        integrals=tuple(integrands),
        stored=0,
        observed=tuple(observed),
        constants=2 * len(constants.slots),
        work=LANES * -(-rows.doubles // LANES),
        lanes=0,
        parts=2,
        series=series,
        operations={"jet": jet.body.operations, "observe": 0},
    )


def observation(model: Model[Node], nodes: list[Node], constants: Constants, rows: int) -> str:
    """``@observe`` (see ``program``): rows of high parts come first, in states and in results."""
    body = DoubleDoubleBody()

    def sample(i: str) -> None:
        def column(pointer: str, row: int, beyond: int) -> tuple[str, str]:
            places = (body.integer("mul", "%stride", r) for r in (row, row + beyond))
            high, low = (body.place(pointer, body.integer("add", place, i)) for place in places)
            return high, low

        known = {model.time: Pair(body, body.load("%times", i), body.number(0).low)}
        for row, symbol in enumerate((*model.q, *model.v)):
            high, low = column("%states", row, rows)
            known[symbol] = Pair(body, body.load(high, 0), body.load(low, 0))
        values = Values(body, known, constants)
        for row, node in enumerate(nodes):
            value = values.value(node)
            for part, place in zip((value.high, value.low), column("%results", row, len(nodes))):
                body.store(part, place, 0)

    body.loop(0, "%count", sample)
    lines = "\n".join(body.lines)
    heads = "ptr %constants, ptr %times, ptr %states, ptr %results, i64 %stride, i64 %count"
    return f"define void @observe({heads}) #0 {{\n{lines}\n  ret void\n}}\n"


def preparation(model: Model[Node], constants: Constants) -> str:
    """``@prepare``: ``%constants`` from the parameters, whose low parts follow after all high ones."""
    body, count = DoubleDoubleBody(), len(model.parameters)
    known = {node: body.get("%parameters", i, count) for i, node in enumerate(model.parameters.values())}
    values = Values(body, known, None)
    for node, slot in constants.slots.items():
        body.put(values.value(node), "%constants", 2 * slot, 1)
    lines = "\n".join(body.lines)
    return f"define void @prepare(ptr %parameters, ptr %constants) #0 {{\n{lines}\n  ret void\n}}\n"
