"""The probable meaning of an unknown name, as a hint."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

from lagrange_cli.expression.confusions import (
    FORCES,
    MULTIPLIERS,
    NAMES,
    QUANTITIES,
    SWITCHES,
    VELOCITIES,
    parameter_example,
    rate_of,
    romanized,
)
from lagrange_cli.expression.near import known_hint, look_alike_hint, near_match, shown
from lagrange_cli.expression.syntax import Name
from lagrange_cli.expression.vocabulary import (
    CALLABLE,
    COMPONENTS,
    CONSTANTS,
    FAMILY_WORDS,
    MULTIPLIER,
    VELOCITY_COMPONENTS,
    velocity_name,
)
from lagrange_cli.records import dataclass
from lagrange_cli.spec.kinds import Kind, Meaning

VELOCITY = "write {0}.vx, {0}.vy, ... for the components of the velocity of {0}"
SHORT, LONGEST = 4, 12
"""Names shorter than this are like many others; longer ones are no products without operators."""


@dataclass(frozen=True)
class Unknown:
    """The names that an expression may contain: ``table`` by name, ``bound`` by the name of a constraint.

    ``allowed`` are the kinds that may stand in its section, ``indices`` those of its family. If ``ranged``, a
    name may be given a range instead of being declared. Observables may mean an output, the values of an
    energy. Names that are like no other are added to ``undeclared``.
    """

    table: Mapping[str, Meaning]
    bound: Mapping[str, Meaning]
    allowed: Collection[Kind]
    indices: Mapping[str, int]
    undeclared: set[str]
    ranged: bool = False
    section: str = ""

    def report(self, name: str) -> tuple[str, str]:
        """The message for an unknown name, and a hint."""
        message = f"unknown name {shown(name)}"
        if name in self.indices or name in CONSTANTS:
            return f"'{name}' is a number: it takes no index and has no components", f"write {name}"
        if name in (*CALLABLE, *FAMILY_WORDS):
            return f"missing parentheses after '{name}'", f"write {name}(...)"
        if name.lower() in ("nan", "inf", "infinity"):
            return f"'{name}' is not a finite number", "write a number"
        coordinate, order = rate_of(name, self._called(Kind.COORDINATE))
        if order > 1:
            return f"the acceleration '{name}' cannot be used", "the equations of motion determine it"
        if order:
            return message, f"write {velocity_name(coordinate)} for the velocity of {coordinate}"
        output, what = QUANTITIES.get(name, ("", ""))
        if output and self.section == "observables":
            return message, f"--outputs {output} writes the {what}; or add {name} to the parameters"
        if output in ("T", "U") and self.section in ("lagrangian", "potential"):
            return message, f"write out the {what}, here or as '{name}' under 'definitions'"
        if name.lower() in SWITCHES:
            return f"'{name}' is not a number", "write a number, such as 1 or 0, or an expression"
        if name in NAMES:
            return message, f"write {NAMES[name]}"
        if alike := self._alike(name):
            return message, alike
        if hint := self._of_particle(name) or self._other_notation(name) or self._run_together(name):
            return message, hint
        match = near_match(name, [*self._usable(), *self.indices, *CONSTANTS])
        family = self.table[match].family if match in self.table else None
        near = f"did you mean '{family.label if family else match}'?" if match else ""
        if (not near or len(name) < SHORT) and (factors := self._factors(name)):
            return message, f"write {'*'.join(factors)}"
        known = known_hint(self._words())
        declare = f"add it to the parameters: '{parameter_example(name)}'"
        if self.ranged:
            declare = f"give it a range: {{at: ..., {name}: [-1, 1]}}"
        if near and len(name) < 3:
            return message, f"{near} Or {declare}"
        if near:
            return message, near
        self.undeclared.add(name)
        return message, f"{known}; or {declare}" if known else declare

    def _alike(self, name: str) -> str:
        """A hint where a letter is from another alphabet than it seems, unless its name is that of a name."""
        spelled = romanized(name)
        if any(romanized(one) == spelled for one in self.table):
            return ""
        return look_alike_hint(name, [*self.table, *self.indices, *CONSTANTS])

    def _called(self, *kinds: Kind) -> list[str]:
        return [name for name, meaning in self.table.items() if meaning.what in kinds]

    def _has(self, particle: str, axis: int) -> bool:
        """Whether the position of a particle has that component, as far as it is known."""
        value = self.table[particle].value
        return not isinstance(value, tuple) or axis < len(value)

    def _of_particle(self, name: str) -> str:
        """A hint for ``y``, ``vy`` and ``v`` where these can only be those of a particle."""
        particles = self._called(Kind.PARTICLE, Kind.BODY)
        if not particles or Kind.PARTICLE not in self.allowed:
            return ""
        one = particles[0]
        axis = next((axis for axis in COMPONENTS if name in (axis, f"v{axis}")), "")
        if axis:
            having = [each for each in particles if self._has(each, COMPONENTS.index(axis))]
            return f"write {having[0]}.{name} for the {name} of {having[0]}" if having else ""
        if name in VELOCITIES:
            return VELOCITY.format(one)
        for one in particles:
            if name == velocity_name(one) or rate_of(name, [one])[1] == 1:
                return VELOCITY.format(one)
        return ""

    def _other_notation(self, name: str) -> str:
        """A hint where a name is another way to write a known one: ``theta``, ``y_bob``, ``m1``, ``x_i``."""
        spelled = romanized(name)
        for one, meaning in self.table.items():
            if romanized(one) == spelled:
                return f"did you mean '{one}'?"
            if meaning.family and name.startswith(one):
                index = name[len(one) :].lstrip("_")
                if index.isdecimal():
                    return meaning.family.hint(name)
                if index in self.indices:
                    return f"write {one}[{index}]"
                if len(index) == 1 and "_" in name[len(one) :]:  # perhaps the index of a sum
                    return f"did you mean '{one}[{index}]'?"
        for one, meaning in self.bound.items():
            if spelled in MULTIPLIERS or spelled in {
                spelling for word in FORCES for spelling in (f"{word}_{one}", f"{one}_{word}")
            }:
                return f"write {meaning.family.label if meaning.family else one}.{MULTIPLIER}"
        for one in self._called(Kind.PARTICLE, Kind.BODY):
            axis = name.removesuffix(one).rstrip("_") if name.endswith(one) else ""
            axis = axis or (name.removeprefix(one).lstrip("_") if name.startswith(one) else "")
            if axis in COMPONENTS + VELOCITY_COMPONENTS:
                return f"write {one}.{axis}"
        return ""

    def _run_together(self, name: str) -> str:
        """A hint where a name is a function with its argument, as in ``cosθ`` or ``sin2theta``."""
        for function in sorted(CALLABLE, key=len, reverse=True):
            found = re.fullmatch(rf"{function}([0-9]*)(.+)", name)
            if found and (found[2] in self.table or found[2] in CONSTANTS):
                return f"write {function}({f'{found[1]}*' if found[1] else ''}{found[2]})"
        return ""

    def _factors(self, name: str) -> list[str]:
        """The known names that were written without an operator, as in ``mgz``; empty if there are none."""
        known = {one: one for one, meaning in self.table.items() if not meaning.family}
        known = {one: one for one in known if self.table[one].what in self.allowed} | {
            one: one for one in CONSTANTS
        }
        particles = self._called(Kind.PARTICLE, Kind.BODY) if Kind.PARTICLE in self.allowed else []
        for axis in COMPONENTS if particles else ():
            known.setdefault(axis, f"{particles[0]}.{axis}")
        splits: list[list[str] | None] = [[], *([None] * len(name))]
        for stop in range(1, len(name) + 1 if len(name) <= LONGEST else 0):
            ways = (
                [*before, known[name[start:stop]]]
                for start in range(stop)
                if (before := splits[start]) is not None and name[start:stop] in known
            )
            splits[stop] = min(ways, key=len, default=None)
        found = splits[-1] or []
        return found if len({*found}) == len(found) > 1 else []  # mm is no square

    def _usable(self) -> list[str]:
        """All names that may be used here."""
        return [name for name, one in self.table.items() if one.kinds <= frozenset(self.allowed)]

    def _words(self) -> list[str]:
        """The same as they are written: families with an index."""
        families = ((name, self.table[name].family) for name in self._usable())
        return [family.label if family else name for name, family in families]


def end_of_differential(name: Name, text: str, table: Mapping[str, Meaning]) -> int:
    """Where ``dx/dt`` ends, of which an unknown ``name`` is the ``dx``; 0 for other names."""
    coordinates = (one for one, meaning in table.items() if meaning.what is Kind.COORDINATE)
    is_differential = name.identifier.startswith("d") and rate_of(name.identifier, coordinates)[1]
    if "dt" in table or not is_differential:
        return 0
    below = re.match(r"\s*/\s*dt2?\b", text[name.span.stop :])
    return name.span.stop + below.end() if below else 0
