"""The methods whose steps are taken on rates (``rates.steps``), by their names."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.native.rates.steps import RateSteps
    from lagrange_cli.native.stepping.coupling import Coupling
    from lagrange_cli.native.stepping.given import Given


def scheme_of(name: str) -> type[RateSteps]:
    """What the steps of a method are."""
    if name == "DOP853":
        from lagrange_cli.native.rates.dop853 import Dop853Steps

        return Dop853Steps
    if name == "Radau":
        from lagrange_cli.native.rates.radau import RadauSteps

        return RadauSteps
    from lagrange_cli.native.rates.gauss_radau import GaussRadauSteps

    return GaussRadauSteps


def on_rates(name: str, given: Given, coupling: Callable[[], Coupling], least: int) -> tuple[int, str]:
    """The doubles of ``%work``, at ``least`` so many, and IR of ``@advance`` and its helpers by the method of
    this name, on a function ``given.rates`` that has ``given.work`` for itself."""
    from lagrange_cli.native.stepping.advance import advance

    scheme = scheme_of(name)
    if scheme.implicit:
        given = replace(given, coupling=coupling())
    if not scheme.beside:  # errors of short steps are measured by more than what is so small
        given = replace(given, static="")
    work = max(least, scheme.places_of(given).jet + given.work)
    return work, advance(scheme(replace(given, work=work)))
