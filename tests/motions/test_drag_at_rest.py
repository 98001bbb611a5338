"""Resistances with a kink at v = 0, such as -b v |v|, on what is at rest in equilibrium up to rounding.

There the sign of v is that of a rounding error, and ends no step; where something moves, every turn does."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lagrange_cli.integrate.ending import Ending
from tests.support.command import lagrange
from tests.support.motion import follow

CHAIN = """
sizes: {{N: {N}}}
parameters: {{k: 1000.0, g: 9.81, b: {b}}}
coordinates:
  x[i in range(N)]: {{initial: sum(sum((1 + n)*g/k for n in range(j, N)) for j in range(i + 1))}}
masses: {{"p[i in range(N)]": 1 + i}}
positions: {{"p[i in range(N)]": ["x[i]"]}}
potential: >
  k*x[0]**2/2 + sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N)) - sum((1 + i)*g*x[i] for i in range(N))
generalized_forces: {{"x[i in range(N)]": "{drag}"}}
"""
ONE = """
parameters: {{k: 1000.0, g: 9.81, m: 3.0, b: {b}, d: {d}}}
coordinates: {{x: {{initial: m*g/k + d, velocity: {v}}}}}
masses: {{p: m}}
positions: {{p: [x]}}
potential: k*x**2/2 - m*g*x
generalized_forces: {{x: "{drag}"}}
"""
QUADRATIC, ROOT = "-b*x_dot[i]*abs(x_dot[i])", "-b*x_dot[i]*sqrt(abs(x_dot[i]))"
OMEGA = np.sqrt(1000.0 / 3.0)


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("drag", [QUADRATIC, ROOT, "where(x_dot[i] > 0, -b*x_dot[i]**2, 2*b*x_dot[i]**2)"])
@pytest.mark.parametrize("N", [1, 3, 12])
@pytest.mark.parametrize(
    ("method", "tolerance", "steps"),
    [("taylor", 2.0**-52, 600), ("ias15", 2.0**-52, 2000), ("Radau", 1e-10, 9)],
)
def test_a_chain_hangs_at_rest(drag: str, N: int, method: str, tolerance: float, steps: int) -> None:
    """As many steps as without drag, about 45 in a period of the fastest oscillation."""
    system = CHAIN.format(N=N, b=1.0, drag=drag)
    motion = follow(system, 10.0, 6, method=method, tolerance=tolerance)
    assert motion.t[-1] == 10.0
    assert motion.outcome.steps <= steps
    for i in range(N):
        x = motion[f"q/x[{i}]"] if f"q/x[{i}]" in motion.data else motion["q/x"][:, i]
        assert np.ptp(x) <= 1e-12 * max(1.0, abs(x[0]))


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_steps_are_those_without_drag(method: str) -> None:
    with_drag, without = (
        follow(CHAIN.format(N=5, b=1.0, drag=drag), 10.0, 2, method=method).outcome.steps
        for drag in (QUADRATIC, "0")
    )
    assert with_drag <= 1.5 * without


@pytest.mark.parametrize(
    ("N", "options", "steps"),
    [
        (20, ("--method", "taylor"), 600),  # in loops
        (20, ("--method", "ias15"), 600),
        (20, ("--method", "Radau"), 9),
        (3, ("--precision", "double-double"), 700),
    ],
)
def test_the_command_steps_over_turns_of_rounding_errors(
    N: int, options: tuple[str, ...], steps: int, tmp_path: Path
) -> None:
    file = tmp_path / "chain.yaml"
    file.write_text(CHAIN.format(N=N, b=1.0, drag=QUADRATIC).replace("1000.0", "1003.0"), encoding="utf-8")
    run = lagrange("solve", file, *options, "--stop", "10", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout)["steps"] <= steps


@pytest.mark.parametrize("d", [1e-2, 1e-6, 1e-9, 1e-11])
def test_what_is_out_of_balance_by_little_is_damped(d: float) -> None:
    """Each swing has the integral that follows from d(v^2)/dx = -2 w^2 x +- 2 B v^2, where B = b/m."""
    system = ONE.format(b=0.3 / d, d=d, v=0.0, drag="-b*x_dot*abs(x_dot)")
    motion = follow(system, 10.0, 2001, outputs=("q", "v"))
    out, v = motion["q/x"] - motion["q/x"][0] + d, motion["v/x"]
    turns = np.flatnonzero(v[1:-1] * v[2:] < 0.0) + 1
    assert 55 <= len(turns) <= 59  # 10 s of half a period each, the first at the start
    B = 0.1 / d
    # in each swing down (or up, with -x for x): v^2 = C exp(2 B x) + w^2 (x + 1/(2 B))/B
    for first, last in pairwise(turns):
        inside = slice(first + 1, last + 1)
        x = out[inside] * np.sign(-v[first + 1])
        energy = (v[inside] ** 2 - OMEGA**2 / B * (x + 0.5 / B)) * np.exp(-2.0 * B * x)
        error = 1e-10 + 16.0 * np.finfo(float).eps * abs(motion["q/x"][0]) / d
        assert np.ptp(energy) <= error * np.abs(energy).max()


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_a_push_after_rest_is_resisted(method: str) -> None:
    """A force, and the drag itself, begin at t = 5: the motion from then on is that from rest at t = 0."""
    resting = ONE.format(b=0.0, d=0.0, v=0.0, drag="where(t > 5, 500 - 40*x_dot*abs(x_dot), 0)")
    pushed = ONE.format(b=0.0, d=0.0, v=0.0, drag="500 - 40*x_dot*abs(x_dot)")
    later = follow(resting, 8.0, 9, method=method)["q/x"][5:]
    assert np.abs(later - follow(pushed, 3.0, 4, method=method)["q/x"]).max() <= 1e-12
    assert np.ptp(later) > 0.1


OTHER = """
coordinates: {{u: {{initial: {u!r}, velocity: 0.6}}}}
definitions: {{slope: 1 + 0.3*u**2}}
masses: {{p: 0.7}}
positions: {{p: [u + 0.1*u**3]}}
potential: 3.5*p.x**2
generalized_forces: {{u: "-0.45*abs(slope*u_dot)**{power}*sign(slope*u_dot)*slope"}}
"""
SAME = """
coordinates: {{x: {{initial: {x!r}, velocity: {v!r}}}}}
masses: {{p: 0.7}}
positions: {{p: [x]}}
potential: 3.5*x**2
generalized_forces: {{x: "-0.45*abs(x_dot)**{power}*sign(x_dot)"}}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("power", [0.5, 1.5, 2.5])
def test_powers_of_a_velocity_that_is_a_product_pass_its_zeros(power: float, method: str) -> None:
    """In other coordinates the velocity has a factor that is positive."""
    for u in (-0.5, 0.4):
        x, slope = u + 0.1 * u**3, 1 + 0.3 * u**2
        texts = OTHER.format(u=u, power=power), SAME.format(x=x, v=0.6 * slope, power=power)
        tolerance = 1e-12 if method == "DOP853" else 2.0**-52
        other, same = (follow(text, 4.0, 41, method=method, tolerance=tolerance) for text in texts)
        assert other.outcome.ending is same.outcome.ending is Ending.COMPLETE
        assert other["q/u"] + 0.1 * other["q/u"] ** 3 == pytest.approx(same["q/x"], abs=1e-9)
        assert other.outcome.steps < 3 * same.outcome.steps


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("watched", [False, True])
def test_a_root_of_the_velocity_stops_what_it_brakes(watched: bool, method: str) -> None:
    """v' = -c sqrt(v): sqrt(v) decreases evenly. What steps on rates leave of v when it is 0 is rounding."""
    text = """
coordinates: {x: {initial: 0, velocity: 0.25}}
masses: {p: 1}
positions: {p: [x]}
generalized_forces: {x: "-1.5*abs(x_dot)**0.5*sign(x_dot)"}
"""
    text += 'events: {passes: "x**2 + 0.5*sin(3*t)"}\n' if watched else ""
    tolerance = {"DOP853": 1e-12, "Radau": 1e-10}.get(method, 2.0**-52)
    motion = follow(text, 2.0, 21, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"] == pytest.approx(np.fmax(0.5 - 0.75 * motion.t, 0.0) ** 2, abs=1e-9)
    assert np.all(motion["v/x"][motion.t > 0.67] == 0.0)


BOTH = """
coordinates: {{u: {{initial: 0.3, velocity: 1}}}}
definitions: {{slope: {slope}}}
masses: {{p: 1}}
positions: {{p: [{x}]}}
potential: 5*p.x**2/2
generalized_forces: {{u: "-(2 + 0.5*abs(slope*u_dot)**{power})*sign(slope*u_dot)*slope"}}
"""


def braked(x: float, v: float, power: float, times: np.ndarray) -> np.ndarray:
    """Swings between -F and F of dry friction, with a drag beside it; where it rests, it stays."""
    found, t = np.zeros(len(times)), 0.0
    while t < times[-1]:
        side = float(np.sign(v if v else -x))

        def rates(_: float, y: np.ndarray, side: float = side) -> list[float]:
            return [y[1], -5.0 * y[0] - side * (2.0 + 0.5 * max(side * y[1], 0.0) ** power)]

        def turns(_: float, y: np.ndarray) -> float:
            return float(y[1])

        turns.terminal, turns.direction = True, -side  # type: ignore[attr-defined]
        left = times[times >= t]
        given = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "dense_output": True}
        swing = solve_ivp(rates, (t, times[-1] + 1e-9), [x, v], events=turns, **given)
        inside = left[left <= swing.t[-1]]
        first = len(times) - len(left)
        found[first : first + len(inside)] = swing.sol(inside)[0] if len(inside) else 0.0
        t, x, v = float(swing.t[-1]), float(swing.y[0, -1]), 0.0
        if abs(5.0 * x) <= 2.0:
            found[times > t] = x
            break
    return found


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("power", [1 / 3, 0.5, 1.5])
@pytest.mark.parametrize("product", [False, True])
def test_dry_friction_beside_a_power_of_the_velocity_stops_or_turns(
    product: bool, power: float, method: str
) -> None:
    """It begins beyond the limit of dry friction. A factor of the velocity may be of any sign, for what is
    known of it: it is not what friction holds."""
    slope, place = ("1 + 0.3*cos(u)", "u + 0.3*sin(u)") if product else ("1", "u")
    text = BOTH.format(slope=slope, x=place, power=power)
    tolerance = {"DOP853": 1e-12, "Radau": 1e-10}.get(method, 2.0**-52)
    motion = follow(text, 2.0, 41, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    u = motion["q/u"]
    x, v = (0.3 + 0.3 * np.sin(0.3), 1 + 0.3 * np.cos(0.3)) if product else (0.3, 1.0)
    own = u + 0.3 * np.sin(u) if product else u
    assert own == pytest.approx(braked(x, v, power, motion.t), abs=1e-8)
    assert motion.outcome.steps < 600
