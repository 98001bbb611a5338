"""Why the members of families are written out one by one, for messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrange_cli.families.system import UNKNOWN, family_system, reason
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True)
class WrittenOut:
    """Members are written out because of ``what``; the ``way`` out is to do without."""

    what: str
    way: str


OTHER = WrittenOut("a system of another kind", "change it")
"""A system that is not one of families; ``unsuited`` looks closer."""


def without_outputs(names: Sequence[str]) -> WrittenOut:
    """What cannot be computed with families."""
    listed = ",".join(names)
    return WrittenOut(f"--outputs {listed}", f"leave {'it' if len(names) == 1 else 'them'} out of --outputs")


def unsuited(spec: Spec) -> WrittenOut:
    """What a system contains that is not one of families."""
    for part in UNKNOWN:
        if getattr(spec, part):
            key = "coordinates that replace others" if part == "replaced" else f"'{part}'"
            return WrittenOut(key, "write a system without them")
    known = reason(spec)
    if known:
        return WrittenOut(*known)
    if spec.events and family_system(replace(spec, events={})) is not None:
        what = "events that reduce the speed, that jump, or that act on chains or where constraints hold"
        return WrittenOut(what, "let them record or stop only")
    for part in ("constraints", "observables"):
        if getattr(spec, part) and family_system(replace(spec, **{part: {}})) is not None:
            return WrittenOut(f"what '{part}' contains", "write it in terms of neighbours, without kinks")
    for part in spec.forces:
        others = {key: given for key, given in spec.forces.items() if key != part}
        if family_system(replace(spec, forces=others)) is not None:
            return WrittenOut(f"what '{part}' contains", "write it in terms of neighbours, without jumps")
    what = "these energies (loops over members need a constant diagonal mass matrix, or chains and trees of "
    what += "angles, rigid bodies with three coordinates each, and forces that do not jump with positions or "
    what += "velocities)"
    return WrittenOut(what, "write energies of this form")
