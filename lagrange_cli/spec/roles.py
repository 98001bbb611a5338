"""What a name of a system file stands for, in a word: for messages where it is in a wrong place."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from lagrange_cli.expression.vocabulary import CONSTANTS, TIME, VELOCITY_SUFFIX, family_name
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.spec import Spec

SIZE, PARAMETER, COORDINATE, VELOCITY = "a size", "a parameter", "a coordinate", "a velocity"
ROLES = {
    "sizes": SIZE,
    "parameters": PARAMETER,
    "coordinates": COORDINATE,
    "definitions": "a definition",
    "embedding": "a particle",
    "bodies": "a body",
    "constraints": "a constraint",
    "nonholonomic": "a nonholonomic constraint",
    "observables": "an observable",
    "events": "an event",
}
"""By the section that a name is declared in."""


def role(spec: Spec, name: str) -> str:
    """What a name stands for in a system; empty for one that it does not have."""

    def declared(section: str) -> Iterable[str]:
        given = getattr(spec, section)
        return names_of(given) if section in ("parameters", "coordinates") else given

    return _role(declared, name)


def role_in_draft(draft: Draft, name: str) -> str:
    """The same, before sizes are known."""
    return _role(lambda section: [one.name for one in draft.sections.get(section, ())], name)


def _role(declared: Callable[[str], Iterable[str]], name: str) -> str:
    """The role of a name, of a member of a family, or of a component of a particle."""
    base = family_name(name).partition(".")[0]
    for section, word in ROLES.items():
        if base in map(family_name, declared(section)):
            return word
    moving = base.removesuffix(VELOCITY_SUFFIX)
    if moving != base and moving in map(family_name, declared("coordinates")):
        return VELOCITY
    return "the time" if base == TIME else "a constant" if base in CONSTANTS else ""
