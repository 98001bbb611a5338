"""What rests where forces cancel, and forces that begin: accelerations are rounding errors of larger ones."""

from __future__ import annotations

import random

import mpmath
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.mechanics.static_forces import rounding_at_rest
from tests.motions.test_double_double import LONG, solved
from tests.support.motion import follow, residual_of

HANGING = """
parameters: {{m: {m}, k: {k}, g: 9.81, d: m*g/k}}
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}}}
masses: {{a: m, b: m}}
embedding: {{a: [x], b: [y]}}
potential: k*(x + 2*d)**2/2 + k*(y - x + d)**2/2 - m*g*x - m*g*y
"""
BEGINNING = """
parameters: {{A: {A}, w: {w}, V: {V}, k: {k}}}
definitions: {{s: "V*t - {start}"}}
coordinates: {{x: {{initial: 0}}}}
masses: {{a: 1}}
embedding: {{a: [x]}}
potential: k*x**2/2
generalized_forces: {{x: "where(s > 0, A*({form}), 0)"}}
"""


def own(k, s):
    """cos and sin of the motion without force."""
    return mpmath.cos(mpmath.sqrt(k) * s), mpmath.sin(mpmath.sqrt(k) * s) / mpmath.sqrt(k)


def versine(A, w, k, s):
    free, _ = own(k, s)
    return A / k * (1 - free) - A * (mpmath.cos(w * s) - free) / (k - w**2)


def rise(A, w, k, s):
    free, kicked = own(k, s)
    return A / k * (1 - free) - A / (k + w**2) * (mpmath.exp(-w * s) - free + w * kicked)


def parabola(A, w, k, s):
    free, kicked = own(k, s)
    return A / k * (2 * w * s + w**2 * s**2 - 2 * w**2 / k * (1 - free) - 2 * w * kicked)


FORMS = {"1 - cos(w*s)": versine, "1 - exp(-w*s)": rise, "(1 + w*s)**2 - 1": parabola}
"""x of x'' + k x = A f(s), from rest at s = 0."""


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_what_hangs_at_rest_stays_there_in_few_steps(method, request):
    source = random.Random(request.config.option.seed)
    given = {"m": f"{source.uniform(0.1, 30):.3g}", "k": f"{10 ** source.uniform(1, 4):.3g}"}
    print(given)
    motion = follow(HANGING.format(**given), 10.0, 11, method=method)
    length = float(given["m"]) * 9.81 / float(given["k"])
    assert motion.outcome.ending is Ending.COMPLETE
    assert abs(motion["q/x"]).max() + abs(motion["q/y"]).max() <= 1e-11 * length
    assert motion.outcome.steps <= 5000


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("form", FORMS)
def test_a_force_that_begins_is_followed_from_its_beginning(form, request):
    """Its first terms cancel but for rounding, and all that moves is smaller."""
    source = random.Random(f"{form} {request.config.option.seed}")
    given = {name: f"{10 ** source.uniform(-1, 1.5):.3g}" for name in ("A", "w", "V", "k")}
    start = source.choice(["0.3", "5", "5/7"])
    print(given, start)
    with mpmath.workdps(40):  # these terms cancel, too
        A, w, V, k = (mpmath.mpf(float(given[name])) for name in ("A", "w", "V", "k"))
        begin = mpmath.mpf(5) / 7 if "/" in start else mpmath.mpf(start)
        motion = follow(BEGINNING.format(**given, start=start, form=form), float((begin + 1) / V), 41)
        known = FORMS[form](A, w, k / V**2, V * mpmath.mpf(float(motion.t[-1])) - begin) / V**2
        error = abs(motion["q/x"][-1] - known)
    assert motion.outcome.ending is Ending.COMPLETE
    assert error <= 1e-12 * abs(motion["q/x"]).max()
    assert motion.outcome.steps <= 1000


@pytest.mark.exhaustive(keep=0.5)
def test_a_force_that_begins_in_double_double(tmp_path):
    system = BEGINNING.format(A="1.75", w="2.5", V="3", k="16", start="5", form="1 - cos(w*s)")
    _, found = solved(tmp_path, system, *LONG, "--stop", "2", "--samples", "3")
    with mpmath.workdps(50):
        known = versine(mpmath.mpf("1.75"), mpmath.mpf("2.5"), mpmath.mpf(16) / 9, mpmath.mpf(1)) / 9
    assert abs(found["q/x"][-1] - known) <= 1e-28


