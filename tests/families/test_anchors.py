"""What members that stick are held by."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.expression.graph import Graph
from lagrange_cli.families.arrays import NONE, Domain, Source, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.switching.anchors import anchors_of


def forces(rows: list[list[int]]) -> Bonds:
    """Forces on these coordinates, those on as many of them in one bound."""
    zero, bounds = Graph().zero, []
    for size in {len(one) for one in rows}:
        numbers = np.array([i for i, one in enumerate(rows) if len(one) == size])
        columns = tuple(np.array([rows[i] for i in numbers]).T)
        bounds.append(Bound(Domain(len(numbers)), zero, numbers, columns, (), (), zero))
    return Bonds(tuple(bounds), [str(i) for i, _ in enumerate(rows)], Total(Source.TOTAL, len(rows)), 0)


@pytest.mark.parametrize("seed", range(20))
def test_the_velocities_of_anchors_are_known_before(seed: int) -> None:
    """Random forces without circles, each on up to three coordinates, of which one may stick to the
    ground."""
    chance = np.random.default_rng(seed)
    count = int(chance.integers(1, 30))
    names, groups = chance.permutation(count), [[i] for i in range(count)]
    rows: list[list[int]] = []
    while len(groups) > 1 and chance.random() < 0.95:
        size = min(int(chance.integers(2, 4)), len(groups))
        chosen = [groups.pop(int(chance.integers(len(groups)))) for _ in range(size)]
        rows.append([int(names[chance.choice(one)]) for one in chosen])
        groups.append([i for one in chosen for i in one])
    grounded = [one for one in groups if chance.random() < 0.5]
    rows += [[int(names[chance.choice(one)])] for one in grounded]
    if not rows:
        return
    order = chance.permutation(len(rows))
    rows = [rows[i] for i in order]
    found = anchors_of(forces(rows), count)
    assert sorted(found.numbers) == [*range(len(rows))]
    assert np.array_equal(found.numbers[found.places], np.arange(len(rows)))
    assert len(set(found.held.tolist())) == len(rows)
    later = set(found.held.tolist())
    for number, held, others in zip(found.numbers, found.held, found.others):
        listed = [i for i in rows[number] if i != held]
        assert others.tolist() == [*listed, *[NONE] * (len(others) - len(listed))]
        assert not later & {*listed}
        later.remove(held)
