"""Entries by name of the section ``draw``, members of families one by one: colours, sliders."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from lagrange_cli.expression.loops import places
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, plain_names
from lagrange_cli.expression.vocabulary import member_name, velocity_name
from lagrange_cli.limits import whole
from lagrange_cli.records import dataclass
from lagrange_cli.spec.draft import Draft, Written
from lagrange_cli.spec.draw.numbers import ends
from lagrange_cli.spec.draw.ranges import WrittenRange
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import by_family
from lagrange_cli.spec.wanted import Range

LINES = ("rods", "springs")
"""Words that ``colours`` has for all of a kind."""


@dataclass
class Named:
    """The draft, the table of names, and where problems go."""

    draft: Draft
    names: Names
    problems: Problems

    def colours(self, given: Sequence[Any], particles: Mapping[str, list[str]]) -> dict[str, str]:
        """Colours by name, of ``particles`` and of whatever else has a colour."""
        known = dict(particles)
        curves = self.draft.sections["draw"].get("curves") or ()
        others = [one.name for one in curves]
        others += [entry.name for entry in self.draft.entries("definitions")]
        if "lagrangian" in self.draft.sections:
            others += [one.name for one in self.draft.declared("coordinates")]
        for name, members in by_family((name, name) for name in (*others, *LINES)).items():
            known.setdefault(name, members)
        found: dict[str, str] = {}
        for one in sorted(given, key=lambda one: bool(one.key.axes)):  # members after their families
            for name in self.members(one, known, "name", "colours"):
                found[name] = one.colour
        return {name: colour for name, colour in found.items() if colour}

    def sliders(self, given: Sequence[WrittenRange]) -> dict[str, Range]:
        """Ranges by name."""
        parameters = [one.name for one in self.draft.declared("parameters")]
        coordinates = [one.name for one in self.draft.declared("coordinates")]
        every = (*parameters, *coordinates, *map(velocity_name, coordinates))
        known = by_family((name, name) for name in every)
        found: dict[str, Range] = {}
        for one in given:
            members = self.members(one, known, "name", "sliders")
            if one.ends is not None:
                limits = ends(self.names, one.ends, f"slider '{one.key.label}'")
                found |= dict.fromkeys(members, limits)
        return found

    def members(
        self, one: Written, known: Mapping[str, Collection[str]], what: str, where: str
    ) -> Sequence[str]:
        """The names that a key stands for, which must be known; a family's name for all of its members."""
        base, axes = one.name, one.key.axes
        if base in self.problems.broken:
            return ()
        members = known.get(base)
        if members is None:
            hint = near_hint(base, known) or known_hint(known)
            self.problems.add_once(one.place, f"unknown {what} {shown(base)} in {where}", hint)
            return ()
        if not axes:
            return [*members]
        try:
            those, every = places(axes, self.names.sizes, whole("members")), frozenset(members)
            found = [member_name(base, place) for place, _ in those]
            for name in found:
                if name not in every:
                    first, *_, last = [*members, *members]
                    raise ExpressionError(axes[0].span, f"no member '{name}'", f"there are {first} to {last}")
        except ExpressionError as error:
            if not any(plain_names(bound) & self.problems.broken for axis in axes for bound in axis.bounds):
                self.problems.add_once(one.at(error.span), f"{error.message} in {where}", error.hint)
            return ()
        return found
