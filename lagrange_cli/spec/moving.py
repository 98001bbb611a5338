"""What a constraint must contain: a holonomic one coordinates, any other velocities."""

from __future__ import annotations

from collections.abc import Set

from lagrange_cli.spec.kinds import Kind

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
