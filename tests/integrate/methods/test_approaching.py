"""Steps of ``Radau`` do not pass over narrow forces: they become shorter before one may act. (Where some may
be missed there is a warning, which would be an error here.)"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.errors import LagrangeWarning
from lagrange_cli.families import system as systems
from lagrange_cli.native.rates import collocation

COASTING = """
sizes: {{N: {count}}}
parameters: {{w: {width}, mu: 1}}
coordinates: {{"x[i in range(N)]": {{initial: 0, velocity: 1 + i/8}}}}
masses: {{"m[i in range(N)]": 1}}
embedding: {{"m[i in range(N)]": "x[i]"}}
potential: 0
generalized_forces: {{"x[i in range(N)]": "{force}"}}
solve: {{stop: 4, samples: 9, tolerance: 1e-8}}
"""
PASSING = """
parameters: {{w: {width}, E: {height}}}
coordinates: {{x: {{initial: -1, velocity: 1}}}}
lagrangian: x_dot**2/2 - {potential}
generalized_forces: {{x: 0}}
solve: {{stop: 2, samples: 3, tolerance: 1e-7}}
"""
NARROW = {
    "a core": "E*exp(-(x/w)**2)",
    "a step": "E*(1 + tanh(x/w))/2",
    "a softened step": "E*(1 + x/sqrt(x**2 + w**2))/2",
    "a pole": "E/(1 + (x/w)**2)**3",
    "an exponential": "E*exp((x - 0.1)/w)",
}


@pytest.fixture(params=["in loops", "written out"])
def loops(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether families stay families, however few their members are."""
    if request.param == "in loops":
        monkeypatch.setattr(systems, "FEWEST", 0)
    return request.param == "in loops"


@pytest.mark.parametrize("width", [1e-2, 1e-5])
def test_friction_that_brings_to_rest(loops: bool, width: float) -> None:
    """dv/dt = -tanh(v/w): sinh(v/w) = sinh(v0/w) exp(-t/w)."""
    text = COASTING.format(count=6, width=width, force="-mu*tanh(x_dot[i]/w)")
    motion = lagrange_cli.solve(text, method="Radau")
    for i in range(6):
        v0, v = 1 + i / 8, motion.v["x"][:, i]
        left = v0 - motion.t  # log sinh(v/w) = (v0 - t)/w - log 2, nearly
        expected = width * np.arcsinh(np.exp(np.minimum(left / width, 700)) / 2)
        expected = np.where(left > 600 * width, left, expected)
        assert np.max(np.abs(v - expected)) < 1e-6
        assert motion.q["x"][-1, i] == pytest.approx(v0**2 / 2, abs=1e-5 + width**2)


@pytest.mark.parametrize("force", ["-mu*atan(x_dot[i]/w)", "-mu*x_dot[i]/sqrt(x_dot[i]**2 + w**2)"])
def test_other_friction(loops: bool, force: str) -> None:
    text = COASTING.format(count=4, width=1e-3, force=f"{force} + sin(2*t)/2")
    motion, series = (lagrange_cli.solve(text, method=one, tolerance=1e-8) for one in ("Radau", "taylor"))
    assert np.max(np.abs(motion.q["x"] - series.q["x"])) < 1e-6


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize("height", [0.4, 0.6])
def test_what_is_passed(name: str, height: float) -> None:
    """Of a kinetic energy of 1/2: a particle passes or returns, and keeps its energy."""
    width = 10 ** -random.uniform(1.5, 5)
    print(f"width {width:g}")
    motion = lagrange_cli.solve(
        PASSING.format(potential=NARROW[name], width=width, height=height), method="Radau", stop=4
    )
    v = motion.v["x"][-1]
    if name in ("a core", "a pole"):
        assert v == pytest.approx(1 if height < 0.5 else -1, abs=1e-4)
    elif name == "an exponential":
        assert v == pytest.approx(-1, abs=1e-4)
    else:
        beyond = math.sqrt(1 - 2 * height) if height < 0.5 else -1
        assert v == pytest.approx(beyond, abs=1e-3 + 2 * width)


def test_steps_that_become_shorter_make_the_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the bound a particle passes a wall, which is 1e-5 wide, as if it were not there."""
    text = PASSING.format(potential=NARROW["a core"], width=1e-5, height=0.6)
    seen = lagrange_cli.solve(text, method="Radau", cache=False)
    monkeypatch.setattr(collocation, "NEARER", 1e300)
    with pytest.warns(LagrangeWarning, match="h drifted"):
        missed = lagrange_cli.solve(f"{text}# again", method="Radau", cache=False)
    assert (seen.v["x"][-1], missed.v["x"][-1]) == pytest.approx((-1, 1), abs=1e-4)
    assert missed.attributes["steps"] < seen.attributes["steps"] < 200


@pytest.mark.parametrize(
    "potential", ["E*exp(-((x**2 - 1/4)/w)**2)", "E/cosh(x**2/w - 1)", "E*exp(-((x - cos(t))/w)**2)"]
)
def test_what_may_be_missed(potential: str) -> None:
    """Nothing convex tells where these begin to act."""
    with pytest.warns(LagrangeWarning, match="does not detect narrow forces"):
        lagrange_cli.solve(PASSING.format(potential=potential, width=0.1, height=0.1), method="Radau")
