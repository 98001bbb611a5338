"""Parts of chains and trees that share coordinates are one joint; joints that are alike are one kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Chain, Domain, Slot, placed
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.joints.joints import Joints, Part, Weight

MOST = 4
"""Coordinates of a joint."""
ROUNDS = 4 * MOST
"""By then the coordinates of a joint have found each other."""


class Assembly:
    """Joins the parts that share coordinates; ``rows_of`` has the numbers of those in a slot, or None."""

    def __init__(
        self,
        builder: FamilyBuilder,
        chains: Sequence[Chain],
        parts: Sequence[Part],
        rows_of: Callable[[Slot], Places | None],
    ) -> None:
        self.builder, self.chains, self.parts, self.rows_of = builder, chains, parts, rows_of
        self.nodes, self.rows = chains[0].count if chains else 0, builder.q.count
        tree = chains[0].tree if chains else None
        self.parents = tree.parents if tree else np.zeros(0, dtype=np.int64)
        self.joint_of = self.joined()
        """The joint of each node, then of each coordinate."""

    def is_step(self, part: Part) -> bool:
        return part.mass is None

    def joined(self) -> Places:
        """Numbers of joints: nodes and coordinates that meet in a part have one."""
        ones, others = [], []
        for part in self.parts:
            tables = [one + self.nodes for one in part.tables]
            if self.is_step(part) and part.nodes is not None:
                tables.insert(0, part.nodes)
            ones += [tables[0]] * (len(tables) - 1)
            others += tables[1:]
        labels = np.arange(self.nodes + self.rows)
        if ones:
            one, other = np.concatenate(ones), np.concatenate(others)
            for _ in range(ROUNDS):
                before = labels.copy()
                np.minimum.at(labels, one, labels[other])
                np.minimum.at(labels, other, labels[one])
                if np.array_equal(before, labels):
                    break
            else:
                raise Unsuited
        if np.any(labels[: self.nodes] != np.arange(self.nodes)):
            raise Unsuited  # coordinates that move several nodes
        _, numbers = np.unique(labels, return_inverse=True)
        return np.asarray(numbers, dtype=np.int64)

    def columns(self, count: int) -> Iterator[tuple[Part, Places]]:
        """Parts, each at most once in a joint, and which of their members each joint has (-1: none)."""
        for part in self.parts:
            at = part.nodes if self.is_step(part) else part.tables[0] + self.nodes
            assert at is not None
            owners = self.joint_of[at]
            order = np.argsort(owners, kind="stable")
            ranked = owners[order]
            first = np.concatenate([[True], ranked[1:] != ranked[:-1]]) if len(ranked) else np.zeros(0, bool)
            starts = np.maximum.accumulate(np.where(first, np.arange(len(ranked)), 0))
            rank = np.arange(len(ranked)) - starts
            for k in range(int(rank.max(initial=-1)) + 1):
                member = np.full(count, NONE, dtype=np.int64)
                member[ranked[rank == k]] = order[rank == k]
                yield part, member

    def joints(self) -> Iterator[Joints]:
        """All joints, each kind together."""
        count = int(self.joint_of.max()) + 1
        node_of = np.full(count, NONE, dtype=np.int64)
        node_of[self.joint_of[: self.nodes]] = np.arange(self.nodes)
        sizes = np.bincount(self.joint_of[self.nodes :], minlength=count)
        if sizes.max(initial=0) > MOST:
            raise Unsuited
        columns = [*self.columns(count)]
        parent_of = np.full(count, NONE, dtype=np.int64)
        has_node = node_of != NONE
        parent_of[has_node] = self.parents[node_of[has_node]]
        own = np.zeros((len(columns), count), dtype=np.int64)
        for k, (part, member) in enumerate(columns):
            if self.is_step(part) or part.nodes is None:
                continue
            which = member != NONE
            hung = part.nodes[member[which]]
            mine = hung == node_of[which]
            leaf = ~has_node[which]
            known = parent_of[which]
            if np.any(~mine & ~leaf & (hung != known)) or np.any(leaf & (known != NONE) & (hung != known)):
                raise Unsuited
            parent_of[np.flatnonzero(which)[leaf]] = hung[leaf]
            own[k, which] = mine
        weighs = np.any(
            [one != NONE for part, one in columns if not self.is_step(part)] or [has_node & False], axis=0
        )
        hangs = (parent_of != NONE) | (
            has_node & ~weighs
        )  # what carries no weights may hang from nothing, too
        signature = np.array(
            [has_node, hangs, sizes, *(one != NONE for _, one in columns), *own], dtype=np.int64
        )
        _, kinds = np.unique(signature.T, axis=0, return_inverse=True)
        kinds = np.asarray(kinds).reshape(-1)
        for kind in range(int(kinds.max()) + 1):
            which = np.flatnonzero(kinds == kind)
            here = [(part, one[which], bool(own[k, which[0]])) for k, (part, one) in enumerate(columns)]
            here = [one for one in here if one[1][0] != NONE]
            yield self.kind(which, here, node_of[which], parent_of[which], int(sizes[which[0]]))

    def kind(
        self,
        which: Places,
        parts: Sequence[tuple[Part, Places, bool]],
        nodes: Places,
        parents: Places,
        size: int,
    ) -> Joints:
        """Joints that are alike."""
        domain, graph = Domain(len(which)), self.builder.graph
        moves = [graph.zero for _ in self.chains]
        weights: list[Weight] = []
        for part, members, _ in parts:
            if self.is_step(part) and part.component is not None:
                moves[part.component] = placed(self.builder.slots, part.node, domain, members)
        for part, members, own in parts:
            if part.mass is not None:
                move, mass = (
                    placed(self.builder.slots, one, domain, members) for one in (part.node, part.mass)
                )
                if own and part.component is not None:
                    move = moves[part.component] + move
                weights.append(Weight(part.component, move, mass))
        symbols: dict[Node, Places] = {}
        for node in (*moves, *(one.move for one in weights)):
            for symbol, slot in self.builder.slots.inside(node):
                rows = self.rows_of(slot)
                if rows is not None and np.all(rows != NONE):
                    symbols[symbol] = rows
        has_node = nodes[0] != NONE
        if len(symbols) != size or (not size and not has_node):
            raise Unsuited
        if not has_node and not size:
            raise Unsuited
        return Joints(
            domain, tuple(symbols.values()), tuple(symbols),
            None if np.all(parents == NONE) else np.where(parents == NONE, self.nodes, parents),
            nodes if has_node else None,
            tuple(moves) if has_node else (), tuple(weights),
        )  # fmt: skip
