"""The section ``definitions``: positions of particles may use some of them, and others contain particles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from lagrange_cli.expression.syntax import names
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import groups_of, statements
from lagrange_cli.spec.draft import Draft, Entry
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.order import leading_to
from lagrange_cli.spec.settling import Settling
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.whole import WrittenFamily

Groups: TypeAlias = "Mapping[str, Entry | WrittenFamily[Entry]]"


def definitions_of(draft: Draft, known: Names, settling: Settling) -> tuple[Groups, Groups]:
    """The definitions of a file that positions may use, and those that contain particles, each after those
    that it uses; cycles are reported."""
    entries = draft.entries("definitions")
    defined = {family_name(one.name) for one in groups_of(entries)}
    particles = {name for name, one in known.table.items() if one.what in (Kind.PARTICLE, Kind.BODY)}
    made = {name: used & defined for name, used in made_of(draft).items() if name in particles}
    groups = settling.in_order(entries, Kind.DEFINITION, made)
    last = leading_to({name: settling.uses(one) for name, one in groups.items()}, particles)
    for name in last:
        if settling.stands_for(name, Kind.DEFINITION):  # positions that use it are told why they may not
            known.table[name] = replace(known.table[name], kinds=frozenset({Kind.PARTICLE}))
    others = {name: one for name, one in groups.items() if name not in last}
    return others, {name: groups[name] for name in last}


def made_of(draft: Draft) -> dict[str, set[str]]:
    """The names that positions of particles, and positions and orientations of bodies, are made of."""
    given: list[tuple[str, Expression | None]] = []
    for group in groups_of(draft.entries("embedding")):
        given += ((group.name, one.value) for one in statements(group))
    for bodies in groups_of(draft.bodies):
        for body in statements(bodies):
            turned = () if body.orientation is None else body.orientation.entries
            given += ((bodies.name, one) for one in (body.position, *turned))
    found: dict[str, set[str]] = {}
    for name, expression in given:
        used = set() if expression is None else {one.base for one in names(expression.tree)}
        found.setdefault(family_name(name), set()).update(used)
    return found
