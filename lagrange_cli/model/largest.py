"""The largest expression of a system file: where to look when the equations become too large."""

from __future__ import annotations

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.bounds import Bounds, BoundsAlgebra
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Place, Spec

LEAST = 1000
"""Terms and factors below which an expression is not what makes a system large."""


@dataclass(frozen=True)
class Largest:
    """``size``: terms and factors with all definitions written out; ``place``: where it stands."""

    size: int
    place: Place


class Sizes(Scope[Bounds]):
    """The sizes of the values of names."""

    def _rate(self, component: Bounds) -> Bounds:
        """A rate is about as long as what changes; it is 0 only where that is a number."""
        return component if component.value is None else Bounds(0.0)


def largest_expression(spec: Spec) -> Largest | None:
    """The largest expression of a file that has been checked; None where all are small."""
    scope = Sizes(spec, BoundsAlgebra())
    sizes = [Largest(size_of(scope.build(one)), one.at(one.tree.span)) for one in spec.moving_members]
    largest = max(sizes, key=lambda one: one.size)
    return largest if largest.size >= LEAST else None


def size_of(value: Value) -> int:
    """The size of a scalar, or of all components of a vector."""
    return sum(one.size for one in (value if isinstance(value, tuple) else (value,)))
