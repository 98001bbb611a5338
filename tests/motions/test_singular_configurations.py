"""Linkages that pass configurations where their constraints become dependent, by all methods."""

from __future__ import annotations

import json
import math
import random
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods import leading
from tests.motions.test_double_double import solved
from tests.support.motion import follow

INVERSOR = """
parameters: {{L: {L!r}, s: {s!r}, r: {r!r}, m: 1.3, g: 9.81, a: {a!r}, b: {b!r}}}
coordinates:
  cx: {{initial: r + r*cos(2*a)}}
  cy: {{initial: r*sin(2*a)}}
  ax: {{initial: L*cos(a + b)}}
  ay: {{initial: L*sin(a + b)}}
  bx: {{initial: L*cos(a - b)}}
  by: {{initial: L*sin(a - b)}}
  px: {{initial: (L**2 - s**2)/(2*r)}}
  py: {{initial: (L**2 - s**2)/(2*r)*tan(a)}}
masses: {{C: m, A: m, B: 2*m, P: m}}
positions: {{C: [cx, cy], A: [ax, ay], B: [bx, by], P: [px, py]}}
potential: g*m*(C.y + A.y + 2*B.y + P.y)
constraints:
  crank: (cx - r)**2 + cy**2 - r**2
  oa: norm(A) - L
  ob: norm(B) - L
  ca: norm(A - C) - s
  cb: norm(B - C) - s
  pa: norm(A - P) - s
  pb: norm(B - P) - s
solve: {{stop: 3}}
"""
"""Peaucellier's linkage: P moves along a straight line, and where A and B meet, the rhombus C A P B is
stretched: its constraints become dependent, and the motion turns."""


def inversor(source: random.Random) -> str:
    """One that begins with |OC| = 2 r cos(a) = L cos(b) - s cos(c), where s sin(c) = L sin(b)."""
    while True:
        L, s, r = source.uniform(4, 6), source.uniform(1.6, 2.4), source.uniform(1.7, 2.2)
        b = source.uniform(0.2, min(0.35, 0.95 * math.asin(s / L)))
        cosine = (L * math.cos(b) - math.sqrt(s**2 - (L * math.sin(b)) ** 2)) / (2 * r)
        stretched = (L - s) / (2 * r)
        if 0.1 < stretched < 0.85 and cosine < 0.99:
            return INVERSOR.format(L=L, s=s, r=r, a=math.acos(cosine), b=b)


BOUNDS = {"taylor": 1e-10, "ias15": 1e-8, "DOP853": 1e-5, "Radau": 1e-6}
TOLERANCES = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-10, "Radau": 1e-10}


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", BOUNDS)
def test_an_inversor_passes_where_it_is_stretched(method: str, request: pytest.FixtureRequest) -> None:
    """(Steps of ``DOP853`` may be so long that they lead beyond.)"""
    text = inversor(random.Random(request.config.option.seed))
    motion = follow(text, 3.0, 301, method=method, tolerance=TOLERANCES[method], outputs=("q", "h"))
    assert motion.outcome.ending is Ending.COMPLETE, text
    assert len(motion.outcome.singular) >= 1 or method == "DOP853", text
    assert np.ptp(motion["q/px"]) < BOUNDS[method]
    apart = np.hypot(motion["q/ax"] - motion["q/bx"], motion["q/ay"] - motion["q/by"])
    assert apart.min() < 0.3 < apart.max()


@pytest.mark.exhaustive(keep=0.5)
def test_an_inversor_passes_in_double_double(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    text = inversor(random.Random(request.config.option.seed))
    given = "--precision", "double-double", "--stop", "3", "--samples", "31", "--outputs", "q,h"
    attributes, found = solved(tmp_path, text, *given)
    assert len(json.loads(attributes["singular"])) >= 1, text
    for path in "q/px", "diagnostics/h":
        assert max(found[path]) - min(found[path]) < 1e-20, text


@pytest.mark.parametrize("parts", leading.CHOICES)
def test_polynomials_lead_beyond_what_they_are_known_on(parts: int) -> None:
    """Through 1/(2 - t) before t = 1, whose pole they do not reach; in decimals to more than doubles."""

    def sampled(times: Array) -> Array:
        with localcontext(leading.DECIMALS):
            exact = [1 / (2 - Decimal(float(t))) for t in times]
            high = np.array([[float(one) for one in exact]])
            low = np.array([[float(one - Decimal(float(one))) for one in exact]])
        return np.concatenate([high, low][:parts])

    ways = [*leading.passages(1.0, iter([1.0, 0.5]), sampled, parts, leading.CHOICES[parts].away[-1])]
    assert len(ways) == 2 * len(leading.CHOICES[parts].degrees)
    best = min(ways, key=lambda one: one.error)
    with localcontext(leading.DECIMALS):
        value = sum(Decimal(float(one)) for one in best.at(np.array([best.stop]))[:, 0])
        error = value - 1 / (2 - Decimal(best.stop))
    bound = leading.CHOICES[parts].rounding
    assert best.error < 8 * bound and abs(error) < 8 * bound
    assert best.rates(best.stop)[0] == pytest.approx((2 - best.stop) ** -2, rel=1e-10)
