"""The books are kept: conserved quantities stay, ledgers close, the action adds up."""

from __future__ import annotations

from unittest.mock import patch

import mpmath
import numpy as np
import pytest

from lagrange_cli import solve
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from tests.support.motion import CONSTRAINED, DIGITS, NAMES, Motion, error, follow, residual_of, samples_of

LEDGER = ("q", "v", "p", "h", "ledger", "action")


def largest(motion: Motion, path: str) -> float:
    return float(abs(motion[path]).max())


def size(motion: Motion, quantity: str) -> float:
    """The size of the terms of ``h`` or of momenta: h may be the small difference of large energies."""
    names = [path[2:] for path in motion.data if path.startswith("q/")]
    if quantity != "h":
        return max(largest(motion, f"diagnostics/p/{name}") for name in names)
    products = [abs(motion[f"v/{name}"] * motion[f"diagnostics/p/{name}"]) for name in names]
    twice_kinetic = sum(product.reshape(len(motion.t), -1).sum(axis=1) for product in products)
    return max(largest(motion, "diagnostics/h"), float(twice_kinetic.max()))


@pytest.mark.parametrize(
    ("system", "start", "bound", "steps"),
    [
        ("pendulum", {}, 1e-13, 14000),
        ("rotating_hoop", {}, 1e-13, 40000),
        ("double_pendulum", {"theta1": 2.0, "theta2": 2.5}, 5e-12, 60000),
    ],
)
def test_h_stays_over_1000_seconds(system: str, start: dict[str, float], bound: float, steps: int) -> None:
    motion = follow(system, 1000.0, 2001, sets=start)
    h = motion["diagnostics/h"]
    assert motion.outcome.h_drift == abs(h - h[0]).max()
    assert motion.outcome.h_drift / abs(h[0]) < bound
    assert motion.outcome.steps < steps
    assert len(h) == 2001


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_ledgers_begin_after_an_impact_at_the_start(precision: str) -> None:
    """A table that rises hits what lies on it at once. No sample is before this impact."""
    text = """
coordinates: {y: {initial: 0}}
masses: {ball: 1}
positions: {ball: y}
potential: y
events:
  table: {when: y - sin(t)/5, direction: falling, action: {set: {y_dot: 0.35*cos(t) - 0.75*y_dot}}}
"""
    motion = solve(text, stop=0.5, samples=11, outputs=["v", "p", "ledger"], precision=precision)
    assert list(motion.events["table/t"][:2]) == pytest.approx([0.0, 0.306], abs=1e-3)
    assert motion.v["y"][:7] == pytest.approx(0.35 - motion.t[:7], abs=1e-15)
    assert abs(motion.ledger["h"]).max() < 1e-15
    assert abs(motion.ledger["p/y"]).max() < 1e-15


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_work_that_cancels_is_integrated_from_rest(precision: str) -> None:
    """Two blocks that push each other do no work on each other, but for rounding errors, which grow with
    their velocity: at rest, where they begin, there are none."""
    speed = "(1.5*x_dot + 1.2*y_dot)/2.7"
    text = f"""
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}, z: {{initial: 0}}}}
masses: {{a: 1.5, b: 1.2, c: 1}}
positions: {{a: [x], b: [y], c: [z]}}
potential: -2*x - 0.5*y
events:
  touch: {{when: y - x, direction: falling, action: {{set: {{x_dot: "{speed}", y_dot: "{speed}"}}}}}}
  wall: {{when: z + 1 + t, direction: falling, action: {{set: {{z_dot: -z_dot/2 - 1.5}}}}}}
"""
    motion = solve(text, stop=0.2, samples=5, outputs=["q", "ledger"], precision=precision)
    assert motion.q["x"] == pytest.approx(2.5 / 2.7 * motion.t**2 / 2, rel=1e-15)
    assert abs(motion.ledger["h"]).max() < 1e-16


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("system", [*NAMES, *CONSTRAINED])
def test_what_should_stay_stays(system: str) -> None:
    """Every quantity that is said to be conserved, in every shipped system."""
    motion = follow(system, 0.1 if system == "andrews_squeezer" else 5.0, 501)
    constant = [each for each in residual_of(system).conserved if not each.breaks]
    for each in constant:
        path = f"diagnostics/p/{each.quantity[2:]}" if each.quantity.startswith("p_") else "diagnostics/h"
        series = motion[path]
        assert abs(series - series[0]).max() < 1e-13 * size(motion, each.quantity)
        drifts = {"h": motion.outcome.h_drift} | {f"p_{k}": x for k, x in motion.outcome.p_drift.items()}
        assert drifts[each.quantity] == abs(series - series[0]).max()
    reported_momenta = {f"p_{name}" for name in motion.outcome.p_drift}
    assert reported_momenta == {each.quantity for each in constant} - {"h"}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("system", [*NAMES, *CONSTRAINED])
