"""Chains in which a member's place follows from the coordinates of the member before, too, as those of the
centres of links: x[i] = x[i - 1] + g(q[i - 1]) + h(q[i]).

With x[i] = c[i] - g(q[i]), c[i] = c[i - 1] + g(q[i]) + h(q[i]) is a chain in which each coordinate moves what
comes behind one joint: c[i] is the end of link i.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.families.arrays import NONE, Array, Chain, Domain, Slots, Term, Tree, placed
from lagrange_cli.mechanics.multiplied_out import monomials


def shifted(
    slots: Slots, q: Array, terms: Sequence[Term], tree: Tree
) -> tuple[Sequence[Term], Sequence[Term]]:
    """What is added from c to c, from the ``terms`` that are added from x to x, one for each member; and c -
    x of the members that have it. There is none if no coordinate moves two members, and no sum of these."""
    parents, owners = tree.parents, owners_of(slots, q, terms, tree.order)
    own, before = list[Term](), list[Term]()
    for term in terms:
        for mine, theirs in parted(slots, term, owners, parents):
            own.append(mine)
            if not theirs.node.is_zero:
                before.append(theirs)
    at = np.concatenate([np.zeros(0, dtype=np.int64), *(one.targets for one in before)])
    if not before or len(distinct(at)) < len(at):  # or several members follow from one
        return terms, ()
    return [*together(slots, own, before, len(parents))], before


def owners_of(slots: Slots, q: Array, terms: Sequence[Term], order: Places) -> dict[Array, Places]:
    """For each coordinate the first member in this order that it moves, and for each sum of these."""
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    found: dict[Array, Places] = {}
    for term in terms:
        for _, slot in slots.inside(term.node):
            if slot.array is q or isinstance(slot.array, Chain):
                owners = found.setdefault(slot.array, np.full(slot.array.count, NONE, dtype=np.int64))
                known = owners[slot.table]
                first = (known == NONE) | (rank[term.targets] < rank[known])
                owners[slot.table[first]] = term.targets[first]
    return found


def parted(
    slots: Slots, term: Term, owners: Mapping[Array, Places], parents: Places
) -> Iterator[tuple[Term, Term]]:
    """What coordinates of the members themselves add, and at the members before what their coordinates alone
    add; those members together for which the same addends are of this kind."""
    graph, listed, up = slots.graph, monomials(slots.graph, term.node), parents[term.targets]
    listed = [(term.node, 1.0)] if listed is None else listed
    inherited = np.zeros((len(listed), term.domain.count), dtype=bool)
    for k, (one, _) in enumerate(listed):
        moving = [(owners[slot.array], slot.table) for _, slot in slots.inside(one) if slot.array in owners]
        if moving:
            inherited[k] = np.all([found[table] == up for found, table in moving], axis=0)
    kinds, labels = np.unique(inherited, axis=1, return_inverse=True)
    for label, kind in enumerate(kinds.T):
        members = np.flatnonzero(labels.reshape(-1) == label)
        domain = term.domain if len(members) == term.domain.count else Domain(len(members))
        mine, theirs = (
            placed(
                slots, graph.sum([one for one, other in zip(listed, kind) if other == which]), domain, members
            )
            for which in (False, True)
        )
        yield Term(domain, mine, term.targets[members]), Term(domain, theirs, up[members])


def together(slots: Slots, own: Sequence[Term], others: Sequence[Term], count: int) -> Iterator[Term]:
    """The sums of both, one term for each member."""
    which, at = (np.full(count, NONE, dtype=np.int64) for _ in range(2))
    for k, other in enumerate(others):
        which[other.targets], at[other.targets] = k, np.arange(other.domain.count)
    for term in own:
        found = which[term.targets]
        for k in distinct(found).tolist():
            members = np.flatnonzero(found == k)
            targets, domain = term.targets[members], Domain(len(members))
            node = placed(slots, term.node, domain, members)
            if k != NONE:
                node = node + placed(slots, others[k].node, domain, at[targets])
            yield Term(domain, node, targets)
