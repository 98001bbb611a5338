"""What a run can write: a row for each name of ``--outputs``.

A new output is a row and a module of ``outputs.datasets`` with a function ``plan``, as in ``positions``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.model.quantity import Quantity
    from lagrange_cli.model.survey import Survey


@dataclass(frozen=True)
class OutputRow:
    """An output: its ``name``, and the ``module`` whose function ``plan``, or one whose name follows, adds
    its datasets and what they are made of. (It raises ``NotDefined`` where the system does not have all of
    it; what it has is added before that.)

    In the documentation, ``datasets`` are the paths of its datasets in the file, ``shape`` is that of each,
    and ``meaning`` what they hold, in Markdown. ``units`` gives the quantity of each by its path, that of a
    family as one. A ``default`` output is written unless other outputs are asked for; with ``section``, only
    if the file has that section. One ``of_particles`` does not exist where a system is given by its
    Lagrangian. It may be called ``also`` by other words, which are no names of it.
    """

    name: str
    module: str
    datasets: str
    shape: str
    meaning: str
    units: Callable[[Survey], Mapping[str, Quantity]]
    default: bool = False
    section: str = ""
    of_particles: bool = False
    also: str = ""


def under(path: str, quantities: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """The quantities of a group's datasets."""
    return {f"{path}/{name}": quantity for name, quantity in quantities.items()}


def of_bodies(known: Survey, quantity: Quantity) -> dict[str, Quantity]:
    """The same quantity for every rigid body."""
    return {family_name(name): quantity for name in known.spec.bodies}


def conserved_quantities(known: Survey) -> dict[str, Quantity]:
    """h, the momenta, and those of all particles, where their positions have one unit."""
    found = {"h": known.energy, **{f"p_{name}": p for name, p in known.momenta(known.energy).items()}}
    found |= {f"h_{name}": known.energy for name in known.coordinates}
    found |= {f"F_{pair}": known.energy for pair in ("xy", "xz", "yz")}
    positions = [*known.positions.values()]
    if positions and all(one == positions[0] for one in positions):
        momentum = known.energy * known.time / positions[0]
        for axis in "xyz":
            found |= {f"P_{axis}": momentum, f"K_{axis}": momentum * known.time}
            found |= {f"L_{axis}": known.energy * known.time, f"A_{axis}": known.energy * positions[0]}
    return found


