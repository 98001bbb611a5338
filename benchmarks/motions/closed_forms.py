"""Closed forms: q at time t from the parameters p and the initial q and v, all numbers of mpmath."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import mpmath as mp

Numbers = tuple[Any, ...]
Parameters = Mapping[str, Any]


def constant(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """At rest."""
    return q


def oscillator(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """At the angular frequency w, which is 1 unless the parameters say otherwise."""
    w = p.get("w", mp.mpf(1))
    return (q[0] * mp.cos(w * t) + v[0] / w * mp.sin(w * t),)


def far_oscillator(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """About 1e12."""
    return (10**12 + (q[0] - 10**12) * mp.cos(t),)


def detuned(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """Two oscillators; their stiffness is rounded as it is in double precision."""
    stiffness = mp.mpf(float(p["k"]) * (1 + float(p["detuning"])))
    return q[0] * mp.cos(t), q[1] * mp.cos(mp.sqrt(stiffness) * t)


def rod(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """A stiffness of -1."""
    return (q[0] * mp.cosh(t) + v[0] * mp.sinh(t),)


def fall(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """Free, from t = 1e9."""
    since = t - 10**9
    return (q[0] + v[0] * since - mp.mpf(9.81) * since**2 / 2,)


def kink(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """From rest at q > 0 in U = |x|: parabolas of alternating sign, a quarter of the period sqrt(2 q)."""
    quarter = mp.sqrt(2 * q[0])
    number = mp.floor((t + quarter) / (2 * quarter))
    rest = t + quarter - 2 * quarter * number
    height = q[0] - (rest - quarter) ** 2 / 2
    return (height if int(number) % 2 == 0 else -height,)


def overdamped(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """x'' = -1e6 x' - x."""
    half = mp.mpf(10) ** 6 / 2
    root = mp.sqrt(half**2 - 1)
    slow, fast = -1 / (half + root), -half - root
    return (q[0] * (fast * mp.exp(slow * t) - slow * mp.exp(fast * t)) / (fast - slow),)


def pulse(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """A free particle, pushed by a normalized Gaussian about t = 50 of width w."""
    w = p["w"]

    def twice_integrated(z: Any) -> Any:  # of exp(-z^2)/sqrt(pi), from minus infinity
        return (z * (1 + mp.erf(z)) + mp.exp(-(z**2)) / mp.sqrt(mp.pi)) / 2

    return (q[0] + v[0] * t + w * (twice_integrated((t - 50) / w) - twice_integrated(-50 / w)),)


def run_across(shape: Callable[[Any], Any], far: int = 100) -> Callable[..., Numbers]:
    """Across the potential shape(x/w)/4, w = 1e-6, from before it: t = int dx/v, and v is constant where
    |x/w| > ``far``."""
    w = mp.mpf(10) ** -6
    marks = [mp.mpf(10) ** n for n in range(int(mp.log10(far)))]

    def q_at(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
        def speed(u: Any) -> Any:
            return mp.sqrt(v[0] ** 2 + (shape(-far) - shape(u)) / 2)

        def since(u: Any) -> Any:
            ways = [-far, *(-each for each in reversed(marks)), 0, *marks]
            return w * mp.quad(lambda x: 1 / speed(x), [*(way for way in ways if way < u), u])

        enter = (-far * w - q[0]) / v[0]
        if t <= enter:
            return (q[0] + v[0] * t,)
        leave = enter + since(far)
        if t >= leave:
            return (far * w + speed(far) * (t - leave),)
        return (w * mp.findroot(lambda u: since(u) - (t - enter), (t - enter) * v[0] / w - far),)

    return q_at


potential_step = run_across(mp.tanh)
narrow_bump = run_across(lambda u: mp.exp(-(u**2)))
narrow_well = run_across(lambda u: -1 / (1 + u**4), far=10**4)


def cubic(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """x^3 moves uniformly."""
    cube = q[0] ** 3 + 3 * q[0] ** 2 * v[0] * t
    return (mp.sign(cube) * abs(cube) ** (mp.mpf(1) / 3),)


def polar(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """A free particle in polar coordinates; where it runs through the origin r changes its sign."""
    radial, across = v[0], q[0] * v[1]
    x, y = q[0] + radial * t, across * t
    if not across:
        return x, q[1]
    return mp.sqrt(x**2 + y**2), q[1] + mp.atan2(y, x)


def blow_up(p: Parameters, q: Numbers, v: Numbers, t: Any) -> Numbers:
    """x = (1 - t)^-2, infinite beyond."""
    return (1 / (1 - t) ** 2 if t < 1 else mp.inf,)
