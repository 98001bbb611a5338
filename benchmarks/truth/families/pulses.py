"""Pulses in time: a force that is short, narrow, or far away, on a free particle or an oscillator."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.course import integral
from benchmarks.truth.families.line import line

Shape = tuple[str, Callable[[Number], Number]]
"""A pulse as written with u, and its values."""

SHAPES: dict[str, Shape] = {
    "gauss": ("exp(-(u)**2)", lambda u: MP.exp(-(u**2))),
    "steep": ("exp(-(u)**4)", lambda u: MP.exp(-(u**4))),
    "lorentz": ("1/(1 + (u)**2)", lambda u: 1 / (1 + u**2)),
    "lorentz4": ("1/(1 + (u)**4)", lambda u: 1 / (1 + u**4)),
    "lorentz_power": ("(1 + (u)**2)**(-1.5)", lambda u: (1 + u**2) ** MP.mpf(-1.5)),
    "sech": ("1/cosh(u)", lambda u: MP.sech(u)),
    "sech2": ("1/cosh(u)**2", lambda u: MP.sech(u) ** 2),
    "tanh2": ("(1 - tanh(u)**2)", lambda u: MP.sech(u) ** 2),
    "slope": ("(u)*exp(-(u)**2)", lambda u: u * MP.exp(-(u**2))),
    "packet": ("exp(-(u)**2)*cos(5*(u))", lambda u: MP.exp(-(u**2)) * MP.cos(5 * u)),
    "angle": ("cos(atan(u))**6", lambda u: (1 + u**2) ** -3),
    "angle2": ("sin(atan2(1, u))**4", lambda u: (1 + u**2) ** -2),
    "roots": ("((1 + (u)**4)**0.5 - (u)**2)**4", lambda u: 1 / (MP.sqrt(1 + u**4) + u**2) ** 4),
    "logistic": ("exp(-(u))/(1 + exp(-(u)))**2", lambda u: MP.sech(u / 2) ** 2 / 4),
}


ROUNDED = 4 * 2.0**-52 / 1e-12
"""A few roundings, as a part of what an error may be: t, and x, are no better known within a pulse or a
barrier, and what a force makes of that does not show in the sensitivity to a shift of the whole."""


def marks(center: Number, width: Number) -> list[Number]:
    """Where integrals over a pulse are divided."""
    near = [center + k * width for k in (-8, -5, -3, -2, -1, 0, 1, 2, 3, 5, 8)]
    far = [center + side * MP.mpf(4) ** k * width for side in (-1, 1) for k in range(2, 18)]
    return sorted([*near, *far])


def pushed(
    force: Callable[[Numbers], Callable[[Number], Number]],
    ways: Callable[[Numbers], list[Number]],
    k: Callable[[Numbers], Number] = lambda p: MP.mpf(0),
) -> Callable[[Numbers, Sequence[Number]], Truth]:
    """x'' = -k x + f(t) by Duhamel's integral."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        f, places, w = force(p), ways(p), MP.sqrt(k(p))
        x, v = [], []
        sums = [MP.mpf(0), MP.mpf(0)]
        before = MP.mpf(0)
        for t in times:  # integrals of f(s) cos(w s) and f(s) sin(w s), or of f and s f
            if t > before:
                if w:
                    sums[0] += integral(lambda s: f(s) * MP.cos(w * s), before, t, places)
                    sums[1] += integral(lambda s: f(s) * MP.sin(w * s), before, t, places)
                else:
                    sums[0] += integral(f, before, t, places)
                    sums[1] += integral(lambda s: f(s) * s, before, t, places)
            before = t
            if w:
                cosine, sine = MP.cos(w * t), MP.sin(w * t)
                x.append(p.x0 * cosine + p.v0 / w * sine + (sine * sums[0] - cosine * sums[1]) / w)
                v.append(p.v0 * cosine - w * p.x0 * sine + cosine * sums[0] + sine * sums[1])
            else:
                x.append(p.x0 + p.v0 * t + t * sums[0] - sums[1])
                v.append(p.v0 + sums[0])
        size = integral(lambda s: abs(f(s)), times[0], times[-1], places)
        size += ROUNDED * max((abs(f(s)) * abs(s) for s in places if 0 <= s <= times[-1]), default=0)
        return Truth({"q/x": x, "v/x": v}, sizes={"v/x": size, "q/x": size * times[-1]})

    return reference


def push(d: Draw, force: str) -> dict[str, Any]:
    """A force of the time, as such or in the potential."""
    return d.choice({"potential": [f"-x*{force}"]}, {"forces": [force]}, {"lagrangian": [f"x*{force}"]})  # type: ignore[no-any-return]


def start(d: Draw) -> None:
    """An initial state; at rest in some."""
    d.uniform("x0", -1, 1)
    d.uniform("v0", -1, 1)
    if d.choice(True, False):
        d.numbers["v0"] = "0"


