"""Code for cyclic momenta in place of velocities.

They are computed when a motion begins and stored in rows of the state, which no step changes. From then on
the velocities follow from them, so that rounding errors of velocities do not accumulate. They are computed in
twice the precision, since their error is the same in every step. Factors of series are rounded,
so that they are the same at all orders: if they were more accurate at the first ones, the energy would drift.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import numbered
from lagrange_cli.native.numbers.kind import Condition, NumberKind, V
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.series.program import Op, SeriesProgram


def cyclic_values(
    kind: NumberKind[V],
    residual: Residual,
    program: SeriesProgram,
    width: int,
    known: dict[Node, V | None],
    constants: Constants,
) -> tuple[dict[Node, V | None], dict[int, V]]:
    """The constants of sums that contain symbols of ``residual.cyclic_momenta``, and velocities that follow
    from stored momenta, by series.

    ``known`` are the time, q and q_dot; low parts lie ``width`` behind high ones in the state.
    """
    scales: dict[Node, None] = {}
    for operation in program.series:
        if operation.op is Op.LINEAR:
            assert isinstance(operation.data, tuple)
            scales |= dict.fromkeys((operation.data[0], *operation.data[1]))

    def value(node: Node) -> V | None:
        emit_values(kind, [node], known, constants)
        return kind.normalized(known[node])

    state = numbered([*residual.state_q, *residual.state_v])
    series = [*program.coordinates, *program.velocities]
    begins: dict[Node, Condition] = {}
    first = len(program.state) - program.stored
    for row, one in enumerate(residual.cyclic_momenta, first):
        momentum = value(one.momentum)
        if program.stored:
            stored = kind.load("%state", row, width)
            begins[one.symbol] = kind.compare("oeq", stored, None)
            momentum = kind.select(begins[one.symbol], momentum, stored)
            kind.store(momentum, "%state", row, width)
        known[one.symbol] = momentum
    speeds: dict[int, V] = {}
    for one in residual.cyclic_momenta if program.stored else ():
        row = state[one.velocity]
        speeds[series[row]] = kind.select(begins[one.symbol], known[one.velocity], value(one.speed))
        kind.store(speeds[series[row]], "%state", row, width)
    depending = [s for s in scales if any(s.symbols & one.symbol.symbols for one in residual.cyclic_momenta)]
    return {scale: value(scale) for scale in depending}, speeds