def test_ledgers_close_for_every_system(system: str) -> None:
    """Driven, damped or rheonomic: h(t) - h(0) + int dL/dt - int Q q_dot = 0, and p_k likewise."""
    stop = {"rotating_rod": 10.0, "andrews_squeezer": 0.1}.get(system, 30.0)
    motion = follow(system, stop, 301, outputs=LEDGER)
    for name in ("h", *(f"p/{coordinate}" for coordinate in residual_of(system).coordinates)):
        assert largest(motion, f"diagnostics/ledger/{name}") < 1e-11 * size(motion, name)


@pytest.mark.exhaustive(keep=0.55)
def test_a_ledger_that_is_cooked_does_not_close() -> None:
    """The driven damped pendulum changes h by far more than its ledger says is unaccounted for."""
    motion = follow("driven_damped_pendulum", 30.0, 301, outputs=LEDGER)
    h = motion["diagnostics/h"]
    assert abs(h - h[0]).max() > 1e12 * largest(motion, "diagnostics/ledger/h")
    assert motion.outcome.h_drift is None


@pytest.mark.exhaustive(keep=0.55)
def test_h_of_the_rotating_rod_stays_although_its_energy_grows() -> None:
    motion = follow("rotating_rod", 10.0, 101, outputs=(*LEDGER, "T", "U", "energy"))
    assert motion["diagnostics/energy"][-1] > 1e6 * motion["diagnostics/energy"][0]
    assert motion.outcome.h_drift is not None
    assert motion.outcome.h_drift < 1e-12 * largest(motion, "diagnostics/energy")
    assert np.array_equal(motion["diagnostics/energy"], motion["diagnostics/T"] + motion["diagnostics/U"])


@pytest.mark.exhaustive(keep=0.8)
def test_action_of_the_oscillator_is_the_integral_of_L() -> None:
    """x = cos(w t): S = -m w sin(2 w t)/4, from L = -m w^2 cos(2 w t)/2."""
    motion = follow("harmonic_oscillator", 40.0, 301, sets={"x": 1, "x_dot": 0}, outputs=("action",))
    m, k = (mpmath.mpf(motion.values.parameters[name]) for name in "mk")
    with mpmath.workdps(DIGITS):
        w = mpmath.sqrt(k / m)
    exact = samples_of(lambda t: -m * w * mpmath.sin(2 * w * t) / 4, motion.t)
    assert error(motion["diagnostics/action"], exact) < 1e-11


def test_action_of_a_free_fall() -> None:
    """s = a t^2/2 with a = g sin(alpha): L = m a^2 t^2, S = m a^2 t^3/3."""
    motion = follow("incline", 5.0, outputs=("action",))
    p = {name: mpmath.mpf(value) for name, value in motion.values.parameters.items()}
    with mpmath.workdps(DIGITS):
        a = p["g"] * mpmath.sin(p["alpha"])
    exact = samples_of(lambda t: p["m"] * a**2 * t**3 / 3, motion.t)
    assert error(motion["diagnostics/action"], exact) < 1e-14