def shaped(d: Draw, low: float, high: float, far: float) -> tuple[str, Callable[[Numbers], Any], float]:
    """A pulse A shape((t - T)/w) of a random shape, written in one of several ways; and the time to stop."""
    text, values = SHAPES[d.choice(*SHAPES)]
    d.log("w", low, high)
    A, T = (
        d.log("A", 0.3 / d.value("w") ** 0.5, 3 / d.value("w") ** 0.5),
        d.uniform("T", 0.3 * far, 0.8 * far),
    )
    sign = d.choice(1, -1)
    force = f"{A}*{written(text, f'(t - {T})/w' if sign > 0 else f'({T} - t)/w')}"
    return force, lambda p: lambda t: p.A * values(sign * (t - p.T) / p.w), far


def written(shape: str, u: str) -> str:
    """A shape with its argument."""
    return re.sub(r"\bu\b", f"({u})", shape)


def pulse(d: Draw) -> Case:
    """One pulse, more or less narrow, on a free particle."""
    force, values, far = shaped(d, 1e-3, 0.3, 10)
    start(d)
    return line(d, pushed(values, lambda p: marks(p.T, p.w)), far, **push(d, force))


def narrow_pulse(d: Draw) -> Case:
    """A pulse of up to a millionth of the time."""
    force, values, far = shaped(d, 1e-6, 1e-3, 10)
    start(d)
    return line(d, pushed(values, lambda p: marks(p.T, p.w)), far, **push(d, force))


def far_pulse(d: Draw) -> Case:
    """A pulse after a long time in which nothing happens."""
    force, values, far = shaped(d, 0.01, 1, d.choice(1e3, 1e4))
    start(d)
    return line(d, pushed(values, lambda p: marks(p.T, p.w)), far, samples=3, **push(d, force))


def pulse_on_oscillator(d: Draw) -> Case:
    """A pulse on a spring."""
    force, values, far = shaped(d, 1e-3, 0.3, 10)
    k = d.uniform("k", 0.5, 9)
    start(d)
    given = push(d, force)
    spring = {"potential": [f"{k}/2*x**2", *given.get("potential", ())]}
    return line(d, pushed(values, lambda p: marks(p.T, p.w), lambda p: p.k), far, **{**given, **spring})


def two_pulses(d: Draw) -> Case:
    """Two pulses, far apart."""
    text, values = SHAPES[d.choice("gauss", "sech2", "lorentz", "packet")]
    A, B, w = d.uniform("A", 1, 5), d.uniform("B", -5, -1), d.log("w", 1e-3, 0.1)
    T, S = d.uniform("T", 1, 4), d.uniform("S", 6, 9)
    start(d)
    one, other = (written(text, f"(t - {at})/{w}") for at in (T, S))
    return line(
        d, pushed(
            lambda p: lambda t: p.A * values((t - p.T) / p.w) + p.B * values((t - p.S) / p.w),
            lambda p: sorted(marks(p.T, p.w) + marks(p.S, p.w)),
        ), 10, **push(d, f"({A}*{one} + {B}*{other})"),
    )  # fmt: skip


def high_power(d: Draw) -> Case:
    """A high power of a sine or cosine: a comb of short pulses."""
    n = d.source.randint(10, 62)
    function = d.choice("sin", "cos")
    w, phi = d.uniform("w", 0.6, 2), d.uniform("phi", 0, 6)
    start(d)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        # cos^n y = 2^-n sum_j C(n, j) cos((n - 2 j) y)
        shift = p.phi - (MP.pi / 2 if function == "sin" else 0)
        x, v = [p.x0 + p.v0 * t for t in times], [p.v0 for t in times]
        for j in range(n + 1):
            scale, m = MP.binomial(n, j) / MP.mpf(2) ** n, n - 2 * j
            for i, t in enumerate(times):
                if m:
                    rate, phase = m * p.w, m * shift
                    v[i] += scale * (MP.sin(rate * t + phase) - MP.sin(phase)) / rate
                    x[i] += (
                        scale * ((MP.cos(phase) - MP.cos(rate * t + phase)) / rate - t * MP.sin(phase)) / rate
                    )
                else:
                    v[i] += scale * t
                    x[i] += scale * t**2 / 2
        pulse = MP.sqrt(2 * MP.pi / n) / p.w  # of odd powers, which may take back all at the samples
        return Truth({"q/x": x, "v/x": v}, sizes={"v/x": pulse, "q/x": pulse / p.w})

    return line(d, reference, 100, **push(d, f"{function}({w}*t + {phi})**{n}"))


