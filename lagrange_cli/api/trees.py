"""Motions as trees of xarray's datasets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import MissingPackage
from lagrange_cli.model.units import udunits
from lagrange_cli.store.layout import AXES, labels

if TYPE_CHECKING:
    import xarray

    from lagrange_cli.store.layout import Layout, Series


def tree_of(layout: Layout, rows: Mapping[str, np.ndarray], attributes: Mapping[str, Any]) -> xarray.DataTree:
    """The datasets of a layout with their ``rows`` by path, a node for each group.

    Raises ``MissingPackage`` where there is no xarray.
    """
    try:
        from xarray import DataArray, Dataset, DataTree
    except ImportError as error:
        raise MissingPackage("to_xarray", "xarray", "xarray") from error

    indices = layout.indices()

    def array_of(series: Series, times: Series) -> DataArray:
        """A dataset with its axes; ``times`` is that of the first."""
        axes = [indices[axis] for axis in series.indexed]
        components = [AXES[: series.components]] if series.components in (1, 2, 3) else []
        named = ["t", *axes, *components]
        dims = [*named, *(f"{series.path}_{i}" for i in range(1 + len(series.shape) - len(named)))]
        coordinates: dict[str, Any] = {"t": ("t", rows[times.path], described(times))}
        coordinates |= {name: [*AXES[: series.components]] for name in components}
        coordinates |= {axes[0]: [*labels(series.places)]} if series.places else {}
        return DataArray(rows[series.path], coordinates, dims, attrs=described(series))

    found: dict[str, dict[str, DataArray]] = {}
    for series in layout.series:
        if series.path in rows:
            place, _, name = series.path.rpartition("/")
            found.setdefault(f"/{place}", {})[name] = array_of(series, layout.time)
    for event in layout.events:
        times, *others = event.series
        for series in others:
            if series.path in rows:
                place, _, name = series.path.rpartition("/")
                found.setdefault(f"/{place}", {})[name] = array_of(series, times)
    nodes = {place: Dataset(arrays) for place, arrays in found.items()}
    nodes["/"] = nodes.get("/", Dataset()).assign_attrs(attributes)
    tree: xarray.DataTree = DataTree.from_dict(nodes)
    return tree


def described(series: Series) -> dict[str, str]:
    """A dataset's attributes, as the output file has them: the unit in the words of the system file, and in
    those of the CF conventions where UDUNITS knows it."""
    units = udunits(series.unit) if series.unit else ""
    said = {"unit": series.unit, "units": units, "long_name": series.long_name}
    return {name: text for name, text in said.items() if text}
