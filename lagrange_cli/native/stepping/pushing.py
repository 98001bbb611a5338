"""``@push`` where no constraints have impulses after a simple action: it sets velocities, and nothing else
changes (see ``native.families.constraints.impulses`` for others)."""

from __future__ import annotations

from lagrange_cli.native.guards import DONE, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.actions import PUSH

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
    time, one, moving = f.place(state, layout.time), f.count(1), state
    if rows.degrees < layout.degrees:  # without auxiliary coordinates
        moving = f.place(results, -2 * rows.degrees, "double")
        f.copy_rows((state, layout.degrees), (moving, rows.degrees), rows.degrees, 1)
    f.call(None, "speeds", f.pointer("%constants"), time, moving, speeds, one, one)
    contacts = {guard for guard, _ in rows.reached}
    numbers = [n for n, (guard, _) in enumerate(rows.bounces) if guard in contacts]
    for k, n in enumerate(numbers):
        if n != k:  # others have no contact
            f.store(f.load(speeds, n), speeds, k)
    f.give(f.count(DONE))
    return f.text()
