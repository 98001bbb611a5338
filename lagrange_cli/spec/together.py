"""The numbers of all members of a family at once: the very ones that ``evaluation`` finds one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.array_builder import ArrayBuilder, Members
from lagrange_cli.expression.columns import ColumnAlgebra, numbers
from lagrange_cli.expression.index_arrays import Differ, Whole, flat, integers
from lagrange_cli.expression.index_loops import inner
from lagrange_cli.expression.indices import Indices, Unsuited
from lagrange_cli.expression.syntax import ExpressionError, Sum, Tree
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.spec.family import Family
from lagrange_cli.spec.members import indices_of
from lagrange_cli.spec.recurrence import addends, direction
from lagrange_cli.spec.whole import Part

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]


class Together(ArrayBuilder):
    """Builds expressions of numbers for many members. ``scope`` gives the numbers of names, ``families``
    those of complete families as arrays of their shape."""

    def __init__(
        self,
        scope: Callable[[str], Value],
        families: Callable[[str], Numbers | None],
        sizes: Indices,
        *,
        fades: bool,
    ) -> None:
        self.algebra: ColumnAlgebra
        super().__init__(scope, ColumnAlgebra(1), sizes, fades=fades)
        self.families = families

    def of_part(self, tree: Tree, part: Part[Any]) -> Numbers | None:
        """The numbers of the members of a part of a family (members,); None where they have to be found one
        by one, as where something is wrong."""
        try:
            return self._all(tree, {**self.sizes, **indices_of(part)}, part.count)
        except (Unsuited, Differ, ExpressionError, ArithmeticError):
            return None

    def of_sequence(self, tree: Tree, part: Part[Any], family: Family) -> Numbers | None:
        """The numbers of members that are sums of their neighbours and of what is added to these, as in
        ``x[i - 1] + a[i]``; None where they have to be found one by one. The scope is asked for the first."""
        indices: dict[str, Whole] = {**self.sizes, **indices_of(part)}
        shape = tuple(map(len, part.ranges))
        try:
            used, added = addends(tree, family.name)
            axis, step = direction(used, part, indices)
            terms = [self._all(one, indices, part.count) for one, _ in added]
            places = flat([integers(one, indices) for one in used.indices], family.shape, part.count)
        except (Unsuited, Differ, ExpressionError, ArithmeticError):
            return None
        signed = [-one if minus else one for one, (_, minus) in zip(terms, added)]
        rows = np.moveaxis(np.stack(signed, axis=-1).reshape(*shape, len(added)), axis, -2)[..., ::step, :]
        begins = np.moveaxis(places.reshape(shape), axis, -1)[..., ::step][..., :1]
        firsts = [self.scope(member_name(family.name, family.at(k))) for k in begins.ravel().tolist()]
        if not all(isinstance(one, float) for one in firsts):
            return None
        all_terms = [np.reshape(firsts, begins.shape), rows.reshape(*begins.shape[:-1], -1)]
        sums = np.cumsum(np.concatenate(all_terms, axis=-1), axis=-1)[..., len(added) :: len(added)]
        found = np.moveaxis(sums[..., ::step], -1, axis).ravel()
        return found if np.all(np.isfinite(found)) else None

    def _all(self, tree: Tree, indices: Mapping[str, Whole], count: int) -> Numbers:
        """The numbers that ``tree`` is for all members."""
        found, outer = np.empty(count), self.algebra
        for _, value, which in self.each(tree, indices, count):
            if isinstance(value, tuple):
                raise Unsuited
            found[which] = numbers(value)
            if np.any(self.algebra.failed):
                raise Unsuited
        self.algebra = outer
        if not np.all(np.isfinite(found)):
            raise Unsuited
        return found

    def domain(self, count: int) -> None:
        self.algebra = ColumnAlgebra(count, fades=self.fades)

    def number(self, value: Whole, members: Members) -> Value:
        return float(value) if isinstance(value, int) else self.algebra.column(value.astype(np.float64))

    def named(self, identifier: str, places: list[Whole], members: Members) -> Value:
        if not places:
            return self.scope(identifier)
        array = self.families(identifier)
        if array is not None:
            return self.algebra.column(array.ravel()[flat(places, array.shape, members.count)])
        if not all(isinstance(place, int) for place in places):
            raise Unsuited
        return self.scope(member_name(identifier, places))

    def summed(self, tree: Sum, members: Members) -> Value:
        stop = integers(tree.bounds[-1], members)
        shared = None if len(tree.bounds) > 2 else self.shared(tree, members)
        if shared is not None and all(isinstance(integers(one, members), int) for one in tree.bounds[:-1]):
            indices, own = shared
            partial = np.append(0.0, np.cumsum(self._all(tree.body, indices, len(own))))
            return self.algebra.column(partial[np.broadcast_to(np.searchsorted(own, stop), members.count)])
        found, owners = inner(tree, members, members.count)
        terms = self._all(tree.body, found, len(owners))
        total = np.full(members.count, -0.0)  # to which any number can be added without changing it
        np.add.at(total, owners, terms)  # one after the other
        total[np.bincount(owners, minlength=members.count) == 0] = 0.0
        return self.algebra.column(total)


def array_of(family: Family, known: Mapping[str, Any]) -> Numbers | None:
    """The values of a complete family, in its shape; None where some are not known, or no numbers."""
    if not family.complete:
        return None
    found = [*map(known.get, family.members)]
    if {*map(type, found)} != {float}:
        return None
    return np.array(found).reshape(family.shape)
