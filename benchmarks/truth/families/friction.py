"""Friction: forces that depend on the sense of the velocity, and may hold a body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, System, Truth
from benchmarks.truth.families.line import in_pieces, line, sixteenths
from benchmarks.truth.pieces import Exit, Linear, pieces, to

REST = "at rest"


def dry(d: Draw, mu: str, v: str = "x_dot") -> dict[str, Any]:
    """Coulomb's law, as a force or by a dissipation function."""
    if v == "x_dot" and d.choice(True, False):
        return {"dissipation": [f"{mu}*({d.absolute(v)})"]}
    return {"forces": [f"-{mu}*({d.sign(v)})"]}


def stops(mode: Any = REST) -> Exit:
    """A positive velocity comes to 0."""
    return Exit(lambda q, v, t: v[0], halted(mode))


def halted(mode: Any) -> Any:
    """Goes on with velocity 0, exactly."""
    return lambda _, q, v, t: (mode, q, [MP.mpf(0)] * len(v))


def sliding_to_rest(d: Draw) -> Case:
    """Slides until it rests, for ever; with and without resistance that grows with the velocity."""
    mu = d.uniform("mu", 0.2, 2)
    c = d.uniform("c", 0.1, 1) if d.choice(True, False) else None
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 3)
    reference = in_pieces(
        lambda p, mode: Linear() if mode == REST else Linear(f=-p.mu, c=getattr(p, "c", 0)),
        lambda p, mode: [] if mode == REST else [stops()],
        lambda p: "sliding",
    )
    given = dry(d, mu)
    if c:
        given = {**given, "dissipation": [*given.get("dissipation", ()), f"{c}*x_dot**2/2"]}
    return line(d, reference, 1.5 * d.value("v0") / d.value("mu") + 1, **given)


def sticks(p: Numbers, force: Number) -> Any:
    """The mode that follows when the velocity is 0 and this other force acts."""
    if abs(force) <= p.mu:
        return REST
    return 1 if force > 0 else -1


def on_a_spring(d: Draw) -> Case:
    """A block on a spring with dry friction: half oscillations, until it sticks."""
    k, mu = d.uniform("k", 1, 5), d.uniform("mu", 0.1, 0.6)
    d.uniform("x0", 1, 3)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def turned(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            return sticks(p, -p.k * q[0]), q, [MP.mpf(0)]

        return pieces(
            sticks(p, -p.k * p.x0), [p.x0], [MP.mpf(0)],
            lambda mode, q, v, t: [Linear() if mode == REST else Linear(f=-mode * p.mu, k=p.k)],
            lambda mode: [] if mode == REST else [Exit(lambda q, v, t: mode * v[0], turned)],
            times[-1],
        ).truth(times)  # fmt: skip

    return line(d, reference, 14, potential=[f"{k}*x**2/2"], v="0", **dry(d, mu))


def rough_patch(d: Draw) -> Case:
    """Friction begins at a place, and ends at another that may be reached."""
    mu, a, b = d.uniform("mu", 0.3, 1.5), d.uniform("a", 0.5, 1.5), d.uniform("b", 2, 3)
    d.uniform("x0", -1, 0.3)
    d.uniform("v0", 0.8, 2.5)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.mu) if mode == "rough" else Linear(),
        lambda p, mode: {
            "before": [Exit(lambda q, v, t: p.a - q[0], to("rough"))],
            "rough": [stops(), Exit(lambda q, v, t: p.b - q[0], to("beyond"))],
        }.get(str(mode), []),
        lambda p: "before",
    )  # fmt: skip
    where = d.choice(
        f"where(x > {a} and x < {b}, 1, 0)",
        f"where(x < {a} or x > {b}, 0, 1)",
        f"({d.step(f'x - {a}')})*({d.step(f'{b} - x')})",
        f"where(abs(x - ({a} + {b})/2) < ({b} - {a})/2, 1, 0)",
    )
    return line(d, reference, 9, forces=[f"-{mu}*{where}*({d.sign('x_dot')})"])


def from_a_time_on(d: Draw) -> Case:
    """Friction begins at a time."""
    mu, T = d.uniform("mu", 0.3, 1.5), d.uniform("T", 0.5, 3)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 2.5)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.mu) if mode == "braking" else Linear(),
        lambda p, mode: {
            "before": [Exit(lambda q, v, t: p.T - t, to("braking"))], "braking": [stops()],
        }.get(str(mode), []),
        lambda p: "before",
    )  # fmt: skip
    return line(d, reference, 10, forces=[f"-{mu}*({d.step(f't - {T}')})*({d.sign('x_dot')})"])


