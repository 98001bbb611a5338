"""Edges of domains that the equations do not show: motions end there, at a time that an integral gives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import lagrange_cli as lagrange
from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

WIRE = """
    coordinates: {{x: {{initial: 0.3, velocity: 0.8}}}}
    masses: {{bead: 1}}
    positions: {{bead: [x, "{wire}"]}}
    potential: -0.4*x
    """
LINE = """
    coordinates: {{x: {{initial: 0.5, velocity: -0.2}}, y: {{initial: 1, velocity: -1}}}}
    masses: {{p: 1}}
    positions: {{p: [x, y]}}
    {more}
    """
SLOPES = {
    "1.3*(2 - x)**1.5": lambda u: 1.95 * u**0.5,
    "0.9*(2 - x)**2.5": lambda u: 2.25 * u**1.5,
    "sqrt(1.4*(2 - x))**2": lambda u: 1.4,
    "(2 - x)*log(2 - x)": lambda u: math.log(u) + 1.0,
    "1.2*sqrt(2 - x)": lambda u: 0.6 * u**-0.5,
    "1.7*asin(x/2)": lambda u: 1.7 / math.sqrt(u * (4.0 - u)),
}
"""Wires that end at x = 2, with the size of their slopes at 2 - u."""


def arrival(slope):
    """The time of the end: of v dt = ds, with v^2/2 - 0.4 x constant; where x = 2 - s^6, all is smooth."""
    first = 0.64 * (1.0 + slope(1.7) ** 2)

    def integrand(s):
        u = max(s**6, 1e-250)
        return math.sqrt((1.0 + slope(u) ** 2) / (first + 0.8 * (1.7 - u))) * 6.0 * s**5

    return quad(integrand, 0.0, 1.7 ** (1 / 6), epsabs=1e-13, epsrel=1e-12, limit=200)[0]


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("setup", ["taylor", "double-double"])
@pytest.mark.parametrize("wire", SLOPES)
def test_a_bead_leaves_the_end_of_a_wire(wire, setup):
    expected = arrival(SLOPES[wire])
    with pytest.raises(lagrange.MotionError, match="reaches") as caught:
        lagrange.solve(
            WIRE.format(wire=wire),
            stop=3 * expected,
            samples=3,
            **({"precision": setup} if setup != "taylor" else {}),
        )
    ended = float(str(caught.value).partition("at t = ")[2].partition(",")[0])
    assert ended == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    "more",
    [
        "potential: 1e-4*sqrt(x)*sqrt(x)",
        "dissipation: 1e-9*(sqrt(x)*x_dot)**2",
        "definitions: {root: sqrt(x)}\n    generalized_forces: {y: 1e-9*root**2}",
    ],
)
def test_what_is_simplified_has_the_domain_of_what_is_written(more):
    motion = follow(LINE.format(more=more), 4.0, 9)
    assert motion.outcome.ending is Ending.EDGE
    assert motion.outcome.final.q["x"] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    "potential",
    [
        "where(x > 0, sqrt(x)*sqrt(x), 0)*0.01",
        "0.01*max(0, x)**1.5 + 0.01*abs(x)**1.5",
        "0.01*sqrt(1 + x**2)**2",
    ],
)
def test_what_need_not_have_a_value_ends_nothing(potential):
    motion = follow(LINE.format(more=f"potential: {potential}"), 4.0, 9)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.final.q["x"] < 0.0


def test_an_action_beyond_an_edge_ends_the_motion():
    more = "potential: 1e-4*sqrt(x)*sqrt(x)\n    events: {e: {when: y, action: {set: {x: -0.1}}}}"
    with pytest.raises(lagrange.MotionError, match=r"x is -0.1 in sqrt\(x\) \(line 5\) at t = 1,"):
        lagrange.solve(LINE.format(more=more), stop=4)


def test_members_of_a_sweep_and_motions_backward_end_there_too():
    text = LINE.format(more="potential: 0*y + 1e-4*sqrt(x)*sqrt(x)")
    with pytest.warns(lagrange.LagrangeWarning, match="x reaches 0 in sqrt"):
        swept = lagrange.sweep(text, over={"x_dot": np.linspace(-0.3, 0.3, 9)}, stop=4)
    own = [0.5 + 4 * v - 8e-4 > 0.0 for v in np.linspace(-0.3, 0.3, 9)]
    assert [one == "complete" for one in swept.statuses] == own
    motion = follow(text.replace("-0.2", "0.2"), -4.0, 9)
    assert motion.outcome.ending is Ending.EDGE


def test_methods_that_do_not_notice_say_so():
    text = LINE.format(more="potential: 1e-4*sqrt(x)*sqrt(x)")
    with pytest.warns(lagrange.LagrangeWarning, match="does not notice where a root"):
        lagrange.solve(text, stop=1, method="LSODA")
