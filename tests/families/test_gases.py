"""Gases of discs beside an event-driven simulation: no event is missed by steps that look at discs near one
another alone."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.families.test_events import keep_families
from tests.families.test_switches import followed, ready

Floats = NDArray[np.float64]
GAS = """
sizes: {{N: {count}}}
parameters: {{R: {radius}, g: {gravity}, L: {length}, "m[i in range(N)]": "1 + 0.5*cos({a}*i)"}}
coordinates:
  x[i in range(N)]:
    initial: "{cell}*(i % {across} + 0.5) + {loose}*sin({a}*i)"
    velocity: "cos({b}*i*i + 1)"
  y[i in range(N)]:
    initial: "{cell}*(i // {across} + 0.5) + {loose}*cos({a}*i)"
    velocity: "{slow}*sin({b}*i + 2)"
masses: {{"disc[i in range(N)]": "m[i]"}}
positions: {{"disc[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(m[i]*g*y[i] for i in range(N))
definitions:
  dx[i in range(N), j in range(i)]: x[i] - x[j]
  dy[i in range(N), j in range(i)]: y[i] - y[j]
  push[i in range(N), j in range(i)]: >-
    2*((x_dot[i] - x_dot[j])*dx[i, j] + (y_dot[i] - y_dot[j])*dy[i, j])
    /((dx[i, j]**2 + dy[i, j]**2)*(1/m[i] + 1/m[j]))
events:
  hit[i in range(N), j in range(i)]:
    when: dx[i, j]**2 + dy[i, j]**2 - 4*R**2
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] - push[i, j]*dx[i, j]/m[i]
        y_dot[i]: y_dot[i] - push[i, j]*dy[i, j]/m[i]
        x_dot[j]: x_dot[j] + push[i, j]*dx[i, j]/m[j]
        y_dot[j]: y_dot[j] + push[i, j]*dy[i, j]/m[j]
  right[i in range(N)]:
    {{when: "x[i] - L + R", direction: rising, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
  left[i in range(N)]:
    {{when: "x[i] - R", direction: falling, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
  top[i in range(N)]:
    {{when: "y[i] - L + R", direction: rising, action: {{set: {{"y_dot[i]": "-y_dot[i]"}}}}}}
  bottom[i in range(N)]:
    {{when: "y[i] - R", direction: falling, action: {{set: {{"y_dot[i]": "-y_dot[i]"}}}}}}
"""
ACROSS = 6
"""Discs side by side."""


class Discs:
    """Elastic discs in a box, from event to event: all times of contact are roots of quadratic equations, as
    all discs fall alike."""

    def __init__(
        self, radius: float, gravity: float, length: float, mass: Floats, r: Floats, v: Floats
    ) -> None:
        self.radius, self.gravity, self.length, self.mass = radius, gravity, length, mass
        self.r, self.v, self.t = r.copy(), v.copy(), 0.0
        self.pairs = np.tril_indices(len(mass), -1)

    def meetings(self) -> Floats:
        """How long it takes until the discs of each pair meet."""
        i, j = self.pairs
        dr, dv = self.r[i] - self.r[j], self.v[i] - self.v[j]
        b, c = np.sum(dr * dv, axis=1), np.sum(dr**2, axis=1) - 4.0 * self.radius**2
        inside = b**2 - np.sum(dv**2, axis=1) * c
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where((b < 0.0) & (inside >= 0.0), c / (-b + np.sqrt(inside)), np.inf)

    def walls(self) -> tuple[Floats, ...]:
        """How long it takes until each disc comes to the walls: right, left, top, bottom."""
        (x, y), (u, w) = self.r.T, self.v.T
        far, near, g = self.length - self.radius, self.radius, self.gravity
        with np.errstate(invalid="ignore", divide="ignore"):
            right = np.where(u > 0.0, (far - x) / u, np.inf)
            left = np.where(u < 0.0, (near - x) / u, np.inf)
            rises = w**2 - 2.0 * g * (far - y)
            top = np.where((w > 0.0) & (rises >= 0.0), 2.0 * (far - y) / (w + np.sqrt(rises)), np.inf)
            falls = np.sqrt(w**2 + 2.0 * g * (y - near))
            slow = np.where(w < 0.0, 2.0 * (y - near) / (falls - w), (w + falls) / g if g else np.inf)
        return right, left, top, slow

    def events(self) -> Iterator[tuple[float, str, tuple[int, ...]]]:
        """Those that happen, with their times."""
        while True:
            meet, walls = self.meetings(), self.walls()
            which = int(np.argmin([np.min(meet), *map(np.min, walls)]))
            k = int(np.argmin(meet if which == 0 else walls[which - 1]))
            dt = float((meet if which == 0 else walls[which - 1])[k])
            self.t += dt
            self.r += self.v * dt
            self.r[:, 1] -= self.gravity * dt**2 / 2.0
            self.v[:, 1] -= self.gravity * dt
            if which:
                self.v[k, (which - 1) // 2] *= -1.0
                yield self.t, ("right", "left", "top", "bottom")[which - 1], (k,)
                continue
            i, j = (int(one[k]) for one in self.pairs)
            dr, m = self.r[i] - self.r[j], self.mass
            push = 2.0 * (self.v[i] - self.v[j]) @ dr / (dr @ dr) / (1.0 / m[i] + 1.0 / m[j])
            self.v[i] -= push * dr / m[i]
            self.v[j] += push * dr / m[j]
            yield self.t, "hit", (i, j)


def gas(seed: int, count: int) -> tuple[str, Discs]:
    """A random one: its file, and its simulation."""
    chance = np.random.default_rng(seed)
    a, b = chance.uniform(0.5, 40.0, 2).round(3)
    cell, radius = 0.5, float(chance.choice([0.05, 0.15, 0.22]))
    loose, gravity = round(0.8 * (0.25 - radius), 4), float(chance.choice([0.0, 1.5]))
    slow, length = float(chance.choice([0.1, 1.0, 10.0])), cell * ACROSS
    text = GAS.format(
        count=count, across=ACROSS, cell=cell, radius=radius, gravity=gravity, loose=loose, a=a, b=b,
        slow=slow, length=length,
    )  # fmt: skip
    i = np.arange(count)
    places = [cell * (k + 0.5) + loose * f(a * i) for k, f in ((i % ACROSS, np.sin), (i // ACROSS, np.cos))]
    speeds = [np.cos(b * i * i + 1), slow * np.sin(b * i + 2)]
    return text, Discs(
        radius, gravity, length, 1.0 + 0.5 * np.cos(a * i), np.stack(places, axis=1), np.stack(speeds, axis=1)
    )


@pytest.mark.exhaustive(keep=0.1)
@pytest.mark.parametrize("count", [23, 36])
@pytest.mark.parametrize("seed", range(30))
def test_the_events_are_those_of_a_simulation(seed: int, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors grow from impact to impact by about the distance between these divided by the radius."""
    keep_families(monkeypatch, whole=True)
    text, discs = gas(seed, count)
    prepared = ready(text)
    assert "@act_alone" in prepared.machine.program.text
    *expected, after = islice(discs.events(), 2 * count)
    stop = (expected[-1][0] + after[0]) / 2.0
    motion = followed(prepared, text, stop)
    found = []
    for name in {path.split("/")[1] for path in motion.data if path.startswith("events/")}:
        times = motion[f"events/{name}/t"]
        members = [motion[f"events/{name}/{index}"] for index in (("i", "j") if name == "hit" else ("i",))]
        found += [(float(t), name, tuple(map(int, one))) for t, *one in zip(times, *members)]
    found.sort()
    assert [one[1:] for one in found] == [one[1:] for one in expected]
    assert np.allclose([one[0] for one in found], [one[0] for one in expected], rtol=0.0, atol=1e-6)
