"""The largest expression of a system file: where to look when the equations become too large."""

from __future__ import annotations

from collections.abc import Iterator

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.bounds import BoundsAlgebra
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Expression, Place, Spec

LEAST = 1000
"""Terms and factors below which an expression is not what makes a system large."""


@dataclass(frozen=True)
class Largest:
    """``size``: terms and factors with all definitions written out; ``place``: where it stands."""

    size: int
    place: Place


def largest_expression(spec: Spec) -> Largest | None:
    """The largest expression of a file that has been checked; None where all are small."""
    scope = Scope(spec, BoundsAlgebra())
    sizes = [Largest(size_of(scope.build(one)), one.at(one.tree.span)) for one in expressions(spec)]
    largest = max(sizes, key=lambda one: one.size)
    return largest if largest.size >= LEAST else None


def expressions(spec: Spec) -> Iterator[Expression]:
    """What the equations and the events are made of."""
    for section in (spec.embedding, spec.potential, *spec.forces.values()):
        yield from section.values()
    for body in spec.bodies.values():
        yield from body.expressions
    if spec.lagrangian is not None:
        yield spec.lagrangian
    for event in spec.events.values():
        yield from (event.when, *event.changes.values())


def size_of(value: Value) -> int:
    """The size of a scalar, or of all components of a vector."""
    return sum(one.size for one in (value if isinstance(value, tuple) else (value,)))