@pytest.mark.exhaustive(keep=0.6)
def test_work_of_a_particle_force_is_in_the_ledger() -> None:
    """A constant force on a particle that moves on a circle: dh/dt = F.v, and T gains what F gives."""
    pulled = """
    coordinates: {a: {initial: 0.3, velocity: 0.1}}
    masses: {p: 2.0}
    embedding: {p: [cos(a), sin(a)]}
    forces: {p: [0.0, 1.5]}
    """
    motion = follow(pulled, 20.0, 201, outputs=LEDGER)
    h, a = motion["diagnostics/h"], motion["q/a"]
    assert abs(h - h[0] - 1.5 * (np.sin(a) - np.sin(a[0]))).max() < 1e-13
    assert largest(motion, "diagnostics/ledger/h") < 1e-13
    assert largest(motion, "diagnostics/ledger/p/a") < 1e-13
    assert motion.outcome.h_drift is None


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("form", ["lagrangian", "potential"])
def test_a_potential_that_changes_in_time_is_in_the_ledger(form: str) -> None:
    """dh/dt = -dL/dt: a spring that is tuned, with random numbers, wins and loses energy."""
    seed = int(np.random.default_rng().integers(2**32))
    print(f"seed {seed}")
    c, w, start = np.random.default_rng(seed).uniform((0.2, 1.0, 0.5), (0.6, 3.0, 1.5))
    spring = f"(1 + {c}*cos({w}*t))*x**2/2"
    stated = {
        "lagrangian": f"lagrangian: x_dot**2/2 - {spring}",
        "potential": f"masses: {{p: 1}}\nembedding: {{p: [x]}}\npotential: {spring}",
    }
    text = f"coordinates: {{x: {{initial: {start}}}}}\n{stated[form]}"
    motion = follow(text, 20.0, 201, outputs=LEDGER)
    h = motion["diagnostics/h"]
    assert abs(h - h[0]).max() > 0.01 * size(motion, "h")
    assert largest(motion, "diagnostics/ledger/h") < 1e-12 * size(motion, "h")


def test_the_hoop_conserves_h_and_not_t_plus_u() -> None:
    motion = follow("rotating_hoop", 20.0, outputs=("q", "v", "h", "energy", "T", "U"))
    assert motion.outcome.h_drift is not None
    assert motion.outcome.h_drift <= 1e-13 * abs(motion["diagnostics/h"][0])
    energy = motion["diagnostics/energy"]
    assert abs(energy - energy[0]).max() > 0.01
    assert np.array_equal(energy, motion["diagnostics/T"] + motion["diagnostics/U"])


@pytest.mark.exhaustive(keep=0.4)
def test_quadratures_do_not_change_the_motion() -> None:
    plain = follow("driven_damped_pendulum", 20.0)
    ledger = follow("driven_damped_pendulum", 20.0, outputs=("q", "v", "ledger", "action"))
    assert plain.outcome.steps == ledger.outcome.steps
    assert abs(plain["q/theta"] - ledger["q/theta"]).max() <= 1e-13


HELD = ["nonholonomic: {b: y_dot - 0.1, c: -z_dot}", "constraints: {b: y - 0.1*t - 0.3, c: z - 0.5}"]


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("held", HELD)
def test_forces_on_coordinates_that_constraints_hold_cancel(held: str) -> None:
    """Their momenta do not change: rounding is all there would be to integrate."""
    text = """
coordinates: {x: {initial: 0.1, velocity: 0.3}, y: {initial: 0.3}, z: {initial: 0.5}}
lagrangian: x_dot**2/2 + y_dot**2 + 3*z_dot**2/2 + y**2*x_dot**2/5 + cos(x)
generalized_forces: {z: 1.3*sin(t) - 0.8*z_dot*x**2}
"""
    with patch("lagrange_cli.native.elimination.reduced", lambda residual: None):
        motion = follow(text + held, 1.0, 5, outputs=LEDGER)
    for name in ("h", "p/x", "p/y", "p/z"):
        assert largest(motion, f"diagnostics/ledger/{name}") < 1e-14


GYROSCOPIC = "x: c*a_dot, a: -c*x_dot", "x: c*(a_dot + b_dot), a: -c*x_dot, b: -c*x_dot"


