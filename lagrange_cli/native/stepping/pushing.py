"""``@push`` where no constraints have impulses after a simple action: it sets velocities, and nothing else
changes (see ``native.families.constraints.impulses`` for others)."""

from __future__ import annotations

from lagrange_cli.native.guards import DONE, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.actions import PUSH
from lagrange_cli.native.stepping.at_once import write_speeds

HEAD = f"define i64 @{PUSH}(ptr %constants, ptr %state, ptr %results, ptr %speeds, i64 %event) #0"


def push(rows: GuardRows, layout: StateLayout) -> str:
    """Its text. Of ``%results``, what ``@act`` gives, it sets what the event sets, and it gives the rates of
    contacts' arguments then, at ``%speeds``."""
    f = Function(HEAD)
    state, results, speeds = f.pointers("state", "results", "speeds")
    j = Integer(f, "%event") + rows.first_event
    with f.loop(0, len(rows.changed), tested=False) as i, f.when(f.load_integer("@changed_by", i).equals(j)):
        place = f.load_integer("@changed_places", i)
        f.store(f.load(results, i), state, place)
        f.store(f.constant(0.0), state, place + layout.width)
    write_speeds(f, rows, layout, results, speeds)
    f.give(f.count(DONE))
    return f.text()
