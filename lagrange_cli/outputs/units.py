"""``find_units``: the unit of everything that a system's output holds, by dimension.

The unit of t is the one that the file states, or else the one that its units contain.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.model.quantity import BROKEN, Quantity
from lagrange_cli.model.survey import Conflict, Survey
from lagrange_cli.model.unit import WHOLE, Unit
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.model.units import is_pure, simplified, times_within
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import firsts_of
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.spec import Spec, by_family, has_units

UNNAMED = "the unit of t"
"""Stands for the unit of t where the file has no unit of time at all."""
UNNAMED_TIME = Unit(((UNNAMED, WHOLE),))


@dataclass(frozen=True)
class Units:
    """The units of a system's quantities, as texts, by the path of their dataset; and contradictions."""

    texts: Mapping[str, str] = field(default_factory=dict)
    conflicts: tuple[Conflict, ...] = ()


def find_units(spec: Spec) -> Units:
    """The units of the system's quantities."""
    if not has_units(spec):
        return Units()
    if spec.time_unit:
        survey = Survey(spec, read_unit(spec.time_unit))
        return Units(texts_of(survey), tuple(survey.conflicts))
    found, unclear = times_of(units_given(spec))
    if not found and not unclear:
        survey = Survey(spec, UNNAMED_TIME)
        return Units(texts_of(survey), tuple(one for one in survey.conflicts if UNNAMED not in one.message))
    if len(found) == 1:
        return with_time(spec, Unit(((found[0], WHOLE),)))
    survey = Survey(spec, None)
    if found:
        message = f"the units contain several units of time, {' and '.join(found)}: that of t is not clear"
        survey.conflicts.append(Conflict(WHOLE_FILE, message, f"add 'time: {{unit: {found[0]}}}'"))
    return Units(texts_of(survey), tuple(survey.conflicts))


def units_given(spec: Spec) -> set[str]:
    """The units that the file has; an empty text where one is not given."""
    return {one.unit for one in firsts_of(spec.parameters)} | {
        one.unit for one in firsts_of(spec.coordinates)
    }


def with_time(spec: Spec, time: Unit) -> Units:
    """The same where t seems to be in ``time``, unless another unit of time may be right: where that is why
    units differ by a factor."""
    survey = Survey(spec, time)
    conflicts = survey.conflicts
    if any(one.factor for one in conflicts):
        without = Survey(spec, None)
        doubtful = [one.factor and one not in without.conflicts for one in conflicts]
        if any(doubtful):
            hint = f"if t is not in {time}, add 'time: {{unit: ...}}'"
            conflicts = [
                replace(one, hint=one.hint or hint) if it else one for one, it in zip(conflicts, doubtful)
            ]
            if survey.energy.broken:
                without.energy = without.balance = BROKEN
            survey = without
    return Units(texts_of(survey), tuple(conflicts))


def times_of(texts: Iterable[str]) -> tuple[list[str], bool]:
    """The units of time that units contain, and whether there are others that say nothing of t."""
    found, unclear = set[str](), False
    for unit in map(read_unit, texts):
        if unit is not None:
            times, further = times_within(unit)
            found, unclear = found | times, unclear or further
    return sorted(found), unclear


def texts_of(survey: Survey) -> dict[str, str]:
    """The unit of each dataset that has one, by its path, and of each parameter."""
    spec, time = survey.spec, survey.time
    found = {"t": spec.time_unit or told(time)}
    for row in OUTPUTS.values():
        found |= {path: told(quantity) for path, quantity in row.units(survey).items()}
    for parameter in spec.parameters:
        unit = parameter.unit or told(survey.parameters[family_name(parameter.name)])
        found[f"parameters/{parameter.name}"] = unit
    for name, members in by_family((one.name, one) for one in firsts_of(spec.coordinates)).items():
        written = {one.unit for one in members}
        if len(written) == 1:
            found[f"q/{name}"] = written.pop() or found[f"q/{name}"]
    return {path: text for path, text in found.items() if text}


def told(quantity: Quantity) -> str:
    """The unit as it is written to the output; empty where it is not known, or a plain number."""
    unit = quantity.unit
    if unit is None or quantity.broken or quantity.number is not None or UNNAMED in unit.symbols:
        return ""
    if "rad" in unit.symbols:
        return str(unit)
    return "" if is_pure(unit) else str(simplified(unit))
