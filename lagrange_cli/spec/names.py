"""What each name of a system file means, and whether an expression may use it where it stands."""

from __future__ import annotations

from enum import Enum
from typing import Any

from lagrange_cli.expression.bounds import Bounds, BoundsAlgebra
from lagrange_cli.expression.build import build
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, Name, names
from lagrange_cli.expression.vocabulary import (
    ACCELERATION_SUFFIX,
    CALLABLE,
    COMPONENTS,
    CONSTANTS,
    RESERVED,
    VELOCITY_COMPONENTS,
)
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Expression


class Kind(Enum):
    """What an expression may depend on; the value is the word for it in messages."""

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
    them for a vector, and None where its own expression is wrong (that has been said, and nothing more is).
    """

    what: Kind
    kinds: frozenset[Kind]
    value: Any
    place: Place | None = None


@dataclass(frozen=True)
class Rule:
    """What the expressions of a section may depend on, and what to say when they do not keep to it."""

    allowed: frozenset[Kind]
    hint: str


_CONSTANT = frozenset({Kind.PARAMETER})
_CONFIGURATION = _CONSTANT | {Kind.COORDINATE, Kind.TIME}
_STATE = _CONFIGURATION | {Kind.VELOCITY}
_ALL = _STATE | {Kind.PARTICLE}
RULES: dict[str, Rule] = {
    "parameters": Rule(_CONSTANT, "a parameter is made of numbers and other parameters"),
    "coordinates": Rule(_CONSTANT, "an initial value is made of numbers and parameters"),
    "masses": Rule(_CONSTANT, "a mass is made of numbers and parameters"),
    "definitions": Rule(
        _STATE, "a definition is made of coordinates, velocities, t, parameters, definitions"
    ),
    "embedding": Rule(_CONFIGURATION, "an embedding is r(q, t): coordinates, t and parameters only"),
    "lagrangian": Rule(_STATE, "a lagrangian is L(q, q_dot, t)"),
    "potential": Rule(_ALL, ""),
    "forces": Rule(_ALL, ""),
    "generalized_forces": Rule(_ALL, ""),
    "dissipation": Rule(_ALL, ""),
    "observables": Rule(_ALL, ""),
}


class Names:
    """The table of names of one file."""

    def __init__(self, problems: Problems) -> None:
        self.problems = problems
        self.table: dict[str, Meaning] = {}

    def declare(self, name: str, what: Kind, place: Place | None, value: Any = None) -> bool:
        """Enter a name; it must be free."""
        if place is not None and name in RESERVED:
            self.problems.add(
                place, f"the name '{name}' is reserved", f"call the {what.value} {name}_ or another name"
            )
            return False
        other = self.table.get(name)
        if other is not None and place is not None:
            first = f" in line {other.place.line}" if other.place else ""
            self.problems.add(
                place,
                f"the {what.value} '{name}' has the name of a {other.what.value}",
                f"rename it, or the {other.what.value}{first}",
            )
            self.table[name] = replace(other, kinds=frozenset(), value=None)  # either may be meant
            return False
        self.table[name] = Meaning(what, frozenset({what}), value, place)
        return True

    def settle(self, name: str, kinds: frozenset[Kind], value: Any) -> None:
        """Say what a declared definition or particle came to."""
        self.table[name] = replace(self.table[name], kinds=kinds, value=value)

    def value(self, identifier: str) -> Any:
        """The bounds of a (dotted) name that has been checked."""
        base, _, component = identifier.partition(".")
        value = self.table[base].value
        if component:
            return value[(COMPONENTS + VELOCITY_COMPONENTS).index(component) % 3]
        return value

    def check(self, expression: Expression, section: str, where: str) -> tuple[frozenset[Kind], Any]:
        """What ``expression`` comes down to, and its bounds (None where something in it is wrong).

        Every unknown or forbidden name is reported; the shapes are looked at only if there is none.
        """
        kinds: frozenset[Kind] = frozenset()
        sound = True
        for name in names(expression.tree):
            if name.identifier in CONSTANTS:
                continue
            try:
                meaning = self._look_up(name, section)
            except ExpressionError as error:
                self.problems.add_expression(expression, error, where)
                sound = False
                continue
            kinds |= meaning.kinds
            sound = sound and meaning.value is not None
        if not sound:
            return kinds, None
        try:
            return kinds, build(expression.tree, self.value, BoundsAlgebra())
        except ExpressionError as error:
            self.problems.add_expression(expression, error, where)
            return kinds, None

    def _look_up(self, name: Name, section: str) -> Meaning:
        base, _, component = name.identifier.partition(".")
        meaning = self.table.get(base)
        if meaning is None and base in self.problems.broken:
            return Meaning(Kind.DEFINITION, frozenset(), None)
        if meaning is None:
            raise ExpressionError(name.span, *self._unknown(base))
        rule = RULES[section]
        forbidden = [kind for kind in Kind if kind in meaning.kinds - rule.allowed]
        if forbidden:
            via = ""
            if meaning.what is Kind.DEFINITION and forbidden[0] is not Kind.DEFINITION:
                via = (
                    f", which depends on a {forbidden[0].value},"
                    if forbidden[0] is not Kind.TIME
                    else ", which depends on t,"
                )
            raise ExpressionError(
                name.span, f"the {meaning.what.value} '{base}'{via} cannot be used", rule.hint
            )
        if component and meaning.value is not None:
            self._check_component(name, meaning, base, component)
        return meaning

    def _check_component(self, name: Name, meaning: Meaning, base: str, component: str) -> None:
        if not isinstance(meaning.value, tuple):
            raise ExpressionError(
                name.span, f"'{base}' is a scalar and has no component '{component}'", f"write {base}"
            )
        known = COMPONENTS[: len(meaning.value)]
        if meaning.what is Kind.PARTICLE:
            known += VELOCITY_COMPONENTS[: len(meaning.value)]
        if component not in known:
            raise ExpressionError(
                name.span,
                f"'{base}' has no component '{component}'",
                known_hint(f"{base}.{one}" for one in known),
            )

    def _unknown(self, name: str) -> tuple[str, str]:
        message = f"unknown name {shown(name)}"
        if name in CALLABLE:
            return f"the function '{name}' needs parentheses", f"write {name}(...)"
        if name.lower() in ("nan", "inf", "infinity"):
            return f"'{name}' is not a finite number", "write a number"
        if name.endswith(ACCELERATION_SUFFIX) and name.removesuffix(ACCELERATION_SUFFIX) in self.table:
            return f"the acceleration '{name}' cannot be used", "coordinates and velocities determine it"
        if name in ("π", "Pi", "PI"):
            return message, "write pi"
        if name in ("e", "E"):
            return message, "write exp(1) for Euler's number, or add it to the parameters"
        near = near_hint(name, [*self.table, *CONSTANTS])
        return message, near or known_hint(self.table) or "add it to the parameters"


def scalar() -> Bounds:
    """The bounds of a parameter, a coordinate, a velocity or the time."""
    return Bounds()
