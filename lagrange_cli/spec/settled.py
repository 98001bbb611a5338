"""The bounds of the values of names; those of families as a whole, as far as their members are alike."""

from __future__ import annotations

from typing import Any

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.spec.family import Family, Grid, MemberNames, Place
from lagrange_cli.spec.whole import Part


class Settled:
    """Bounds by name, or by the name of a member; None where what is named has a mistake."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}
        self._members: dict[str, dict[str, Any]] = {}
        """Those of them that are members of families, by family."""
        self._names: dict[str, MemberNames] = {}
        self._parts: dict[str, list[tuple[Part[Any] | None, Any]]] = {}
        """By family: parts, or None for the whole of it, and the bounds of their members."""

    def copy(self) -> Settled:
        """One that may go on by itself."""
        found = Settled()
        found._own, found._names = {**self._own}, {**self._names}
        found._members = {name: {**members} for name, members in self._members.items()}
        found._parts = {name: [*parts] for name, parts in self._parts.items()}
        return found

    def settle(self, name: str, value: Any) -> None:
        """Set the bounds of one name."""
        self._own[name] = value
        base, bracket, _ = name.partition("[")
        if bracket:
            self._members.setdefault(base, {})[name] = value

    def settle_part(self, family: Family, part: Part[Any] | None, value: Any) -> None:
        """Set those of the members of a part of a family, or of all members."""
        assert isinstance(family.members, MemberNames)
        self._names[family.name] = family.members
        self._parts.setdefault(family.name, []).append((part, value))

    def forget(self, name: str) -> None:
        """Remove a name."""
        del self._own[name]

    def __contains__(self, name: str) -> bool:
        return name in self._own or self._of_part(name) is not None

    def __getitem__(self, name: str) -> Any:
        """Raises ``KeyError`` for what is not settled yet."""
        if name in self._own:
            return self._own[name]
        found = self._of_part(name)
        if found is None:
            raise KeyError(name)
        part, place, value = found
        return value if part is None else bounds_at(value, part, place)

    def get(self, name: str) -> Any:
        """The same, or None."""
        try:
            return self[name]
        except KeyError:
            return None

    def _of_part(self, name: str) -> tuple[Part[Any] | None, Place, Any] | None:
        base = name.partition("[")[0]
        place = self._names[base].place(name) if base in self._names and base != name else None
        if place is None:
            return None
        parts = self._parts[base]
        return next(((part, place, x) for part, x in parts if part is None or part.has(place)), None)

    def of_family(self, family: Family) -> list[Any] | None:
        """The bounds that its members have; None where some are not settled yet."""
        parts = self._parts.get(family.name, [])
        found = [value for _, value in parts]
        if all(part is not None for part, _ in parts):
            own = self._members.get(family.name, {})
            found += own.values()
            if sum(part.count for part, _ in parts if part is not None) + len(own) != len(family.members):
                return None
        return found


def bounds_at(value: Any, part: Part[Any], place: Place) -> Any:
    """The bounds of one member of those that have been found together."""
    if isinstance(value, tuple):
        return tuple(bounds_at(one, part, place) for one in value)
    numbers = getattr(value, "numbers", None)
    if numbers is None:
        return value
    number = numbers if numbers.ndim == 0 else numbers[Grid(part.ranges).number(place)]
    return Bounds(float(number), value.size, value.depth, value.kind)
