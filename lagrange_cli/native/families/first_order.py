"""``@project`` of systems with coordinates without mass: their velocities follow from places, q_dot = f(q, t)
(see ``families.first_order``)."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.state import StateLayout


def project_velocities(
    evaluation: Evaluation,
    totals: Sequence[Total],
    velocities: Total,
    rows: Sequence[int],
    layout: StateLayout,
) -> str:
    """``@project(constants, state)``, in the function of the ``evaluation``: the ``velocities`` in these
    ``rows``, which follow from ``totals``."""
    f, vectors = evaluation.f, evaluation.vectors
    evaluation.write(totals)
    source, places = evaluation.where(velocities), evaluation.tables.of_places(rows)
    high = f.place("%state", layout.degrees, "double")
    low = f.place("%state", layout.width + layout.degrees, "double")
    with f.loop(0, len(rows), tested=False) as i:
        k = place_at(f, i + places)
        f.store(f.load(vectors.parts_at(source, 0), k), high, k)
        rest = f.load(vectors.parts_at(source, 1), k) if vectors.parts > 1 else f.constant(0.0)
        f.store(rest, low, k)
    f.give()
    return f.text()
