"""The edges of the domains of functions in the file, as u = 0 of sqrt(u).

What is made of an expression may have a value where it has none itself: the slope of log(u), the square of
the velocity of u**1.5. So they are found in the file as it is written. A branch of ``where`` may be
undefined: what stands in one does not count.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from lagrange_cli.expression.algebra import E
from lagrange_cli.expression.borders import borders, outside_branches
from lagrange_cli.expression.syntax import Name, Tree, ends_somewhere
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.content import groups_by_name, statements, written
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.whole import WrittenFamily


def built_edges(scope: Scope[E]) -> Iterator[E]:
    """What is positive within the domains of all functions that the equations of motion are made of."""
    spec, found = scope.spec, set[E]()
    every = [*spec.in_motion(written), *written(spec.all_constraints)]
    members = chain(spec.in_motion(lambda section: section.values()), spec.all_constraints.values())
    for each in chain(members, definitions_in(spec, every)):
        for border, indices in borders(each.tree, {**spec.sizes, **each.indices}, branches=False):
            if ends_somewhere(border.whole):
                inside = scope.builder.build(border.argument, indices)
                if len(border.ends) > 1:
                    inside = scope.algebra.number("1") - inside * inside
                if inside not in found:
                    found.add(inside)
                    yield inside


def counted(expression: Expression) -> Iterator[Tree]:
    """The parts of an expression that have to have a value."""
    return outside_branches(expression.tree)


def definitions_in(spec: Spec, expressions: Iterable[Expression]) -> Iterator[Expression]:
    """The definitions that ``expressions`` use."""
    groups, seen = groups_by_name(spec.definitions), set[str]()
    bases: dict[str, list[str]] = {}
    for name in groups:
        bases.setdefault(name.partition("[")[0], []).append(name)
    pending = [*expressions]
    while pending:
        used = {one.base for one in counted(pending.pop()) if isinstance(one, Name)}
        for name in (name for base in used - seen for name in bases.get(base, ())):
            one = groups[name]
            pending += statements(one)
            yield from one if isinstance(one, WrittenFamily) else [one]
        seen |= used
