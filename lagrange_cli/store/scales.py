"""Dimension scales: what the axes of a dataset count, attached to it and linked into its group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py

from lagrange_cli.store.layout import AXES, Layout, Series, labels


class Scales:
    """The scales of a layout's vectors and families in ``file``: ``/x``, ``/xy`` or ``/xyz`` name a vector's
    components, others, such as ``/N``, count the members of families, or list them, such as
    ``/gap_index``."""

    def __init__(self, file: Any, layout: Layout) -> None:
        self._components = {size: create_components(file, AXES[:size]) for size in layout.vector_sizes()}
        self._indices = {
            axis: create_index(file, name, labels(axis[1])) for axis, name in layout.indices().items()
        }

    def attach(self, dataset: Any, series: Series, *leading: Any) -> None:
        """Attach the scales of all axes of a series; ``leading`` are those of the first."""
        for number, scale in enumerate(leading):
            attach(dataset, number, scale)
        for number, axis in enumerate(series.indexed, len(leading)):
            attach(dataset, number, self._indices[axis])
        if series.components in self._components:
            last = len(leading) + len(series.shape) - 1
            attach(dataset, last, self._components[series.components])


def attach(dataset: Any, axis: int, scale: Any) -> None:
    """Make ``scale`` the coordinate of one axis, and link it into the dataset's group, so that a reader that
    opens that group finds it."""
    dataset.dims[axis].attach_scale(scale)
    link(dataset.parent, scale)


def link(group: Any, scale: Any) -> None:
    """Link ``scale`` into a group, unless it is there."""
    name = scale.name.rpartition("/")[2]
    if name not in group:
        group[name] = h5py.SoftLink(scale.name)


def describe(dataset: Any, series: Series) -> None:
    """Give a dataset its name and unit as attributes: ``unit`` as the system file writes it, and ``units`` as
    the CF conventions do, where UDUNITS knows it."""
    if series.unit:
        from lagrange_cli.model.units import udunits

        dataset.attrs["unit"] = series.unit
        spelled = udunits(series.unit)
        if spelled:
            dataset.attrs["units"] = spelled
    if series.long_name:
        dataset.attrs["long_name"] = series.long_name


def create_components(file: Any, letters: str) -> Any:
    """The dimension scale that names a vector's components."""
    axis = file.create_dataset(letters, data=list(letters), dtype=h5py.string_dtype())
    axis.attrs["long_name"] = "component"
    axis.make_scale(letters)
    return axis


def create_index(file: Any, name: str, members: Sequence[int | str]) -> Any:
    """The dimension scale that counts or lists the members of a family."""
    kind = h5py.string_dtype() if isinstance(members[0], str) else "i8"
    axis = file.create_dataset(name, data=members, dtype=kind)
    axis.attrs["long_name"] = "index" if kind == "i8" else "indices"
    axis.make_scale(name)
    return axis
