"""The machine code that follows eight motions at once, beside that of a program for single states."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from lagrange_cli.mechanics.hidden_forces import hidden_forces
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import HIGHEST_ORDER, LANES
from lagrange_cli.native.linear.blocks import UNROLLED
from lagrange_cli.native.numbers.double import literal, operand
from lagrange_cli.native.numbers.lanes import VECTOR, LaneEmitter
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.evaluation import Constants, emit_prepare
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout_lanes import arrange_lanes
from lagrange_cli.native.recurrences.paired import write_paired_jet
from lagrange_cli.native.stepping.ensemble import Pack, follow
from lagrange_cli.records import replace

MOST_SERIES = 600
"""Series of the largest system that is followed in lanes.

The code of a larger one takes too long to compile, and single motions use vectors as well.
"""


def lane_order(tolerance: float) -> int:
    """The order of q's series at ``tolerance``: a little above Jorba and Zou's (2005, sec. 3.1), lower than
    that of single motions.

    With eight motions at once it is operations that take time, as they assume, and not chains of them.
    """
    return min(HIGHEST_ORDER, 2 + max(4, math.ceil(-0.6 * math.log(tolerance))))


def suits_lanes(program: Program, residual: Residual) -> bool:
    """Whether its motions are followed eight at once: not where a force may hide."""
    if hidden_forces(residual):
        return False
    largest = max((len(block) for block in residual.blocks), default=0)
    written_out = UNROLLED["definite" if residual.definite else "general"]
    return len(program.series.series) <= MOST_SERIES and largest <= written_out


def with_lanes(program: Program, residual: Residual, tolerance: float) -> Program:
    """``program`` with ``@follow``, which takes members of an ensemble to their ends (see ``lanes.ll``)."""
    order, constants = lane_order(tolerance), Constants()
    layout = arrange_lanes(program.series, order)
    expansion = Expansion(residual, program.series, layout.one_motion, constants, LaneEmitter())
    jet = write_paired_jet(expansion, layout)
    prepare, size = emit_prepare(constants, residual.model.parameters, "internal void @prepare_lane")
    pack = Pack(program.degrees, program.rows, program.state.width, layout.span, size, layout.vectors)
    stepping = follow(pack, order, tolerance, len(program.parameters))
    text = "\n".join([program.text, *tables(order), prepare, jet, stepping])
    text += definitions(text)
    present = set(re.findall(r"^ *declare .*@([\w.]+)\(", text, re.MULTILINE))
    missing = (line for name, line in DECLARATIONS.items() if name not in present)
    return replace(program, text="\n".join([text, *missing, ATTRIBUTES]), lanes=LANES * pack.places["size"])


def tables(order: int) -> list[str]:
    """The numbers that stages of a loop need."""
    rows = {"numbers": range(order + 3), "reciprocals": [0.0, *(1.0 / m for m in range(1, order + 3))]}
    return [
        f"@lane_{name} = private constant [{order + 3} x double] "
        f"[{', '.join(f'double {operand(literal(float(x)))}' for x in row)}]"
        for name, row in rows.items()
    ]


def declared() -> Mapping[str, str]:
    """The declarations of LLVM's functions that are called here, by name."""
    counts = {"fma": 3, "fmuladd": 3, "maxnum": 2, "fabs": 1, "floor": 1}
    heads = {f"llvm.{name}.v{LANES}f64": (VECTOR, [VECTOR] * count) for name, count in counts.items()}
    heads |= {f"llvm.cttz.{kind}": (kind, [kind, "i1"]) for kind in ("i8", "i64")}
    return {name: f"declare {kind} @{name}({', '.join(given)})" for name, (kind, given) in heads.items()}


DECLARATIONS = declared()
ATTRIBUTES = 'attributes #1 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }\n'