def test_a_resting_car_is_lifted_by_a_smooth_bump():
    """Its damper's sides are told apart by velocities that are rounding errors at first."""
    motion = follow(
        """
parameters: {ms: 300, mu: 40, ks: 20, kt: 200, c1: 1.5, c2: 0.7, V: 36}
definitions: {s: V*t, road: "where(s > 5 and s < 6, 0.05*(1 - cos(2*pi*(s - 5)))/2, 0)"}
coordinates: {zs: {initial: 0}, zu: {initial: 0}}
masses: {body: ms, wheel: mu}
embedding: {body: [zs], wheel: [zu]}
potential: ks*(zs - zu)**2/2 + kt*(zu - road)**2/2
generalized_forces:
  zs: -where(zs_dot > zu_dot, c1, c2)*(zs_dot - zu_dot)
  zu: where(zs_dot > zu_dot, c1, c2)*(zs_dot - zu_dot)
""",
        0.3,
        4,
    )
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/zu"][-1] > 0


PAIR = """
parameters: {{A: {A}, k: {k}, K: {K}, V: {V}}}
definitions: {{s: "V*t - {start}", road: "where(s > 0, A*({form}), 0)"}}
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}}}
masses: {{a: {a}, b: {b}}}
embedding: {{a: [x], b: [y]}}
potential: k*(x - y)**2/2 + K*(y - road)**2/2
generalized_forces: {{x: "-{c}*(x_dot - y_dot)", y: "{c}*(x_dot - y_dot)"}}
"""
ROADS = ["1 - cos(2*s)", "(0.55*s + 1)**2 - 1", "log(1 + 0.6*s**2)", "cosh(s) - 1", "sqrt(1 + 6*s**2) - 1"]
DAMPERS = ["0", "0.3", "where(x_dot > y_dot, 20.2, 0.15)"]


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("damper", DAMPERS)
@pytest.mark.parametrize("road", ROADS)
def test_what_follows_a_mass_that_begins_to_move_has_its_errors(road, damper, request):
    """A mass is pushed by a spring, by another one, by the road: each at first by rounding errors of the one
    before. Both methods agree, and none takes these for motion."""
    source = random.Random(f"{road} {damper} {request.config.option.seed}")
    scales = {"A": (-3, 1), "k": (0, 2.5), "K": (0, 2.5), "V": (0, 1), "a": (-0.5, 1.5), "b": (-0.5, 1.5)}
    given = {name: f"{10 ** source.uniform(*both):.3g}" for name, both in scales.items()}
    text = PAIR.format(start=source.choice(["0.3", "5", "5/7"]), form=road, c=damper, **given)
    print(text)
    stop = 5.8 / float(given["V"])
    motions = [follow(text, stop, 41, method=method) for method in ("taylor", "ias15")]
    for motion in motions:
        assert motion.outcome.ending is Ending.COMPLETE
        assert motion.outcome.steps <= 6000
    for name in ("x", "y"):
        one, other = (motion[f"q/{name}"] for motion in motions)
        assert abs(one[-1] - other[-1]) <= 1e-11 * abs(one).max()  # the last one may be near 0


CHATTERING = """
parameters: {A: 0.0044}
definitions: {s: "4.89*t - 5", road: "where(s > 0 and s < 0.607, A*((0.548*s + 1)**2 - 1), 0)"}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {a: 14.3, b: 10.9}
embedding: {a: [x], b: [y]}
potential: 18.4*(x - y)**2/2 + 12.7*(y - road)**2/2
generalized_forces:
  x: "-where(x_dot > y_dot, 20.2, 0.153)*(x_dot - y_dot)"
  y: "where(x_dot > y_dot, 20.2, 0.153)*(x_dot - y_dot)"
"""


@pytest.mark.exhaustive(keep=0.5)
def test_a_switch_of_velocities_that_are_rounding_errors_does_not_hold_the_motion(tmp_path):
    """By rounding alone one mass is faster at first, while the force is about to drive the other one."""
    end = ["--stop", "1.5", "--samples", "3"]
    found = {name: solved(tmp_path, CHATTERING, *end, "--method", name) for name in ("taylor", "ias15")}
    assert all(said["steps"] <= 100 for said, _ in found.values())
    for name in ("q/x", "q/y"):
        one, other = (data[name][-1] for _, data in found.values())
        assert abs(one - other) <= 1e-10 * abs(one)


def test_only_forces_at_rest_that_cancel_are_known_to_their_rounding():
    assert not rounding_at_rest(residual_of("double_pendulum"))
    assert not rounding_at_rest(residual_of("fpu_chain"))
    assert len(rounding_at_rest(residual_of(HANGING.format(m=1, k=2)))) == 2
    rooted = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2\n"
    assert not rounding_at_rest(residual_of(rooted + 'generalized_forces: {x: "sqrt(abs(sin(t - 1)))"}'))
    assert not rounding_at_rest(residual_of(rooted + 'generalized_forces: {x: "1/(x - 3)**2 - 1/9"}'))
    assert rounding_at_rest(residual_of(rooted + 'generalized_forces: {x: "cos(t) - 1"}'))
    assert rounding_at_rest(residual_of(rooted + 'generalized_forces: {x: "x/sqrt(x**2 + 1) - 1/2"}'))
