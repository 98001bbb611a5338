"""Poles and ends of domains: the motion ends at a time that is known, or turns before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.course import Course
from benchmarks.truth.families.barriers import across
from benchmarks.truth.families.line import line
from benchmarks.truth.roots import root_of


def ends(
    potential: Callable[[Numbers, Number], Number], place: Callable[[Numbers], Number], mass: Number = 1
) -> Callable[[Numbers, Sequence[Number]], Truth]:
    """The motion from x0 with v0 ends at a place."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        end = place(p)
        ways = [end - (end - p.x0) / 4**k for k in range(1, 6)]
        course = Course(
            lambda x: potential(p, x),
            p.x0,
            p.v0,
            mass=mass,
            towards=1 if end > p.x0 else -1,
            marks=[*ways, end],
        )
        last = course.time(end)
        states = [course.at(t) if t < last * MP.mpf("0.999") else (None, None) for t in times]
        return Truth({"q/x": [x for x, _ in states], "v/x": [v for _, v in states]}, ends=last)

    return reference


def stop(d: Draw, reference: Callable[[Numbers, Sequence[Number]], Truth]) -> float:
    """A time beyond the end."""
    from types import SimpleNamespace

    p = SimpleNamespace(**{name: MP.mpf(value) for name, value in d.numbers.items()})
    end = reference(p, [MP.mpf(0)]).ends
    return float(end * MP.mpf(d.source.uniform(1.2, 2)))


def towards(d: Draw) -> None:
    """To the left, from the right of 0."""
    d.uniform("x0", 0.5, 1.5)
    d.uniform("v0", -1.5, -0.1)


def attracted(d: Draw, text: str, potential: Callable[[Numbers, Number], Number]) -> Case:
    """Falls into a pole at b + c x = 0."""
    b, c = d.uniform("b", 1, 3), d.uniform("c", 0.5, 2)
    towards(d)
    reference = ends(potential, lambda p: -p.b / p.c)
    return line(d, reference, stop(d, reference), h=True, potential=[text.replace("U", f"({b} + {c}*x)")])


def logarithm(d: Draw) -> Case:
    """U = s log(b + c x)."""
    s = d.log("s", 0.05, 2)
    return attracted(d, f"{s}*log(U)", lambda p, x: p.s * MP.log(p.b + p.c * x))


def negative_power(d: Draw) -> Case:
    """U = -s/(b + c x)^n, with a strength down to 1e-6."""
    s, n = d.log("s", 1e-6, 1), d.choice("1", "2", "0.5", "3", "1.5")
    text = f"-{s}/U" if n == "1" else d.choice(f"-{s}/U**{n}", f"-{s}*U**(-{n})")
    return attracted(d, text, lambda p, x: -p.s / (p.b + p.c * x) ** MP.mpf(n))


def fractional_power(d: Draw) -> Case:
    """U = s (b + c x)^n: the force has no value beyond."""
    s, n = d.uniform("s", 0.2, 2), d.choice("1.5", "2.5", "0.5", "0.75", "1.2", "3.5")
    text = d.choice(f"{s}*U**{n}", f"{s}*sqrt(U)" if n == "0.5" else f"{s}*U**{n}")
    return attracted(d, text, lambda p, x: p.s * (p.b + p.c * x) ** MP.mpf(n))


def arcsine(d: Draw) -> Case:
    """A force with asin(x/b) or acos(x/b), where x leaves the domain."""
    s, b = d.uniform("s", -0.5, -0.05), d.uniform("b", 1.6, 3)
    d.uniform("x0", -0.5, 0.5)
    d.uniform("v0", 0.5, 2)
    form = d.choice("force", "potential", "arccosine")

    def potential(p: Numbers, x: Number) -> Number:
        u = x / p.b
        if form == "force":  # the integral of asin(u) is u asin(u) + sqrt(1 - u^2)
            return p.s * p.b * (u * MP.asin(u) + MP.sqrt(abs(1 - u**2)))
        return (
            p.s
            * (MP.asin(u) if form == "potential" else MP.pi / 2 - MP.asin(u))
            * (1 if form == "potential" else -1)
        )

    reference = ends(potential, lambda p: p.b)
    given: dict[str, Any] = {
        "force": {"forces": [f"-{s}*asin(x/{b})"]},
        "potential": {"potential": [f"{s}*asin(x/{b})"]},
        "arccosine": {"potential": [f"-{s}*acos(x/{b})"]},
    }[form]
    return line(d, reference, stop(d, reference), h=True, **given)


