"""The outputs of a run: those that are asked for, or the default ones of the system."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import suggest
from lagrange_cli.outputs.catalog import OUTPUTS, PARTICLE_OUTPUTS

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

ALL = "all"
"""Every output that the system has."""


def default_outputs(spec: Spec) -> tuple[str, ...]:
    """The default outputs, which depend on the sections of the file."""
    rows = (row for row in OUTPUTS.values() if row.default)
    return tuple(row.name for row in rows if not row.section or getattr(spec, row.section))


def optional_outputs(names: Iterable[str]) -> frozenset[str]:
    """Those that ``all`` stands for, if it is among the names, and that are not named themselves."""
    asked = set(names)
    return frozenset(OUTPUTS).difference(asked) if ALL in asked else frozenset()


def resolve_outputs(names: Iterable[str], *, has_particles: bool) -> frozenset[str]:
    """The outputs asked for; ``all`` stands for every one that the system has."""
    known = frozenset(OUTPUTS) if has_particles else frozenset(OUTPUTS) - PARTICLE_OUTPUTS
    asked = set(names)
    for name in sorted(asked - known - {ALL, "t"}):
        if name in PARTICLE_OUTPUTS:
            without = f"a system given by its 'lagrangian' has no output {name!r}"
            raise UsageError(f"{without}: give it 'masses', 'positions' and 'potential'")
        words = [word for word in name.replace("&", " ").replace(";", " ").split() if word != "and"]
        meant = f"write {','.join(words)}" if len(words) > 1 and known.issuperset(words) else ""
        if other := next((one for one, row in OUTPUTS.items() if name in row.also.split()), ""):
            meant = f"write {other}"
        raise UsageError(f"unknown output {name!r}; {meant or suggest(name, (*OUTPUTS, ALL))}")
    return known if ALL in asked else frozenset(asked & known)
