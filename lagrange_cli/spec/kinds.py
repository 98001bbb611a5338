"""What the names of a system file stand for, and what the expressions of a section may depend on."""

from __future__ import annotations

from enum import Enum
from typing import Any

from lagrange_cli.records import dataclass
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
    DEFINITION = "definition"


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


CONSTANT = frozenset({Kind.PARAMETER})
CONFIGURATION = CONSTANT | {Kind.COORDINATE, Kind.TIME}
STATE = CONFIGURATION | {Kind.VELOCITY}
ANYTHING = Rule(STATE | {Kind.PARTICLE})
"""The rule of a section whose expressions may depend on the whole state."""
