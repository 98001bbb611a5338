"""What a run can write: a row for each name of ``--outputs``.

A new output is a row and a module of ``outputs.datasets`` with a function ``plan``, as in ``momenta``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.model.dimensions import Quantity
    from lagrange_cli.model.survey import Survey


@dataclass(frozen=True)
class OutputRow:
    """An output: its ``name``, and the ``module`` that plans how it is computed.

    In the documentation, ``datasets`` are the paths of its datasets in the file, ``shape`` is that of each,
    and ``meaning`` what they hold, in Markdown. ``units`` gives the quantity of each by its path, that of a
    family as one. A ``default`` output is written unless other outputs are asked for; with ``section``, only
    if the file has that section. One ``of_particles`` does not exist where a system is given by its
    Lagrangian.
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


def under(path: str, quantities: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """The quantities of a group's datasets."""
    return {f"{path}/{name}": quantity for name, quantity in quantities.items()}


OUTPUTS = {
    row.name: row
    for row in (
        OutputRow(
            "q",
            "coordinates",
            "/q/NAME",
            "(n,)",
            "the coordinates",
            lambda known: under("q", known.coordinates),
            default=True,
        ),
        OutputRow(
            "v",
            "velocities",
            "/v/NAME",
            "(n,)",
            "their velocities",
            lambda known: under("v", known.velocities),
            default=True,
        ),
        OutputRow(
            "p",
            "momenta",
            "/diagnostics/p/NAME",
            "(n,)",
            "p_k = dL/dq_dot_k",
            lambda known: under("diagnostics/p", known.momenta(known.energy)),
            default=True,
        ),
        OutputRow(
            "h",
            "energy_function",
            "/diagnostics/h",
            "(n,)",
            "the energy function, sum q_dot_k p_k - L",
            lambda known: {"diagnostics/h": known.energy},
            default=True,
        ),
        OutputRow(
            "T",
            "kinetic_energy",
            "/diagnostics/T",
            "(n,)",
            "the kinetic energy",
            lambda known: {"diagnostics/T": known.energy},
            of_particles=True,
        ),
        OutputRow(
            "U",
            "potential",
            "/diagnostics/U",
            "(n,)",
            "the potential",
            lambda known: {"diagnostics/U": known.energy},
            of_particles=True,
        ),
        OutputRow(
            "energy",
            "total_energy",
            "/diagnostics/energy",
            "(n,)",
            "T + U",
            lambda known: {"diagnostics/energy": known.energy},
            of_particles=True,
        ),
        OutputRow(
            "ledger",
            "ledgers",
            "/diagnostics/ledger/h /diagnostics/ledger/p/NAME",
            "(n,)",
            "h(t) - h(0) + int dL/dt - int Q.q_dot, and p_k(t) - p_k(0) - int (dL/dq_k + Q_k): the "
            "*ledgers*, or balances of work and energy, and of force and momentum. They are zero for an "
            "exact solution of any system, driven or damped",
            lambda known: {
                "diagnostics/ledger/h": known.balance,
                **under("diagnostics/ledger/p", known.momenta(known.balance)),
            },
        ),
        OutputRow(
            "action",
            "action",
            "/diagnostics/action",
            "(n,)",
            "S = int L dt",
            lambda known: {"diagnostics/action": known.energy * known.time},
        ),
        OutputRow(
            "positions",
            "positions",
            "/positions/PARTICLE",
            "(n, d)",
            "r(q, t)",
            lambda known: under("positions", known.positions),
            of_particles=True,
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
        ),
    )
}
"""The outputs by name, in the order of their datasets in the file. Sample times ``t`` are always written."""

DEFAULT_OUTPUTS = tuple(row.name for row in OUTPUTS.values() if row.default and not row.section)
"""What is written of every system."""
PARTICLE_OUTPUTS = frozenset(row.name for row in OUTPUTS.values() if row.of_particles)
"""What a system has only if it is given by particles, not by a Lagrangian."""
