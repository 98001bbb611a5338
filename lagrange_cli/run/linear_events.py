"""Whether implicit steps find the events of a system as surely as its motion.

Within a step coordinates are polynomials that are as precise as the tolerance. So are expressions that are
linear in coordinates and t: two zeros that are missed then are those of a motion that hardly touches 0.
Other expressions, such as sin(100 x), may be 0 twice where their own polynomial is not, and velocities that
are 0 at rest are rounding errors.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from lagrange_cli.expression.syntax import Binary, Call, Name, Negative, Number, Tree
from lagrange_cli.expression.vocabulary import TIME, family_name

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec


def are_linear(spec: Spec) -> bool:
    """Whether the expressions of all events are linear in coordinates and t, as far as their form shows."""
    moving = {TIME, *(family_name(one.name) for one in spec.coordinates)}
    fixed = {*spec.sizes, *(family_name(one.name) for one in spec.parameters)}
    trees = {one.when.tree for one in spec.events.values()}
    return all(degree(tree, moving, fixed) is not None for tree in trees)


def degree(tree: Tree, moving: Collection[str], fixed: Collection[str]) -> int | None:
    """0 for what does not move, 1 for what is linear in what is ``moving``; None for anything else."""
    if isinstance(tree, Number):
        return 0
    if isinstance(tree, Name):
        return 1 if tree.identifier in moving else 0 if tree.identifier in fixed else None
    if isinstance(tree, Negative):
        return degree(tree.operand, moving, fixed)
    if isinstance(tree, Call):
        return 0 if all(degree(one, moving, fixed) == 0 for one in tree.arguments) else None
    if not isinstance(tree, Binary):
        return None
    left, right = (degree(one, moving, fixed) for one in (tree.left, tree.right))
    if left is None or right is None:
        return None
    if tree.operator in ("+", "-"):
        return max(left, right)
    if tree.operator == "*":
        return left + right if left + right < 2 else None
    if tree.operator == "/":
        return left if right == 0 else None
    return 0 if left == right == 0 else None
