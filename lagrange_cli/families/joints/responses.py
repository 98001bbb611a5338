"""Which constraints on chains and trees feel each other's forces: those with something of the same tree."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import NONE
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


MANY = (
    "more than {} constraints on one chain or tree",
    "give each link coordinates of its own, and the joints as holonomic constraints",
    "nonholonomic",
    "constraints",
)
"""What members are written out for, how to do without, and where it is."""


@dataclass(frozen=True, eq=False)
class Responses:
    """The constraints (entries, 2) of each entry of A M^-1 A^T on the diagonal and below. No constraint feels
    two of one ``color``: what forces of all of these do is found at once. ``trees`` (trees, colors) has the
    constraint of each color on each tree, ``NONE`` where there is none."""

    places: Places
    colors: Places
    trees: Places


def trees_of(joints: Articulation, coordinates: int) -> tuple[Sequence[Places], Places]:
    """The trees of all ``Articulation.places``, and of so many ``coordinates``, as numbers."""
    parents = joints.parents
    roots = np.where(parents == NONE, np.arange(joints.count), parents)
    while np.any(roots != roots[roots]):
        roots = roots[roots]
    ground = np.append(roots, NONE)
    found = np.full(coordinates, NONE, dtype=np.int64)
    for kind in joints.joints:
        if not kind.rows:
            continue
        own = np.full(kind.domain.count, NONE) if kind.parents is None else ground[kind.parents]
        if kind.nodes is not None:
            own = roots[kind.nodes]
        own = np.where(own == NONE, joints.count + kind.rows[0], own)
        for rows in kind.rows:
            found[rows] = own
    if joints.relative is not None:
        roots, found = joined(roots, found, joints.relative.before)
    _, numbers = np.unique(np.concatenate([roots, found]), return_inverse=True)
    nodes, moved = numbers[: joints.count], numbers[joints.count :]
    ends = joints.relative.chains.values() if joints.relative else ()
    return [*(nodes for _ in joints.nodes), *(np.append(moved, NONE)[one] for one in ends)], moved


def joined(nodes: Places, coordinates: Places, before: Places) -> tuple[Places, Places]:
    """The same trees, where those of coordinates and of the ones ``before`` them are one."""
    first = [*range(1 + max(int(one.max(initial=NONE)) for one in (nodes, coordinates)))]

    def root(tree: int) -> int:
        while first[tree] != tree:
            first[tree] = tree = first[first[tree]]
        return tree

    has = np.flatnonzero(before != NONE)
    for one, other in zip(coordinates[has].tolist(), coordinates[before[has]].tolist()):
        first[root(one)] = root(other)
    numbers = np.array([root(tree) for tree in range(len(first))], dtype=np.int64)
    return numbers[nodes], numbers[coordinates]


def responses(touched: Iterable[tuple[Places, Places]], count: int, forest: int, most: int) -> Responses:
    """The responses of ``count`` constraints, from their numbers and the trees that they touch, of a
    ``forest`` of so many. Raises ``Unsuited`` where there are more than ``most`` colors."""
    pairs = np.unique(np.concatenate([np.stack(one, axis=1) for one in touched]), axis=0)
    on_tree: dict[int, list[int]] = {}
    trees: list[list[int]] = [[] for _ in range(count)]
    for number, tree in pairs.tolist():
        on_tree.setdefault(tree, []).append(number)
        trees[number].append(tree)
    if any(len(one) > most for one in on_tree.values()):
        raise Unsuited(MANY[0].format(most), *MANY[1:])
    felt = [sorted({j for tree in trees[i] for j in on_tree[tree]}) for i in range(count)]
    colors = np.full(count, NONE, dtype=np.int64)
    taken: list[set[int]] = [set() for _ in range(forest)]
    for i in range(count):
        near = set[int]().union(*(taken[tree] for tree in {tree for j in felt[i] for tree in trees[j]}))
        colors[i] = color = next(color for color in range(len(near) + 1) if color not in near)
        for tree in trees[i]:
            taken[tree].add(color)
    if count and colors.max() >= most:
        raise Unsuited(MANY[0].format(most), *MANY[1:])
    owners = np.full((forest, int(colors.max()) + 1), NONE, dtype=np.int64)
    owners[pairs[:, 1], colors[pairs[:, 0]]] = pairs[:, 0]
    rows = [[j for j in felt[i] if j <= i] for i in range(count)]
    columns = np.array([j for row in rows for j in row], dtype=np.int64)
    places = np.stack([np.repeat(np.arange(count), [*map(len, rows)]), columns], axis=1)
    return Responses(places, colors, owners)
