"""How many terms the sums of a system have, before anything is built of them."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.index_arrays import Whole
from lagrange_cli.expression.index_loops import inner
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Sum, Tree, children
from lagrange_cli.spec.spec import Spec


def terms_of(spec: Spec) -> int:
    """The terms of all sums of the energies, loops within loops counted together; 0 where that cannot be
    told."""
    energies = [*spec.potential.values(), *([] if spec.lagrangian is None else [spec.lagrangian])]
    try:
        return sum(counted(one.tree, {**spec.sizes, **one.indices}, 1) for one in energies)
    except Unsuited:
        return 0


def counted(tree: Tree, indices: Mapping[str, Whole], count: int) -> int:
    """The terms of the sums in ``tree``, which ``count`` members have."""
    if not isinstance(tree, Sum):
        return sum(counted(part, indices, count) for part in children(tree))
    found, owners = inner(tree, indices, count)
    return max(len(owners), counted(tree.body, found, len(owners)))
