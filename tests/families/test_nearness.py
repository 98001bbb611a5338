"""Arguments of events that cannot become 0 within a step have no series: nothing else may change."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.native.families import nearness
from tests.families.test_events import followed, keep_families, ready

DISCS = 9
WHENS = {
    "squares": "(x[i] - x[j])**2 + (y[i] - y[j])**2 - 4*R**2",
    "norms": "norm(disc[i] - disc[j]) - 2*R",
    "cubes": "((x[i] - x[j])**2 + (y[i] - y[j])**2)**1.5 - 8*R**3",
}
FORCES = {
    "none": "0",
    "gravity": "sum(g*y[i] for i in range(N))",
    "a trap": "sum((x[i] - 0.5)**4 + cos(3*y[i] + t) for i in range(N))",
    "springs": "sum(k[i]*((x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2) for i in range(1, N))",
}
FURTHER = {
    "nothing": "",
    "a moving wall": """
  lid[i in range(N)]: {when: y[i] - 0.8 - 0.1*sin(3*t), direction: rising}""",
    "speeds": """
  fast[i in range(N)]: {when: "x_dot[i]**2 + y_dot[i]**2 - 0.8"}
  above[i in range(N), j in range(i) if (i + j) % 3]: {when: "sin(3*x[i]) - u*cos(x[j])"}""",
    "a parameter": """
  lamp: {when: "x[0] - 0.3", action: {set: {u: "u + 0.05"}}}
  lit[i in range(N)]: {when: "x[i] + sum(0.1*y[m] for m in range(N)) - u"}""",
}


def gas(seed: int) -> str:
    """Discs in a box, with walls and contacts of random elasticity, in a random order of statements."""
    chance = np.random.default_rng(seed)
    chosen = {name: str(chance.choice([*one])) for name, one in (("when", WHENS), ("force", FORCES))}
    further = FURTHER[str(chance.choice([*FURTHER]))]
    e = 1.0
    if chosen["when"] == "squares" and chosen["force"] in ("none", "gravity"):  # discs do not rest on others
        e = chance.choice([1.0, 0.9])
    a, b, c, d = chance.uniform(0.5, 40.0, 4).round(3)
    return f"""
sizes: {{N: {DISCS}}}
parameters: {{R: 0.06, g: 2, u: 0.6, "k[i in range(N)]": 1 + i/10}}
coordinates:
  x[i in range(N)]: {{initial: "0.2 + 0.3*(i % 3) + 0.03*sin({a}*i)", velocity: "sin(1 + {b}*i*i)"}}
  y[i in range(N)]: {{initial: "0.2 + 0.3*(i//3) + 0.03*cos({c}*i)", velocity: "cos(2 + {d}*i*i)"}}
masses: {{"disc[i in range(N)]": 1}}
positions: {{"disc[i in range(N)]": ["x[i]", "y[i]"]}}
potential: {FORCES[chosen["force"]]}
definitions:
  push[i in range(N), j in range(i)]: >-
    {(1 + e) / 2}*((x_dot[i] - x_dot[j])*(x[i] - x[j]) + (y_dot[i] - y_dot[j])*(y[i] - y[j]))
    /((x[i] - x[j])**2 + (y[i] - y[j])**2)
events:
  hit[i in range(N), j in range(i)]:
    when: {WHENS[chosen["when"]]}
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] - push[i,j]*(x[i] - x[j])
        y_dot[i]: y_dot[i] - push[i,j]*(y[i] - y[j])
        x_dot[j]: x_dot[j] + push[i,j]*(x[i] - x[j])
        y_dot[j]: y_dot[j] + push[i,j]*(y[i] - y[j])
  left[i in range(N)]: {{when: "x[i] - R", direction: falling, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
  right[i in range(N)]: {{when: 1 - R - x[i], direction: falling, action: {{set: {{"x_dot[i]": -x_dot[i]}}}}}}
  low[i in range(N)]: {{when: "y[i] - R", direction: falling, action: {{set: {{"y_dot[i]": "-y_dot[i]"}}}}}}
{further}
"""


def found_of(text: str, fewest: int, monkeypatch: pytest.MonkeyPatch) -> Mapping[str, NDArray[np.float64]]:
    """A motion whose steps look for arguments that need series if there are so many."""
    monkeypatch.setattr(nearness, "FEWEST", fewest)
    prepared = ready(text)
    assert prepared.machine.program.loops
    assert ("@motion(" in prepared.machine.program.text) == (fewest == 0)
    return followed(prepared, text, 0.7)


@pytest.mark.exhaustive(keep=0.05)
@pytest.mark.parametrize("seed", range(40))
def test_no_event_is_missed(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same events as where all arguments have series in all steps. Roots are looked for in shorter times,
    and the rounding errors of their last bits grow from impact to impact."""
    text = gas(seed)
    keep_families(monkeypatch, whole=True)
    near, every = found_of(text, 0, monkeypatch), found_of(text, 10**9, monkeypatch)
    assert near.keys() == every.keys()
    assert sum(len(near[path]) for path in near if path.endswith("/t")) > 5
    for path, values in every.items():
        assert near[path].shape == values.shape, path
        assert np.max(np.abs(near[path] - values), initial=0.0) <= 2.0**-37, path


ALIKE = """
sizes: {N: 24}
parameters: {g: 9.81, e: 0.5}
coordinates: {"z[i in range(N)]": {initial: "HEIGHT"}}
masses: {"ball[i in range(N)]": "1 + i"}
positions: {"ball[i in range(N)]": [0, "z[i]"]}
potential: sum((1 + i)*g*z[i] for i in range(N))
events:
  "hit[i in range(N)]": {when: "z[i]", direction: falling, action: {set: {"z_dot[i]": "-e*z_dot[i]"}}}
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("heights", ["0.55", "0.5 + 0.001*i", "0.3 + 0.1*(i//8)"])
def test_forces_of_contact_that_last_are_known_at_single_states(
    heights: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Balls that come to rest at (1 + e)/(1 - e) sqrt(2 z/g), eight or all of them at a time. The force under
    each is constant: whatever a step takes, it does not become 0."""
    monkeypatch.setattr(nearness, "FEWEST", 0)
    text, stop = ALIKE.replace("HEIGHT", heights), 1.5
    keep_families(monkeypatch, whole=True)
    found = followed(ready(text), text, stop)
    assert found["t"][-1] == stop
    assert np.all(found["q/z"][-1] == 0.0) and np.all(found["v/z"][-1] == 0.0)
    rests = 3.0 * np.sqrt(2.0 * found["q/z"][0] / 9.81)
    times, members = found["events/hit/t"], found["events/hit/i"]
    last = np.array([times[members == i].max() for i in range(24)])
    assert np.allclose(last, rests, rtol=0.0, atol=1e-8)
