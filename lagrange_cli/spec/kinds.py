"""What the names of a system file stand for, and what the expressions of a section may depend on."""

from __future__ import annotations

from collections.abc import Set
from enum import Enum
from typing import Any

from lagrange_cli.records import dataclass
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Family


class Kind(Enum):
    """What an expression may depend on; the value is the word for it in messages."""

    SIZE = "size"
    PARAMETER = "parameter"
    TIME = "time"
    COORDINATE = "coordinate"
    VELOCITY = "velocity"
    PARTICLE = "particle"
    BODY = "body"
    DEFINITION = "definition"
    MULTIPLIER = "multiplier"


@dataclass(frozen=True)
class Meaning:
    """What a name stands for.

    ``what`` is the word for it, ``kinds`` what it comes down to, ``value`` its ``Bounds`` or a tuple of
    them for a vector (of a family: that of any member), and None where its own expression is wrong (that has
    been said, and nothing more is). ``family`` is there if the name is that of a family.
    """

    what: Kind
    kinds: frozenset[Kind]
    value: Any
    place: Place | None = None
    family: Family | None = None


@dataclass(frozen=True)
class Rule:
    """What the expressions of a section may depend on, and the hint where one depends on more."""

    allowed: frozenset[Kind]
    hint: str = ""


def comes_to(what: Kind) -> frozenset[Kind]:
    """The kinds that a name of one kind comes down to by itself: a body is used like a particle."""
    return frozenset({Kind.PARTICLE if what is Kind.BODY else what})


CONSTANT = frozenset({Kind.PARAMETER})
CONFIGURATION = CONSTANT | {Kind.COORDINATE, Kind.TIME}
PLACES = CONFIGURATION | {Kind.PARTICLE}
STATE = CONFIGURATION | {Kind.VELOCITY}
ANYTHING = Rule(STATE | {Kind.PARTICLE, Kind.MULTIPLIER})
"""The rule of a section whose expressions may depend on the whole state, and on forces of constraint."""
SOURCE = Rule(
    STATE | {Kind.PARTICLE},
    "multipliers follow from energies and constraints: forces, observables and events may use them",
)
"""The rule of one whose expressions multipliers follow from."""

NO_COORDINATE = "constraint '{}' contains no coordinate", "write an expression in coordinates that stays 0"
NO_VELOCITY = (
    "nonholonomic constraint '{}' contains no velocity",
    "write it under 'constraints', if coordinates obey it",
)
"""The messages, for a name, and the hints."""
_NEEDED = {"constraints": (Kind.COORDINATE, NO_COORDINATE), "nonholonomic": (Kind.VELOCITY, NO_VELOCITY)}


def lacking(section: str, kinds: Set[Kind]) -> tuple[str, str] | None:
    """The message and the hint for a constraint that contains these kinds of names, and not what one of its
    section needs; None where nothing is lacking, as far as the names show."""
    if section not in _NEEDED:
        return None
    needed, said = _NEEDED[section]
    return None if kinds & {needed, Kind.PARTICLE, Kind.BODY} else said


def called(written: Written, what: Kind) -> str:
    """What messages call something that is written."""
    label = written.key.label
    if what is Kind.BODY:
        return f"position of body '{label}'"
    return f"position of '{label}'" if what is Kind.PARTICLE else f"{what.value} '{label}'"
