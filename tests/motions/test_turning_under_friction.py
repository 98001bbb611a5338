"""Friction along the velocity of what turns round: through rest, and close to it. Along a line it is friction
on a spring, with a closed form: half-cycles about places that are shifted to and fro."""

from __future__ import annotations

import random

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

SPRING = """
parameters: {k: 30, stiffer: 2, limit: 0.981, amplitude: 0, rate: 3, w: 5}
coordinates: {x: {initial: 1}, y: {initial: 0}}
lagrangian: (x_dot**2 + y_dot**2)/2 - k*(x**2 + stiffer*y**2)/2
definitions: {v: "(x_dot, y_dot)"}
generalized_forces:
  x: amplitude*sin(rate*t) - limit*v.x/norm(v)
  y: -limit*v.y/norm(v)
"""
BOUNDS = {
    ("taylor", 2.0**-52): 2e-13, ("ias15", 2.0**-52): 1e-14, ("ias15", 1e-9): 1e-11,
    ("Radau", 1e-7): 1e-6, ("Radau", 1e-9): 1e-9, ("Radau", 1e-11): 1e-11,
    ("DOP853", 1e-7): 5e-6, ("DOP853", 1e-9): 5e-8, ("DOP853", 1e-12): 5e-11,
}  # fmt: skip
"""The largest error of a coordinate, for each method and tolerance."""
ROUNDED = 4.0 * 2.0**-52
"""And the least one, as part of a sqrt(k) t, with the amplitude a: by so much of the phase times are rounded
(up to 1.1 ulp in 400 draws)."""
METHODS = [(method, tolerance) for method, tolerance in BOUNDS if method != "taylor"]


STIFF = 10.0
"""Friction turns the velocity back to the line at the rate ``limit/speed``, which is so many times as fast as
the spring if the last half-cycle is a tenth as wide as the places of rest. Beyond that, stability limits the
explicit steps of ``DOP853``, and samples within them are less precise than their ends: by up to 3000 times
the tolerance (60 draws at each), by 4 times before."""


def stiffness(amplitude: float, k: float, limit: float) -> float:
    """The rate of friction at the greatest speed of the last half-cycle, in units of the spring's."""
    shift = limit / k
    return shift / (amplitude - shift * (2 * np.ceil((amplitude / shift - 1) / 2) - 1))


def half_cycles(t: NDArray[np.float64], amplitude: float, k: float, limit: float) -> NDArray[np.float64]:
    """The coordinate of what is let go at an ``amplitude`` on a spring of ``k``, a unit of mass."""
    period, shift, x = np.pi / np.sqrt(k), limit / k, amplitude
    found, begins = np.full(len(t), np.nan), 0.0
    while abs(x) > shift:
        middle = np.copysign(shift, x)
        within = (t >= begins) & (t <= begins + period)
        found[within] = middle + (x - middle) * np.cos(np.sqrt(k) * (t[within] - begins))
        x, begins = 2 * middle - x, begins + period
    found[t >= begins] = x
    return found


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(("method", "tolerance"), BOUNDS)
def test_what_turns_round_on_a_spring_loses_the_same_in_each_half_cycle(
    method: str, tolerance: float, request: pytest.FixtureRequest
) -> None:
    source = random.Random(request.config.option.seed)
    for _ in range(2):
        sets = {"k": source.uniform(5, 60), "limit": source.uniform(0.3, 3), "stiffer": 1.0}
        amplitude, angle = source.uniform(0.5, 2), source.uniform(0, 2 * np.pi)
        while method == "DOP853" and stiffness(amplitude, sets["k"], sets["limit"]) > STIFF:
            amplitude = source.uniform(0.5, 2)
        along = amplitude * np.array([np.cos(angle), np.sin(angle)])
        start = {"x": along[0], "y": along[1]}
        motion = follow(SPRING, 3, 61, method=method, tolerance=tolerance, sets=sets | start)
        expected = half_cycles(motion.t, amplitude, sets["k"], sets["limit"])
        bound = max(BOUNDS[method, tolerance], ROUNDED * amplitude * np.sqrt(sets["k"]) * motion.t[-1])
        for name, part in start.items():
            error = motion[f"q/{name}"] - part / amplitude * expected
            assert np.max(np.abs(error)) < bound, (sets, start)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "tolerance"), METHODS)
