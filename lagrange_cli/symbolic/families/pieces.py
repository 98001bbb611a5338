"""What members of a chain or a tree add to their parents, in pieces with an expression each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed, renamed
from lagrange_cli.symbolic.indexed.whole import Whole, named, number
from lagrange_cli.symbolic.work import size_of

PARENT = "@{}"
"""What stands for a component of a member's parent, while the member is built."""


@dataclass(frozen=True)
class Piece:
    """``added`` to the ``parent`` (None: to nothing), for the members whose index is that of the ``loop``."""

    loop: Loop
    added: sympy.Expr
    parent: Whole | None


def parted(value: sympy.Expr, component: int) -> tuple[sympy.Expr, Whole | None]:
    """What is added to the parent, and which that is."""
    found = [one for one in value.free_symbols if KNOWN.get(one.name, ("", ()))[0].startswith(PARENT[0])]
    if not found:
        return value, None
    (base, indices), rest = KNOWN[found[0].name], sympy.expand_mul(value) - found[0]
    if len(found) > 1 or base != PARENT.format(component) or found[0] in rest.free_symbols:
        raise Unsuited
    return rest, indices[0]


def begun(pieces: Sequence[Piece]) -> tuple[sympy.Expr, Sequence[Piece]]:
    """What the only root has besides what all members add, and pieces without it."""
    (root,) = [one for one in pieces if one.parent is None]
    beside = [one for one in pieces if one.parent is not None][:1]
    for one in beside:
        usual = added_at(one, root.loop.start)
        rest = sympy.expand_mul(root.added) - sympy.expand_mul(usual)
        there = rest.free_symbols <= root.added.free_symbols  # no members from before the root
        if there and size_of(rest) < size_of(root.added):
            return rest, [Piece(p.loop, usual, None) if p is root else p for p in pieces]
    return sympy.S.Zero, pieces


def merged(pieces: Sequence[Piece]) -> Iterator[Piece]:
    """Pieces beside each other that are alike as one."""
    last: Piece | None = None
    for piece in pieces:
        together = None if last is None else joined(last, piece)
        if last is not None and together is None:
            yield last
        last = piece if together is None else together
    if last is not None:
        yield last


def joined(one: Piece, other: Piece) -> Piece | None:
    """Two pieces as one, if the second follows the first, and what is added to a single member is what is
    added to all others, too."""
    loops = one.loop, other.loop
    if loops[0].stop != loops[1].start or loops[0].conditions or loops[1].conditions:
        return None
    alone = [loop.stop - loop.start == number(1) for loop in loops]
    general = one if alone[1] and not alone[0] else other
    single = one if general is other else other
    place = single.loop.start if any(alone) else named(single.loop.index)
    if added_at(one, place) != added_at(other, place):
        return None
    return Piece(Loop(general.loop.index, loops[0].start, loops[1].stop), general.added, general.parent)


def added_at(piece: Piece, place: Whole) -> sympy.Expr:
    """What is added at a place, where sums may have one term."""
    found = renamed(piece.added, {piece.loop.index: place}, {})
    return found.replace(lambda one: isinstance(one, Summed), single_term) if found.has(Summed) else found


def single_term(summed: Summed) -> sympy.Expr:
    """A sum of one term as this term."""
    (first, *others), body = summed.loops, summed.body
    if first.step != 1 or first.stop - first.start != number(1) or first.conditions or others:
        return summed
    return renamed(body, {first.index: first.start}, {})
