"""Which constraints on velocities of families are integrable: all members of a template at once.

A form w = sum_k a_k dx_k is integrable by itself if w ^ dw = 0 (Frobenius; H. Flanders, Differential Forms,
1963, sec. 7.3). Its components are evaluated for all members at random states. Constraints without a
coordinate in common are integrable together if each of them is, and no combination of others is: the
directions that each allows, and their brackets, change its own coordinates only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.node import Node
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.constrained.frobenius import VANISHING, Integrability
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

STATES, TRIES = 3, 20
MOST = 16
"""Coordinates of one constraint up to which it is examined."""


@dataclass(frozen=True, eq=False)
class Forms:
    """The forms of members that are alike, with these ``numbers``: ``a`` are their coefficients, of the
    coordinates at ``rows`` and of t behind them, ``slopes[i, k]`` the derivatives of ``a[k]`` by the i-th."""

    numbers: Places
    rows: tuple[Places, ...]
    a: tuple[Node, ...]
    slopes: Mapping[tuple[int, int], Node]


def integrability(system: FamilySystem, parameters: Mapping[str, float]) -> Integrability:
    """The result for the constraints on velocities, where it is found; parameters without a value are drawn.
    What holonomic constraints and sums over members have to do with is not decided."""
    bonds = system.bonds
    if bonds is None:
        return Integrability({}, None)
    listed = [one for bound in bonds.bounds if not bound.holonomic for one in forms_of(system, bound)]
    shares = sharing(system, bonds)
    decided: dict[int, bool] = {}
    for one in listed:
        free = np.all([~shares.held[rows] for rows in one.rows], axis=0)
        known, alone = judged(system, one, parameters)
        which = np.flatnonzero(free & known)
        decided.update(zip(one.numbers[which].tolist(), alone[which].tolist()))
    moving = range(bonds.holonomic, bonds.count)
    found = {bonds.names[k]: decided.get(k) for k in moving}
    if len(decided) < len(moving) or shares.several:
        return Integrability(found, None)
    kept = bonds.holonomic + sum(decided.values())
    return Integrability(found, all(decided.values()), functions=kept)


@dataclass(frozen=True, eq=False)
class Sharing:
    """Which coordinates are in holonomic constraints (``held``), and whether there are ``several``
    constraints on velocities that contain the same."""

    held: NDArray[np.bool_]
    several: bool


def sharing(system: FamilySystem, bonds: Bonds) -> Sharing:
    """What constraints have to do with each other."""
    pairs = [
        np.stack([rows, np.broadcast_to(one.numbers, rows.shape)], axis=1)
        for one in bonds.bounds
        for rows in touched(system, one)
    ]
    owners = np.unique(np.concatenate(pairs), axis=0) if pairs else np.zeros((0, 2), dtype=np.int64)
    held = np.zeros(system.q.count, dtype=bool)
    held[owners[owners[:, 1] < bonds.holonomic, 0]] = True
    on_velocities = owners[owners[:, 1] >= bonds.holonomic, 0]
    return Sharing(held, len(distinct(on_velocities)) < len(on_velocities))


def touched(system: FamilySystem, bound: Bound) -> Iterator[Places]:
    """The coordinates that members contain, or the velocities of."""
    for _, slot in system.slots.inside(bound.node):
        if slot.array in (system.q, system.v):
            yield slot.table


def forms_of(system: FamilySystem, bound: Bound) -> Iterator[Forms]:
    """The forms of a bound, if they are of coordinates alone, and of few."""
    graph = system.slots.graph
    tables: dict[bytes, Places] = {one.tobytes(): one for one in touched(system, bound)}
    if not bound.whole or bound.holds or len(tables) > MOST:
        return
    rows = tuple(tables.values())
    if any(np.any(one == other) for one, other in combinations(rows, 2)):
        return
    slopes = {one.tobytes(): slope for one, slope in zip(bound.rows, bound.slopes)}
    symbols = {slot.table.tobytes(): symbol for symbol, slot in system.slots.inside(bound.node)
               if slot.array is system.q}  # fmt: skip
    a = (*(slopes.get(key, graph.zero) for key in tables), bound.at_rest(graph))
    variables = [*(symbols.get(key) for key in tables), system.time]
    derivatives = {
        (i, k): graph.diff(one, x)
        for k, one in enumerate(a)
        for i, x in enumerate(variables)
        if x is not None and one.symbols & x.symbols
    }
    yield Forms(bound.numbers, rows, a, derivatives)


def judged(
    system: FamilySystem, forms: Forms, parameters: Mapping[str, float]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Of which members it is known whether w ^ dw vanishes, and of which it does."""
    count = len(forms.numbers)
    seen, alone = np.zeros(count, dtype=np.int64), np.ones(count, dtype=bool)
    for seed in range(TRIES):
        total, size = curling(state(system, parameters, seed), forms)
        known = np.isfinite(total).all(axis=0) & np.isfinite(size).all(axis=0)
        alone &= ~known | np.all(np.abs(total) <= VANISHING * size, axis=0)
        seen += known
        if np.all(seen >= STATES):
            break
    return seen > 0, alone


def state(system: FamilySystem, parameters: Mapping[str, float], seed: int) -> FamilyValues:
    """A random state."""
    chance, spec = np.random.default_rng(seed), system.spec
    q = chance.uniform(0.2, 1.4, system.q.count) * chance.choice([-1.0, 1.0], system.q.count)
    drawn = chance.uniform(0.5, 1.5, len(spec.parameters))
    given = np.array([parameters.get(one.name, x) for one, x in zip(spec.parameters, drawn.tolist())])
    return FamilyValues(system, float(chance.uniform(0.2, 1.4)), q, np.zeros_like(q), given)


def curling(values: FamilyValues, forms: Forms) -> tuple[Values, Values]:
    """The components (triples, members) of w ^ dw, and the sizes of what is added up in them."""
    count = len(forms.numbers)
    with np.errstate(all="ignore"):
        a = [np.broadcast_to(values.node(one), count) for one in forms.a]
        slopes = {pair: np.broadcast_to(values.node(one), count) for pair, one in forms.slopes.items()}
    listed, sizes = [np.zeros(count)], [np.ones(count)]
    for triple in combinations(range(len(a)), 3):
        terms = [*wedge(triple, a, slopes)]
        if terms:
            listed.append(np.sum(terms, axis=0))
            sizes.append(np.sum(np.abs(terms), axis=0))
    return np.array(listed), np.array(sizes)


def wedge(
    triple: tuple[int, ...], a: Sequence[Values], slopes: Mapping[tuple[int, int], Values]
) -> Iterator[Values]:
    """The terms of a_i (d_j a_k - d_k a_j) and of what follows from it by turning i, j and k."""
    i, j, k = triple
    for one, two, three in ((i, j, k), (j, k, i), (k, i, j)):
        if (two, three) in slopes:
            yield a[one] * slopes[two, three]
        if (three, two) in slopes:
            yield -a[one] * slopes[three, two]
