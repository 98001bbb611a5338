"""Derivatives by velocities that are found from few changes of these."""

from __future__ import annotations

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.integrate.guards.slopes import LinearSlopes, connected, grouped
from lagrange_cli.integrate.workspace import Accelerated

BALLS = """
name: balls
sizes: {N: 4}
parameters: {F: 0.6, R: 0.1}
coordinates:
  "x[i in range(N)]": {initial: "i/2", velocity: "0.7*sin(3*i + 1)"}
  "y[i in range(N)]": {initial: "sin(i)", velocity: "0.7*cos(5*i)"}
  "a[i in range(N)]": {initial: 0, velocity: "3*cos(i)"}
  "b[i in range(N)]": {initial: 0, velocity: "2*sin(2*i)"}
lagrangian: sum((x_dot[i]**2 + y_dot[i]**2)/2 + 0.4*R**2*(a_dot[i]**2 + b_dot[i]**2)/2 for i in range(N))
dissipation: sum(F*norm((x_dot[i] - R*b_dot[i], y_dot[i] + R*a_dot[i])) for i in range(N))
solve: {stop: 3, samples: 31}
"""
"""Balls that slide on a table, until they roll."""


class Numbers:
    """Numbers that are linear in velocities, by a matrix; how often they were computed."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix, self.count = matrix, 0
        self.own = np.sin(np.arange(len(matrix)))
        self.speeds = np.cos(np.arange(matrix.shape[1]))

    def __call__(self, change: np.ndarray) -> np.ndarray:
        self.count += 1
        return (
            np.array([row[row != 0.0] @ (self.speeds + change)[row != 0.0] for row in self.matrix]) + self.own
        )


def of_pairs(count: int) -> np.ndarray:
    """Each number depends on two velocities."""
    matrix = np.zeros((count, 2 * count))
    rows = np.arange(count)
    matrix[rows, rows], matrix[rows, rows + count] = 1.0, 0.5 + np.cos(rows)
    return matrix


def test_few_changes_are_enough_once_it_is_known_what_depends_on_what() -> None:
    slopes, first, second = LinearSlopes(100), Numbers(of_pairs(50)), Numbers(2.0 * of_pairs(50))
    for numbers, most in ((first, 101), (second, 4)):
        assert np.max(np.abs(slopes.at(numbers) - numbers.matrix)) < 1e-14
        assert numbers.count <= most


@pytest.mark.parametrize("size", [1.0, 1e-6])
def test_numbers_that_depend_on_more_than_before(size: float) -> None:
    slopes, matrix = LinearSlopes(100), of_pairs(50)
    slopes.at(Numbers(matrix))
    more = matrix.copy()
    more[7, 3] = size
    assert np.max(np.abs(slopes.at(Numbers(more)) - more)) < 1e-14
    numbers = Numbers(more)
    assert np.max(np.abs(slopes.at(numbers) - more)) < 1e-14 and numbers.count < 10
    numbers = Numbers(matrix)  # what was known to depend on something may not do so elsewhere
    assert np.max(np.abs(slopes.at(numbers) - matrix)) < 1e-14 and numbers.count < 10


def test_what_is_not_finite_is_found_one_by_one() -> None:
    slopes, matrix = LinearSlopes(8), of_pairs(4)
    slopes.at(Numbers(matrix))
    matrix[2, 2] = np.nan
    assert np.isnan(slopes.at(Numbers(matrix))[2]).any()


def test_groups_share_no_row() -> None:
    depends = np.random.default_rng(1).random((30, 40)) < 0.1
    groups = grouped(depends)
    assert sorted(np.concatenate(groups)) == np.flatnonzero(depends.any(axis=0)).tolist()
    assert all(depends[:, group].sum(axis=1).max() <= 1 for group in groups)


def test_balls_that_begin_to_roll_take_few_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction F changes the slip of a ball with the moment of inertia 2/5 m R^2 at the rate 7/2 F/m, until
    it rolls; the slip keeps its direction."""
    count, rates = 0, Accelerated.rates

    def counted(self, machine):
        nonlocal count
        count += 1
        return rates(self, machine)

    monkeypatch.setattr(Accelerated, "rates", counted)
    motion = lagrange_cli.solve(BALLS, method="taylor")
    assert count < 150  # one by one 249
    v = motion.v
    slip = np.hypot(v["x"] - 0.1 * v["b"], v["y"] + 0.1 * v["a"])
    assert np.max(np.abs(slip - np.fmax(slip[0] - 3.5 * 0.6 * motion.t[:, None], 0.0))) < 1e-12


PUSHED = """
name: pushed
sizes: {N: 3}
parameters: {F: 0.6, R: 0.1, u: 0.5}
definitions: {"f[i in range(N)]": sqrt((1 + i)**2 + 4)}
coordinates:
  "x[i in range(N)]": {initial: 0, velocity: "u*(1 + i)/f[i]"}
  "y[i in range(N)]": {initial: 0, velocity: "2*u/f[i]"}
  "a[i in range(N)]": {initial: 0}
  "b[i in range(N)]": {initial: 0}
lagrangian: sum((x_dot[i]**2 + y_dot[i]**2)/2 + 0.4*R**2*(a_dot[i]**2 + b_dot[i]**2)/2
  + t*(1 + i)*x[i] + 2*t*y[i] for i in range(N))
dissipation: sum(F*norm((x_dot[i] - R*b_dot[i], y_dot[i] + R*a_dot[i])) for i in range(N))
solve: {stop: 3, samples: 61}
"""


def test_balls_that_roll_and_slide_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball slides along a line with the slip u, until it rolls: 2/7 of a push f t must then be less than
    the friction F. It slides again where that is no longer so."""
    computed, rates = [], Accelerated.rates
    monkeypatch.setattr(Accelerated, "rates", lambda *one: (computed.append(1), rates(*one))[1])
    motion = lagrange_cli.solve(PUSHED, method="taylor")
    assert len(computed) < 900  # one by one 1271
    t = motion.t
    for i in range(3):
        f, F, u = np.hypot(1.0 + i, 2.0), 0.6, 0.5
        again = 3.5 * F / f
        rolls = again - np.sqrt(again**2 - 2 * u / f)
        ends = np.fmin(t, rolls), np.clip(t, rolls, again), np.fmax(t, again)
        sliding = u + f * ends[0] ** 2 / 2 - F * ends[0]
        rolling = 5 / 7 * f * (ends[1] ** 2 - rolls**2) / 2
        speed = sliding + rolling + f * (ends[2] ** 2 - again**2) / 2 - F * (ends[2] - again)
        for name, part in (("x", 1.0 + i), ("y", 2.0)):
            assert np.max(np.abs(motion.v[name][:, i] - speed * part / f)) < 1e-12


def test_what_depends_on_itself_falls_into_parts() -> None:
    depends = np.zeros((7, 7), bool)
    for row, column in ((0, 3), (3, 5), (1, 1), (6, 2)):
        depends[row, column] = True
    assert [one.tolist() for one in connected(depends)] == [[0, 3, 5], [1], [2, 6]]
