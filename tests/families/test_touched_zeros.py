"""Zeros that expressions of families of events touch are no crossings, or two (see the same of motions)."""

from __future__ import annotations

import random
import re
from collections import defaultdict

import numpy as np
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import OUTPUTS, followed, keep_families, ready
from tests.motions.test_touched_zeros import FLAT, OTHER, TOUCHED, apart, parities, zeros

STOP = 6.0
OSCILLATORS = """
sizes: {{N: {count}}}
parameters: {{"a[i in range(N)]": "{a!r} - 0.01*i", "b[i in range(N)]": "{b!r} - 0.01*i"}}
coordinates: {{"x[i in range(N)]": {{initial: 0, velocity: 1}}}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(x[i]**2/2 for i in range(N))
events: {{"touch[i in range(N)]": {{when: "{when}"}}}}
"""
METHODS = pytest.mark.parametrize("method", ["taylor", "ias15"])


@pytest.fixture
def source(request: pytest.FixtureRequest) -> random.Random:
    return random.Random(request.config.option.seed)


def crossings(
    source: random.Random, when: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> list[tuple[float, float, list[float]]]:
    """Of each oscillator x = sin t the places a and b, and when its event happens."""
    keep_families(monkeypatch, whole=True)
    count, (a, b) = source.choice((1, 3, 9)), apart(source)
    when = re.sub(r"\b(x_dot|[xab])\b", r"\1[i]", when)
    text = OSCILLATORS.format(count=count, a=a, b=b, when=when)
    assert family_run(read_spec(text, "system.yaml"), Compilation(method, 2.0**-52, OUTPUTS)) is not None
    found, times = followed(ready(text, method), text, STOP), defaultdict[int, list[float]](list)
    for i, t in zip(found.get("events/touch/i", ()), found.get("events/touch/t", ())):
        times[int(i)].append(float(t))
    return [(a - 0.01 * i, b - 0.01 * i, times[i]) for i in range(count)]


@pytest.mark.exhaustive(keep=1)
@METHODS
@pytest.mark.parametrize("other", OTHER)
@pytest.mark.parametrize("touched", TOUCHED[:2])
def test_factors_that_are_never_negative_change_no_sign(
    touched: str, other: str, method: str, source: random.Random, monkeypatch: pytest.MonkeyPatch
) -> None:
    touched = touched.format(even=source.choice((2, 4, 6)), any=source.choice((1, 2, 3)))
    for _, b, times in crossings(source, f"{touched}*{other}", method, monkeypatch):
        assert times == pytest.approx(zeros(b), abs=1e-11)


@pytest.mark.exhaustive(keep=1)
@METHODS
@pytest.mark.parametrize("when", ["a polynomial", "with a speed"])
def test_where_rounding_crosses_0_it_comes_back(
    when: str, method: str, source: random.Random, monkeypatch: pytest.MonkeyPatch
) -> None:
    for a, _, times in crossings(source, FLAT[when], method, monkeypatch):
        assert parities(np.array(times), a) == [0, 0], (a, times)
