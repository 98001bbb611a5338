"""What joints move that hangs from nothing: its kinetic energy, multiplied out.

Axes that turn make squares that add up (cos^2 + sin^2 = 1), as those of a body that is symmetric about the
axis on which it spins. T does not contain the angle of the spin then, and with d/dt dT/dq_dot - dT/dq in
place of the masses' accelerations the equations of motion do not, either (H. Goldstein, Classical Mechanics,
3rd ed., sec. 5.7): steps are as long as the motion of the axis allows.
"""

from __future__ import annotations

from lagrange_cli.expression.node import union
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.joints.joints import FreeEnergy, Joints
from lagrange_cli.mechanics.multiplied_out import beside, halved_squares
from lagrange_cli.records import replace


def with_free_energy(builder: FamilyBuilder, joints: Joints) -> Joints:
    """The joints with the energy of what hangs from nothing, where that depends on fewer coordinates, or not
    on t, unlike the places of the weights."""
    graph, domain = builder.graph, joints.domain
    free = [one for one in joints.weights if joints.parents is None or one.component is None]
    parts = [(one.mass, builder.rate(one.move, domain)) for one in free]
    turning = union((*joints.coordinates, builder.time)) & union(speed for _, speed in parts)
    kinetic = halved_squares(graph, parts) if turning else None
    if kinetic is None or not turning & ~kinetic.symbols:
        return joints
    velocities = tuple(builder.rate(one, domain) for one in joints.coordinates)
    momenta = tuple(graph.diff(kinetic, u) for u in velocities)
    slopes = tuple(graph.diff(kinetic, x) for x in joints.coordinates)
    masses = tuple(tuple(graph.diff(p, u) for u in velocities) for p in momenta)
    made = replace(joints, free=FreeEnergy(kinetic, velocities, momenta, slopes, masses))
    return with_spin(builder, made)


def with_spin(builder: FamilyBuilder, joints: Joints) -> Joints:
    """The same with the masses of the others beside a spin, where they are the shorter for it: those of a
    top's axis are exact where it is vertical then, unlike I1 sin^2 + I3 cos^2 - (I3 cos)^2/I3 in numbers."""
    graph, free = builder.graph, joints.free
    assert free is not None
    moving = union((*joints.coordinates, builder.time))
    turned = free.kinetic.symbols | union((*joints.moves, *(one.move for one in joints.hung)))
    best, found = 0, joints
    for spin, (coordinate, row) in enumerate(zip(joints.coordinates, free.masses)):
        if turned & coordinate.symbols or row[spin].is_zero or row[spin].symbols & moving:
            continue
        shorter, masses = beside(graph, free.masses, spin)
        if shorter > best:
            alone = tuple(map(tuple, masses))
            best, found = shorter, replace(joints, free=replace(free, spin=spin, beside=alone))
    return found
