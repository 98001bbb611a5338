"""Estimates beside errors of the problem as it is written, whose numbers are no doubles."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER
from tests.integrate.certify.test_certificate import Number, certified, coverage

UPSIDE_DOWN = """
parameters: {g: 9.81, l: 1/5}
coordinates: {th: {initial: pi}}
lagrangian: l**2*th_dot**2/2 + g*l*cos(th)
"""


def at(times: Sequence[float], known: Callable[[Number], Number]) -> list[Number]:
    """What is known, at each time."""
    with mpmath.workdps(50):
        return [known(Number(t)) for t in times]


def third(text: str) -> Number:
    """A fraction as a number of many digits."""
    above, _, below = text.partition("/")
    return Number(above) / Number(below or 1)


@pytest.mark.exhaustive(keep=0.6)
def test_a_rounded_angle_leaves_the_top():
    """As written, the pendulum stays there for ever; the first time was 8e-8 away with an estimate of
    4e-16."""
    data, outcome = certified(UPSIDE_DOWN, 5.0, 501)
    assert coverage(data, "q/th", at(data["t"], lambda t: mpmath.pi)) == 1
    assert abs(data["q/th"][-1] - np.pi) > 0.01
    assert np.max(data[AS_RUN + "q/th"]) < 1e-13
    found = outcome.estimated
    assert found.staying and found.rounded == ("g", "l", "th")
    assert 3 < found.trusted_until < 4 and found.trusted_until_as_run == 5


@pytest.mark.exhaustive(keep=0.5)
def test_what_is_not_the_roundings_is_not_called_so():
    """A chaotic motion from doubles loses all digits, by rounding in the steps."""
    _, outcome = certified(
        """
coordinates: {x: {initial: 0.875}, y: {initial: 0.25, velocity: 0.75}}
lagrangian: (x_dot**2 + y_dot**2)/2 - x**2*y**2/2 - (x**2 + y**2)/32
""",
        200.0,
        801,
    )
    found = outcome.estimated
    assert found.trusted_until < 200 and found.rounded is None and not found.staying
    assert found.trusted_until == found.trusted_until_as_run


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("lagrangian: x_dot**2/2 + x/10", lambda t: 1 + t**2 / 20),
        ("lagrangian: x_dot**2/2 - pi*x", lambda t: 1 - mpmath.pi * t**2 / 2),
        ("lagrangian: x_dot**2/2 - x**2*(1/3)/2", lambda t: mpmath.cos(t / mpmath.sqrt(3))),
        ("lagrangian: x_dot**2/2 + (2/7)*(x - 3/5)**2/2",
         lambda t: Number(3) / 5 + Number(2) / 5 * mpmath.cosh(t * mpmath.sqrt(Number(2) / 7))),
    ],
)  # fmt: skip
def test_numbers_in_expressions_count(text, known):
    data, _ = certified(f"coordinates: {{x: {{initial: 1}}}}\n{text}\n", 60.0, 301)
    assert coverage(data, "q/x", at(data["t"], known)) >= 0.99


def test_the_time_of_the_start_counts():
    data, _ = certified(
        "coordinates: {x: {initial: 0, velocity: 1}}\nlagrangian: x_dot**2/2\n", 1004.0, 41, start="1000.1"
    )
    truth = at(data["t"], lambda t: t - Number("1000.1"))
    assert coverage(data, "q/x", truth) == 1
    assert np.max(data[FOLDER + "q/x"]) > 1e-14


def bounced(k: str, x: str) -> Callable[[Number], Number]:
    """Between two equal constant forces towards 0, from rest."""

    def known(t: Number) -> Number:
        force, begin = third(k), third(x)
        quarter = mpmath.sqrt(2 * begin / force)
        phase = t / quarter
        turns = int(mpmath.floor((phase + 1) / 2))
        rest = (phase - 2 * turns) * quarter
        return (-1) ** turns * (begin - force * rest**2 / 2)

    return known


def two_springs(t: Number) -> Number:
    """From x = 0 with v = 1: x'' = -x/10 on the right, and -3x/7 on the left."""
    right, left = mpmath.sqrt(Number(1) / 10), mpmath.sqrt(Number(3) / 7)
    half, whole = mpmath.pi / right, mpmath.pi / right + mpmath.pi / left
    t = mpmath.fmod(t, whole)
    return mpmath.sin(right * t) / right if t < half else -mpmath.sin(left * (t - half)) / left


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("coordinates: {x: {initial: 1/7}}\nlagrangian: x_dot**2/2 - abs(x)/3\n", bounced("1/3", "1/7")),
        (
            "parameters: {k: 1/10, l: 3/7}\ncoordinates: {x: {initial: 0, velocity: 1}}\n"
            "lagrangian: x_dot**2/2 - where(x > 0, k, l)*x**2/2\n",
            two_springs,
        ),
    ],
)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_where_the_force_changes_the_roundings_are_still_carried(text, known, method):
    """Constants are computed anew there."""
    stop = 200.0 if method == "taylor" else 10.0
    data, _ = certified(text, stop, 401, method)
    truth = at(data["t"], known)
    assert coverage(data, "q/x", truth) >= 0.97
    if method == "taylor":
        assert max(abs(x - y) for x, y in zip(data["q/x"], truth)) > 1e-15


@pytest.mark.exhaustive(keep=0.8)
def test_a_method_that_misses_a_pulse_has_an_error():
    """It is compared with a motion whose steps are proven."""
    data, outcome = certified(
        "coordinates: {x: {initial: 0}}\nlagrangian: x_dot**2/2 + x*exp(-1000*(t - 50)**2)\n",
        100.0,
        101,
        "DOP853",
    )
    with mpmath.workdps(50):
        speed = mpmath.sqrt(mpmath.pi / 1000)
    wrong = abs(float(data["v/x"][-1]) - float(speed))
    assert wrong > 0.01
    assert 0.1 * wrong <= data[FOLDER + "v/x"][-1] <= 100 * wrong
    found = outcome.estimated  # the run itself has not moved: no part of its size is right
    assert found.error == 1.0 and 49 <= found.trusted_until < 51
