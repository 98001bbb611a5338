"""Which constraints depend on others, by their slopes, and by which factors."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.model import orthogonal, sparse
from lagrange_cli.model.start.equations import Row
from lagrange_cli.model.start.linear import DENSE, FILLED, least_squares, products, steepness

DEPENDENT = 1e-7
"""A constraint depends on others where the sine of the angle between its slopes and theirs is smaller."""
APART = 1e-5
"""The same at states that are not known exactly."""
CLEAR = 1e-4
"""The square of this sine, from which on no closer look is needed."""
CHANGED = 1e-5
"""Factors that differ by more, beside the largest, are not the same."""
NO_SHARE = 1e-9
"""A factor that is no larger, beside the largest, is 0."""
SURE = 10.0
"""A sine that is smaller than another one by this factor is smaller in any order of constraints."""


def independent(
    rows: Sequence[Row], scale: Sequence[float], typical: Sequence[float] = (), sine: float = DEPENDENT
) -> list[int]:
    """The rows, in their order, that do not depend on earlier ones, with slopes by x_k/``scale[k]``.

    A row that is
    negligible beside its ``typical`` steepness depends on any others. ``sine`` is that of the
    angle below which one does.
    """
    scaled = [{k: float(a) * scale[k] for k, a in row.items()} for row in rows]
    norms, least = steepness(rows, scale), [sine * x for x in typical] or [0.0] * len(rows)
    kept = [i for i, norm in enumerate(norms) if least[i] < norm < math.inf]
    unit = [{k: a / norms[i] for k, a in scaled[i].items()} for i in kept]
    if len(kept) <= DENSE:
        return [kept[i] for i in leading_dense(unit, sine)]
    matrix = sparse.products(unit, unit)
    found: list[int] = []
    for part in sparse.parts_of(matrix):
        factors = sparse.factored(sparse.within(matrix, part), FILLED * len(part))
        if factors is not None and min(factors.pivots) > CLEAR:
            found += [kept[i] for i in part]
            continue
        mine = [unit[i] for i in part]
        chosen = leading_dense(mine, sine) if len(part) <= DENSE else leading_sparse(mine, sine)
        found += [kept[part[i]] for i in chosen]
    return sorted(found)


def leading_sparse(unit: Sequence[Mapping[int, float]], sine: float) -> list[int]:
    """The same for many rows. They are taken in an order in which few entries arise, and those that depend on
    others are exchanged for the last ones that do. Where it is not clear which do, they keep their order."""
    order = sparse.order_of(sparse.products(unit, unit), FILLED * len(unit))
    places = orthogonal.leading([unit[i] for i in order], sine / SURE, sine) if order else None
    if order and places is not None:
        chosen = [order[i] for i in places]
        among = {*chosen}
        rest = [i for i in order if i not in among]
        shares = shares_of([unit[i] for i in chosen], [unit[i] for i in rest])
        wholes = ({i: -1.0, **{chosen[k]: a for k, a in one.items()}} for i, one in zip(rest, shares))
        last = last_ones(wholes, sine, unit)
        if last is not None:
            return [i for i in range(len(unit)) if i not in last]
    found = orthogonal.leading(unit, sine, sine)
    assert found is not None
    return found


def last_ones(
    wholes: Iterable[dict[int, float]], sine: float, unit: Sequence[Mapping[int, float]]
) -> Collection[int] | None:
    """The last rows of combinations that vanish, of as many as possible: they depend on earlier rows. None
    where some may not."""
    found = dict[int, dict[int, float]]()
    for whole in wholes:
        while (last := last_of(whole)) in found:
            factor = whole.pop(last)
            for k, share in found[last].items():
                whole[k] = whole.get(k, 0.0) - factor * share
        factor = whole[last]
        if length(whole, unit) > sine * abs(factor):
            return None
        found[last] = {k: share / factor for k, share in whole.items() if k != last}
    return found


def last_of(whole: Mapping[int, float]) -> int:
    """The last row of a combination."""
    least = NO_SHARE * max(map(abs, whole.values()))
    return max(k for k, share in whole.items() if abs(share) > least)


def length(whole: Mapping[int, float], unit: Sequence[Mapping[int, float]]) -> float:
    """That of a combination of rows."""
    sums = dict[int, float]()
    for i, share in whole.items():
        for k, a in unit[i].items():
            sums[k] = sums.get(k, 0.0) + share * a
    return math.hypot(*sums.values())


def leading_dense(unit: Sequence[Mapping[int, float]], sine: float) -> list[int]:
    """The rows of norm 1 that do not depend on earlier ones."""
    if not unit:
        return []
    try:
        pivots = np.diag(np.linalg.cholesky(products(unit, unit))) ** 2
        if pivots.min() > CLEAR:
            return [*range(len(unit))]
    except np.linalg.LinAlgError:
        pass
    places = {k: place for place, k in enumerate(sorted({k for row in unit for k in row}))}
    basis = np.zeros((min(len(unit), len(places)), len(places)))
    found: list[int] = []
    for i, row in enumerate(unit):
        rest = np.zeros(len(places))
        rest[[places[k] for k in row]] = list(row.values())
        done = basis[: len(found)]
        for _ in range(2):  # twice is enough (Kahan and Parlett)
            rest -= done.T @ (done @ rest)
        norm = float(np.linalg.norm(rest))
        if norm > sine and len(found) < len(basis):
            basis[len(found)] = rest / norm
            found.append(i)
    return found


def tied(rows: Sequence[Row], kept: Sequence[int], scale: Sequence[float]) -> list[set[int]]:
    """The rows of each combination that vanishes: one that is not ``kept``, and those it follows from."""
    unit = [
        {k: float(a) * scale[k] / (norm or 1.0) for k, a in row.items()}
        for row, norm in zip(rows, steepness(rows, scale))
    ]
    among = {*kept}
    rest = [i for i in range(len(rows)) if i not in among]
    found = {i: {i} for i in rest}
    for part in sparse.parts_of(sparse.products(unit, unit)) if rest else ():
        others, mine = [i for i in part if i not in among], [i for i in part if i in among]
        if others and mine:
            for i, shares in zip(others, shares_of([unit[i] for i in mine], [unit[i] for i in others])):
                found[i].update(mine[k] for k, share in shares.items() if abs(share) > APART)
    return [*found.values()]


def joined(groups: Iterable[Iterable[int]]) -> tuple[tuple[int, ...], ...]:
    """The same groups, those that have a number in common as one."""
    found: list[set[int]] = []
    of: dict[int, set[int]] = {}
    for group in groups:
        whole = {*group}
        for other in {id(of[i]): of[i] for i in whole if i in of}.values():
            whole |= other
        of.update(dict.fromkeys(whole, whole))
        found.append(whole)
    return tuple(sorted(tuple(sorted(one)) for one in found if of[min(one)] is one))


def in_turn(places: Sequence[Sequence[Row]], kept: Sequence[int], scale: Sequence[float]) -> tuple[int, ...]:
    """The rows that are not ``kept`` and are combinations of those by factors that differ between places, and
    those that are coupled with them."""
    among, found = {*kept}, list[int]()
    scaled = [[{k: float(a) * scale[k] for k, a in row.items()} for row in rows] for rows in places]
    for part in sparse.parts_of(sparse.products(scaled[0], scaled[0])):
        others, mine = [i for i in part if i not in among], [i for i in part if i in among]
        if others and mine:
            first, *rest = (
                [*shares_of([rows[i] for i in mine], [rows[i] for i in others])] for rows in scaled
            )
            largest = max((change(first, one) for one in rest), default=0.0)
            found += others if largest > CHANGED * change(first, [{}] * len(others)) else []
    return tuple(sorted(found))


def change(shares: Sequence[Mapping[int, float]], others: Sequence[Mapping[int, float]]) -> float:
    """The largest difference between shares and others."""
    pairs = zip(shares, others)
    return max((abs(a.get(k, 0.0) - b.get(k, 0.0)) for a, b in pairs for k in {*a, *b}), default=0.0)


def shares_of(own: Sequence[Row], others: Sequence[Row]) -> Iterator[dict[int, float]]:
    """The combinations of ``own`` rows, which are independent, that are nearest to each of the others."""
    factors = None
    if len(own) > DENSE:
        factors = sparse.factored(sparse.products(own, own), FILLED * len(own))
    for first in range(0, len(others), DENSE):
        some = others[first : first + DENSE]
        right = sparse.array_of(sparse.products(own, some), len(some))
        found = factors.solve_all(right) if factors else least_squares(products(own, own), right)
        for column in found.T:
            yield {k: float(column[k]) for k in np.flatnonzero(np.abs(column) > NO_SHARE).tolist()}
