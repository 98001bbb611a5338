"""L + dF/dt gives the motion of L, however steep F is: its terms are left out before anything is rounded."""

from __future__ import annotations

import math
import random

import pytest

import lagrange_cli as lagrange
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.variables import graph_of
from tests.support.motion import model_of

FREE = "x_dot**2/2 + y_dot**2/2"
SYSTEM = """
parameters: {a: 0.7, w: 0.003}
coordinates: {x: {initial: 0.1, velocity: 1}, y: {initial: -0.3, velocity: 0.4}}
lagrangian: LAGRANGIAN
"""


def left(given: str):
    """L as given, and what of it acts, as nodes of one graph, beside what acts for a free particle."""
    model = model_of(SYSTEM.replace("LAGRANGIAN", given))
    return acting(model, graph_of(model), model.lagrangian), model.lagrangian


TOTAL = [
    "x_dot*exp(-((x - a)/w)**2)",
    "-2*((x - a*t)/w)*exp(-((x - a*t)/w)**2)*(x_dot - a)/w",
    "(y*x_dot + x*y_dot)*cos(x*y)",
    "cos(x)*x_dot*exp(t) + sin(x)*exp(t)",
    "(x_dot + y_dot)*tanh((x + y)/w) + y_dot*exp(-t/w) - y*exp(-t/w)/w",
    "(x_dot - y_dot)*max(0, x - y)",
    "where(x < y, 0, 1)*(x_dot - y_dot)*exp(x - y)",
]


@pytest.mark.parametrize("term", TOTAL)
def test_a_total_derivative_acts_on_nothing(term: str) -> None:
    free, _ = left(FREE)
    found, given = left(f"{FREE} + {term}")
    assert found is not given and repr(found) == repr(free)


def test_several_are_found_beside_what_acts() -> None:
    both = f"{FREE} + {TOTAL[3]} + {TOTAL[0]} + {TOTAL[2]} - cos(x)*y**2"
    assert repr(left(both)[0]) == repr(left(f"{FREE} - cos(x)*y**2")[0])


@pytest.mark.parametrize(
    "term",
    [
        "x_dot*y",
        "x_dot*exp(-((y - a)/w)**2)",
        "cos(x)*x_dot*exp(t) + 2*sin(x)*exp(t)",
        "where(x < 1, 0, 1)*y_dot",  # its curl is 0 but for an infinite one where x = 1
        "where(t < 1, 0, 1)*x_dot*exp(x)",
        "(x*y_dot - y*x_dot)/(x**2 + y**2)*x",
        "y_dot*atan2(y, x)*x",
    ],
)
def test_what_acts_is_kept(term: str) -> None:
    found, given = left(f"{FREE} + {term}")
    assert found is given


def test_steep_ones_with_decimals_leave_a_uniform_motion() -> None:
    source = random.Random()
    seed = source.randrange(10**6)
    source.seed(seed)
    a, c, w = (round(source.uniform(0.3, 2), 3) for _ in range(3))
    u = f"((x - {c}*t)/{w / 1000:.6f})"
    text = f"""
coordinates: {{x: {{initial: 0.1, velocity: {a}}}}}
lagrangian: x_dot**2/2 - 2*{a}*{u}*exp(-{u}**2)*(x_dot - {c})/{w / 1000:.6f}
"""
    motion = lagrange.solve(text, stop=4, samples=5, outputs="q,v")
    for t, x, v in zip(motion.t, motion.q["x"], motion.v["x"]):
        assert math.isclose(v, a, rel_tol=1e-15), seed
        assert math.isclose(x, 0.1 + a * t, rel_tol=1e-15), seed
