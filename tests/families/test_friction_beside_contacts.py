"""Families whose members rub and hit stops, at which they may rest: beside the same written out."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families.system import any_family_system
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import followed, keep_families, ready

SYSTEM = """
sizes: {{N: {count}}}
coordinates:
  "x[i in range(N)]": {{initial: "{x} + i/50", velocity: "{v}*cos(2*i)"}}
  "y[i in range(N)]": {{initial: "(10 + i)/100", velocity: 0.4}}
masses: {{"p[i in range(N)]": 1 + i/5}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "{coupling}"
generalized_forces:
  "x[i in range(N)]": "{drive} - {limit}*sign(x_dot[i]{belt})"
  "y[i in range(N)]": "-9.81 + {shaken}*cos(4*t)"
events:
  "right[i in range(N)]":
    {{when: "x[i] - {wall}", direction: rising, action: {{set: {{"x_dot[i]": "-{e}*x_dot[i]"}}}}}}
  "left[i in range(N)]":
    {{when: "x[i] + {wall}", direction: falling, action: {{set: {{"x_dot[i]": "-{e}*x_dot[i]"}}}}}}
  "floor[i in range(N)]":
    {{when: "y[i]", direction: falling, action: {{set: {{"y_dot[i]": "-{e}*y_dot[i]"}}}}}}
"""
DRIVES = "{a}*cos({w}*t + i)", "{a}", "{a}*sin({w}*t) - {k}*x[i]", "{a}*sin(3*t)*x[i]**2"
LIMITS = "{f}", "({f} + x[i]**2/3)", "{f}*(1 + i/3)"
BELTS = "", " - {w}/3", " - cos({w}*t)/3"
COUPLINGS = (
    "0",
    "sum({k}*(x[i] - x[i - 1])**2/2 for i in range(1, N))",
    "sum(2*(y[i] - x[i])**2 for i in range(N))",
)


def drawn(chance: random.Random, count: int) -> str:
    """The text of a random system."""
    a, w, k, f = (round(chance.uniform(*one), 3) for one in ((-4, 4), (0.5, 3), (0.5, 5), (0.1, 1.5)))
    parts = {
        name: chance.choice(forms).format(a=a, w=w, k=k, f=f)
        for name, forms in (("drive", DRIVES), ("limit", LIMITS), ("belt", BELTS), ("coupling", COUPLINGS))
    }
    x, v, wall, e = (round(chance.uniform(*one), 3) for one in ((-0.2, 0.2), (-3, 3), (0.3, 1.2), (0.1, 0.8)))
    return SYSTEM.format(count=count, x=x, v=v, wall=wall, e=e, shaken=chance.choice([0, 5, 15]), **parts)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", range(4))
def test_motions_are_those_of_the_members(
    case: int, count: int, method: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{request.config.option.seed} {case}"), count)
    keep_families(monkeypatch, whole=True)
    one = ready(text, method)
    keep_families(monkeypatch, whole=False)
    other = ready(text, method)
    assert one.machine.program.loops and not other.machine.program.loops
    found, expected = (followed(each, text, 3.0) for each in (one, other))
    for path, samples in expected.items():
        if not path.startswith("events/"):
            size = max(1.0, float(np.max(np.abs(samples))))
            assert found[path] == pytest.approx(samples, rel=0, abs=1e-9 * size), (path, text)


PAIR = """
sizes: {N: 2}
coordinates: {"x[i in range(N)]": {initial: i}}
masses: {"p[i in range(N)]": 1}
embedding: {"p[i in range(N)]": "x[i]"}
generalized_forces: {"x[i in range(N)]": "-x[i] - sign(x_dot[i])/9"}
events:
  "hit[i in range(1, N)]":
    when: "x[i] - x[i - 1] - 0.1"
    direction: falling
    action:
      set: {"x_dot[i]": "(x_dot[i] + 3*x_dot[i - 1])/4", "x_dot[i - 1]": "(3*x_dot[i] + x_dot[i - 1])/4"}
"""


def test_what_rubs_and_touches_one_another_is_written_out() -> None:
    """Forces between them decide what friction holds."""
    assert any_family_system(read_spec(PAIR, "system.yaml")) is None
    assert any_family_system(read_spec(PAIR.replace(" - sign(x_dot[i])/9", ""), "system.yaml")) is not None
