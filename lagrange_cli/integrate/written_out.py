"""Why the members of families are written out one by one, for messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.expression.syntax import calls
from lagrange_cli.families.system import UNKNOWN, any_family_system, reason
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Expression, Place, Spec


@dataclass(frozen=True)
class WrittenOut:
    """Members are written out because of ``what``, at its ``place`` in the file if it stands there; the
    ``way`` out is to do without. If it is for ``outputs``, these are their names."""

    what: str
    way: str
    place: Place | None = None
    outputs: tuple[str, ...] = ()


OTHER = WrittenOut("a system of another kind", "change it")
"""A system that is not one of families; ``unsuited`` looks closer."""


KINKED = "sign", "where", "abs", "min", "max", "atan2"


def without_outputs(names: Sequence[str]) -> WrittenOut:
    """What cannot be computed with families."""
    listed, them = ",".join(names), "it" if len(names) == 1 else "them"
    return WrittenOut(f"--outputs {listed}", f"leave {them} out of --outputs", outputs=tuple(names))


def unsuited(spec: Spec) -> WrittenOut:
    """What a system contains that is not one of families."""
    for part, what in UNKNOWN.items():
        for name in getattr(spec, part):
            place = {**spec.replaced, **spec.all_constraints}[name].place
            return WrittenOut(what, "write a system without them", place)
    known = reason(spec)
    energies = [*spec.potential.values(), *([] if spec.lagrangian is None else [spec.lagrangian])]
    forces = [one for given in spec.forces.values() for one in given.values()]
    if known:
        what, way, *parts = known
        longest = max(parts, key=lambda part: len(getattr(spec, part)), default="")
        where = getattr(spec, longest).values() if longest else [*forces, *energies]
        if longest == "events":
            where = [one.when for one in written(spec.events)]
        elif longest == "forces":
            where = forces
        return WrittenOut(what, way, kinked(where))
    if spec.events and (found := any_family_system(replace(spec, events={}))) is not None:
        if found.coupled_masses is not None:
            return coupled([one.when for one in written(spec.events)])
        what = "events that jump, that set masses, or impacts between members"
        events = [*written(spec.events)]
        acting = [one.when for one in events if one.sets] or [one.when for one in events]
        return WrittenOut(what, "let them record or stop only", kinked(acting))
    for part in ("constraints", "nonholonomic", "observables"):
        given = getattr(spec, part)
        if given and any_family_system(replace(spec, **{part: {}})) is not None:
            way = "write it in terms of neighbours, without kinks"
            return WrittenOut(f"what '{part}' contains", way, kinked(given.values()))
    for part in spec.forces:
        others = {key: given for key, given in spec.forces.items() if key != part}
        if (found := any_family_system(replace(spec, forces=others))) is not None:
            if found.coupled_masses is not None:
                return coupled(spec.forces[part].values())
            way = "write it in terms of neighbours, without jumps"
            return WrittenOut(f"what '{part}' contains", way, kinked(spec.forces[part].values()))
    what = "these energies (loops over members need masses without kinks, or "
    what += "chains and trees of angles with up to four coordinates in a joint, and forces that do not jump "
    what += "with positions or velocities)"
    return WrittenOut(what, "write energies of this form", kinked(energies))


def coupled(expressions: Iterable[Expression]) -> WrittenOut:
    """That expressions need numbers of the inverse of a mass matrix that is not diagonal."""
    what = "friction, and impacts that reduce the speed, where the mass matrix is not diagonal"
    return WrittenOut(
        what, "give each coordinate a mass of its own, without products of velocities", kinked(expressions)
    )


def kinked(expressions: Iterable[Expression]) -> Place | None:
    """Where the first of these stands that jumps or has a kink; else the first of all."""
    every = [*distinct(expressions)]
    return next((one.place for one in every if calls(one.tree, KINKED)), every[0].place if every else None)