@pytest.mark.parametrize("beside", [1e-2, 1e-5, 1e-8])
def test_what_turns_round_beside_rest(method: str, tolerance: float, beside: float) -> None:
    exact, motion = (
        follow(SPRING, 2, 41, method=one, tolerance=most, sets={"y": beside})
        for one, most in (("taylor", 2.0**-52), (method, tolerance))
    )
    for name in ("q/x", "q/y"):
        assert np.max(np.abs(motion[name] - exact[name])) < BOUNDS[method, tolerance]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "tolerance"), METHODS)
def test_a_force_sets_what_rests_in_motion_again(method: str, tolerance: float) -> None:
    """Along a line the force jumps with the sign of one velocity."""
    sets = {"x": 0.2, "amplitude": 4.0, "rate": 2.0}
    alone = SPRING.replace("v.x/norm(v)", "sign(x_dot)").replace("v.y/norm(v)", "sign(y_dot)")
    exact = follow(alone, 6, 61, sets=sets)
    motion = follow(SPRING, 6, 61, method=method, tolerance=tolerance, sets=sets)
    assert np.any(exact["v/x"][1:] == 0) and np.any(exact["v/x"] != 0)
    assert np.max(np.abs(motion["q/x"] - exact["q/x"])) < 3 * BOUNDS[method, tolerance]


BELT = """
parameters: {c: 0.6, s: 0.8, k: 40, limit: 1.1, V: 0.4, w: 3}
coordinates: {x: {initial: 0.5*c}, y: {initial: 0.5*s}}
masses: {puck: 1}
positions: {puck: [x, y]}
potential: k*(x**2 + y**2)/2
definitions: {u: "(x_dot - c*V*cos(w*t), y_dot - s*V*cos(w*t))"}
forces: {puck: -limit*u/norm(u)}
"""
ON_A_LINE = """
parameters: {k: 40, limit: 1.1, V: 0.4, w: 3}
coordinates: {r: {initial: 0.5}}
masses: {puck: 1}
positions: {puck: [r]}
potential: k*r**2/2
generalized_forces: {r: -limit*sign(r_dot - V*cos(w*t))}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "tolerance"), METHODS)
def test_a_puck_on_a_spring_and_a_swinging_belt(method: str, tolerance: float) -> None:
    line = follow(ON_A_LINE, 1.6, 33)
    motion = follow(BELT, 1.6, 33, method=method, tolerance=tolerance)
    for name, part in (("q/x", 0.6), ("q/y", 0.8)):
        assert np.max(np.abs(motion[name] - part * line["q/r"])) < BOUNDS[method, tolerance]


PAIR = """
parameters: {k: 50}
coordinates: {a: {initial: -0.07}, b: {initial: -0.08}, p: {initial: 0.29}, q: {initial: 0.33}}
masses: {one: 0.64, other: 0.54}
positions: {one: [a, b], other: [p, q]}
potential: 50*((a - p)**2 + (b - q)**2)/2 + 19*(a**2 + b**2)/2 + 40*(p**2 + q**2)/2
definitions: {u: "(a_dot, b_dot)", w: "(p_dot, q_dot)"}
forces: {one: -1.4*u/norm(u), other: -2*w/norm(w)}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "tolerance"), BOUNDS)
def test_two_pucks_that_turn_round_soon_after_one_another(method: str, tolerance: float) -> None:
    """Where one begins to slide, the way that it is taken ends before the other one turns round."""
    fine, coarse = ("ias15", 1e-11) if method == "taylor" else ("taylor", 2.0**-52), (method, tolerance)
    for shift in (0.0, 0.005, 0.01):
        sets = {"p": 0.29 + shift, "a": -0.07 - shift}
        exact, motion = (
            follow(PAIR, 1, 21, method=one, tolerance=most, sets=sets) for one, most in (fine, coarse)
        )
        assert motion.outcome.ending is Ending.COMPLETE
        for name in "abpq":
            assert np.max(np.abs(motion[f"q/{name}"] - exact[f"q/{name}"])) < 3 * BOUNDS[coarse]


