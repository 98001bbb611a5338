"""Motions in smooth potentials whose time is an integral: periods, turns, escapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.course import Course
from benchmarks.truth.families.barriers import across
from benchmarks.truth.families.line import line
from benchmarks.truth.roots import root_of

Potential = Callable[[Numbers, Number], Number]


def oscillation(
    potential: Potential, bounds: tuple[float, float]
) -> Callable[[Numbers, Sequence[Number]], Truth]:
    """The motion between two turning points, the first from 0 to one bound, the other from the other to 0."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        energy = p.v0**2 / 2 + potential(p, p.x0)
        high = root_of(lambda x: potential(p, x) - energy, MP.mpf(0), MP.mpf(bounds[1]))
        low = root_of(lambda x: potential(p, x) - energy, MP.mpf(bounds[0]), MP.mpf(0))
        top = MP.sqrt(2 * (energy - potential(p, MP.mpf(0))))
        right = Course(lambda x: potential(p, x), MP.mpf(0), top, turn=high)
        left = Course(lambda x: potential(p, x), MP.mpf(0), -top, turn=low)
        one, other = 2 * right.time_to_turn(), 2 * left.time_to_turn()
        begin = right.time(p.x0) if p.x0 > 0 else -left.time(p.x0)  # with v0 > 0
        x, v = [], []
        for t in times:
            s = t + begin
            s -= (one + other) * MP.floor(s / (one + other))
            at, speed = right.at(s) if s < one else left.at(s - one)
            x.append(at)
            v.append(speed)
        return Truth({"q/x": x, "v/x": v})

    return reference


def swinging(d: Draw, text: str, potential: Potential, bounds: tuple[float, float], stop: float = 10) -> Case:
    """To and fro, from near the middle."""
    d.uniform("x0", -0.2, 0.2)
    d.uniform("v0", 0.5, 1.3)
    return line(d, oscillation(potential, bounds), stop, h=True, potential=[text])


def pendulum(d: Draw) -> Case:
    """Swings."""
    k = d.uniform("k", 0.8, 5)
    return swinging(d, f"-{k}*cos(x)", lambda p, x: -p.k * MP.cos(x), (-3.1, 3.1), 20)


def even_power(d: Draw) -> Case:
    """U = s x^n, up to steep walls."""
    n, s = 2 * d.source.randint(2, 25), d.uniform("s", 0.5, 5)
    return swinging(d, f"{s}*x**{n}", lambda p, x: p.s * x**n, (-4, 4))


def morse(d: Draw) -> Case:
    """Morse's bond."""
    D, a = d.uniform("D", 1, 4), d.uniform("a", 0.5, 2)
    return swinging(d, f"{D}*(1 - exp(-{a}*x))**2", lambda p, x: p.D * (1 - MP.exp(-p.a * x)) ** 2, (-2, 10))


def exponential_walls(d: Draw) -> Case:
    """Between walls exp(+-s x)."""
    s = d.log("s", 3, 100)
    text = d.choice(f"exp({s}*(x - 1)) + exp(-{s}*(x + 1))", f"2*exp(-{s})*cosh({s}*x)")
    return swinging(
        d, text, lambda p, x: MP.exp(p.s * (x - 1)) + MP.exp(-p.s * (x + 1)), (-3, 3)
    )  # fmt: skip


def hole(d: Draw) -> Case:
    """In a hole -s/cosh(x/w)^2."""
    s, w = d.uniform("s", 1.2, 3), d.uniform("w", 0.7, 2)
    text = d.choice(f"-{s}/cosh(x/{w})**2", f"{s}*tanh(x/{w})**2")
    return swinging(d, text, lambda p, x: p.s * MP.tanh(x / p.w) ** 2, (-15, 15))


