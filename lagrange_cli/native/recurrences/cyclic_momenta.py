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
from lagrange_cli.native.recurrences.compensated import Doubled, Doubling
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.series.program import Op, SeriesProgram


def hold(
    residual: Residual,
    program: SeriesProgram,
    width: int,
    low: dict[int, Value],
    emitter: Emitter,
    constants: Constants,
) -> dict[Node, Value]:
    """The constants of sums that contain symbols of ``residual.held``.

    ``low`` is what q and q_dot hold beyond their doubles, by series; in the state it lies ``width`` behind
    them.
    """
    if not residual.held:
        return {}
    scales: dict[Node, None] = {}
    for operation in program.series:
        if operation.op is Op.LINEAR:
            assert isinstance(operation.data, tuple)
            scales |= dict.fromkeys((operation.data[0], *operation.data[1]))
    depending = [s for s in scales if any(s.symbols & one.symbol.symbols for one in residual.held)]
    state = numbered([*residual.model.q, *residual.model.v])
    series = [*program.coordinates, *program.velocities]
    known: dict[Node, Doubled] = {
        x: (emitter.load("%state", row), low[series[row]]) for x, row in state.items()
    }
    known[residual.model.time] = "%t", None
    doubling = Doubling(residual.graph, emitter, constants, known)
    begins: dict[Node, str] = {}
    first = len(series) + len(program.integrals) - program.kept
    for row, one in enumerate(residual.held, first):
        momentum = doubling.value(one.momentum)
        if program.kept:
            kept = emitter.load("%state", row), emitter.load("%state", width + row)
            begins[one.symbol] = emitter.define(f"fcmp oeq double {kept[0]}, {operand(None)}")
            momentum = select(emitter, begins[one.symbol], momentum, kept)
            store(emitter, momentum, row, width)
        doubling.set(one.symbol, momentum)
    for one in residual.held if program.kept else ():
        row = state[one.velocity]
        speed = select(emitter, begins[one.symbol], known[one.velocity], doubling.value(one.speed))
        store(emitter, speed, row, width)
        low[series[row]] = speed[1]
    return {scale: doubling.value(scale)[0] for scale in depending}


def select(emitter: Emitter, condition: str, yes: Doubled, no: Doubled) -> Doubled:
    """One of two values."""
    high, low = (
        emitter.define(f"select i1 {condition}, double {operand(a)}, double {operand(b)}")
        for a, b in zip(yes, no)
    )
    return high, low


def store(emitter: Emitter, value: Doubled, row: int, width: int) -> None:
    """Put a value into its row of the state."""
    emitter.store(value[0], "%state", row)
    emitter.store(value[1], "%state", width + row)
