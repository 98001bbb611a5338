"""Which unknowns equations determine together, and which one after the other, by their structure alone.

The equations are put in block triangular form (A. L. Dulmage and N. S. Mendelsohn, Can. J. Math. 10, 1958; A.
Pothen and C.-J. Fan, ACM Trans. Math. Softw. 16, 1990): each block contains unknowns of its own and of
earlier blocks. Links of a chain are a block each, a closed loop is one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from lagrange_cli.records import dataclass

Pattern = Mapping[int, Sequence[int]]
"""The unknowns that each equation contains."""


@dataclass(frozen=True)
class Block:
    """Equations ``rows``, at least as many as the ``unknown`` that they determine."""

    rows: Sequence[int]
    unknown: Sequence[int]


def blocks(pattern: Pattern, unknown: Sequence[int]) -> tuple[list[Block], list[int]]:
    """The blocks, each after those that it depends on, and the unknowns that are left free."""
    containing: dict[int, list[int]] = {k: [] for k in unknown}
    for i, inside in pattern.items():
        for k in inside:
            containing[k].append(i)
    row_of = matched(containing)
    unknown_of = {i: k for k, i in row_of.items()}
    free = reached((k for k in unknown if k not in row_of), lambda k: (unknown_of[i] for i in containing[k]))
    spare = [i for i in pattern if i not in unknown_of]
    many = reached((k for i in spare for k in pattern[i]), lambda k: pattern[row_of[k]])
    of_many: dict[int, list[int]] = {}
    for i in (*spare, *(row_of[k] for k in many)):
        for k in pattern[i]:
            of_many.setdefault(k, []).append(i)
    found: list[Block] = []
    left = {*many}
    for start in sorted(many):
        if start in left:
            part = reached([start], lambda k: (j for i in of_many[k] for j in pattern[i]))
            left.difference_update(part)
            found.append(Block(sorted({i for k in part for i in of_many[k]}), sorted(part)))
    rest = {k: [j for j in pattern[i] if j not in many] for k, i in row_of.items() if k not in {*many, *free}}
    found += [Block(sorted(row_of[k] for k in one), sorted(one)) for one in cycles(rest)]
    return found, sorted(free)


def matched(containing: Mapping[int, Sequence[int]]) -> dict[int, int]:
    """An equation for each unknown, different ones for as many as possible, by augmenting paths."""
    row_of: dict[int, int] = {}
    unknown_of: dict[int, int] = {}
    for start in containing:
        came: dict[int, int] = {}
        pending, end = [start], None
        for k in pending:
            end = next((i for i in containing[k] if i not in unknown_of), None)
            if end is not None:
                came[end] = k
                break
            for i in containing[k]:
                if i not in came:
                    came[i] = k
                    pending.append(unknown_of[i])
        while end is not None:
            k = came[end]
            before = row_of.get(k)
            row_of[k], unknown_of[end] = end, k
            end = before
    return row_of


def reached(starts: Iterable[int], following: Callable[[int], Iterable[int]]) -> dict[int, None]:
    """All that follow from the ``starts``, which belong to them, in order."""
    found = dict.fromkeys(starts)
    pending = [*found]
    for one in pending:
        for other in following(one):
            if other not in found:
                found[other] = None
                pending.append(other)
    return found


def cycles(uses: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Those that use each other, directly or not, after those that they use (R. Tarjan, SIAM J.
    Comput. 1, 146, 1972)."""
    number: dict[int, int] = {}
    lowest: dict[int, int] = {}
    stack: list[int] = []
    waiting: set[int] = set()
    found: list[list[int]] = []
    for start in uses:
        if start in number:
            continue
        calls = [(start, iter(uses[start]))]
        number[start] = lowest[start] = len(number)
        stack.append(start)
        waiting.add(start)
        while calls:
            one, others = calls[-1]
            for other in others:
                if other not in number:
                    number[other] = lowest[other] = len(number)
                    stack.append(other)
                    waiting.add(other)
                    calls.append((other, iter(uses[other])))
                    break
                if other in waiting:
                    lowest[one] = min(lowest[one], number[other])
            else:
                calls.pop()
                if calls:
                    above = calls[-1][0]
                    lowest[above] = min(lowest[above], lowest[one])
                if lowest[one] == number[one]:
                    part: list[int] = []
                    while not part or part[-1] != one:
                        part.append(stack.pop())
                        waiting.discard(part[-1])
                    found.append(part)
    return found
