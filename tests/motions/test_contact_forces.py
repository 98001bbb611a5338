"""Contacts whose force is a power of the depth, as Hertz's, against closed forms and conservation laws."""

from __future__ import annotations

import math
import random
from itertools import product

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.spec.values import resolve_long_values
from tests.support.motion import FULL, SYSTEMS, follow, prepared, run, spec_of

BALL = """
parameters: {{k: {k}, p: {p}, a: 2}}
coordinates: {{y: {{initial: {y}, velocity: {v}}}}}
masses: {{b: 1}}
embedding: {{b: y}}
potential: k/p*{power}
"""
POWERS = [
    "max(0, -y)**{p}", "where(y < 0, -y, 0)**p", "(-min(y, 0))**p", "((abs(y) - y)/2)**{p}",
    "sqrt(max(0, -y))**(2*p)", "a**p*(max(0, -y)/a)**p", "(max(0, -y)**2 + max(0, y - 9)**2)**{half}",
    "abs(min(y, 0))**{p}", "(max(0, -y) + max(0, y - 9))**{p}",
]  # fmt: skip


@pytest.fixture
def source(request: pytest.FixtureRequest) -> random.Random:
    return random.Random(request.config.option.seed)


def contact_time(k: float, p: float, v: float) -> float:
    """How long a unit mass with the speed v is in contact with U = k/p s^p: twice the integral of ds/s' up to
    the largest s (H. Hertz, J. reine angew. Math. 92, 156, 1882, for p = 5/2)."""
    deepest = (p * v * v / (2 * k)) ** (1 / p)
    return 2 * deepest / v * math.sqrt(math.pi) / p * math.gamma(1 / p) / math.gamma(1 / p + 0.5)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("power", POWERS)
