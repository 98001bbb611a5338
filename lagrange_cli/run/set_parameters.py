"""The parameters along a motion: what actions of events have set, found from its crossings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.drawing.along import Along
from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.model.build import build_model
from lagrange_cli.run.jumps import parameters_set
from lagrange_cli.spec.spec import Spec, grouped
from lagrange_cli.store.result import Result

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node

Array = np.ndarray
Crossing = tuple[float, Array, Array, "Mapping[str, Node]"]
"""t, q and v before an action, and what it sets."""
Rows = Callable[[str], "Array | None"]
"""The dataset of a path, such as events/cut/t; None where there is none."""


def of_output(result: Result) -> Rows:
    """The datasets of an output."""
    return lambda path: result.read(path) if path in result.held else None


def parameters_along(rows: Rows, spec: Spec, parameters: Mapping[str, float]) -> Along:
    """The parameters along a motion that began with ``parameters``, from the ``rows`` of its crossings.

    What an action sets to something that these do not tell, such as a multiplier, is not a number.
    """
    names = sorted(parameters_set(spec))
    if not names:
        return Along(parameters, np.empty(0), {})
    order = sorted(crossings(rows, spec, names), key=lambda one: one[0])
    now, found = dict(parameters), []
    for t, q, v, sets in order:
        state = dict(zip((one.name for one in spec.coordinates), q.tolist()))
        state |= dict(zip(map(velocity_name, [one.name for one in spec.coordinates]), v.tolist()))
        now |= set_to(sets, {**now, **state, TIME: t})
        found.append([now[name] for name in names])
    table = np.array(found).reshape(len(found), len(names))
    times = np.array([one[0] for one in order])
    return Along(parameters, times, dict(zip(names, table.T)))


def set_to(sets: Mapping[str, Node], known: Mapping[str, float]) -> dict[str, float]:
    """What an action sets, from the state before it."""
    try:
        return {name: float(evaluate([node], known)[0]) for name, node in sets.items()}
    except KeyError:
        return dict.fromkeys(sets, float("nan"))


def crossings(rows: Rows, spec: Spec, names: list[str]) -> Iterator[Crossing]:
    """Those of events whose actions set one of these parameters."""
    families = spec.coordinate_families
    coordinates = [one.name for one in grouped((one.name for one in spec.coordinates), families)]
    for event in build_model(spec, GraphAlgebra()).events:
        sets = {name: node for name, node in event.changes.items() if name in names}
        at = f"events/{event.name.partition('[')[0]}"
        times = rows(f"{at}/t") if sets else None
        if times is None:
            continue
        own = np.full(len(times), fill_value=True)
        for index, number in spec.events[event.name].indices.items():
            numbers = rows(f"{at}/{index}")
            own &= True if numbers is None else numbers == number
        q, v = (
            np.concatenate([known(rows(f"{at}/{kind}/{one}"), len(times)) for one in coordinates], 1)
            for kind in "qv"
        )
        for k in np.flatnonzero(own).tolist():
            yield float(times[k]), q[k], v[k], sets


def known(values: Array | None, count: int) -> Array:
    """The values (count, ...) of a coordinate or its members; not a number where there are none."""
    return np.full((count, 1), np.nan) if values is None else values.reshape(count, -1)
