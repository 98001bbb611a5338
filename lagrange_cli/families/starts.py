"""Initial values as the file has them, expressions in parameters: each once for all members alike."""

from __future__ import annotations

import numpy as np

from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import Source, Term, Total
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.groups import Group, placed_parts
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.spec import Coordinate, Expression, Spec


def initial_state(spec: Spec) -> tuple[ChainBuilder, Total, Total]:
    """q and v at the start, 0 where the file gives nothing, and what they are built with. Raises ``Unsuited``
    where arrays do not know an expression."""
    builder = ChainBuilder(spec)
    terms: tuple[list[Term], list[Term]] = [], []
    first = 0
    for one in groups_of(spec.coordinates):
        for kind, made in zip(("initial", "velocity"), terms):
            if isinstance(one, Coordinate):
                written: Expression | None = getattr(one, kind)
                if written is not None:
                    value = builder.value(written.tree, Members(builder.root, 1, spec.sizes))
                    if isinstance(value, tuple):
                        raise Unsuited
                    made.append(Term(builder.root, value, np.array([first])))
                continue
            given = [
                part.of(getattr(part.item, kind))
                for part in one.parts
                if getattr(part.item, kind) is not None
            ]
            if given:
                made += listed(builder, placed_parts(one.family, given), first)
        first += 1 if isinstance(one, Coordinate) else len(one.family.members)
    count = builder.q.count
    q, v = (Total(Source.TOTAL, count, tuple(some)) for some in terms)
    return builder, q, v


def listed(builder: ChainBuilder, group: Group, first: int) -> list[Term]:
    """The values of a group's members, as terms from a place on."""
    found = []
    for domain, value, which in builder.pieces(group, np.flatnonzero(group.labels >= 0)):
        if isinstance(value, tuple):
            raise Unsuited
        found.append(Term(domain, value, first + which))
    return found