SEVERAL = """
sizes: {N: 1}
parameters: {k: 30, limit: 2.943}
coordinates: {"x[i in range(N)]": {initial: 1.0}, "y[i in range(N)]": {initial: 0.5}}
masses: {"p[i in range(N)]": 1}
positions: {"p[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(k*(x[i]**2 + y[i]**2)/2 for i in range(N))
dissipation: sum(limit*norm((p[i].vx, p[i].vy)) for i in range(N))
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("count", [2, 3, 7])
@pytest.mark.parametrize(
    ("method", "tolerance"), [("taylor", 2.0**-52), ("ias15", 2.0**-52), ("DOP853", 1e-9)]
)
def test_bodies_that_turn_round_at_the_same_time(method: str, tolerance: float, count: int) -> None:
    """Then nothing moves, and no velocity tells what is none."""
    sets = {f"{q}[{i}]": one for i in range(count) for q, one in (("x", 0.8), ("y", 0.6))}
    motion = follow(
        SEVERAL.replace("N: 1", f"N: {count}"), 2.0, 21, method=method, tolerance=tolerance, sets=sets
    )
    assert motion.outcome.ending is Ending.COMPLETE
    expected = half_cycles(motion.t, 1.0, 30.0, 2.943)
    for name, part in (("x", 0.8), ("y", 0.6)):
        assert np.max(np.abs(motion[f"q/{name}"].T - part * expected)) < BOUNDS[method, tolerance]


@pytest.mark.exhaustive(keep=0.4)
def test_friction_reverses_while_another_body_begins_to_slide() -> None:
    """Three bodies on a line: the second one turns round 4 ms after the first."""
    masses, limits = (0.6407893801613523, 0.5425212147830094, 1.7536476558798046), (
        1.4585749814084665, 2.024460323623736, 2.408425383179437,
    )  # fmt: skip
    c, s, starts = 0.6646228009932844, 0.7471790497597219, (-0.10922561, 0.44308, -0.54247398)
    springs = "51.608855531547796*P01/2 + 47.00760404371377*P12/2 + 19.028796415668193*P0/2 + 32.25*P2/2"
    push = "2.3*sin(4.05*t)"

    def text(plane: bool) -> str:
        names = ("x", "y") if plane else ("x",)
        parts = (c, s) if plane else (1.0,)
        lines = dict(zip(names, parts))

        def square(i: int, j: int | None = None) -> str:
            other = "" if j is None else f" - {{0}}{j}"
            return "(" + " + ".join(f"({n}{i}{other.format(n)})**2" for n in names) + ")"

        potential = springs
        for code, value in (
            ("P01", square(0, 1)),
            ("P12", square(1, 2)),
            ("P0", square(0)),
            ("P2", square(2)),
        ):
            potential = potential.replace(code, value)
        coordinates = ", ".join(
            f"{n}{i}: {{initial: {start * part}}}"
            for i, start in enumerate(starts)
            for n, part in lines.items()
        )
        forces = []
        for i, limit in enumerate(limits):
            speeds = [f"{n}{i}_dot" for n in names]
            for n, speed, part in zip(names, speeds, parts):
                along = f"{speed}/norm(({', '.join(speeds)}))" if plane else f"sign({speed})"
                pushed = f"{part}*{push}" if i == 0 else "0*t"
                forces.append(f"{n}{i}: {pushed} - {limit}*{along}")
        bodies = ", ".join(f"b{i}: {m}" for i, m in enumerate(masses))
        places = ", ".join(f"b{i}: [{', '.join(f'{n}{i}' for n in names)}]" for i in range(3))
        listed = "".join(f"\n  {one}" for one in forces)
        return (
            f"coordinates: {{{coordinates}}}\nmasses: {{{bodies}}}\npositions: {{{places}}}\n"
            f"potential: {potential}\ngeneralized_forces:{listed}\n"
        )

    line, plane = (follow(text(one), 1.5, 31) for one in (False, True))
    for i in range(3):
        assert np.max(np.abs(plane[f"q/x{i}"] - c * line[f"q/x{i}"])) < 1e-12
