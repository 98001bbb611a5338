"""Code for constants of the motion in place of velocities.

They are computed when a motion begins and kept in rows of the state, which no step changes. From then on
the velocities follow from them: what rounding adds to these in a step is not carried on. They are computed
in twice the precision, since what they are off, they are off in every step. What multiplies series is
rounded, so that it is the same at all orders: were it better at the first ones, the energy would drift.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import numbered
from lagrange_cli.native.numbers.double import Emitter, Value, operand
from lagrange_cli.native.recurrences.compensated import Compensated, Compensation
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.series.program import Op, SeriesProgram


def cyclic_values(
    residual: Residual,
    program: SeriesProgram,
    width: int,
    low: dict[int, Value],
    emitter: Emitter,
    constants: Constants,
) -> dict[Node, Value]:
    """The constants of sums that contain symbols of ``residual.cyclic_momenta``.

    ``low`` is what q and q_dot hold beyond their doubles, by series; in the state it lies ``width`` behind
    them.
    """
    if not residual.cyclic_momenta:
        return {}
    scales: dict[Node, None] = {}
    for operation in program.series:
        if operation.op is Op.LINEAR:
            assert isinstance(operation.data, tuple)
            scales |= dict.fromkeys((operation.data[0], *operation.data[1]))
    depending = [s for s in scales if any(s.symbols & one.symbol.symbols for one in residual.cyclic_momenta)]
    state = numbered([*residual.model.q, *residual.model.v])
    series = [*program.coordinates, *program.velocities]
    known: dict[Node, Compensated] = {
        x: (emitter.load("%state", row), low[series[row]]) for x, row in state.items()
    }
    known[residual.model.time] = "%t", None
    compensation = Compensation(residual.graph, emitter, constants, known)
    begins: dict[Node, str] = {}
    first = len(series) + len(program.integrals) - program.stored
    for row, one in enumerate(residual.cyclic_momenta, first):
        momentum = compensation.value(one.momentum)
        if program.stored:
            kept = emitter.load("%state", row), emitter.load("%state", width + row)
            begins[one.symbol] = emitter.define(f"fcmp oeq double {kept[0]}, {operand(None)}")
            momentum = select(emitter, begins[one.symbol], momentum, kept)
            store(emitter, momentum, row, width)
        compensation.set(one.symbol, momentum)
    for one in residual.cyclic_momenta if program.stored else ():
        row = state[one.velocity]
        speed = select(emitter, begins[one.symbol], known[one.velocity], compensation.value(one.speed))
        store(emitter, speed, row, width)
        low[series[row]] = speed[1]
    return {scale: compensation.value(scale)[0] for scale in depending}


def select(emitter: Emitter, condition: str, yes: Compensated, no: Compensated) -> Compensated:
    """One of two values."""
    high, low = (
        emitter.define(f"select i1 {condition}, double {operand(a)}, double {operand(b)}")
        for a, b in zip(yes, no)
    )
    return high, low


def store(emitter: Emitter, value: Compensated, row: int, width: int) -> None:
    """Put a value into its row of the state."""
    emitter.store(value[0], "%state", row)
    emitter.store(value[1], "%state", width + row)
