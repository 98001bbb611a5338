"""Soft contacts, whose force (d - r)^p has no series where it begins and ends: few series, all digits."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrange_cli as lagrange
from lagrange_cli.api.motion import Motion
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.workspace import Accelerated
from tests.support.motion import follow

SERIES = 130
"""Series that a contact takes from its beginning to its end; half of them on the ways across."""
EXPONENTS = [1.5, 1.8, 2.2, 2.5, 3.5]
G, K, FLOOR = 9.81, 1e4, 0.5
LARGE = 20
"""So many grains that ways across are made longer."""
BALL = """
parameters: {{k: 1e4, g: 9.81}}
coordinates: {{y: {{initial: {y!r}, velocity: {v!r}}}}}
masses: {{b: 1}}
embedding: {{b: [0, y]}}
potential: g*y + k*max(0, 0.5 - y)**{p}
"""
GRAINS = """
sizes: {{N: {count}}}
parameters: {{R: 0.5, k: {k!r}, g: {g!r}, W: {width!r}}}
coordinates:
  x[i in range(N)]: {{initial: 0}}
  y[i in range(N)]: {{initial: 0}}
masses: {{b[i in range(N)]: 1}}
embedding: {{b[i in range(N)]: [x[i], y[i]]}}
potential: >-
  sum(g*y[i] + k*max(0, R - y[i])**{p} for i in range(N))
  + sum(k*max(0, R - x[i])**{p} + k*max(0, x[i] - W + R)**{p} for i in range(N))
  + sum(k*max(0, 2*R - norm(b[i] - b[j]))**{p} for i in range(N) for j in range(i))
