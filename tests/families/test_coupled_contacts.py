"""Resting contacts of families that depend on one another or on constraints, beside the same written out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families import elimination
from lagrange_cli.families import system as systems
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.system import any_family_system, reason
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.spec.read import read_spec
from tests.families.test_actions import BOBS
from tests.families.test_events import keep_families
from tests.families.test_switches import METHODS, OUTPUTS, followed, ready

FLOOR = """
events:
  "hit[i in range(N)]": {{when: "y[i]", direction: falling, action: {{set: {{"y_dot[i]": "-{e}*y_dot[i]"}}}}}}
"""
SLOPE = """
definitions: {{"rate[i in range(N)]": "(1 + {e})*(y_dot[i] - 0.3*x_dot[i])/1.09"}}
events:
  "hit[i in range(N)]":
    when: "y[i] - 0.3*x[i] + 0.5"
    direction: falling
    action: {{set: {{"y_dot[i]": "y_dot[i] - rate[i]", "x_dot[i]": "x_dot[i] + 0.3*rate[i]"}}}}
"""
PILE = """
sizes: {{N: {count}}}
parameters: {{g: 9.8, e: {e}, "m[i in range(N)]": "1 + 0.3*i"}}
coordinates: {{"y[i in range(N)]": {{initial: "1.1*i + 0.4", velocity: "-0.3*i"}}}}
masses: {{"ball[i in range(N)]": "m[i]"}}
embedding: {{"ball[i in range(N)]": [0, "y[i]"]}}
potential: "sum(m[i]*g*y[i] for i in range(N))"
events:
  floor: {{when: "y[0]", direction: falling, action: {{set: {{"y_dot[0]": "-e*y_dot[0]"}}}}}}
  "hit[i in range(1, N)]":
    when: "y[i] - y[i - 1] - 1"
    direction: falling
    action:
      set:
        "y_dot[i]": "y_dot[i] - (1 + e)*m[i - 1]/(m[i] + m[i - 1])*(y_dot[i] - y_dot[i - 1])"
        "y_dot[i - 1]": "y_dot[i - 1] + (1 + e)*m[i]/(m[i] + m[i - 1])*(y_dot[i] - y_dot[i - 1])"
"""
LIFT = """
sizes: {{N: {count}}}
coordinates: {{"y[i in range(N)]": {{initial: "0.3 + 0.1*i"}}}}
masses: {{"ball[i in range(N)]": "1 + i/3"}}
embedding: {{"ball[i in range(N)]": [0, "y[i]"]}}
potential: "sum(9.8*(1 + i/3)*y[i] for i in range(N))"
events:
  "floor[i in range(N)]":
    {{when: "y[i]", direction: falling, action: {{set: {{"y_dot[i]": "-{e}*y_dot[i]"}}}}}}
  "lift[i in range(N)]":
    when: "y[i] - 0.4*t + 0.5"
    direction: falling
    action: {{set: {{"y_dot[i]": "0.4 - {e}*(y_dot[i] - 0.4)"}}}}
"""
SOFT = BOBS.replace("*g*y[i] for", "*g*y[i] + 9*max(0, 0.4 - y[i])**2 for")
CASES = {
    "bobs on rods": BOBS + FLOOR,
    "bobs on springs": SOFT + FLOOR,
    "bobs on a slope": BOBS + SLOPE,
    "a pile": PILE,
    "lifts": LIFT,
}
SAMPLES = 2.0**-27
"""A bound for samples: impacts make rounding errors grow."""


def motion(
    text: str, stop: float, *, whole: bool, patch: pytest.MonkeyPatch, method: str = "taylor"
) -> Mapping[str, NDArray[np.float64]]:
    """A motion, as one of families or written out."""
    keep_families(patch, whole=whole)
    if whole:
        asked = Compilation(method, METHODS[method], OUTPUTS)
        assert family_run(read_spec(text, "system.yaml"), asked) is not None
    return followed(ready(text, method=method), text, stop).data


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("e", [0, 0.3])
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_contacts_hold_as_written_out(
    case: str, count: int, e: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = CASES[case].format(count=count, e=e)
    stop = 0.8 if case == "bobs on a slope" else 1.6
    found, expected = (motion(text, stop, whole=whole, patch=monkeypatch) for whole in (True, False))
    for path in ("t", "q/x", "q/y", "v/x", "v/y"):
        if path in expected:
            assert np.max(np.abs(found[path] - expected[path])) <= SAMPLES, path


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize(("count", "e"), [(16, 0), (10, 0.4)])
def test_a_chain_of_rods_comes_to_rest_on_a_floor(
    count: int, e: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No bob falls through it, each impact takes energy away, and in the end all of them lie on it."""
    text = (BOBS + FLOOR).format(count=count, e=e)
    found = motion(text, 2.6, whole=True, patch=monkeypatch)
    y, h = found["q/y"], found["diagnostics/h"]
    assert np.all(y >= -1e-12)
    assert np.all(np.diff(h) <= 1e-10 * h[0])
    assert np.all(np.abs(y[-1]) <= 1e-12) and np.all(np.abs(found["v/y"][-1]) <= 1e-10)


@pytest.mark.exhaustive(keep=0.15)
def test_dense_factors_pass_over_contacts_that_do_not_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of the matrix come and go as bodies touch, and part."""
    text = CASES["bobs on rods"].format(count=9, e=0)
    expected = motion(text, 0.6, whole=True, patch=monkeypatch)
    monkeypatch.setattr(elimination, "MOST", 0)
    monkeypatch.setattr(systems, "_LATEST", [])
    system = any_family_system(read_spec(text, "system.yaml"))
    assert system is not None and isinstance(system.contacts, Coupled)
    assert system.contacts.bonds.elimination is None
    found = motion(text, 0.6, whole=True, patch=monkeypatch)
    assert len(found["events/hit/t"]) > 50
    for path in ("q/y", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= SAMPLES, path


@pytest.mark.exhaustive(keep=0.35)
def test_what_rests_alone_rests_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    found = motion(CASES["a pile"].format(count=3, e=0.2), 5.0, whole=True, patch=monkeypatch)
    assert found["q/y"][-1, 0] == 0.0
    assert np.allclose(found["q/y"][-1], [0.0, 1.0, 2.0], rtol=0.0, atol=1e-14)
    assert np.allclose(found["v/y"][-1], 0.0, rtol=0.0, atol=1e-14)


def test_impacts_that_push_elsewhere_are_written_out() -> None:
    text = (BOBS + FLOOR).format(count=12, e=0.5)
    text = text.replace(
        '"y_dot[i]": "-0.5*y_dot[i]"',
        '"y_dot[i]": "-0.5*y_dot[i]", "x_dot[i]": "0.9*x_dot[i] + 0.1*y_dot[i]"',
    )
    spec = read_spec(text, "system.yaml")
    assert any_family_system(spec) is None
    assert "along the gradient" in reason(spec)[0]