def logarithm_of_cosh(d: Draw) -> Case:
    """A wedge with a rounded corner."""
    s, w = d.uniform("s", 0.5, 2), d.log("w", 1e-4, 0.3)
    form = d.choice("log", "root")
    text = {"log": f"{s}*{w}*log(cosh(x/{w}))", "root": f"{s}*sqrt(x**2 + {w}**2)"}[form]

    def potential(p: Numbers, x: Number) -> Number:
        return p.s * (p.w * MP.log(MP.cosh(x / p.w)) if form == "log" else MP.sqrt(x**2 + p.w**2))

    if form == "log":  # cosh overflows where x/w > 700
        d.log("w", 5e-3, 0.3)
        text = text.replace("w", "w")
    d.uniform("x0", 0.4, 0.8)
    d.uniform("v0", 0.5, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def halved(course_potential: Potential) -> Truth:
            energy = p.v0**2 / 2 + course_potential(p, p.x0)
            turn = root_of(lambda x: course_potential(p, x) - energy, p.x0, p.x0 + 2 + energy / p.s)
            top = MP.sqrt(2 * (energy - course_potential(p, MP.mpf(0))))
            near = [k * p.w for k in (MP.mpf(1) / 2, 1, 2, 4, 8, 16, 50, 200, 1000)]
            course = Course(lambda x: course_potential(p, x), MP.mpf(0), top, turn=turn, marks=near)
            half = 2 * course.time_to_turn()
            begin = course.time(p.x0)
            x, v = [], []
            for t in times:
                number = int(MP.floor((t + begin) / half))
                at, speed = course.at(t + begin - number * half)
                x.append(-at if number % 2 else at)
                v.append(-speed if number % 2 else speed)
            return Truth({"q/x": x, "v/x": v})

        return halved(potential)

    return line(d, reference, 10, h=True, potential=[text])


def escaping(d: Draw) -> Case:
    """Away from a centre, faster than needed."""
    s, b = d.uniform("s", 0.5, 2), d.uniform("b", 0.05, 0.5)
    d.uniform("x0", 0.3, 1)
    d.uniform("v0", 3, 5)
    return line(
        d,
        across(lambda p, x: -p.s / MP.sqrt(x**2 + p.b**2), lambda p: [MP.mpf(2) ** k for k in range(8)]),
        10,
        h=True,
        potential=[f"-{s}/sqrt(x**2 + {b}**2)"],
    )


def relativistic(d: Draw) -> Case:
    """L = -sqrt(1 - v^2) + f x: the velocity comes close to 1, but never there."""
    f = d.uniform("f", 0.3, 3)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -0.9, 0.9)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        first = p.v0 / MP.sqrt(1 - p.v0**2)
        momenta = [first + p.f * t for t in times]
        return Truth({
            "q/x": [p.x0 + (MP.sqrt(1 + u**2) - MP.sqrt(1 + first**2)) / p.f for u in momenta],
            "v/x": [u / MP.sqrt(1 + u**2) for u in momenta],
        })  # fmt: skip

    return line(d, reference, 10, h=True, mass="", lagrangian=[f"-sqrt(1 - x_dot**2) + {f}*x"])


def curved_line(d: Draw) -> Case:
    """A bead on the line y = s(x) in no field: the arc grows uniformly."""
    s = d.uniform("s", 0.3, 2)
    d.uniform("x0", -1, 0.5)
    d.uniform("v0", 0.5, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        # y = s x^2/2, the arc is (u sqrt(1 + u^2) + asinh u)/(2 s) with u = s x
        def arc(u: Number) -> Number:
            return (u * MP.sqrt(1 + u**2) + MP.asinh(u)) / (2 * p.s)

        u0 = p.s * p.x0
        rate = p.v0 * MP.sqrt(1 + u0**2)
        x, v = [], []
        for t in times:
            u = MP.findroot(
                lambda u, t=t: arc(u) - arc(u0) - rate * t, (u0, u0 + p.s * p.v0 * t + 1), verify=False
            )
            x.append(u / p.s)
            v.append(rate / MP.sqrt(1 + u**2))
        return Truth({"q/x": x, "v/x": v})

    return line(d, reference, 6, h=True, mass="", lagrangian=[f"(1 + ({s}*x)**2)*x_dot**2/2"])


KINDS = (
    pendulum,
    even_power,
    morse,
    exponential_walls,
    hole,
    logarithm_of_cosh,
    escaping,
    relativistic,
    curved_line,
)
