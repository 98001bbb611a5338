"""What keeps a system from being one of families."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.constrained.weightless import NOTHING
from lagrange_cli.mechanics.switching.cuts import cuts_of
from lagrange_cli.mechanics.switching.saturation import saturated_each
from lagrange_cli.model.indefinite import factors_of
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

TRIES = 3
"""Random states at which M is looked at."""
CUTS = (
    "an energy or a constraint that jumps with the angle atan2(y, x)",
    "write it with sin, cos or the square of the angle, which do not",
)
INCOMPLETE = (
    "a mass matrix that is singular without the constraints",
    "give each coordinate a mass, however small",
    "constraints",
    "nonholonomic",
)
"""What members are written out for, and how to do without."""
_ABSOLUTE = "make these angles the coordinates, and write the others as their differences"
RELATIVE = "actions in systems with constraints, on links whose angles are sums", _ABSOLUTE
REACHING = "impacts of places that reduce the speed, on links whose angles are sums", _ABSOLUTE
RUBBING = "dry friction between links whose angles are sums, other than in hinges, or with impacts", _ABSOLUTE


def refuse_speeds(builder: FamilyBuilder, potential: Node, totals: Iterable[Total]) -> None:
    """Raise ``Unsuited`` where an energy depends on velocities beyond the masses."""
    for node in (potential, *(one.node for total in totals for one in total.terms)):
        if any(slot.array is builder.v for _, slot in builder.slots.inside(node)):
            raise Unsuited


def refuse_others(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where energies and constraints jump with angles, and where forces have exponentials
    that have to be bounded."""
    roots = [*system.force_nodes, system.potential]
    moving = system.time.symbols | system.slots.symbols_of(system.q, system.v, *system.totals)
    for node in reachable(roots):
        if node.kind is Kind.DDT:
            raise Unsuited
    bound = system.bonds.nodes if system.bonds else ()
    places = [one.node for axes in system.positions.values() for total in axes for one in total.terms]
    if cuts_of(system.slots.graph, system.slots.made_of([system.potential, *bound, *places]), moving):
        raise Unsuited(*CUTS)
    if saturated_each(system.slots.graph, roots, moving) != tuple(roots):
        raise Unsuited


def refuse_singular(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where M is singular and constraints determine what it does not: their matrix is
    regular, but not as it is eliminated here. It is looked at in a random state."""
    if system.saddle is None:
        return
    found = pivots_of_masses(system, system.saddle, 0)
    if np.all(np.isfinite(found)) and np.any(np.abs(found) <= NOTHING):
        raise Unsuited(*INCOMPLETE)


def pivots_of_masses(system: FamilySystem, saddle: SaddlePoint, seed: int) -> Values:
    """Those of M among the equations with constraints, as parts of the sizes of its diagonal, in a random
    state; if the matrix is dense, the eigenvalues of M."""
    chance, count, parameters = np.random.default_rng(seed), system.q.count, len(system.spec.parameters)
    q, v, given = chance.uniform(0.2, 1.2, count), np.zeros(count), chance.uniform(0.5, 1.5, parameters)
    with np.errstate(all="ignore"):
        values = FamilyValues(system, 0.5, q, v, given)
        masses = values.of(saddle.masses.entries)[: len(saddle.masses.pairs)]
        if saddle.elimination is None:
            return eigenvalues(saddle.masses, masses)
        entries = np.zeros(len(saddle.pairs))
        entries[: len(masses)] = masses
        for (b, a), places in zip(saddle.bonds.pulls, saddle.places):
            np.add.at(entries, places, values.node(saddle.bonds.bounds[b].slopes[a]))
        pivots = factors_of(saddle.elimination, saddle.pairs, entries).pivots
        return np.asarray(pivots[:count] / np.abs(masses[saddle.sizes[:count]]))


def with_pivoting(system: FamilySystem) -> FamilySystem:
    """The system, with pivoting if M is no constant and not positive: its pivots may become 0 at states where
    it is regular. Raises ``Unsuited`` where that is not possible."""
    saddle = system.saddle
    if saddle is None or not system.curved:
        return system
    if all(np.all(pivots_of_masses(system, saddle, seed) > 0.0) for seed in range(TRIES)):
        return system
    return replace(system, saddle=saddle.pivoted())


def eigenvalues(masses: CoupledMasses, entries: Values) -> Values:
    """Those of M, scaled to 1 on its diagonal."""
    matrix = np.zeros((masses.count, masses.count))
    i, j = masses.pairs.T
    matrix[i, j] = matrix[j, i] = entries
    scale = np.sqrt(np.abs(np.diag(matrix)))
    matrix /= scale[:, None] * scale
    return np.asarray(np.linalg.eigvalsh(matrix)) if np.all(np.isfinite(matrix)) else np.array([np.nan])


def refuse_friction(smooth: FamilySystem) -> None:
    """Raise ``Unsuited`` where friction may hold something."""
    modes = smooth.modes
    if modes is not None and (modes.limits is not None or modes.sticking is not None or modes.vectors):
        raise Unsuited


def refuse_holding(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where something may hold coordinates, and M is not diagonal, or that of joints whose
    coordinates are sums of these."""
    relative = system.joints is not None and system.joints.relative is not None
    if system.coupled_masses is None and not relative:
        return
    modes = None if system.smooth is None else system.smooth.modes
    if relative:
        between = modes is not None and modes.sticking is not None
        if between or (modes is not None and modes.limits is not None and system.contact is not None):
            raise Unsuited(*RUBBING)
        return
    holding = modes is not None and (modes.limits is not None or modes.sticking is not None)
    if holding:
        raise Unsuited
