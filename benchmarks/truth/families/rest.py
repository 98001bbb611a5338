"""Motions that decay, to rest or to a constant velocity, and are followed for a long time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.families.line import line
from benchmarks.truth.pieces import Linear


def under(law: Callable[[Numbers], Linear]) -> Callable[[Numbers, Sequence[Number]], Truth]:
    """A linear law."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        states = [law(p).at(p.x0, p.v0, MP.mpf(0), t) for t in times]
        return Truth({"q/x": [x for x, _ in states], "v/x": [v for _, v in states]})

    return reference


def long(d: Draw) -> float:
    """A long time."""
    return float(d.choice(200, 1000, 2000, 5000))


def start(d: Draw) -> None:
    """An initial state."""
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", 0.2, 2)


def resistance(d: Draw, c: str) -> dict[str, Any]:
    """Viscous, as a force or by a dissipation function."""
    return d.choice({"dissipation": [f"{c}*x_dot**2/2"]}, {"forces": [f"-{c}*x_dot"]})  # type: ignore[no-any-return]


def damped_oscillator(d: Draw) -> Case:
    """To rest, in oscillations or without."""
    k, c = d.uniform("k", 0.5, 4), d.log("c", 0.05, 10)
    start(d)
    return line(
        d,
        under(lambda p: Linear(k=p.k, c=p.c)),
        long(d),
        samples=9,
        potential=[f"{k}/2*x**2"],
        **resistance(d, c),
    )


def slowed_down(d: Draw) -> Case:
    """A free particle with viscous resistance."""
    c = d.log("c", 0.05, 5)
    start(d)
    return line(d, under(lambda p: Linear(c=p.c)), long(d), **resistance(d, c))


def driven(d: Draw) -> Case:
    """To the steady motion of a driven oscillator."""
    k, c, a, w = (
        d.uniform("k", 0.5, 4),
        d.uniform("c", 0.1, 2),
        d.uniform("a", 0.2, 2),
        d.uniform("w", 0.3, 3),
    )
    start(d)
    return line(
        d, under(lambda p: Linear(k=p.k, c=p.c, a=p.a, w=p.w)), float(d.choice(100, 500, 1000)),
        potential=[f"{k}/2*x**2 - x*{a}*cos({w}*t)"], **resistance(d, c),
    )  # fmt: skip


def falling(d: Draw) -> Case:
    """To a terminal velocity."""
    g, c = d.uniform("g", 1, 10), d.uniform("c", 0.1, 2)
    start(d)
    return line(d, under(lambda p: Linear(f=-p.g, c=p.c)), long(d), potential=[f"{g}*x"], **resistance(d, c))


def falling_in_air(d: Draw) -> Case:
    """To a terminal velocity, by a resistance that is quadratic (as long as the sense stays the same)."""
    g, c = d.uniform("g", 1, 10), d.uniform("c", 0.1, 2)
    start(d)
    d.numbers["v0"] = "0"

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        rate, terminal = MP.sqrt(p.g * p.c), MP.sqrt(p.g / p.c)
        return Truth({
            "q/x": [p.x0 + MP.log(MP.cosh(rate * t)) / p.c for t in times],
            "v/x": [terminal * MP.tanh(rate * t) for t in times],
        })  # fmt: skip

    return line(d, reference, long(d), forces=[f"{g} - {c}*x_dot**2"])


def quadratic(d: Draw) -> Case:
    """v' = -c v^2."""
    c = d.uniform("c", 0.1, 2)
    start(d)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        return Truth({
            "q/x": [p.x0 + MP.log(1 + p.c * p.v0 * t) / p.c for t in times],
            "v/x": [p.v0 / (1 + p.c * p.v0 * t) for t in times],
        })  # fmt: skip

    return line(d, reference, long(d), forces=[f"-{c}*x_dot**2"])


def cubic(d: Draw) -> Case:
    """v' = -c v^3."""
    c = d.uniform("c", 0.1, 2)
    start(d)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        roots = [MP.sqrt(1 + 2 * p.c * p.v0**2 * t) for t in times]
        return Truth({
            "q/x": [p.x0 + (r - 1) / (p.c * p.v0) for r in roots], "v/x": [p.v0 / r for r in roots],
        })  # fmt: skip

    return line(
        d,
        reference,
        long(d),
        **d.choice({"forces": [f"-{c}*x_dot**3"]}, {"dissipation": [f"{c}*x_dot**4/4"]}),
    )


def kinks_and_resistance(d: Draw) -> Case:
    """U = k |x| and viscous resistance: ever shorter oscillations."""
    from benchmarks.truth.families.line import in_pieces
    from benchmarks.truth.families.walls import above, below

    k, c = d.uniform("k", 0.5, 2), d.uniform("c", 0.02, 0.1)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.k if mode == "right" else p.k, c=p.c),
        lambda p, mode: [above(0, "left") if mode == "right" else below(0, "right")],
        lambda p: "right",
    )
    return line(d, reference, 30, potential=[f"{k}*({d.absolute('x')})"], **resistance(d, c))


def growing_resistance(d: Draw) -> Case:
    """v' = -c t v: Gauss's function of the time."""
    c = d.uniform("c", 0.1, 2)
    start(d)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        root = MP.sqrt(p.c / 2)
        return Truth({
            "q/x": [p.x0 + p.v0 * MP.sqrt(MP.pi) / (2 * root) * MP.erf(root * t) for t in times],
            "v/x": [p.v0 * MP.exp(-p.c * t**2 / 2) for t in times],
        })  # fmt: skip

    return line(d, reference, float(d.choice(20, 100)), **resistance(d, f"{c}*t"))


KINDS = (
    damped_oscillator, slowed_down, driven, falling, falling_in_air, quadratic, cubic, kinks_and_resistance,
    growing_resistance,
)  # fmt: skip
