"""Programs whose motions are followed eight at once, in the lanes of vectors (see ``ensembles.ensemble``)."""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.guards.equations import edges_of
from lagrange_cli.mechanics.guards.vectors import vectors
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.cuts import cuts
from lagrange_cli.mechanics.switching.switches import switches
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.blocks import UNROLLED
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.text import tables
from lagrange_cli.native.members import SECTION, STROBE
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.observation import write_prepare
from lagrange_cli.native.orders import lane_order
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.records import replace

MOST_SERIES = 600
"""Series of the largest system that is followed in lanes.

The code of a larger one takes too long to compile, and single motions use vectors as well.
"""


def suits_lanes(program: Program, residual: Residual, integrands: Iterable[Node] = ()) -> bool:
    """Whether its motions are followed eight at once: not where a force may hide, or a switch changes."""
    if (
        program.hiding
        or residual.bent
        or residual.surplus
        or residual.model.events
        or cuts(residual.model)
        or edges_of(residual)
        or switches([*residual.residual, *integrands], residual.variables)
        or vectors(residual)
    ):
        return False
    degrees, definite = len(residual.model.q), residual.definite
    blocks = [block for block in residual.blocks if not definite or block[-1] < degrees]
    largest = max(map(len, blocks), default=0)
    unrolled = UNROLLED["definite" if definite else "general"]
    return len(program.series.series) <= MOST_SERIES and largest <= unrolled


def with_lanes(program: Program, residual: Residual, tolerance: float, section: str = "") -> Program:
    """``program`` with ``@follow``, which takes members to their ends (see ``ensembles.ensemble``), or
    through a ``section`` (see ``ensembles.crossings``)."""
    from lagrange_cli.native.ensembles.ensemble import Follower
    from lagrange_cli.native.ensembles.pack import Pack
    from lagrange_cli.native.functions.elementary import definitions
    from lagrange_cli.native.recurrences.paired import arrange_lanes, write_paired_jet

    order, constants, series = lane_order(tolerance), Constants(), program.series
    layout, width = arrange_lanes(series, order), program.state.width
    jet = write_paired_jet(residual, series, constants, layout, width)
    parameters, constrained = residual.model.parameters, residual.bound
    sizes = layout.span, 0, layout.vectors, program.state.quadratures
    pack = Pack(program.degrees, program.rows, width, *sizes, constrained=constrained)
    project = ""
    if constrained:
        from lagrange_cli.native.stepping.projection import StatePlaces, in_lanes

        at = pack.places
        places = StatePlaces(at["state"], at["state"] + pack.degrees, width, at["time"], at["time_low"])
        project = in_lanes(residual, places, constants)
    prepare, size = write_prepare(Emitter, constants, parameters, "internal void @prepare_lane")
    pack = replace(pack, constants=size)
    given = order, tolerance, len(program.parameters)
    if section == SECTION:
        from lagrange_cli.native.ensembles.crossings import Crossings

        follower: Follower = Crossings(pack, *given)
    elif section == STROBE:
        from lagrange_cli.native.ensembles.periods import Periods

        follower = Periods(pack, *given)
    else:
        follower = Follower(pack, *given, timed=residual.timed)
    text = "\n".join([program.text, *tables("lane_", order + 3), prepare, jet, project, follower.text()])
    text = "\n".join([text, definitions(text)])
    length.allow(text.count(" = "))
    return replace(program, text=text, lanes=LANES * follower.places["size"])
