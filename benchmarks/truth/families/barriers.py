"""Barriers and wells in space: passed or not, by the energy; wide, narrow, high and barely high enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.course import Course
from benchmarks.truth.families.line import in_pieces, line
from benchmarks.truth.families.pulses import ROUNDED, SHAPES, marks, written
from benchmarks.truth.families.walls import above, below
from benchmarks.truth.pieces import Linear
from benchmarks.truth.roots import root_of

BUMPS = (
    "gauss",
    "steep",
    "lorentz",
    "lorentz4",
    "lorentz_power",
    "sech",
    "sech2",
    "tanh2",
    "angle",
    "angle2",
    "roots",
)
"""Shapes with one maximum, 1 at 0."""


def across(
    potential: Callable[[Numbers, Number], Number],
    ways: Callable[[Numbers], list[Number]],
    turns: Callable[[Numbers], tuple[Number, Number]] | None = None,
) -> Callable[[Numbers, Sequence[Number]], Truth]:
    """The motion from x0 with v0 > 0; where it turns, ``turns`` are two places about that where it does."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        turn = None
        if turns is not None:
            energy = p.v0**2 / 2 + potential(p, p.x0)
            turn = root_of(lambda x: potential(p, x) - energy, *turns(p))
        course = Course(lambda x: potential(p, x), p.x0, p.v0, marks=ways(p), turn=turn)
        states = [course.at(t) for t in times]
        slope = (
            max(abs(MP.diff(lambda s: potential(p, s), x) * x) for x in ways(p) if abs(x) < 10)
            if ways(p)
            else 0
        )
        size = p.v0 + ROUNDED * slope / p.v0
        return Truth(
            {"q/x": [x for x, _ in states], "v/x": [v for _, v in states]},
            sizes={"v/x": size, "q/x": size * times[-1]},
        )

    return reference


def bump(d: Draw, width: tuple[float, float], part: tuple[float, float], sign: int = 1) -> Case:
    """A bump (a well, for ``sign`` -1) at x = a, as high as this part of the kinetic energy."""
    text, values = SHAPES[d.choice(*BUMPS)]
    a, w = d.uniform("a", 0.2, 1), d.log("w", *width)
    d.uniform("x0", -1.5, -0.5)
    v = d.uniform("v0", 0.7, 2)
    B = d.fix("B", sign * d.value(v) ** 2 / 2 * d.source.uniform(*part))
    u = d.choice(f"(x - {a})/{w}", f"({a} - x)/{w}")
    reflected = sign > 0 and part[0] > 1
    return line(
        d, across(
            lambda p, x: p.B * values((x - p.a) / p.w), lambda p: marks(p.a, p.w),
            (lambda p: (p.a - 40 * p.w if p.a - 40 * p.w > p.x0 else p.x0, p.a)) if reflected else None,
        ), 5 / d.value("v0"), h=True, potential=[f"{B}*{written(text, u)}"],
    )  # fmt: skip


def passed(d: Draw) -> Case:
    """A bump below the energy."""
    return bump(d, (1e-3, 0.3), (0.1, 0.95))


def passed_narrow(d: Draw) -> Case:
    """The same, up to a millionth wide."""
    return bump(d, (1e-6, 1e-3), (0.1, 0.95))


def reflected(d: Draw) -> Case:
    """A bump above the energy."""
    return bump(d, (1e-3, 0.1), (1.05, 5))


def reflected_narrow(d: Draw) -> Case:
    """The same, up to a millionth wide."""
    return bump(d, (1e-6, 1e-3), (1.05, 5))


def well(d: Draw) -> Case:
    """A narrow well, passed."""
    return bump(d, (1e-6, 0.3), (0.2, 5), -1)


def step(d: Draw) -> Case:
    """A step of the potential, up or down, steep or not; too high in some."""
    a, w = d.uniform("a", 0.2, 1), d.log("w", 1e-6, 0.2)
    d.uniform("x0", -1.5, -0.5)
    v = d.uniform("v0", 0.7, 2)
    part = d.choice(-2, 0.3, 0.6, 0.9, 1.3, 3)
    B = d.fix("B", d.value(v) ** 2 / 2 * part * d.source.uniform(0.95, 1.05))
    text = d.choice(
        f"{B}*(1 + tanh((x - {a})/{w}))/2", f"{B}/(1 + exp(-2*(x - {a})/{w}))",
        f"{B}*(1/2 + atan((x - {a})/{w})/pi)", f"{B}*(1 + (x - {a})/sqrt((x - {a})**2 + {w}**2))/2",
    )  # fmt: skip

    def potential(p: Numbers, x: Number) -> Number:
        u = (x - p.a) / p.w
        if "atan" in text:
            return p.B * (MP.mpf(1) / 2 + MP.atan(u) / MP.pi)
        if "sqrt" in text:
            return p.B * (1 + u / MP.sqrt(1 + u**2)) / 2
        return p.B / (1 + MP.exp(-2 * u))

    def between(p: Numbers) -> tuple[Number, Number]:
        return max(p.x0, p.a - 40 * p.w), p.a + 400 * p.w

    return line(
        d,
        across(potential, lambda p: marks(p.a, p.w), between if part > 1 else None),
        5 / d.value("v0"),
        h=True,
        potential=[text],
    )


