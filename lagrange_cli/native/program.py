"""``Program``: the text of one system's machine code, and what it holds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.hidden_forces import hidden_forces
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import HIGHEST_ORDER, LANES, STEPPING, Interface
from lagrange_cli.native.linear.cholesky import factor_definite
from lagrange_cli.native.linear.triangular import solve_definite
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.double import Emitter, Value, literal, operand
from lagrange_cli.native.numbers.vector import Bit, Real
from lagrange_cli.native.recurrences.evaluation import DECLARATIONS, Constants, emit_prepare, emit_values
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.jet import write_jet
from lagrange_cli.native.recurrences.layout import arrange
from lagrange_cli.native.recurrences.stage import reciprocal_rest
from lagrange_cli.native.stepping.doubles import stepper
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import SeriesProgram


@dataclass(frozen=True)
class Program(Interface):
    """LLVM IR of a system. Operations are counted by function, each as often as a call executes it."""

    text: str
    series: SeriesProgram
    operations: Mapping[str, int]


def order_for(tolerance: float) -> int:
    """The order of q's series at ``tolerance``: half as high again as Jorba and Zou's (2005, sec. 3.1).

    They count operations, which grow with the order's square. Here most of them are done side by side, and
    the time of an order is mostly that of its longest chain: longer steps of a higher order are cheaper, the
    more so the coarser the tolerance (docs/engine.md). A tolerance far below double precision makes steps
    shorter instead, and so the rounding of their sum less.
    """
    return min(HIGHEST_ORDER, math.ceil(10.9 - 0.5 * math.log(tolerance)))


def write_program(
    residual: Residual,
    order: int,
    integrands: Mapping[str, Node],
    observed: Mapping[str, Node],
    linearized: Sequence[Node] = (),
    accelerations: Sequence[Node] = (),
    tolerance: float = 2.0**-52,
    store_momenta: bool = False,
) -> Program:
    """The program that advances ``residual`` with q's series to ``order``.

    ``@accelerate`` gives the rates at one state; from order 6 on there is ``@advance``. ``@linearize``
    computes the nodes
    ``linearized``, functions of q, v and the symbols ``accelerations``, if there are any. What ``residual``
    holds is kept from one state to the next, in further rows, where ``store_momenta``.
    """
    model = residual.model
    constants = Constants()
    stored = [str(one.symbol.data) for one in residual.cyclic_momenta] if store_momenta else []
    hidden = hidden_forces(residual) if order >= STEPPING else {}
    named = {f"hidden {i}": node for i, node in enumerate(hidden)}
    integrands = {**named, **integrands, **dict.fromkeys(stored, residual.graph.zero)}
    series = lower(
        residual.graph, residual.variables, model.q, model.v, model.time,
        residual.residual, list(integrands.values()),
    )  # fmt: skip
    series = replace(series, stored=len(stored))
    layout = arrange(series, order)
    expansion = Expansion(residual, series, layout, constants)
    parts = [write_jet(expansion)]
    degrees = len(model.q)
    work = LANES * -(-(layout.doubles + expansion.scratch) // LANES)
    if expansion.scratch:
        parts += [fill_in("linear", {}), factor_definite()]
        parts += map(solve_definite, sorted(expansion.strides))
    if order >= STEPPING:
        parts.append(stepper(layout, degrees, work, tolerance, list(hidden.values())))
    parts.append(_accelerate(layout.width + degrees, len(layout.state) - degrees))
    symbols = [*model.q, *model.v]
    observe, observe_operations = _values("observe", model.time, symbols, list(observed.values()), constants)
    parts.append(observe)
    if linearized:
        symbols += accelerations
        parts.append(_values("linearize", model.time, symbols, list(linearized), constants)[0])
    prepare, size = emit_prepare(constants, model.parameters)
    parts.append(prepare)
    return Program(
        text="\n".join([DECLARATIONS, GLOBALS, *_tables(order), *parts, ATTRIBUTES]),
        order=order,
        degrees=degrees,
        parameters=tuple(model.parameters),
        integrals=tuple(integrands),
        stored=len(stored),
        observed=tuple(observed),
        constants=size,
        work=work,
        lanes=0,
        parts=1,
        series=series,
        operations={"jet": expansion.emitter.operations, "observe": observe_operations},
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


def _values(
    name: str, time: Node, symbols: Sequence[Node], nodes: list[Node], constants: Constants
) -> tuple[str, int]:
    """A function that computes ``nodes`` at each of ``%count`` samples, and its number of operations.

    The arrays of states (a row for each of ``symbols``) and of results have ``%stride`` columns.
    """
    emitter = Emitter()
    emitter.line("entry:\n  %none = icmp eq i64 %count, 0\n  br i1 %none, label %done, label %loop\nloop:")
    emitter.line("  %i = phi i64 [ 0, %entry ], [ %next, %loop ]")
    known: dict[Node, Value] = {time: emitter.load("%times", "%i")}
    for row, symbol in enumerate(symbols):
        known[symbol] = emitter.load("%states", _column(emitter, row))
    emit_values(emitter, nodes, known, constants)
    for row, node in enumerate(nodes):
        emitter.store(known[node], "%results", _column(emitter, row))
    emitter.line("  %next = add nuw nsw i64 %i, 1\n  %more = icmp ult i64 %next, %count")
    emitter.line("  br i1 %more, label %loop, label %done\ndone:\n  ret void")
    body = "\n".join(emitter.lines)
    head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
    return f"define void @{name}({head}, i64 %stride, i64 %count) #0 {{\n{body}\n}}\n", emitter.operations


def _column(emitter: Emitter, row: int) -> str:
    base = emitter.define(f"mul i64 %stride, {row}")
    return emitter.define(f"add i64 {base}, %i")


def _tables(order: int) -> list[str]:
    size = order + 4
    rows = {
        "numbers": [float(m) for m in range(size)],
        "reciprocals": [0.0] + [1.0 / m for m in range(1, size)],
        "reciprocal_rests": [0.0] + [reciprocal_rest(m) for m in range(1, size)],
    }
    listed = {name: ", ".join(f"double {operand(literal(x))}" for x in row) for name, row in rows.items()}
    return [f"@{name} = private constant [{size} x double] [{row}]" for name, row in listed.items()]


GLOBALS = "\n".join(
    [
        *(
            f"declare {kind} @llvm.{name}.{tag}({', '.join([kind] * count)})"
            for name, count in (("fmuladd", 3), ("fma", 3), ("fabs", 1), ("maxnum", 2), ("minnum", 2))
            for kind, tag in (("double", "f64"), *((f"<{n} x double>", f"v{n}f64") for n in (2, 4, LANES)))
            if (name, tag) not in (("fmuladd", "f64"), ("fabs", "f64"))
        ),
        *(
            f"declare double @llvm.vector.reduce.{name}.v{n}f64({first}<{n} x double>)"
            for name, first in (("fadd", "double, "), ("fmax", ""))
            for n in (2, 4, LANES)
        ),
        *(f"declare i1 @llvm.vector.reduce.or.v{n}i1(<{n} x i1>)" for n in (2, 4, LANES)),
        "declare i8 @llvm.ctpop.i8(i8)",
    ]
)

ATTRIBUTES = 'attributes #0 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }'
