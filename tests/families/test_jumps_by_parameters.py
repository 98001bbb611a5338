"""Forces and energies that jump with some values of the parameters and not with others: families pass there,
beside the same systems written out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from lagrange_cli.families.system import any_family_system
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_switches import BY_RATES, LEDGERS, compare, followed, ready

TRAIN = """
sizes: {{N: {count}}}
parameters: {{k: {k}, b: {b}, c: 0.3, F: {F}, mu: {mu}}}
coordinates:
  "x[i in range(N)]": {{initial: "-2*i + 0.03*sin(5*i)", velocity: "{speed}*sin(3*i + 1)"}}
masses: {{"car[i in range(N)]": 1 + i % 2}}
embedding: {{"car[i in range(N)]": ["x[i]"]}}
potential: "sum(k*max(0, abs(x[i] - x[i + 1] - 2) - b)**2/2 for i in range(N - 1)) - F*x[0]"
dissipation: "sum(mu*abs(x_dot[i]) for i in range(N))
  + sum(c*(x_dot[i] - x_dot[i + 1])**2/2 for i in range(N - 1))"
"""
POLYMER = """
sizes: {{N: {count}}}
parameters: {{s: 1.1, R: {R}, L: 3.5, w: {k}}}
coordinates:
  "x[i in range(N)]": {{initial: "1.05*i - 3", velocity: "{speed}*sin(3*i + 1)"}}
  "y[i in range(N)]": {{initial: "0.2*cos(2*i)", velocity: "{speed}*cos(5*i)"}}
masses: {{"p[i in range(N)]": 1 + i % 2}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential:
  repulsion: "sum(where(norm(p[i] - p[j]) < R, (s/norm(p[i] - p[j]))**12 - (s/norm(p[i] - p[j]))**6 + 1/4, 0)
    for i in range(N) for j in range(i))"
  springs: "sum(-9*log(1 - dot(p[i + 1] - p[i], p[i + 1] - p[i])/4) for i in range(N - 1))"
  walls: "sum(w*max(0, abs(x[i]) - L)**2/2 + w*max(0, abs(y[i]) - L/9)**2/2 for i in range(N))"
"""

CARS = """
sizes: {{N: {count}}}
parameters: {{v0: 30, a: {F}, b: {k}, T: 1.2, s0: 2}}
coordinates:
  "x[i in range(N)]": {{initial: "-25*i - 3*sin(7*i)", velocity: "20 + 9*{speed}*sin(3*i + 1)"}}
masses: {{"car[i in range(N)]": 1 + i % 2}}
embedding: {{"car[i in range(N)]": ["x[i]"]}}
potential: 0
definitions:
  "wanted[i in range(1, N)]":
    "s0 + max(0, x_dot[i]*T + x_dot[i]*(x_dot[i] - x_dot[i - 1])/(2*sqrt(a*b)))"
generalized_forces:
  "x[0]": "a*where(t < 5, 1 - (x_dot[0]/v0)**4, -2)"
  "x[i in range(1, N)]": "a*(1 - (x_dot[i]/v0)**4 - (wanted[i]/(x[i - 1] - x[i] - 5))**2)"
"""


@dataclass(frozen=True)
class Draw:
    """Numbers of a system."""

    count: int
    seed: int

    def text(self, form: str, *, b: float | None = None) -> str:
        """The text of a system file with random numbers."""
        chance = np.random.default_rng(self.seed)
        k, play, force, mu, speed = chance.uniform([20, 0.02, 0.3, 0.05, 0.2], [90, 0.09, 2.0, 0.4, 0.9])
        play = play if b is None else b
        given = {"k": k, "b": play, "F": force, "mu": mu, "speed": speed, "R": 1.1 * 2 ** (1 / 6)}
        return form.format(count=self.count, **given)


DRAWS = pytest.mark.parametrize("draw", [Draw(count, count) for count in (1, 2, 3, 8, 9)], ids=repr)


@pytest.mark.exhaustive(keep=0.15)
@DRAWS
def test_trains_with_play_and_dry_friction(draw: Draw, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(draw.text(TRAIN), monkeypatch)


@pytest.mark.exhaustive(keep=0.5)
@BY_RATES
@DRAWS
def test_trains_in_steps_on_rates(draw: Draw, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(draw.text(TRAIN), monkeypatch, method=method)


@pytest.mark.exhaustive(keep=0.4)
@DRAWS
def test_cars_that_follow_one_another(draw: Draw, monkeypatch: pytest.MonkeyPatch) -> None:
    """The root of parameters in a side is a number (Treiber, Hennecke and Helbing 2000, eq. 3)."""
    compare(draw.text(CARS), monkeypatch, stop=8.0)


@pytest.mark.exhaustive(keep=0.15)
def test_ledgers_of_trains(monkeypatch: pytest.MonkeyPatch) -> None:
    compare(Draw(3, 7).text(TRAIN), monkeypatch, LEDGERS)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("count", [2, 3])
def test_polymers_whose_repulsion_is_cut_off_at_a_rounded_number(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """U jumps by rounding there, and the walls jump where L is negative."""
    compare(Draw(count, count).text(POLYMER), monkeypatch, stop=0.4, method="ias15")


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("seed", range(6))
def test_a_negative_play_holds_members_or_ends_the_motion(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where members would have to be held, the motion ends: what it has come to is that of the members."""
    text = Draw(3, seed).text(TRAIN, b=-0.02)
    keep_families(monkeypatch, whole=True)
    system = any_family_system(read_spec(text, "system.yaml"))
    assert system is not None
    assert system.passes
    found = followed(ready(text), text, 3.0)
    keep_families(monkeypatch, whole=False)
    expected = followed(ready(text), text, 3.0)
    done = len(found.data["t"])
    assert done == len(expected.data["t"]) or found.outcome.ending is not Ending.COMPLETE
    for path in ("q/x", "v/x"):
        np.testing.assert_allclose(found.data[path], expected.data[path][:done], rtol=0.0, atol=1e-9)