@pytest.mark.parametrize("forces", GYROSCOPIC)
def test_ledgers_close_where_an_integrand_grows_from_nothing(forces: str) -> None:
    """A cart with a pendulum that hangs, and one that falls from pi/2: the first begins to move as t^5, with
    accelerations that are differences of terms. Steps were divided without end, and their integrals lost."""
    text = f"""
parameters: {{c: 0.3}}
coordinates: {{x: {{initial: 0}}, a: {{initial: 0}}, b: {{initial: pi/2}}}}
masses: {{cart: 3, one: 1, two: 1}}
embedding:
  cart: [x, 0]
  one: [x + sin(a), -cos(a)]
  two: [x + sin(b), -cos(b)]
potential: 9.81*(one.y + two.y)
generalized_forces: {{{forces}}}
"""
    motion = solve(text, stop=0.5, samples=6, outputs=LEDGER, precision=DOUBLE_DOUBLE)
    for name in ("h", "p/x", "p/a", "p/b"):
        assert abs(motion.ledger[name]).max() < 1e-30


@pytest.mark.exhaustive(keep=0.55)
def test_ledgers_close_beyond_a_singular_configuration() -> None:
    """A bead on a lemniscate passes the crossing, near which high coefficients overflow: first those of the
    integrals."""
    text = """
coordinates: {x: {initial: 1, velocity: 0}, y: {initial: 0, velocity: 1}}
masses: {b: 1}
positions: {b: [x, y]}
constraints: {lemniscate: (x**2 + y**2)**2 - x**2 + y**2}
"""
    motion = follow(text, 3.0, 7, outputs=LEDGER)
    assert motion["q/x"].min() < -0.9
    for name in ("h", "p/x", "p/y"):
        assert largest(motion, f"diagnostics/ledger/{name}") < 1e-12


AT_TIMES = {
    "spring": "potential: where(t < 1, 1, 4)*x**2/2",
    "square wave": "potential: sign(sin(5*t))*cos(x) + where(t < 0.5, 0, 3)",
    "support": "potential: where(t < 1, 1, 3)*(p.x - s.x)**2/2",
}


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("precision", [DOUBLE, DOUBLE_DOUBLE])
@pytest.mark.parametrize("potential", [*AT_TIMES.values()])
def test_energies_that_jump_at_times_are_in_the_ledger(potential: str, precision: str) -> None:
    """A spring becomes stiffer at once: h jumps by the opposite of L, p does not."""
    text = f"""
coordinates: {{x: {{initial: 1, velocity: 0.3}}}}
masses: {{p: 1, s: 2}}
positions: {{p: [x], s: ["max(0, t - 1)"]}}
{potential}
"""
    motion = solve(text, stop=2, samples=41, outputs=LEDGER, precision=precision)
    bound = 1e-14 if precision == DOUBLE else 1e-30
    assert np.ptp(motion.h) > 0.1
    assert abs(motion.ledger["h"]).max() < bound
    assert abs(motion.ledger["p/x"]).max() < bound


@pytest.mark.exhaustive(keep=0.3)
def test_the_jump_of_h_is_that_of_the_potential() -> None:
    """x = cos(t) until k = 4 instead of 1 from t = 1 on, then x'' = -4 x: h gains 3 x(1)^2/2."""
    text = "coordinates: {x: {initial: 1}}\nmasses: {p: 1}\npositions: {p: x}\n" + AT_TIMES["spring"]
    motion = follow(text, 2.0, 41, outputs=LEDGER)
    assert abs(np.diff(motion["diagnostics/h"][[0, -1]]) - 1.5 * np.cos(1.0) ** 2) < 1e-14
    exact = np.cos(1.0) * np.cos(2.0) - np.sin(1.0) * np.sin(2.0) / 2
    assert abs(motion["q/x"][-1] - exact) < 1e-14


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("count", [3, 60])
def test_families_whose_springs_change_at_times_keep_their_ledgers(count: int) -> None:
    """Written out and in loops: each spring has its own time."""
    text = f"""
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: cos(i), velocity: 0.1}}}}
masses: {{"p[i in range(N)]": 1}}
positions: {{"p[i in range(N)]": "x[i]"}}
potential: sum(where(t < 0.3 + i/N/2, 1, 2)*(x[i + 1] - x[i])**2/2 for i in range(N - 1))
generalized_forces: {{"x[i in range(N)]": -x_dot[i]/9}}
"""
    motion = solve(text, stop=1, samples=11, outputs=LEDGER)
    assert abs(motion.ledger["h"]).max() < 1e-15 * count * count
    assert abs(motion.ledger["p/x"]).max() < 1e-14