def corner(d: Draw) -> Case:
    """exp(-|x - a|/w): a bump with a corner."""
    a, w = d.uniform("a", 0.2, 1), d.log("w", 1e-4, 0.2)
    d.uniform("x0", -1.5, -0.5)
    v = d.uniform("v0", 0.7, 2)
    part = d.choice(-3, 0.4, 0.8, 1.2, 3)
    B = d.fix("B", d.value(v) ** 2 / 2 * part * d.source.uniform(0.95, 1.05))

    def reference(p: Numbers, x: Number) -> Number:
        return p.B * MP.exp(-abs(x - p.a) / p.w)

    between = (lambda p: (max(p.x0, p.a - 40 * p.w), p.a)) if part > 1 else None
    return line(
        d, across(reference, lambda p: marks(p.a, p.w), between), 5 / d.value("v0"), h=True,
        potential=[f"{B}*exp(-({d.absolute(f'x - {a}')})/{w})"],
    )  # fmt: skip


def triangle(d: Draw) -> Case:
    """A triangle, or what is left of it above: made of straight lines."""
    a, w, B = d.uniform("a", 0.2, 1), d.log("w", 1e-3, 0.5), d.uniform("B", -2, 2)
    d.uniform("x0", -1.5, -0.5)
    d.uniform("v0", 0.7, 2)
    reference = in_pieces(
        lambda p, mode: Linear(f=(0, -p.B / p.w, p.B / p.w, 0)[mode]),
        lambda p, mode: (
            [below(p.a - p.w, 1)], [above(p.a - p.w, 0), below(p.a, 2)], [above(p.a, 1), below(p.a + p.w, 3)],
            [above(p.a + p.w, 2)],
        )[mode],
        lambda p: 0,
    )  # fmt: skip
    u = f"1 - ({d.absolute(f'x - {a}')})/{w}"
    return line(d, reference, 5 / d.value("v0"), h=True, potential=[f"{B}*({d.positive(u)})"])


def trapezoid(d: Draw) -> Case:
    """A ramp to a plateau."""
    a, w, B = d.uniform("a", 0.2, 1), d.log("w", 1e-3, 0.5), d.uniform("B", -2, 2)
    d.uniform("x0", -1.5, -0.5)
    d.uniform("v0", 0.7, 2)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.B / p.w if mode == 1 else 0),
        lambda p, mode: ([below(p.a, 1)], [above(p.a, 0), below(p.a + p.w, 2)], [above(p.a + p.w, 1)])[mode],
        lambda p: 0,
    )
    u = f"(x - {a})/{w}"
    text = d.choice(f"min(max({u}, 0), 1)", f"max(0, min(1, {u}))", f"(abs({u}) - abs({u} - 1) + 1)/2",
                    f"where(x > {a} + {w}, 1, where(x > {a}, {u}, 0))")  # fmt: skip
    return line(d, reference, 5 / d.value("v0"), h=True, potential=[f"{B}*{text}"])


def flat_well(d: Draw) -> Case:
    """A high power of a sine as a well: the motion is confined, or passes."""
    n = 2 * d.source.randint(8, 32)
    d.uniform("x0", -0.2, 0.2)
    v = d.uniform("v0", 0.5, 1.5)
    bound = d.choice(True, True, False)
    part = d.source.uniform(1.1, 2) if bound else d.source.uniform(0.4, 0.9)
    B = d.fix("B", d.value(v) ** 2 / 2 * part)

    def potential(p: Numbers, x: Number) -> Number:
        return p.B * MP.sin(x) ** n

    def ways(p: Numbers) -> list[Number]:
        return [MP.pi * (j + MP.mpf(1) / 2) + MP.mpf(k) / 8 for j in range(8) for k in range(-6, 7)]

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        if not bound:
            return across(potential, ways)(p, times)
        # confined: from 0 to a quarter period later and back, and so on
        energy = p.v0**2 / 2 + potential(p, p.x0)
        top = MP.sqrt(2 * energy)
        turn = root_of(lambda x: potential(p, x) - energy, MP.mpf("0.5"), MP.pi / 2)
        course = Course(lambda x: potential(p, x), MP.mpf(0), top, turn=turn, marks=ways(p))
        half = 2 * course.time_to_turn()
        begin = MP.sign(p.x0) * course.time(abs(p.x0)) if p.x0 else MP.mpf(0)
        x, v = [], []
        for t in times:
            number = int(MP.floor((t + begin) / half))
            at, speed = course.at(t + begin - number * half)
            x.append(-at if number % 2 else at)
            v.append(-speed if number % 2 else speed)
        return Truth({"q/x": x, "v/x": v})

    return line(d, reference, 12, h=True, potential=[f"{B}*sin(x)**{n}"])


def comb_in_space(d: Draw) -> Case:
    """exp(k (cos(x) - 1)): one narrow bump after another, passed."""
    k, v = d.log("k", 30, 3000), d.uniform("v0", 0.8, 2)
    d.uniform("x0", 0.6, 3)
    B = d.fix("B", d.value(v) ** 2 / 2 * d.source.uniform(-2, 0.9))

    def ways(p: Numbers) -> list[Number]:
        width = 1 / MP.sqrt(p.k)
        return sorted(2 * MP.pi * j + m * width for j in range(8) for m in (-12, -5, -2, 0, 2, 5, 12))

    return line(
        d, across(lambda p, x: p.B * MP.exp(p.k * (MP.cos(x) - 1)), ways), 16, h=True,
        potential=[f"{B}*exp({k}*(cos(x) - 1))"],
    )  # fmt: skip


KINDS: tuple[Any, ...] = (
    passed, passed_narrow, reflected, reflected_narrow, well, step, corner, triangle, trapezoid, flat_well,
    comb_in_space,
)  # fmt: skip