def test_a_ball_is_as_long_in_contact_as_hertz_found(power: str, source: random.Random) -> None:
    k, v, p = 10 ** source.uniform(1, 5), source.uniform(0.5, 3), source.choice((2.25, 2.5, 3.3))
    text = BALL.format(k=repr(k), p=p, y=1.0, v=repr(-v), power=power.format(p=p, half=p / 2))
    stop = 2.0 / v + contact_time(k, p, v)
    motion = follow(text, stop, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    rounding = 2e-14 * (1 + v) * (1 + math.sqrt(k))
    assert motion["q/y"][-1] == pytest.approx(1.0, abs=rounding)
    assert motion["v/y"][-1] == pytest.approx(v, rel=1e-13)


BETWEEN = [
    "(max(0, -y) + max(0, y - 9))**p", "sqrt(max(0, -y) + max(0, y - 9))**(2*p)",
    "(max(0, -y) + max(0, y - L))**p", "(max(0, -y) + max(0, y - L))**3.3",
]  # fmt: skip
"""A ball between two soft walls; the place of one may be a parameter. Each ended at a touch."""


@pytest.mark.parametrize("power", BETWEEN)
@pytest.mark.parametrize(
    "start", [(34.47124558091775, 2.6185843423430817), (279.3129679829945, 1.701201664003235)]
)
def test_a_ball_between_two_soft_walls_is_back_after_a_contact_with_each(
    power: str, start: tuple[float, float], source: random.Random
) -> None:
    for k, v in (start, (10 ** source.uniform(1, 5), source.uniform(0.5, 3))):
        text = BALL.format(k=k, p=3.3, y=1.0, v=-v, power=power).replace("a: 2", "L: 9")
        motion = follow(text, 18.0 / v + 2 * contact_time(k, 3.3, v), 3)
        assert motion.outcome.ending is Ending.COMPLETE
        assert motion["q/y"][-1] == pytest.approx(1.0, abs=2e-14 * (1 + v) * (1 + math.sqrt(k)))
        assert motion["v/y"][-1] == pytest.approx(-v, rel=1e-13)


def test_the_end_of_a_contact_is_no_edge_of_a_domain() -> None:
    """The argument of the root is never negative. It was 0 at y = -7e-21, and the motion ended there."""
    v, power = 1.7170345905600009, "sqrt(max(0, -y))**(2*p)"
    motion = follow(BALL.format(k=48.09319248227404, p=3.3, y=1.0, v=-v, power=power), 3.0, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/y"][-1] == pytest.approx(v, rel=1e-13)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("method", "bound"), [("taylor", 1e-13), ("DOP853", 1e-7), ("ias15", 1e-12)])
def test_a_motion_may_begin_with_a_touch(method: str, bound: float) -> None:
    text = BALL.format(k=300.0, p=2.5, y=0.0, v=-1.0, power="max(0, -y)**p")
    motion = follow(text, 1.0, 3, method=method, tolerance=2.0**-52 if method != "DOP853" else 1e-10)
    assert motion["q/y"][-1] == pytest.approx(1.0 - contact_time(300.0, 2.5, 1.0), abs=bound)


def test_equal_balls_exchange_their_velocities_with_implicit_steps(source: random.Random) -> None:
    """At the first contact, rates are not finite where a step is tried that leads beyond it."""
    v, w, k = source.uniform(0.5, 2), source.uniform(-1, 0.2), 10 ** source.uniform(1, 4)
    text = f"""
        coordinates: {{x: {{initial: 0, velocity: {v}}}, y: {{initial: 0.5, velocity: {w}}}}}
        masses: {{a: 1, b: 1}}
        embedding: {{a: x, b: y}}
        potential: {k}*max(0, x - y)**(5/2)
    """
    stop = 0.5 / (v - w) + contact_time(5 * k, 2.5, v - w) + 0.1
    motion = follow(text, stop, 2, method="Radau", tolerance=1e-9)
    assert motion.outcome.ending is Ending.COMPLETE
    found = [float(motion[name][-1]) for name in ("v/x", "v/y")]
    assert found == pytest.approx([w, v], abs=1e-5)


def test_a_ball_is_let_go_where_it_touches() -> None:
    """It bounces up to where it was; the contact ends and begins at once there."""
    text = BALL.format(k=100.0, p=2.5, y=1.0, v=0.0, power="max(0, 1 - y)**p").replace("k/p", "9.81*y + k/p")
    motion = follow(text, 3.0)
    h = motion["v/y"] ** 2 / 2 + 9.81 * motion["q/y"] + 40.0 * (1 - motion["q/y"]) ** 2.5
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/y"].max() <= 1.0 + 1e-14
    np.testing.assert_allclose(h, 9.81, rtol=1e-14)


@pytest.mark.exhaustive(keep=0.5)
def test_beads_that_touch_pass_on_a_push() -> None:
    """What is felt of it far away is below 1e-80 at first."""
    text = """
        sizes: {N: 8}
        coordinates: {"x[i in range(N)]": {initial: 0, velocity: "where(i == 0, 1, 0)"}}
        masses: {"b[i in range(N)]": 1}
        embedding: {"b[i in range(N)]": "x[i]"}
        potential: sum(40*max(0, x[i - 1] - x[i])**(5/2) for i in range(1, N))
    """
    motion, other = (follow(text, 2.0, 5, method=method) for method in ("taylor", "ias15"))
    assert motion.outcome.ending is Ending.COMPLETE
    q, v = np.array([motion[f"{part}/x"] for part in "qv"])
    np.testing.assert_allclose(v.sum(axis=1), 1.0, rtol=1e-14)
    energy = (v**2).sum(axis=1) / 2 + 40 * (np.maximum(0, q[:, :-1] - q[:, 1:]) ** 2.5).sum(axis=1)
    np.testing.assert_allclose(energy, 0.5, rtol=1e-14)
    np.testing.assert_allclose(other["q/x"], q, atol=1e-13)
    assert v[-1, -1] > 0.9


def test_a_bounce_far_from_the_origin_takes_as_long() -> None:
    """One unit of rounding of y is a millionth of the depth."""
    text = BALL.format(k=1e6, p=2.5, y=1000.5, v=-1.0, power="max(0, 1000 - y)**p")
    motion = follow(text, 1.0 + contact_time(1e6, 2.5, 1.0), 3)
    assert motion["q/y"][-1] == pytest.approx(1000.5, abs=1e-11)
    assert motion["v/y"][-1] == pytest.approx(1.0, abs=1e-11)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("method", "diameter"), [("taylor", "0.03"), ("ias15", "1/3"), ("DOP853", "0.03")])
def test_a_chain_of_beads_with_absolute_positions(method: str, diameter: str) -> None:
    """Rounding of i*d decides which of them touch; none of that is felt."""
    text = f"""
        sizes: {{N: 20}}
        parameters: {{d: {diameter}}}
        coordinates: {{"x[i in range(N)]": {{initial: i*d, velocity: "where(i == 0, 1, 0)"}}}}
        masses: {{"b[i in range(N)]": 0.1}}
        embedding: {{"b[i in range(N)]": "x[i]"}}
        potential: sum(4e6*max(0, d - (x[i] - x[i - 1]))**2.2 for i in range(1, N))
    """
    motion = follow(text, 0.01, 3, method=method, tolerance=1e-12 if method == "DOP853" else 2.0**-52)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps < 3000
    v = motion["v/x"]
    np.testing.assert_allclose(v.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose((v[-1] ** 2).sum(), 1.0, rtol=1e-10)
    assert v[-1, -1] > 0.8


CRADLE = """
    sizes: {{N: {count}}}
    parameters: {{m: 0.1, g: 9.81, l: 0.2, d: 0.03, k: {k}}}
    coordinates: {{"x[i in range(N)]": {{initial: "{place}where({lifted}, {sign}0.3*{unit}, 0)"}}}}
    masses: {{"ball[i in range(N)]": m}}
    embedding: {{"ball[i in range(N)]": {embedding}}}
    potential:
      weight: sum({weight} for i in range(N))
      contacts: sum(k*max(0, {depth})**({p}) for i in range(1, N))
"""
FORMS = {
    "angles": {
        "place": "", "unit": "1", "embedding": "[d*i + l*sin(x[i]), -l*cos(x[i])]",
        "weight": "m*g*ball[i].y", "depth": "d - norm(ball[i] - ball[i - 1])",
    },
    "places": {
        "place": "d*i + ", "unit": "l", "embedding": "x[i]",
        "weight": "m*g/(2*l)*(x[i] - d*i)**2", "depth": "d - (x[i] - x[i - 1])",
    },
    "displacements": {
        "place": "", "unit": "l", "embedding": "x[i]",
        "weight": "m*g/(2*l)*x[i]**2", "depth": "x[i - 1] - x[i]",
    },
}  # fmt: skip


STIFFNESSES = {"3/2": "1e4", "2": "1e6", "2.2": "1e7", "5/2": "4e8", "7/2": "1e11"}
"""By powers, so that contacts are brief."""


def cradle(form: str, count: int, lifted: int, p: str, k: str, sign: str = "-") -> str:
    """Newton's cradle: so many balls, of which some are lifted together, on the left or on the right."""
    which = f"i < {lifted}" if sign == "-" else f"i >= {count - lifted}"
    return CRADLE.format(count=count, lifted=which, p=p, k=k, sign=sign, **FORMS[form])


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize(
    ("form", "p"), [one for one in product(FORMS, STIFFNESSES) if one != ("angles", "3/2")]
)
@pytest.mark.parametrize("lifted", [1, 2, 3])
def test_any_number_of_balls_may_be_lifted(lifted: int, form: str, p: str) -> None:
    """As many leave on the other side. All the time two that touch have no depth but for rounding, and the
    steps remain few. From the other side the motion is the mirror image."""
    motion, image = (follow(cradle(form, 4, lifted, p, STIFFNESSES[p], sign), 0.5, 11) for sign in "-+")
    for one in (motion, image):
        assert one.outcome.ending is Ending.COMPLETE
        assert one.outcome.steps < 1500
        assert one.outcome.h_drift < 1e-13 * one.outcome.h_size
    apart = np.arange(4) * (0.03 if form == "places" else 0.0)
    np.testing.assert_allclose(image["q/x"][:, ::-1] - apart[::-1], apart - motion["q/x"], atol=1e-9)
    out = np.sort(motion["v/x"][5])[::-1]
    assert out[lifted - 1] > 1.5 * abs(out[lifted])


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize(
    ("p", "k", "lifted", "sign"), [("2.2", "1e5", 3, "+"), ("5/2", "1e7", 1, "+"), ("5/2", "1e5", 2, "+")]
)
def test_contacts_end_in_double_double(p: str, k: str, lifted: int, sign: str) -> None:
    """What was refused before a contact ended says nothing about the steps after it."""
    text = cradle("angles", 4, lifted, p, k, sign)
    ready = prepared(text, tolerance=FULL_DOUBLE_DOUBLE, precision=DOUBLE_DOUBLE)
    motion = run(ready, resolve_long_values(spec_of(text), {}), 0.0, 0.35, 2)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps < 1500
    assert motion.outcome.h_drift < 1e-27 * motion.outcome.h_size


@pytest.mark.exhaustive(keep=0.5)
def test_exponents_may_be_parameters() -> None:
    """The motion is the same, and the energy is finite before the contact."""
    text = cradle("places", 3, 2, "5/2", "4e8")
    named = text.replace("(5/2)", "p").replace("d: 0.03", "d: 0.03, p: 2.5")
    motion, other = (follow(one, 0.5, 6) for one in (text, named))
    np.testing.assert_allclose(other["q/x"], motion["q/x"], atol=1e-12)
    assert other.outcome.h_drift < 1e-15


@pytest.mark.exhaustive(keep=0.45)
def test_balls_that_are_all_lifted_swing_as_one_pendulum() -> None:
    """In as few steps."""
    alone = follow(cradle("angles", 1, 1, "2", "1"), 2.0, 9)
    motion = follow(cradle("angles", 3, 3, "2.2", "1e7"), 2.0, 9)
    np.testing.assert_allclose(motion["q/x"], np.repeat(alone["q/x"], 3, axis=1), atol=1e-14)
    assert motion.outcome.steps < alone.outcome.steps + 10


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("count", [2, 3, 4, 5])
@pytest.mark.parametrize("p", ["1.3", "3/2", "1.75"])
def test_roots_of_depths_that_rounding_hides_are_followed(p: str, count: int, source: random.Random) -> None:
    """The depth is a difference of much larger numbers, and the force a root of it. All samples, even those
    that are taken while a contact begins, have the same energy."""
    k, lifted, sign = 10 ** source.uniform(2, 6), source.randint(1, count - 1), source.choice("-+")
    text = cradle("angles", count, lifted, p, f"{k:.3g}", sign)
    text = text.replace("0.3*1", f"{source.uniform(0.1, 0.5):.3f}*1").replace(
        "l: 0.2", f"l: {source.uniform(0.1, 1):.3g}"
    )
    motion = follow(text, 1.0, 11)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift < 1e-11 * motion.outcome.h_size


@pytest.mark.exhaustive(keep=0.55)
def test_balls_that_touch_but_for_rounding_swing_together() -> None:
    """The root of a depth of 1e-18 would push them apart at once."""
    text = cradle("angles", 5, 4, "1.3", "457", "+").replace("l: 0.2", "l: 0.294").replace("0.3*1", "0.292*1")
    motion = follow(text, 0.25, 6)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps < 20
    np.testing.assert_allclose(motion["q/x"][:, 1:], np.tile(motion["q/x"][:, 1:2], 4), atol=1e-15)


@pytest.mark.exhaustive(keep=0.7)
def test_depths_beside_exact_numbers_are_rounded_too() -> None:
    """Two balls that hang where their coordinates are 0: their distance is a sum of rounded numbers."""
    text = cradle("angles", 3, 1, "1.3", "6.92e5").replace("l: 0.2", "l: 0.106").replace("0.3*1", "0.256*1")
    motion = follow(text, 0.2, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift < 1e-13 * motion.outcome.h_size


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(("k", "lifted"), [("1e3", 1), ("1e4", 2), ("1e5", 2)])
def test_they_move_as_in_double_double(k: str, lifted: int) -> None:
    """Up to what rounding of the depth changes the force by."""
    text = cradle("angles", 4, lifted, "3/2", k)
    ready = prepared(text, tolerance=FULL_DOUBLE_DOUBLE, precision=DOUBLE_DOUBLE)
    exact = run(ready, resolve_long_values(spec_of(text), {}), 0.0, 0.35, 2)
    np.testing.assert_allclose(follow(text, 0.35, 2)["q/x"], exact["q/x"], atol=2e-10)


@pytest.mark.exhaustive(keep=0.75)
def test_samples_that_are_taken_while_a_contact_begins() -> None:
    """Two balls that touch are let go: the series that follows does not converge back to where they were."""
    text = (
        cradle("angles", 5, 2, "1.3", "1.18e6").replace("d: 0.03", "d: 0.064").replace("l: 0.2", "l: 0.756")
    )
    motion = follow(text.replace("0.3*1", "0.101*1").replace("-l*cos", "0.1 - l*cos"), 1e-5, 5)
    np.testing.assert_array_equal(motion["q/x"][0], [-0.101, -0.101, 0, 0, 0])
    np.testing.assert_allclose(motion["q/x"], np.tile([-0.101, -0.101, 0, 0, 0], (5, 1)), atol=1e-9)
    assert motion.outcome.h_drift < 1e-14


def test_energy_of_a_ball_that_bounces_often() -> None:
    """No step goes beyond the circle of convergence, where the force is too weak to show it."""
    text = BALL.format(k=250000.0, p=2.5, y=0.9, v=0.0, power="max(0, -y)**p").replace("k/p", "9.81*y + k/p")
    motion = follow(text, 40.0)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift < 5e-14 * 9.81
    assert motion.outcome.steps < 6500


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("apart", [0.0, 1e-4])
def test_newtons_cradle(apart: float) -> None:
    """Beside the same motion in steps of another kind."""
    initial = f"where(i == 0, -0.3, {apart}*i)"
    text = (SYSTEMS / "newtons_cradle.yaml").read_text().replace("where(i == 0, -0.3, 0)", initial)
    text = text.replace("N: 5", "N: 3")
    motion = follow(text, 0.5, 11)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift < 1e-14
    for method, tolerance in (("DOP853", 1e-12), ("ias15", FULL)):
        other = follow(text, 0.5, 11, method=method, tolerance=tolerance)
        assert other.outcome.steps < 1000
        for path in ("q/theta", "v/theta"):
            np.testing.assert_allclose(other[path], motion[path], atol=1e-9)
    assert motion["v/theta"][5, -1] > 1.8


def test_a_large_cradle_in_small_units() -> None:
    """As the first ball reaches its lowest point, its coordinate tells nothing of the length of a step."""
    text = """
        parameters: {d: 30, l: 200}
        coordinates: {"theta[i in range(2)]": {initial: "where(i == 0, -0.3, 0)"}}
        masses: {"b[i in range(2)]": 1}
        embedding: {"b[i in range(2)]": ["d*i + l*sin(theta[i])", "-l*cos(theta[i])"]}
        potential: sum(9810*b[i].y for i in range(2)) + 1e8*max(0, d - norm(b[1] - b[0]))**(7/2)
    """
    motion = follow(text, 0.4, 5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift < 1e-14 * motion.outcome.h_size


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("method", "tolerance"), [("taylor", FULL), ("ias15", FULL), ("DOP853", 1e-10), ("Radau", 1e-10)]
)
def test_two_beads_that_touch_exchange_their_speeds(method: str, tolerance: float) -> None:
    """The force is as steep as depth**0.25 where the motion begins: no step may begin there."""
    p, k, m, v, stop = 1.25, 1e4, 0.1, 0.5, 0.3
    text = f"""
    coordinates: {{x: {{initial: 0, velocity: 0}}, y: {{initial: 0.1, velocity: {-v}}}}}
    masses: {{a: {m}, b: {m}}}
    embedding: {{a: [x], b: [y]}}
    potential: {k}*max(0, x - y + 0.1)**{p}
    """
    motion = follow(text, stop, 3, method=method, tolerance=tolerance)
    after = v * (stop - contact_time(k * p / (m / 2), p, v))
    error = 1e-13 if tolerance == FULL else 1e-8
    assert motion["q/y"][-1] - motion["q/x"][-1] == pytest.approx(0.1 + after, abs=error)
    assert motion["v/x"][-1] == pytest.approx(-v, abs=error)
    assert motion["v/y"][-1] == pytest.approx(0.0, abs=error)