OUTPUTS = {
    row.name: row
    for row in (
        OutputRow(
            "q",
            "states.coordinates",
            "/q/NAME",
            "(n,)",
            "the coordinates",
            lambda known: under("q", known.coordinates),
            default=True,
            also="coordinates coordinate angles angle generalized_coordinates state",
        ),
        OutputRow(
            "v",
            "states.velocities",
            "/v/NAME",
            "(n,)",
            "their velocities",
            lambda known: under("v", known.velocities),
            default=True,
            also="velocities velocity speeds qdot q_dot",
        ),
        OutputRow(
            "p",
            "states.momenta",
            "/diagnostics/p/NAME",
            "(n,)",
            "p_k = dL/dq_dot_k",
            lambda known: under("diagnostics/p", known.momenta(known.energy)),
            default=True,
            also="momenta momentum generalized_momenta",
        ),
        OutputRow(
            "h",
            "energies.energy_function",
            "/diagnostics/h",
            "(n,)",
            "the energy function, sum q_dot_k p_k - L",
            lambda known: {"diagnostics/h": known.energy},
            default=True,
            also="H hamiltonian Hamiltonian energy_function jacobi",
        ),
        OutputRow(
            "T",
            "energies.kinetic",
            "/diagnostics/T",
            "(n,)",
            "the kinetic energy",
            lambda known: {"diagnostics/T": known.energy},
            of_particles=True,
            also="kinetic kinetic_energy Ekin E_kin K",
        ),
        OutputRow(
            "U",
            "energies.potential",
            "/diagnostics/U",
            "(n,)",
            "the potential",
            lambda known: {"diagnostics/U": known.energy},
            of_particles=True,
            also="V potential potential_energy Epot E_pot",
        ),
        OutputRow(
            "energy",
            "energies.total",
            "/diagnostics/energy",
            "(n,)",
            "T + U",
            lambda known: {"diagnostics/energy": known.energy},
            of_particles=True,
            also="E total_energy energies Etot",
        ),
        OutputRow(
            "ledger",
            "ledgers",
            "/diagnostics/ledger/h /diagnostics/ledger/p/NAME",
            "(n,)",
            "h(t) - h(0) + int dL/dt - int Q.q_dot, and p_k(t) - p_k(0) - int (dL/dq_k + Q_k): the "
            "*ledgers*, or balances of work and energy, and of force and momentum. They are zero for an "
            "exact solution of any system, driven or damped. Terms of a given L that are a total time "
            "derivative are left out, as they balance identically. If an energy jumps at a time, `ledger/h` "
            "contains the jump",
            lambda known: {
                "diagnostics/ledger/h": known.balance,
                **under("diagnostics/ledger/p", known.momenta(known.balance)),
            },
            also="ledgers balance balances",
        ),
        OutputRow(
            "action",
            "energies.action",
            "/diagnostics/action",
            "(n,)",
            "S = int L dt",
            lambda known: {"diagnostics/action": known.energy * known.time},
            also="S",
        ),
        OutputRow(
            "positions",
            "positions",
            "/positions/PARTICLE",
            "(n, d)",
            "r(q, t)",
            lambda known: under("positions", known.positions),
            of_particles=True,
            also="position r xyz trajectory trajectories path paths",
        ),
        OutputRow(
            "reactions",
            "reactions",
            "/reactions/PARTICLE",
            "(n, d)",
            "the force of constraint on each particle, m a - F with the applied force F, -dU/dr included; "
            "it is known where U and the forces are written in positions",
            lambda known: under("reactions", {name: known.energy / r for name, r in known.positions.items()}),
            of_particles=True,
            also="reaction tension tensions force forces "
            "normal normal_force normal_forces constraint_forces forces_of_constraint",
        ),
        OutputRow(
            "angular_velocities",
            "rotations.velocities",
            "/angular_velocities/BODY",
            "(n, 3)",
            "the angular velocity of each rigid body, in space",
            lambda known: under("angular_velocities", of_bodies(known, known.time / known.time / known.time)),
            section="bodies",
            of_particles=True,
        ),
        OutputRow(
            "angular_momenta",
            "rotations.momenta",
            "/angular_momenta/BODY",
            "(n, 3)",
            "its angular momentum about its centre of mass, in space",
            lambda known: under("angular_momenta", of_bodies(known, known.energy * known.time)),
            section="bodies",
            of_particles=True,
        ),
        OutputRow(
            "rotational_energies",
            "rotations.energies",
            "/rotational_energies/BODY",
            "(n,)",
            "the kinetic energy of its rotation",
            lambda known: under("rotational_energies", of_bodies(known, known.energy)),
            section="bodies",
            of_particles=True,
        ),
        OutputRow(
            "orientations",
            "rotations.orientations",
            "/orientations/BODY",
            "(n, 3, 3)",
            "the matrix R, whose columns are the body's axes in space",
            lambda known: {},
            section="bodies",
            of_particles=True,
        ),
        OutputRow(
            "multipliers",
            "multipliers",
            "/multipliers/NAME",
            "(n,)",
            "the Lagrange multiplier of each constraint; the generalized forces of a constraint f are "
            "lambda df/dq_k, those of a nonholonomic one g are lambda dg/dq_dot_k",
            lambda known: under("multipliers", known.multipliers),
            section="all_constraints",
            also="multiplier lambda lambdas lagrange_multipliers",
        ),
        OutputRow(
            "constraints",
            "constraints",
            "/diagnostics/constraints/NAME",
            "(n,)",
            "the value of each constraint, which should be 0",
            lambda known: under(
                "diagnostics/constraints", {**known.constraints, **known.velocity_constraints}
            ),
            section="all_constraints",
            also="constraint residuals residual",
        ),
        OutputRow(
            "conserved",
            "conserved",
            "/diagnostics/conserved/NAME",
            "(n,)",
            "everything that `check` finds to be conserved: h, p_k, total momentum, angular momentum, ...",
            lambda known: under("diagnostics/conserved", conserved_quantities(known)),
            also="conserved_quantities invariants integrals",
        ),
        OutputRow(
            "observables",
            "observables",
            "/observables/NAME",
            "(n,)",
            "as declared in the file",
            lambda known: under("observables", known.observables),
            default=True,
            section="observables",
            also="observable",
        ),
    )
}
"""The outputs by name, in the order of their datasets in the file. Sample times ``t`` are always written."""

DEFAULT_OUTPUTS = tuple(row.name for row in OUTPUTS.values() if row.default and not row.section)
"""The outputs that every system has by default."""
PARTICLE_OUTPUTS = frozenset(row.name for row in OUTPUTS.values() if row.of_particles)
"""The outputs of systems that are given by particles, not by a Lagrangian."""
