"""What sticks and what slides of several velocities that are 0, beside a search of all sets."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize, root

from lagrange_cli.integrate.guards.choice import Choice, places_of

Array = NDArray[np.float64]


def drawn(source: np.random.Generator, parts: list[int]) -> tuple[Array, Array, Array]:
    """K, the forces r of rates that are 0, and limits D: the least value of x K x/2 - r x + sum D |x| is
    sought."""
    width = sum(parts)
    factor = source.normal(size=(width, width + 1))
    wide = source.uniform(0.5, 4.0)
    return (
        factor @ factor.T + 0.1 * np.eye(width),
        wide * source.normal(size=width),
        source.uniform(0.3, 2.0, len(parts)),
    )


def chosen(parts: list[int], K: Array, r: Array, D: Array) -> Array | None:
    """The choice, with forces in terms of their limits, as multipliers are."""
    by = np.repeat(D, parts)
    choice = Choice(parts, -K / by[:, None], np.zeros((len(parts), len(r))))
    return choice.rates(r / by, np.ones(len(parts)))


def satisfied(parts: list[int], K: Array, r: Array, D: Array, x: Array) -> bool:
    """Whether forces are within the cones of friction, or opposite to the rates."""
    forces = r - K @ x
    for place, limit in zip(places_of(parts), D):
        size = np.linalg.norm(x[place])
        if size == 0.0 and not np.linalg.norm(forces[place]) <= limit * (1 + 1e-7):
            return False
        if size > 0.0 and not np.allclose(forces[place], limit * x[place] / size, rtol=0, atol=1e-8 * limit):
            return False
    return True


def searched(parts: list[int], K: Array, r: Array, D: Array) -> Array:
    """The rates that satisfy all conditions, from a search of all sets that may slide."""
    found = []
    for which in product((False, True), repeat=len(parts)):
        rows = np.flatnonzero(np.repeat(which, parts))
        some = [count for count, one in zip(parts, which) if one]
        limits = D[list(which)]

        def off(x: Array, rows: NDArray[np.intp] = rows, some: list[int] = some, D: Array = limits) -> Array:
            along = [x[one] / np.linalg.norm(x[one]) * d for one, d in zip(places_of(some), D)]
            return r[rows] - K[np.ix_(rows, rows)] @ x - np.concatenate([np.zeros(0), *along])

        def least(
            x: Array, rows: NDArray[np.intp] = rows, some: list[int] = some, D: Array = limits
        ) -> float:
            sizes = [np.linalg.norm(x[one]) * d for one, d in zip(places_of(some), D)]
            return float(x @ K[np.ix_(rows, rows)] @ x / 2 - r[rows] @ x + sum(sizes))

        x = np.zeros(len(r))
        if len(rows):
            near = minimize(least, np.linalg.solve(K, r)[rows], method="BFGS", options={"gtol": 1e-6})
            solved = root(off, near.x, tol=1e-13)
            if np.max(np.abs(solved.fun)) > 1e-9:
                continue
            x[rows] = solved.x
        if satisfied(parts, K, r, D, x):
            found.append(x)
    assert found
    for one in found[1:]:
        np.testing.assert_allclose(one, found[0], rtol=0, atol=1e-6)
    return np.array(found[0])


def test_it_is_the_one_set_of_all_that_satisfies_its_conditions(request: pytest.FixtureRequest) -> None:
    source = np.random.default_rng(request.config.option.seed)
    some = 0
    for _ in range(40):
        parts = source.integers(1, 4, size=source.integers(1, 5)).tolist()
        K, r, D = drawn(source, parts)
        x = chosen(parts, K, r, D)
        assert x is not None
        np.testing.assert_allclose(x, searched(parts, K, r, D), rtol=0, atol=1e-7 * (1 + np.abs(x).max()))
        slide = [bool(x[one].any()) for one in places_of(parts)]
        some += any(slide) and not all(slide)
    assert some > 3


@pytest.mark.parametrize("count", [10, 100])
def test_a_long_pile(count: int, request: pytest.FixtureRequest) -> None:
    """Each block rubs on the one below it: the forces depend on one another along the whole pile."""
    source, width = np.random.default_rng(request.config.option.seed), 2 * count
    slopes = np.eye(width) - np.eye(width, k=-2)
    K = np.linalg.inv(slopes @ slopes.T)
    D, pulls = source.uniform(0.5, 1.5, count), source.normal(size=width)
    r, parts = K @ slopes @ pulls, [2] * count
    x = chosen(parts, K, r, D)
    assert x is not None and satisfied(parts, K, r, D, x)
    assert 0 < np.count_nonzero(x) < width


def test_rounds_of_one_force_after_another_lead_there_alone(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """Newton's method takes the last step only."""
    source = np.random.default_rng(request.config.option.seed)
    parts = [2, 1, 3, 2]
    K, r, D = drawn(source, parts)
    K += np.eye(len(K))
    expected, usual, calls = chosen(parts, K, r, D), Choice._by_newton, list[int]()

    def late(choice: Choice, x: Array, forces: Array, limits: Array) -> Array | None:
        calls.append(1)
        return usual(choice, x, forces, limits) if len(calls) > 11 else None

    monkeypatch.setattr(Choice, "_by_newton", late)
    monkeypatch.setattr("lagrange_cli.integrate.guards.choice.ITERATIONS", 2)
    found = chosen(parts, K, r, D)
    assert expected is not None and found is not None and len(calls) == 12
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * (1 + np.abs(expected).max()))


def test_a_force_as_large_as_its_limit_holds() -> None:
    for rounded in (1.0, 1.0 + 2.0**-52, 1.0 + 2.0**-40):
        x = Choice([2], -np.eye(2), np.zeros((1, 2))).rates(rounded * np.array([0.6, 0.8]), np.ones(1))
        assert x is not None and not x.any()


def test_a_limit_that_grows_with_what_slides() -> None:
    """f = 3 - x is D = 1 + x/4 where x = 2/1.25."""
    choice = Choice([1], np.array([[-1.0]]), np.array([[0.25]]))
    found = choice.rates(np.array([3.0]), np.ones(1))
    assert found == pytest.approx([1.6], rel=1e-9)