def on_a_belt(d: Draw) -> Case:
    """A block on a spring, on a belt that moves: it is carried, slips, and is carried again."""
    k, mu, b = d.uniform("k", 1, 4), d.uniform("mu", 0.3, 1), d.uniform("b", 0.2, 1)
    c = d.uniform("c", 0.02, 0.2)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -1, 0.1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def caught(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            force = -p.k * q[0] - p.c * p.b
            return sticks(p, force), q, [p.b]

        def ways(mode: Any) -> list[Exit]:
            if mode == REST:
                return [
                    Exit(lambda q, v, t: p.mu - (p.k * q[0] + p.c * p.b), to(-1)),
                    Exit(lambda q, v, t: p.mu + (p.k * q[0] + p.c * p.b), to(1)),
                ]
            return [Exit(lambda q, v, t: mode * (v[0] - p.b), caught)]

        return pieces(
            1 if p.v0 > p.b else -1, [p.x0], [p.v0],
            lambda mode, q, v, t: [Linear() if mode == REST else Linear(f=-mode * p.mu, k=p.k, c=p.c)],
            ways, times[-1],
        ).truth(times)  # fmt: skip

    return line(
        d, reference, 20, potential=[f"{k}*x**2/2"], dissipation=[f"{c}*x_dot**2/2"],
        forces=[f"-{mu}*({d.sign(f'x_dot - {b}')})"],
    )  # fmt: skip


def pulled_by_a_spring(d: Draw) -> Case:
    """A block at rest, pulled by a spring whose end moves: it sticks, then slips."""
    k, mu, V, c = (
        d.uniform("k", 1, 4),
        d.uniform("mu", 0.3, 2),
        d.uniform("V", 0.2, 1),
        d.uniform("c", 0.1, 0.6),
    )
    d.uniform("x0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def ways(mode: Any) -> list[Exit]:
            if mode == REST:
                return [Exit(lambda q, v, t: p.mu - p.k * (p.x0 + p.V * t - q[0]), to("slips"))]
            return [stops()]

        return pieces(
            REST, [p.x0], [MP.mpf(0)],
            lambda mode, q, v, t: [
                Linear() if mode == REST else Linear(f=p.k * p.x0 - p.mu, g=p.k * p.V, k=p.k, c=p.c)
            ],
            ways, times[-1],
        ).truth(times)  # fmt: skip

    return line(
        d, reference, 12, potential=[f"{k}*(x - x0 - {V}*t)**2/2"], v="0",
        dissipation=[f"{c}*x_dot**2/2", f"{mu}*({d.absolute('x_dot')})"],
    )  # fmt: skip


def inclined_plane(d: Draw) -> Case:
    """Thrown up a slope: it stops, and stays or slides back."""
    s, mu = d.uniform("s", 0.5, 3), d.uniform("mu", 0.3, 3.5)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 3)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def turned(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            return sticks(p, -p.s), q, [MP.mpf(0)]

        return pieces(
            1,
            [p.x0],
            [p.v0],
            lambda mode, q, v, t: [Linear() if mode == REST else Linear(f=-p.s - mode * p.mu)],
            lambda mode: [] if mode == REST else [Exit(lambda q, v, t: mode * v[0], turned)],
            times[-1],
        ).truth(times)

    return line(d, reference, 6, potential=[f"{s}*x"], **dry(d, mu))


def shaken(d: Draw) -> Case:
    """A block shaken by a periodic force: it slips and sticks, twice a period."""
    a, w, mu = d.uniform("a", 1, 3), d.uniform("w", 0.7, 2), d.uniform("mu", 0.2, 0.9)
    d.uniform("x0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def force(t: Any, m: Any = MP) -> Any:
            return p.a * MP.cos(p.w * t)

        def turned(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            return sticks(p, force(t)), q, [MP.mpf(0)]

        def ways(mode: Any) -> list[Exit]:
            if mode != REST:
                return [Exit(lambda q, v, t: mode * v[0], turned)]
            return [
                Exit(lambda q, v, t: p.mu - p.a * cosine(p.w, t), to(1)),
                Exit(lambda q, v, t: p.mu + p.a * cosine(p.w, t), to(-1)),
            ]

        return pieces(
            1, [p.x0], [MP.mpf(0)],
            lambda mode, q, v, t: [Linear() if mode == REST else Linear(f=-mode * p.mu, a=p.a, w=p.w)],
            ways, times[-1],
        ).truth(times)  # fmt: skip

    driving = f"{a}*cos({w}*t)"
    given = dry(d, mu)
    if d.choice(True, False):
        given = {**given, "potential": [f"-x*{driving}"]}
    else:
        given = {**given, "forces": [*given.get("forces", ()), driving]}
    return line(d, reference, 16, v="0", **given)


def cosine(w: Number, t: Any) -> Any:
    """cos(w t), of doubles, too."""
    import numpy as np

    return MP.cos(w * t) if isinstance(t, MP.mpf) else np.cos(float(w) * np.asarray(t))


def two_blocks(d: Draw) -> Case:
    """One block on another that is pulled: they slide on one another until they move together."""
    m, M, mu = d.uniform("m", 0.5, 2), d.uniform("M", 0.5, 2), d.uniform("mu", 0.4, 1.5)
    F = d.uniform("F", 0.05, 0.5)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 2)
    d.uniform("y0", -1, 1)
    d.uniform("w0", -1, 0.4)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def laws(mode: Any, q: Any, v: Any, t: Any) -> list[Linear]:
            if mode == REST:
                return [Linear(f=p.F / (p.m + p.M))] * 2
            return [Linear(f=-mode * p.mu / p.m), Linear(f=(p.F + mode * p.mu) / p.M)]

        def met(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            both = (p.m * v[0] + p.M * v[1]) / (p.m + p.M)
            held = p.m * p.F / (p.m + p.M) <= p.mu
            return REST if held else -mode, q, [both, both]

        return pieces(
            1, [p.x0, p.y0], [p.v0, p.w0], laws,
            lambda mode: [] if mode == REST else [Exit(lambda q, v, t: mode * (v[0] - v[1]), met)], times[-1],
        ).truth(times, ("x", "y"))  # fmt: skip

    forces = {"x": [f"-{mu}*({d.sign('x_dot - y_dot')})"], "y": [f"{mu}*({d.sign('x_dot - y_dot')})", F]}
    rest: list[str] = []
    if d.choice(True, False):
        forces, rest = {"y": [F]}, [f"{mu}*({d.absolute('x_dot - y_dot')})"]
    system = System({"x": ("x0", "v0"), "y": ("y0", "w0")}, {"x": m, "y": M}, forces=forces, dissipation=rest)
    return Case("", "", system, d.numbers, reference, sixteenths(8), "x0")


def quadratic_drag(d: Draw) -> Case:
    """Thrown upwards in air: x'' = -g - c v |v|; closed forms with tan and tanh."""
    g, c = d.uniform("g", 1, 10), d.uniform("c", 0.2, 1.5)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 4)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        rate, terminal = MP.sqrt(p.g * p.c), MP.sqrt(p.g / p.c)
        angle = MP.atan(p.v0 / terminal)
        top, height = angle / rate, p.x0 - MP.log(MP.cos(angle)) / p.c
        x, v = [], []
        for t in times:
            s = t - top
            if s < 0:
                x.append(height + MP.log(MP.cos(rate * s)) / p.c)
                v.append(-terminal * MP.tan(rate * s))
            else:
                x.append(height - MP.log(MP.cosh(rate * s)) / p.c)
                v.append(-terminal * MP.tanh(rate * s))
        return Truth({"q/x": x, "v/x": v})

    drag = d.choice(
        {"forces": [f"-{c}*x_dot*({d.absolute('x_dot')})"]},
        {"forces": [f"-{c}*x_dot**2*({d.sign('x_dot')})"]},
        {"dissipation": [f"{c}*({d.absolute('x_dot')})**3/3"]},
    )
    return line(d, reference, 4, potential=[f"{g}*x"], **drag)


def root_of_the_velocity(d: Draw) -> Case:
    """A resistance c sqrt|v|, which brings to rest in a finite time."""
    c = d.uniform("c", 0.5, 2)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 3)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        root = MP.sqrt(p.v0)
        end = 2 * root / p.c
        left = [max(root - p.c * t / 2, MP.mpf(0)) for t in times]
        del end
        return Truth({
            "q/x": [p.x0 + 2 * (root**3 - s**3) / (3 * p.c) for s in left], "v/x": [s**2 for s in left],
        })  # fmt: skip

    given = d.choice(
        {"dissipation": [f"{c}*({d.absolute('x_dot')})**1.5/1.5"]},
        {"forces": [f"-{c}*sqrt({d.absolute('x_dot')})*({d.sign('x_dot')})"]},
    )
    return line(d, reference, 5, **given)


KINDS = (
    sliding_to_rest,
    on_a_spring,
    rough_patch,
    from_a_time_on,
    on_a_belt,
    pulled_by_a_spring,
    inclined_plane,
    shaken,
    two_blocks,
    quadratic_drag,
    root_of_the_velocity,
)
