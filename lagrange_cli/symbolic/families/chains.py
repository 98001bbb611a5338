"""What follows from member to member, as sums: x[i] = x[i - 1] + s[i] is the sum of s[j] up to j = i.

Along a tree it is the sum of path[i, j]*s[j], where path[i, j] is 1 for i, its parent, the parent of that and
so on, and 0 for all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import count
from typing import Any

import numpy as np
import sympy

from lagrange_cli.expression.index_arrays import integers
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Binary, Sum, Tree, names, plain_names
from lagrange_cli.families.arrays import NONE, tree_of
from lagrange_cli.families.groups import Group, components_in
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.families.builder import WrittenBuilder
from lagrange_cli.symbolic.families.frames import Frame, Split
from lagrange_cli.symbolic.families.pieces import PARENT, Piece, begun, merged, parted
from lagrange_cli.symbolic.families.sums import telescoped
from lagrange_cli.symbolic.indexed.conditions import Loop, changed, holds, relation
from lagrange_cli.symbolic.indexed.members import Summed, member, renamed
from lagrange_cli.symbolic.indexed.whole import Whole, named, number

PATH = "path"


@dataclass(frozen=True, eq=False)
class Path:
    """The matrix with 1 at [i, j] where j is i, its parent, or one further on the way to the root; the
    members in ``loops`` have these ``parents``, all others none."""

    name: str
    size: Whole
    loops: tuple[Loop, ...]
    parents: tuple[Whole, ...]
    table: Any


@dataclass(frozen=True, eq=False)
class Chain:
    """One component of members that follow from one another: from the one before (``step`` -1), the one after
    (1), or along a ``path``; all of them begin at ``start``."""

    start: sympy.Expr
    pieces: tuple[Piece, ...]
    step: int
    path: Path | None


class WrittenChains(WrittenBuilder):
    """A builder that knows chains and trees."""

    def __init__(self, spec: Spec) -> None:
        super().__init__(spec)
        self.paths: list[Path] = []
        self._chains: dict[Group, tuple[Chain, ...] | None] = {}
        self._growing: list[tuple[Group, int]] = []

    def of_group(self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Any:
        group = self.own(group)
        for growing, parts in self._growing:
            if growing is group:
                return together([member(PARENT.format(k), wholes) for k in range(parts)])
        chains = self.chained(group)
        if chains is None:
            return super().of_group(group, wholes, values, frame)
        return together([self.along(one, wholes[0], values[0], frame) for one in chains])

    def own(self, group: Group) -> Group:
        """The group of this name in expressions, if it is the same: members may follow from one another."""
        own = self.groups.get(group.family.name, group)
        same = len(own.trees) == len(group.trees) and all(a is b for a, b in zip(own.trees, group.trees))
        return own if same else group

    def follows(self, group: Group) -> bool:
        """Whether all members are one sum, however they are written."""
        chains = self.chained(self.own(group))
        return chains is not None and all(len(one.pieces) == 1 for one in chains)

    def chained(self, group: Group) -> tuple[Chain, ...] | None:
        """The components of members that follow from one another; None if they do not."""
        if group not in self._chains:
            follows = len(group.family.shape) == 1 and any(
                one.identifier.partition(".")[0] == group.family.name and plain_names(one.indices[0])
                for tree in group.trees
                for one in names(tree)
                if one.indices
            )
            known, self._chains[group] = len(self.paths), None
            if follows:
                try:
                    self._chains[group] = tuple(self.grown(group))
                except (Unsuited, Split):
                    del self.paths[known:]
        return self._chains[group]

    def grown(self, group: Group) -> Iterator[Chain]:
        """The same. Raises ``Unsuited`` where they follow in another way than by an addition."""
        parts = max(components_in(tree, self.groups, group) for tree in group.trees)
        pieces: list[list[Piece]] = [[] for _ in range(parts)]
        with self.growing(group, parts):
            for kind in self.of_family(group):
                for loops, value in self.kinds(kind.loops, kind.frame, self.building(kind.tree)):
                    listed = value if isinstance(value, tuple) else (value,)
                    if len(listed) != parts:
                        raise Unsuited
                    for k, (one, own) in enumerate(zip(listed, pieces)):
                        if loops:
                            own.append(Piece(loops[0], *parted(one, k)))
                        else:
                            own.append(self.single(kind.indices[0], *parted(one, k)))
        for own in pieces:
            yield self.chain(group, sorted(own, key=lambda piece: piece.loop.start.value(self.sizes)))

    @contextmanager
    def growing(self, group: Group, parts: int) -> Iterator[None]:
        """A context in which a group's members stand for their parents."""
        self._growing.append((group, parts))
        try:
            yield
        finally:
            self._growing.pop()

    def single(self, place: Whole, added: sympy.Expr, parent: Whole | None) -> Piece:
        """The piece that one member is."""
        index = self.fresh("i", Frame({}, 1, {}, {}))
        return Piece(Loop(index, place, place + number(1)), added, parent)

    def chain(self, group: Group, pieces: Sequence[Piece]) -> Chain:
        """Pieces as one chain."""
        size = group.family.shape[0]
        parents = np.full(size, NONE, dtype=np.int64)
        every = np.arange(size)
        for one in pieces:
            if one.parent is not None:
                own = self.members(one.loop)
                parents[own] = one.parent.value({**self.sizes, one.loop.index: own})
        if np.any(parents < NONE) or np.any(parents >= size):
            raise Unsuited
        start, shown = begun(pieces) if np.sum(parents == NONE) == 1 else (sympy.S.Zero, pieces)
        if not one_path(parents, every):
            return Chain(start, tuple(merged(shown)), 0, self.path(group, pieces, parents))
        return Chain(start, tuple(merged(shown)), -1 if parents[0] == NONE else 1, None)

    def members(self, loop: Loop) -> Any:
        """The numbers that a loop runs through. Raises ``Unsuited`` if it has steps."""
        if loop.step != 1:
            raise Unsuited
        found = np.arange(loop.start.value(self.sizes), loop.stop.value(self.sizes))
        for one in loop.conditions:
            found = found[np.broadcast_to(holds(one, {**self.sizes, loop.index: found}), len(found))]
        return found

    def path(self, group: Group, pieces: Sequence[Piece], parents: Any) -> Path:
        """The path of a tree: trees that are alike have one."""
        for one in self.paths:
            if np.array_equal(one.table, parents):
                return one
        taken = {*self.taken, *(one.name for one in self.paths)}
        free = (PATH + str(k or "") for k in count())
        name = next(one for one in free if one not in taken)
        on = [one for one in pieces if one.parent is not None]
        tree_of(parents)
        made = Path(
            name, self.bound(group.family, 0, len(parents)), tuple(one.loop for one in on),
            tuple(one.parent for one in on if one.parent is not None), parents,
        )  # fmt: skip
        self.paths.append(made)
        return made

    def along(self, chain: Chain, place: Whole, values: Any, frame: Frame) -> sympy.Expr:
        """A component of the member at a ``place``, whose numbers are ``values``."""
        found = [chain.start]
        values = np.broadcast_to(values, frame.count)
        for piece in chain.pieces:
            outermost = piece is chain.pieces[0 if chain.step > 0 else -1]
            loop = self.up_to(piece.loop, chain.step, place, values, outermost=outermost)
            if loop is None:
                continue
            index = self.fresh(loop.index, frame, piece.added)
            body = renamed(piece.added, {loop.index: named(index)}, {})
            if chain.path is not None and not (
                piece.parent is None and np.sum(chain.path.table == NONE) == 1 == len(self.members(loop))
            ):
                body *= member(chain.path.name, [place, named(index)])
            mine = partial(Whole.with_names, known={loop.index: named(index)})
            conditions = tuple(changed(one, mine) for one in loop.conditions)
            found.append(self._over(Loop(index, loop.start, loop.stop, 1, conditions), body))
        return sympy.Add(*found)

    def up_to(self, loop: Loop, step: int, place: Whole, values: Any, *, outermost: bool) -> Loop | None:
        """The part of a loop up to a place, or from it on; None if that is nothing. No member is beyond the
        ``outermost`` loop."""
        first, last = loop.start.value(self.sizes), loop.stop.value(self.sizes) - 1
        if step < 0:
            if np.all(values < first):
                return None
            if np.any(values < first - 1):
                raise Split(relation(place, "<", loop.start))
            if not outermost and not np.any(values < last):
                return loop
            if np.any(values > last):
                raise Split(relation(place, "<=", loop.stop - number(1)))
            return Loop(loop.index, loop.start, place + number(1), 1, loop.conditions)
        if step > 0:
            if np.all(values > last):
                return None
            if np.any(values > last + 1):
                raise Split(relation(place, ">=", loop.stop))
            if not outermost and not np.any(values > first):
                return loop
            if np.any(values < first):
                raise Split(relation(place, ">=", loop.start))
            return Loop(loop.index, place, loop.stop, 1, loop.conditions)
        return loop

    def _value(self, tree: Tree, indices: Any) -> Any:
        made = super()._value(tree, indices)
        if not isinstance(tree, Binary):
            return made
        known = {**self.sizes, **indices.arrays}
        if isinstance(made, tuple):
            return tuple(shortened(one, known) for one in made)
        return shortened(made, known)

    # sums that go on from member to member

    def rounds(self, tree: Sum, frame: Frame, index: str, names: Mapping[str, Whole]) -> Frame:
        """Where the terms of a sum stand; of one that goes on from member to member, those of the longest."""
        moving = {name for name, one in frame.items() if isinstance(one, np.ndarray)}
        ends = [bool(moving & plain_names(bound)) for bound in tree.bounds]
        inside = moving & (plain_names(tree.body) - {tree.index})
        if sum(ends) != 1 or len(ends) > 2 or tree.conditions or inside:
            return super().rounds(tree, frame, index, names)
        bounds = [integers(one, frame) for one in tree.bounds]
        start, stop = (0, bounds[0]) if len(bounds) == 1 else bounds
        own = np.arange(np.min(start), np.max(stop), dtype=np.int64)
        values = {name: one for name, one in frame.items() if name not in moving}
        return Frame({**values, tree.index: own}, len(own), names, {index: own})


def one_path(parents: Any, every: Any) -> bool:
    """Whether each member follows from the one before, or each from the one after."""
    forward = np.array_equal(parents[1:], every[:-1]) and parents[0] == NONE
    return forward or (np.array_equal(parents[:-1], every[1:]) and parents[-1] == NONE)


def shortened(expression: sympy.Expr, known: Mapping[str, Any]) -> sympy.Expr:
    """The expression without differences of sums that have most of their terms in common."""
    if not expression.has(Summed):
        return expression
    return expression.replace(lambda one: one.is_Add and one.has(Summed), lambda one: telescoped(one, known))


def together(values: Sequence[sympy.Expr]) -> Any:
    """Components as a value."""
    return tuple(values) if len(values) > 1 else values[0]