"""


@pytest.fixture
def source(request) -> random.Random:
    return random.Random(request.config.option.seed)


@pytest.fixture
def series(monkeypatch) -> list[int]:
    """How many series were computed between the steps."""
    counted, rates = [0], Accelerated.rates

    def count(*arguments):
        counted[0] += 1
        return rates(*arguments)

    monkeypatch.setattr(Accelerated, "rates", count)
    return counted


class Pile:
    """Grains in a box, with the energies and accelerations that the file describes, by numpy."""

    def __init__(self, start: np.ndarray, width: float, k: float, p: float, g: float) -> None:
        self.start, self.width, self.k, self.p, self.g = start, width, k, p, g
        self.count = start.shape[1]

    def overlaps(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
        apart = np.hypot(x[:, None] - x, y[:, None] - y) + 9.0 * np.eye(self.count)
        return tuple(np.maximum(0.0, u) for u in (0.5 - y, 0.5 - x, x - self.width + 0.5, 1.0 - apart))

    def energy(self, state: np.ndarray) -> float:
        x, y, u, v = state.reshape(4, -1)
        *walls, pairs = (self.k * one**self.p for one in self.overlaps(x, y))
        return float((u @ u + v @ v) / 2 + self.g * y.sum() + np.sum(walls) + pairs.sum() / 2)

    def rates(self, t: float, state: np.ndarray) -> np.ndarray:
        x, y, u, v = state.reshape(4, -1)
        floor, left, right, pairs = (self.k * self.p * one ** (self.p - 1.0) for one in self.overlaps(x, y))
        dx, dy = x[:, None] - x, y[:, None] - y
        push = pairs / (np.hypot(dx, dy) + np.eye(self.count))
        return np.concatenate([u, v, left - right + (push * dx).sum(1), floor - self.g + (push * dy).sum(1)])

    def followed(self, stop: float, samples: int = 41, **more: Any) -> Motion:
        """Its motion; as families, where there are many of them."""
        text = GRAINS.format(count=self.count, k=self.k, g=self.g, width=self.width, p=self.p)
        names = zip(("x", "y", "x_dot", "y_dot"), self.start.tolist())
        return lagrange.solve(text, set=dict(names), stop=stop, samples=samples, threads=1, **more)

    def states(self, motion: Motion) -> np.ndarray:
        return np.hstack([motion.q["x"], motion.q["y"], motion.v["x"], motion.v["y"]])

    def exactly(self, stop: float, samples: int = 41) -> np.ndarray:
        """Its states by another method."""
        times, start = np.linspace(0.0, stop, samples), self.start.ravel()
        return solve_ivp(
            self.rates, (0.0, stop), start, "DOP853", times, rtol=1e-13, atol=1e-13, max_step=2e-3
        ).y.T


def rows(count: int, columns: int) -> np.ndarray:
    """Grains at rest in rows and columns."""
    i = np.arange(count)
    return np.array([i % columns * 1.2 + 0.7, i // columns * 1.2 + 0.7, 0.0 * i, 0.0 * i])


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("p", EXPONENTS)
def test_a_contact_takes_few_series(p, source, series):
    height = source.uniform(0.8, 1.5)
    motion = follow(BALL.format(y=height, v=0.0, p=p), 3.0, 401)
    assert motion.outcome.ending is Ending.COMPLETE
    contacts = np.count_nonzero(np.diff(np.sign(motion["v/y"])) > 0)
    assert contacts >= 2
    assert motion.outcome.steps + series[0] <= SERIES * (contacts + 1)
    energy = motion["v/y"] ** 2 / 2 + G * motion["q/y"] + K * np.maximum(0.0, FLOOR - motion["q/y"]) ** p
    assert np.max(np.abs(energy - energy[0])) <= 1e-12 * energy[0]


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("p", [1.5, 1.8, 2.5])
def test_samples_on_a_way_across(p, source):
    """They are closer to one another than the way is long, and velocities and h are known."""
    speed, before, after = source.uniform(1.0, 4.0), 1e-6, 4e-6
    start = rows(LARGE, LARGE)
    start[1], start[3] = FLOOR + speed * before - G * before**2 / 2, G * before - speed
    pile = Pile(start, 1.2 * LARGE + 0.2, K, p, G)
    motion = pile.followed(before + after, 801)
    y, v = motion.q["y"], motion.v["y"]
    energies = v**2 / 2 + G * (y - FLOOR) + K * np.maximum(0.0, FLOOR - y) ** p
    assert np.max(np.abs(energies - energies[0])) <= 1e-15 * (np.max(energies) + G)
    pushed = v - v[0] + G * motion.t[:, None]
    depth, free = speed * np.maximum(0.0, motion.t - before), motion.t < before
    force = K * depth**p / speed  # at constant speed: the integral of k p (s t)^(p - 1)
    slower = 2.0 * G * after / speed + 4.0 * np.max(force) / speed
    assert np.max(np.abs(pushed[free])) <= 2.0**-50 * speed
    assert np.max(np.abs(pushed - force[:, None])) <= 2.0**-50 * speed + slower * np.max(force)
    assert motion.attributes["steps"] <= 30


@pytest.mark.exhaustive(keep=0.15)
def test_contacts_that_begin_and_end_at_once(series):
    """Each row of a pile reaches the floor, and what is below it, at one time but for rounding."""
    pile = Pile(rows(LARGE, 5), 6.2, 3000.0, 2.5, G)
    motion, states = pile.followed(0.6), pile.exactly(0.6)
    assert motion.status == "complete"
    assert np.max(np.abs(pile.states(motion) - states)) <= 1e-8
    switched = 4 * 2 * 2  # rows that begin and end two contacts, all columns together
    assert motion.attributes["steps"] + series[0] <= SERIES * switched


@pytest.mark.exhaustive(keep=0.5)
def test_two_contacts_that_end_at_once_take_no_search(series):
    motion = Pile(rows(2, 2), 2.6, 3000.0, 1.5, G).followed(1.0)
    assert motion.status == "complete"
    assert motion.attributes["steps"] + series[0] <= 2 * SERIES * 2


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("p", [1.5, 2.5])
def test_grains_that_graze(p, source, series):
    """Their closest approach is just below the distance at which they touch."""
    grazes(10.0 ** -source.uniform(3, 10), p, series)


@pytest.mark.parametrize("depth", [2.9369935989644085e-09, 2.9203439200178116e-09, 2.9037886273201745e-09])
def test_a_contact_goes_on_that_has_begun_by_less_than_rounding(depth, series):
    """Behind the first step the depth is 2^-54, of which nothing is known."""
    grazes(depth, 1.5, series)


def grazes(depth: float, p: float, series: list[int]) -> None:
    pile = Pile(np.array([[1.0, 3.0], [2.0, 3.0 - depth], [1.0, -1.0], [0.0, 0.0]]), 6.0, 1e3, p, 0.0)
    motion = pile.followed(2.0)
    assert motion.status == "complete"
    energies = [pile.energy(one) for one in pile.states(motion)]
    assert np.ptp(energies) <= 1e-14
    assert np.max(np.abs(np.sum(motion.v["x"], axis=1))) <= 1e-14
    assert motion.attributes["steps"] + series[0] <= 2 * SERIES


@pytest.mark.exhaustive(keep=1)
@pytest.mark.filterwarnings("ignore:.*does not detect narrow forces")
@pytest.mark.parametrize("depth", [1e-3, 3e-4, 1e-4])
def test_the_first_step_of_a_contact_is_no_less_exact_by_radau(depth):
    """Its error is filtered where the error itself may take depths below 0, so that their powers are no
    numbers."""
    pile = Pile(np.array([[1.0, 3.0], [2.0, 3.0 - depth], [1.0, -1.0], [0.0, 0.0]]), 6.0, 6e4, 2.5, 0.0)
    motion = pile.followed(2.0, method="Radau", tolerance=1e-10)
    energies = [pile.energy(one) for one in pile.states(motion)]
    assert np.ptp(energies) <= 1e-9


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("p", EXPONENTS)
def test_random_grains(p, source):
    noise, count = np.random.default_rng(source.randrange(2**32)), source.randint(6, 16)
    moved, speeds = noise.uniform(-0.05, 0.05, (2, count)), noise.normal(size=(2, count))
    start = rows(count, 4) + np.concatenate([moved, speeds])
    pile = Pile(start, 5.0, 10.0 ** source.uniform(2.5, 4.5), p, source.choice([0.0, G]))
    motion = pile.followed(0.4)
    assert motion.status == "complete"
    found, energies = pile.states(motion), [pile.energy(one) for one in pile.states(motion)]
    assert np.ptp(energies) <= 1e-12 * max(map(abs, energies))
    assert np.max(np.abs(found - pile.exactly(0.4))) <= 1e-6 * math.sqrt(pile.k)


HUNG = """
bodies:
  body:
    mass: 1.6
    inertia: [0.27, 0.28, 0.15]
    position: [x, y, z]
    orientation: {quaternion: [a, b, c, d]}
