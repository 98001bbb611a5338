"""The operations of a step by series and of an evaluation, counted."""

from __future__ import annotations

import pytest

from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.family_work import ENCLOSED_FUNCTION, ENCLOSED_POWER, Work, work_of
from lagrange_cli.spec.read import read_spec

BODIES = """
sizes: {{N: {count}}}
parameters: {{k: 1}}
coordinates: {{"x[i in range(N)]": {{initial: i}}, "y[i in range(N)]": {{initial: i}}}}
masses: {{"body[i in range(N)]": 1}}
embedding: {{"body[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum({pair} for i in range(N) for j in range(i))
"""
R2 = "dot(body[i] - body[j], body[i] - body[j])"


def work(pair: str, count: int = 64) -> Work:
    """That of bodies in a plane which act on each other."""
    system = family_system(read_spec(BODIES.format(pair=pair, count=count), "bodies.yaml"))
    assert system is not None
    return work_of(system)


def members(count: int) -> int:
    """Pairs in rows, each filled up to eights."""
    return sum(8 * -(-i // 8) for i in range(1, count))


@pytest.mark.parametrize(
    ("pair", "each"),
    [
        ("1/norm(body[i] - body[j])", 2 * 0.5 + 1.5 + 2),  # two squares, (r^2)^-1.5, and that times x and y
        (f"{R2}", 0),
        (f"({R2})**2", 2 * 0.5 + 2),
        ("(x[i] - x[j])**2*k + cos(y[i] - y[j])", 2),  # sine and cosine
    ],
)
def test_convolutions(pair: str, each: float) -> None:
    assert work(pair).convolutions == each * members(64)


def test_poles_and_proofs() -> None:
    gravity, cores = work("1/norm(body[i] - body[j])"), work(f"exp(-{R2})")
    assert (gravity.has_poles, gravity.proven, gravity.enclosed) == (True, False, 0)
    assert (cores.has_poles, cores.proven) == (False, True)
    steep, even = work("norm(body[i] - body[j])**-2.7"), work(f"({R2})**-6")
    assert steep.enclosed / cores.enclosed == pytest.approx(3 * ENCLOSED_POWER / ENCLOSED_FUNCTION)
    assert (even.proven, even.enclosed) == (True, 0)


def test_a_step_takes_the_square_of_its_order() -> None:
    """And the more evaluations are as long as one, the tighter the tolerance is, the larger coefficients in
    memory are, and the fewer of the operations of an evaluation are slow ones."""
    gravity = work("1/norm(body[i] - body[j])")
    steps = [gravity.step(tolerance) for tolerance in (1e-6, 1e-10, 2.0**-52)]  # of order 18, 23 and 29
    assert 23 / 18 < steps[1] / steps[0] < (23 / 18) ** 2
    assert 29 / 23 < steps[2] / steps[1] < (29 / 23) ** 2
    many = work("1/norm(body[i] - body[j])", 500)
    assert many.price(2.0**-52) > 2 * gravity.price(2.0**-52)
    waves = work("cos(x[i] - x[j])*cos(y[i] - y[j])")
    assert waves.price(2.0**-52) < gravity.price(2.0**-52)
