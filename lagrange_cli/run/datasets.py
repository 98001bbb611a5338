"""The datasets of a run as they stand in the file, with their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.records import replace
from lagrange_cli.spec.spec import has_units

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.layout import Series


def units_of(spec: Spec) -> Mapping[str, str]:
    """The units of datasets by path; a file without any unit does not even import what finds them."""
    if not has_units(spec):
        return {}
    from lagrange_cli.outputs.units import find_units

    return find_units(spec).texts


def series_of(units: Mapping[str, str], prepared: Prepared) -> tuple[Series, ...]:
    """The datasets of the run, with their units."""
    from lagrange_cli.store.layout import Series

    found = [
        Series(
            dataset.path,
            dataset.shape,
            units.get(dataset.path, ""),
            dataset.long_name,
            dataset.axes,
            dataset.components,
        )
        for dataset in prepared.datasets
        if dataset.path != "t"
    ]
    if prepared.machine.program.parts > 1:
        from lagrange_cli.integrate.samples import LOW

        text = "low part of {}, to be added to /{}"
        found += [
            replace(one, path=LOW + one.path, long_name=text.format(one.long_name, one.path)) for one in found
        ]
    return tuple(found)