coordinates:
  a: {initial: 0.3}
  b: {initial: -0.3, velocity: 0.7}
  c: {initial: -0.1}
  d: {initial: 0.5}
  x: {}
  y: {}
  z: {}
constraints: {joint: "body.at(0.3, 0.36, -0.14) - (0.2, 0, 0.26)"}
potential: 1.6*9.81*body.y + 9.7*max(0, WALL - x)**(5/2)
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
def test_rounding_at_a_contact_is_measured_beside_forces_of_constraint(
    method: str, request: pytest.FixtureRequest
) -> None:
    """It is that of accelerations alone: with that of the forces of constraint, as many as all rows of the
    state, it took the place of what tells the sides of contacts, and the motion ended."""
    source = random.Random(f"{request.config.option.seed} {method}")
    for _ in range(3):
        text = HUNG.replace("WALL", str(source.uniform(0.1, 0.25)))
        expected = lagrange.solve(text, stop=1.5, samples=31)
        tolerance = {"DOP853": 1e-12, "Radau": 1e-10}.get(method, 2.0**-52)
        with pytest.warns(lagrange.LagrangeWarning, match="narrow forces"):
            motion = lagrange.solve(text, stop=1.5, samples=31, method=method, tolerance=tolerance)
        for name in "abcdxyz":
            path = f"q/{name}"
            assert motion.datasets[path][:] == pytest.approx(expected.datasets[path][:], abs=1e-7), text
