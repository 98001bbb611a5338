"""Which module says how the entries of a key act: a row for each key that ``spec.sections`` calls a force."""

from __future__ import annotations

from lagrange_cli.model.forces import applied, dissipation, generalized, torques
from lagrange_cli.model.forces.law import Law

FORCES: dict[str, Law] = {
    "forces": applied,
    "generalized_forces": generalized,
    "dissipation": dissipation,
    "torques": torques,
}
