"""Taylor coefficients of every function of the language, to the highest order, against mpmath's."""

from __future__ import annotations

from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from tests.support.jets import coefficients
from tests.support.motion import evaluate, follow

DIGITS = 90
START, RATE, PULL = 0.3, 0.7, 0.4
A, B = 1.7, -0.6

FORMS = [
    "sin({})",
    "cos({})",
    "tan({})",
    "asin({})",
    "acos({})",
    "atan({})",
    "sinh({})",
    "cosh({})",
    "tanh({})",
    "exp({})",
    "log({})",
    "sqrt({})",
    "atan2({}, 1 + {})",
    "atan2(1 - {}, {}*{} - 2)",
    "atan2({}, 2)",
    "atan2(-1, {} - 2)",
    "{}**2",
    "{}**3",
    "{}**5",
    "{}**17",
    "{}**-1",
    "{}**-2",
    "{}**-7",
    "{}**0.5",
    "{}**1.5",
    "{}**-0.5",
    "{}**-3.5",
    "{}**0.3",
    "{}**-2.7",
    "{}**a",
    "{}**b",
    "{}**(a - b)",
    "a**{}",
    "2**{}",
    "{}**{}",
    "1/{}",
    "{}/(1 + {}**2)",
    "a/(b - {})",
    "exp(-{}**2)*sin(3*{})",
    "log(1 + exp({}))/cosh({})",
    "sqrt(1 + sin({})**2)",
    "tan(tanh({}))",
    "asin({}/2)*acos({}/2)",
]
"""Each {} is replaced by an argument that stays between 0 and 1 for a while."""

ARGUMENTS = ["y", "t + 0.3", "y_dot", "y*y_dot + t/5"]


def driven(*forces: str) -> str:
    """x0'' = the first force, x1'' = the second, ..., while y runs with constant acceleration."""
    names = [f"x{k}" for k in range(len(forces))]
    return f"""
    parameters: {{a: {A}, b: {B}}}
    coordinates:
      y: {{initial: {START}, velocity: {RATE}}}
{"".join(f"      {x}: {{initial: 0.2, velocity: -0.1}}{chr(10)}" for x in names)}
    masses: {{p: 1, {", ".join(f"p{x}: 1" for x in names)}}}
    embedding: {{p: y, {", ".join(f"p{x}: {x}" for x in names)}}}
    generalized_forces:
      y: {PULL}
{"".join(f"      {x}: {force}{chr(10)}" for x, force in zip(names, forces))}
    """


def drive(t: mpmath.mpf) -> dict[str, mpmath.mpf]:
    """What the names in a force stand for at ``t``."""
    start, rate, pull = map(mpmath.mpf, (START, RATE, PULL))
    return {
        "y": start + rate * t + pull * t**2 / 2,
        "y_dot": rate + pull * t,
        "t": t,
        "a": mpmath.mpf(A),
        "b": mpmath.mpf(B),
    }


def series_of(function: Callable[[mpmath.mpc], mpmath.mpc], count: int) -> list[mpmath.mpf]:
    """The first ``count`` Taylor coefficients at 0, by Cauchy's integral over a small circle of radius r.

    c_m r^m is the m-th Fourier coefficient, up to c_(m + n) r^(m + n) for n points on the circle.
    """
    n, r = 64, mpmath.mpf(1) / 20
    roots = mpmath.unitroots(n)
    values = [function(r * root) for root in roots]
    return [sum(f * roots[-m * j % n] for j, f in enumerate(values)).real / (n * r**m) for m in range(count)]


def deviation(found: np.ndarray, known: list[mpmath.mpf]) -> float:
    """The largest difference of two series over a step of three quarters of the radius of convergence, for
    their largest term there."""
    later = [(m, abs(c)) for m, c in enumerate(known) if m > len(known) // 2]
    radii = [c ** (mpmath.mpf(-1) / m) for m, c in later if c > mpmath.mpf(10) ** -30]
    step = mpmath.mpf(3) / 4 * min(radii, default=mpmath.mpf(1))
    differences = (abs(mpmath.mpf(float(x)) - c) * step**m for m, (x, c) in enumerate(zip(found, known)))
    return float(max(differences) / max(abs(c) * step**m for m, c in enumerate(known)))


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("form", FORMS)
def test_coefficients_of_a_function(form: str) -> None:
    forces = [form.replace("{}", f"({argument})") for argument in ARGUMENTS]
    rows = coefficients(driven(*forces))[1:]
    for force, row in zip(forces, rows):
        assert len(row) >= 20
        with mpmath.workdps(DIGITS):
            series = series_of(lambda t: evaluate(force, drive(t)), len(row) - 2)  # noqa: B023
            known = [mpmath.mpf(0.2), mpmath.mpf(-0.1)]
            known += [c / ((m + 1) * (m + 2)) for m, c in enumerate(series)]
            assert deviation(row, known) < 2e-15, force


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("form", FORMS)
def test_bead_on_a_wire_of_this_shape(form: str) -> None:
    """(1 + f'^2) x'' + f' f'' x'^2 + g f' = 0 for a bead on z = f(x).

    Here f is differentiated twice along the motion, and its newest coefficient depends on the acceleration.
    The series must satisfy the equation some way off.
    """
    shape = form.replace("{}", "(x)")
    text = f"""
    parameters: {{a: {A}, b: {B}}}
    coordinates: {{x: {{initial: 0.4, velocity: 0.5}}}}
    masses: {{p: 2}}
    embedding: {{p: [x, "{shape}"]}}
    potential: 2*1.5*p.y
    """
    row = coefficients(text)[0]
    with mpmath.workdps(30):
        tail = [abs(mpmath.mpf(c)) ** (mpmath.mpf(-1) / m) for m, c in enumerate(row) if m > 10 and c]
        h = min(tail) / 20  # the series of the acceleration has 20 terms or so
        x = mpmath.polyval([mpmath.mpf(c) for c in row[::-1]], h)
        v = sum(m * mpmath.mpf(c) * h ** (m - 1) for m, c in enumerate(row) if m)
        rate = sum(m * (m - 1) * mpmath.mpf(c) * h ** (m - 2) for m, c in enumerate(row) if m > 1)
        values = {"a": mpmath.mpf(A), "b": mpmath.mpf(B)}
        _, slope, half = series_of(lambda u: evaluate(shape, {**values, "x": x + u}), 3)
        terms = [(1 + slope**2) * rate, 2 * slope * half * v**2, mpmath.mpf(1.5) * slope]
        assert h > 0.001
        assert float(abs(sum(terms)) / max(map(abs, terms))) < 1e-14


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-7, 1e-11, 2.0**-52])
@pytest.mark.parametrize("form", ["sin({})", "tan({})", "{}**-2.7", "atan2({}, 1 + {})", "log({})", "{}**{}"])
def test_driven_motion_at_every_order(form: str, tolerance: float) -> None:
    """The double quadrature x(T) = x0 + v0 T + int_0^T (T - s) f(s) ds, at orders from 8 on."""
    force = form.replace("{}", "y")
    motion = follow(driven(force), 0.75, 4, tolerance=tolerance, outputs=("q",))
    with mpmath.workdps(30):
        end = mpmath.mpf(0.75)
        work = mpmath.quad(lambda s: (end - s) * evaluate(force, drive(s)), [0, end])
        known = mpmath.mpf(0.2) - mpmath.mpf(0.1) * end + work
        assert abs(mpmath.mpf(motion["q/x0"][-1]) - known) < max(tolerance, 4e-16)
