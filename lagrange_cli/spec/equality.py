"""Comparisons by ``==`` and ``!=`` that rounding may decide."""

from __future__ import annotations

from collections.abc import Iterator, Set

from lagrange_cli.expression.near import shown
from lagrange_cli.expression.syntax import Tree, equalities, is_whole, sums
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.spec.content import firsts_of, written
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Expression, Spec, by_family, distinct


def doubtful_equalities(spec: Spec) -> Iterator[tuple[Place, str]]:
    """The comparisons that are exact only if both sides have the same last digit, and the place of each.

    Whole numbers have no such digit: sizes, indices, and parameters that are given as whole numbers.
    """
    known = {*spec.sizes}
    for name, parameters in by_family((one.name, one.value) for one in firsts_of(spec.parameters)).items():
        if all(_is_whole(value.tree, known | value.indices.keys()) for value in parameters):
            known.add(name)
    for event in written(spec.events):
        known -= {one.key.name for one in event.sets if not _is_whole(one.value.tree, known)}
    for expression in distinct(expressions(spec)):
        for comparison in equalities(expression.tree):
            own = {*expression.indices, *(loop.index for loop, _ in sums(expression.tree))}
            if not all(_is_whole(one, known | own) for one in comparison.operands):
                span = comparison.span
                yield expression.at(span), shown(expression.excerpt(span))


def _is_whole(tree: Tree, names: Set[str]) -> bool:
    """Whether it is made of whole numbers and of ``names`` that are known to be some."""
    return is_whole(tree, lambda one: family_name(one.identifier) in names and "." not in one.identifier)


def expressions(spec: Spec) -> Iterator[Expression]:
    """Every expression of a file; of members of a family that are written alike the first."""
    yield from (one.value for one in firsts_of(spec.parameters))
    for one in firsts_of(spec.coordinates):
        yield from (given for given in (one.initial, one.velocity) if given is not None)
    for section in (spec.definitions, spec.masses, spec.observables, spec.solve.times):
        yield from written(section)
    yield from spec.moving