def ramp(d: Draw) -> Case:
    """A force that is switched on or off smoothly, in a short time."""
    T, w, f = d.uniform("T", 2, 8), d.log("w", 1e-5, 0.3), d.uniform("f", 0.5, 2)
    start(d)
    text = d.choice(
        f"{f}*(1 + tanh((t - {T})/{w}))/2", f"{f}/(1 + exp(-2*(t - {T})/{w}))",
        f"{f}*(1/2 + atan((t - {T})/{w})/pi)", f"{f}*(1 + (t - {T})/sqrt((t - {T})**2 + {w}**2))/2",
    )  # fmt: skip

    def values(p: Numbers) -> Callable[[Number], Number]:
        if "atan" in text:
            return lambda t: p.f * (MP.mpf(1) / 2 + MP.atan((t - p.T) / p.w) / MP.pi)
        if "sqrt" in text:
            return lambda t: p.f * (1 + (t - p.T) / MP.sqrt((t - p.T) ** 2 + p.w**2)) / 2
        return lambda t: p.f / (1 + MP.exp(-2 * (t - p.T) / p.w))

    return line(d, pushed(values, lambda p: marks(p.T, p.w)), 10, **push(d, text))


def comb(d: Draw) -> Case:
    """exp(k (cos(w t) - 1)): narrow pulses, once a period."""
    k, w, phi = d.log("k", 30, 3000), d.uniform("w", 0.8, 2), d.uniform("phi", 0.5, 5)
    start(d)

    def ways(p: Numbers) -> list[Number]:
        width = 1 / (p.w * MP.sqrt(p.k))
        return sorted(
            (2 * MP.pi * j - p.phi) / p.w + m * width for j in range(8) for m in (-12, -5, -2, 0, 2, 5, 12)
        )

    return line(
        d, pushed(lambda p: lambda t: MP.exp(p.k * (MP.cos(p.w * t + p.phi) - 1)), ways), 16,
        **push(d, f"exp({k}*(cos({w}*t + {phi}) - 1))"),
    )  # fmt: skip


def double_exponential(d: Draw) -> Case:
    """exp(-|t - T|/w): a pulse with a corner."""
    A, T, w = d.uniform("A", 1, 5), d.uniform("T", 2, 8), d.log("w", 1e-3, 0.3)
    start(d)
    u = d.absolute(f"t - {T}")
    return line(
        d, pushed(lambda p: lambda t: p.A * MP.exp(-abs(t - p.T) / p.w), lambda p: marks(p.T, p.w)), 10,
        **push(d, f"{A}*exp(-({u})/{w})"),
    )  # fmt: skip


def pulse_of_resistance(d: Draw) -> Case:
    """A viscous resistance that is switched on for a short time."""
    c, T, w = d.log("c", 1, 30), d.uniform("T", 2, 6), d.log("w", 1e-4, 0.1)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def gone(t: Number) -> Number:
            return MP.exp(-p.c * p.w * (MP.erf((t - p.T) / p.w) + MP.erf(p.T / p.w)) * MP.sqrt(MP.pi) / 2)

        v = [p.v0 * gone(t) for t in times]
        x, before = [p.x0], times[0]
        for t in times[1:]:
            x.append(x[-1] + p.v0 * integral(gone, before, t, marks(p.T, p.w)))
            before = t
        return Truth({"q/x": x, "v/x": v})

    text = f"{c}*exp(-((t - {T})/{w})**2)"
    return line(d, reference, 8, **d.choice(
        {"dissipation": [f"{text}*x_dot**2/2"]}, {"forces": [f"-x_dot*{text}"]}
    ))  # fmt: skip


def large_argument(d: Draw) -> Case:
    """A force that oscillates a thousand times, or ever faster."""
    w, phi = d.log("w", 30, 3000), d.uniform("phi", 0, 6)
    start(d)
    n = d.choice(1, 2, 3)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        # cos^n as a sum of cosines
        terms = {1: [(1, 1.0)], 2: [(0, 0.5), (2, 0.5)], 3: [(1, 0.75), (3, 0.25)]}[n]
        x, v = [], []
        for t in times:
            at, speed = p.x0 + p.v0 * t, p.v0
            for m, scale in terms:
                a, phase = m * p.w, m * p.phi
                if m:
                    speed += scale * (MP.sin(a * t + phase) - MP.sin(phase)) / a
                    at += scale * ((MP.cos(phase) - MP.cos(a * t + phase)) / a - t * MP.sin(phase)) / a
                else:
                    speed, at = speed + scale * t, at + scale * t**2 / 2
            x.append(at)
            v.append(speed)
        return Truth({"q/x": x, "v/x": v})

    power = "" if n == 1 else f"**{n}"
    return line(d, reference, 5, **push(d, f"cos({w}*t + {phi}){power}"))


KINDS = (
    pulse, narrow_pulse, far_pulse, pulse_on_oscillator, two_pulses, high_power, ramp, comb,
    double_exponential, pulse_of_resistance, large_argument,
)  # fmt: skip
