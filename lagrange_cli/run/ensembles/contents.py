"""What the file of an ensemble holds, and how its members ended."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.run.attributes import doubt_of_all, finite, origin, series_of
from lagrange_cli.run.singular import in_words

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.ensembles.ensemble import Ensemble
    from lagrange_cli.store.layout import Dimension, Series


def series(ensemble: Ensemble, prepared: Prepared, units: Mapping[str, str]) -> tuple[Series, ...]:
    """The datasets of the ensemble, in the file's order."""
    from lagrange_cli.expression.vocabulary import family_name
    from lagrange_cli.integrate.ensemble.datasets import drift_path
    from lagrange_cli.integrate.ensemble.outcome import STATUS
    from lagrange_cli.records import replace
    from lagrange_cli.store.layout import Series

    swept = {name for name, values in ensemble.members.axes if not isinstance(values, int)}
    found = [
        Series(path, unit=units.get(path, ""), long_name=one.description or f"parameter {one.name}")
        for one in ensemble.spec.parameters
        if one.name in ensemble.values.differing and one.name not in swept
        for path in (f"parameters/{one.name}",)
    ]
    for kind, text in (("q", "coordinate {}"), ("v", "velocity d{}/dt")):
        for family in ensemble.families:
            unit, name = units.get(f"{kind}/{family.name}", ""), f"initial {text.format(family.label)}"
            found.append(Series(f"initial/{kind}/{family.name}", family.shape, unit, name, axes=family.axes))
    change = "max |{0} - {0}(0)|" if ensemble.sampled else "|{0} - {0}(0)| at the end"
    found += [
        Series("t_end", unit=units.get("t", ""), long_name="time at which the member ended"),
        Series("steps", long_name="number of steps", kind="i8"),
        Series("status", long_name="status of the member", kind=STATUS),
        *(
            Series(path, (), units.get(family_name(path.replace("drift/", "", 1)), ""), change.format(name))
            for name in prepared.recording.conserved
            for path in (drift_path(name),)
        ),
    ]
    made = [replace(one, sampled=ensemble.sampled) for one in series_of(units, prepared)]
    if ensemble.cut is not None:
        found.append(Series("crossings", long_name="number of crossings", kind="i8"))
        made.insert(0, Series("t", unit=units.get("t", ""), long_name="time"))
    return (*(replace(one, sampled=False) for one in found), *made)


def dimensions(ensemble: Ensemble, units: Mapping[str, str]) -> tuple[Dimension, ...]:
    """The dimensions that the members span: a parameter's has its name, that of an initial value ``_0``
    behind it; ``row`` counts those of a table, ``draw`` the random ones."""
    from lagrange_cli.expression.vocabulary import family_name, velocity_name
    from lagrange_cli.store.layout import Dimension

    spec, found = ensemble.spec, []
    parameters = {one.name: one for one in spec.parameters}
    paths = {each.name: f"q/{family_name(each.name)}" for each in spec.coordinates}
    paths |= {velocity_name(each.name): f"v/{family_name(each.name)}" for each in spec.coordinates}
    for name, values in ensemble.members.axes:
        if isinstance(values, int):
            text = "row of the table" if name == "row" else "draw of the random numbers"
            found.append(Dimension(name, values, long_name=text))
        elif name in parameters:
            text, path = parameters[name].description or f"parameter {name}", f"parameters/{name}"
            found.append(Dimension(name, len(values), values, units.get(path, ""), text, path))
        else:
            unit = units.get(paths[name], "")
            found.append(Dimension(f"{name}_0", len(values), values, unit, f"initial {name}"))
    return tuple(found)


def made_by(ensemble: Ensemble) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file."""
    import binascii

    import numpy as np

    values, members = ensemble.values, ensemble.members
    described = {"shape": dict(members.shape), **members.described}
    checksum = 0
    exact = values.remainder
    rest = () if exact is None else (*exact.parameters.values(), *exact.q, *exact.v)
    for column in (*values.differing.values(), *values.q, *values.v, *rest):
        checksum = binascii.crc32(np.asarray(column, dtype="f8").tobytes(), checksum)
    sampled = ensemble.sampled and ensemble.cut is None
    return {
        **origin(ensemble.spec, ensemble.settings, values.common, f"crc32 {checksum:08x}", sampled),
        **({} if ensemble.cut is None else ensemble.cut.described),
        "sweep": json.dumps({name: value for name, value in described.items() if value not in ({}, None)}),
        "members": values.members,
    }


def told(
    ensemble: Ensemble, outcome: EnsembleOutcome, message: str, events: Mapping[str, int] | None = None
) -> dict[str, str | int | float]:
    """The root's attributes that say how the members ended, and how often ``events`` happened in all."""
    warning = doubt_of_all(outcome, ensemble.settings)
    return {
        "steps": outcome.steps,
        "status": outcome.status,
        "message": message,
        "h_drift": float("nan") if outcome.h_drift is None else outcome.h_drift,
        "p_drift": json.dumps(finite(outcome.p_drift)),
        **({} if warning is None else {"warning": warning}),
        **({"events": json.dumps(events_counted(events))} if events else {}),
    }


def events_counted(events: Mapping[str, int]) -> dict[str, Any]:
    """How often events happened, in terms of JSON: as of one motion, without what members do not share."""
    return {name: {"count": count} for name, count in events.items()}


def how_they_ended(ensemble: Ensemble, outcome: EnsembleOutcome) -> str:
    """How the members ended."""
    members, failed = ensemble.values.members, outcome.count("failed")
    stopped = outcome.count("stopped")
    if outcome.status == "complete" and stopped:
        return f"{members - stopped} of {members} members reached the end, events stopped {stopped}"
    if outcome.status == "complete":
        return "the member reached the end" if members == 1 else f"all {members} members reached the end"
    parts = []
    if outcome.status == "interrupted":
        parts.append(f"interrupted after {members - outcome.count('interrupted')} of {members} members")
    if outcome.failed is not None:
        member, how = outcome.failed
        how = ensemble.values.refused.get(member, in_words(ensemble.spec, how))
        own = ", ".join(f"{name} = {decimal(x[member])}" for name, x in ensemble.members.columns.items())
        those = "the first is member" if failed > 1 else "member"
        parts.append(f"{failed} of {members} members failed; {those} {member} ({own}): {how}")
    return "; ".join(parts)