def tangent(d: Draw) -> Case:
    """U = -s tan(x)^2 or s log(cos(x)): falls into the pole at pi/2."""
    s = d.uniform("s", 0.1, 1)
    d.uniform("x0", -0.3, 0.5)
    d.uniform("v0", 1.5, 3)
    form = d.choice("tan", "log", "cos")
    text = {"tan": f"-{s}*tan(x)**2", "log": f"{s}*log(cos(x))", "cos": f"-{s}/cos(x)"}[form]

    def potential(p: Numbers, x: Number) -> Number:
        return {
            "tan": lambda: -p.s * MP.tan(x) ** 2, "log": lambda: p.s * MP.log(abs(MP.cos(x))),
            "cos": lambda: -p.s / MP.cos(x),
        }[form]()  # fmt: skip

    reference = ends(potential, lambda p: MP.pi / 2)
    return line(d, reference, stop(d, reference), h=True, potential=[text])


def blow_up(d: Draw) -> Case:
    """x'' = s x^n: infinite at a finite time."""
    n = d.choice(2, 3, 5)
    s = d.uniform("s", 0.5, 3)
    d.uniform("x0", 0.5, 1.5)
    d.uniform("v0", 0.2, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def potential(x: Number) -> Number:
            return -p.s * x ** (n + 1) / (n + 1)

        course = Course(potential, p.x0, p.v0)  # without end
        # x = 1/u^2: dt = 2 du/(u^3 v), finite at u = 0 for n = 2 and regular for the others
        last = MP.quad(
            lambda u: 2 / (u**3 * course.speed(1 / u**2)) if u else 0,
            [0, 1 / (2 * MP.sqrt(p.x0)), 1 / MP.sqrt(p.x0)],
        )
        states = [course.at(t) if t < last * MP.mpf("0.95") else (None, None) for t in times]
        return Truth({"q/x": [x for x, _ in states], "v/x": [v for _, v in states]}, ends=last)

    return line(d, reference, stop(d, reference), h=True, **d.choice(
        {"potential": [f"-{s}*x**{n + 1}/{n + 1}"]}, {"forces": [f"{s}*x**{n}"]}
    ))  # fmt: skip


def end_of_time(d: Draw) -> Case:
    """A force that has no value from a time on."""
    s, T = d.uniform("s", -1, 1), d.uniform("T", 1, 4)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -1, 1)
    form = d.choice("root", "inverse", "log", "power", "asin")
    text = {
        "root": f"sqrt({T} - t)",
        "inverse": f"1/({T} - t)",
        "log": f"log({T} - t)",
        "power": f"({T} - t)**(-0.5)",
        "asin": f"asin(t/{T})",
    }[form]

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        first: dict[str, Callable[[Number], Number]] = {  # the integral of the force in u = T - t, and again
            "root": lambda u: -(u ** MP.mpf(1.5)) / MP.mpf(1.5), "inverse": lambda u: -MP.log(u),
            "log": lambda u: -(u * MP.log(u) - u), "power": lambda u: -2 * MP.sqrt(u),
            "asin": lambda u: (p.T - u) * MP.asin((p.T - u) / p.T) + MP.sqrt(p.T**2 - (p.T - u) ** 2),
        }  # fmt: skip
        second: dict[str, Callable[[Number], Number]] = {
            "root": lambda u: u ** MP.mpf(2.5) / MP.mpf(3.75), "inverse": lambda u: u * MP.log(u) - u,
            "log": lambda u: u**2 / 2 * MP.log(u) - 3 * u**2 / 4, "power": lambda u: 4 * u ** MP.mpf(1.5) / 3,
            "asin": lambda u: -MP.quad(first["asin"], [u, p.T]) * -1,
        }  # fmt: skip
        one, two = first[form], second[form]
        x: list[Number | None] = []
        v: list[Number | None] = []
        for t in times:
            if t >= p.T:
                x.append(None)
                v.append(None)
                continue
            u = p.T - t
            v.append(p.v0 + p.s * (one(u) - one(p.T)))
            x.append(p.x0 + (p.v0 - p.s * one(p.T)) * t + p.s * (two(u) - two(p.T)))
        return Truth({"q/x": x, "v/x": v}, ends=p.T)

    return line(d, reference, d.value("T") * d.source.uniform(1.2, 2), **d.choice(
        {"forces": [f"{s}*{text}"]}, {"potential": [f"-x*{s}*{text}"]}
    ))  # fmt: skip


def vanishing_mass(d: Draw) -> Case:
    """L = (b - x)^n v^2/2: the mass matrix is singular at x = b."""
    b, n = d.uniform("b", 1, 2), d.choice(1, 2, 3)
    d.uniform("x0", -0.5, 0.5)
    d.uniform("v0", 0.3, 1.5)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        # (b - x)^(n/2) v is constant
        m = MP.mpf(n) / 2
        rate = (m + 1) * p.v0 / (p.b - p.x0)
        x: list[Number | None] = []
        v: list[Number | None] = []
        for t in times:
            left = 1 - rate * t
            x.append(p.b - (p.b - p.x0) * left ** (1 / (m + 1)) if left > 0 else None)
            v.append(p.v0 * left ** (1 / (m + 1) - 1) if left > 0 else None)
        return Truth({"q/x": x, "v/x": v}, ends=1 / rate)

    power = "" if n == 1 else f"**{n}"
    return line(
        d, reference, stop(d, reference), h=True, mass="", lagrangian=[f"({b} - x){power}*x_dot**2/2"]
    )


def repelled(d: Draw) -> Case:
    """Turns before a pole: there is no end."""
    s, b, c = d.log("s", 1e-4, 1), d.uniform("b", 1, 3), d.uniform("c", 0.5, 2)
    form = d.choice("inverse", "log", "square", "root")
    d.uniform("x0", -1.5, -0.5)
    d.uniform("v0", 0.5, 1.5)
    u = f"({b} - {c}*x)"
    text = {
        "inverse": f"{s}/{u}",
        "log": f"-{s}*log({u})",
        "square": f"{s}*{u}**(-2)",
        "root": f"{s}/sqrt({u})",
    }[form]

    def potential(p: Numbers, x: Number) -> Number:
        left = abs(p.b - p.c * x)
        return {
            "inverse": lambda: p.s / left,
            "log": lambda: -p.s * MP.log(left),
            "square": lambda: p.s / left**2,
            "root": lambda: p.s / MP.sqrt(left),
        }[form]()

    def between(p: Numbers) -> tuple[Number, Number]:
        low = high = p.b / p.c
        energy = p.v0**2 / 2 + potential(p, p.x0)
        apart = (p.b / p.c - p.x0) / 2
        while potential(p, low - apart) > energy:
            apart *= 2
        while potential(p, high - apart) < energy:
            apart /= 2
        return high - 2 * apart, high - apart

    def beside(p: Numbers) -> list[Number]:
        """A place just before the turn, where the force is largest: x is known there to a rounding."""
        energy = p.v0**2 / 2 + potential(p, p.x0)
        turn = root_of(lambda x: potential(p, x) - energy, *between(p))
        return [turn - (p.b / p.c - turn) / 1000]

    if form == "log":  # turns in reach only where the pole is not too weak
        d.log("s", 0.1, 1)
    return line(d, across(potential, beside, between), 6, h=True, potential=[text])


KINDS = (
    logarithm,
    negative_power,
    fractional_power,
    arcsine,
    tangent,
    blow_up,
    end_of_time,
    vanishing_mass,
    repelled,
)
