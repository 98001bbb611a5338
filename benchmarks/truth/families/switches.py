"""Switches: forces that begin and end at places, times and velocities; piecewise potentials; relays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.families.friction import cosine
from benchmarks.truth.families.line import force_or_potential, in_pieces, line
from benchmarks.truth.families.pulses import push, pushed
from benchmarks.truth.families.walls import above, below
from benchmarks.truth.pieces import Exit, Linear, pieces, to


def start(d: Draw, v: tuple[float, float] = (0.5, 2.5)) -> None:
    """x0 left of the origin, and a velocity."""
    d.uniform("x0", -1, 0.3)
    d.uniform("v0", *v)


def on_from_a_place(d: Draw) -> Case:
    """A constant force beyond x = a."""
    a, f = d.uniform("a", 0.5, 1.5), d.uniform("f", -2, 2)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.f) if mode else Linear(),
        lambda p, mode: [above(p.a, 0) if mode else below(p.a, 1)],
        lambda p: 0,
    )
    given = force_or_potential(d, f"-{f}*({d.positive(f'x - {a}')})", f"{f}*({d.step(f'x - {a}')})")
    return line(d, reference, 8, h=True, **given)


def window_in_space(d: Draw) -> Case:
    """A constant force between two places."""
    a, b, f = d.uniform("a", 0.5, 1), d.uniform("b", 1.2, 3), d.uniform("f", -1.5, 2)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.f) if mode == 1 else Linear(),
        lambda p, mode: {0: [below(p.a, 1)], 1: [above(p.a, 0), below(p.b, 2)], 2: [above(p.b, 1)]}[mode],
        lambda p: 0,
    )
    force = d.choice(
        f"where(x > {a} and x < {b}, {f}, 0)", f"where(x > {a}, where(x < {b}, {f}, 0), 0)",
        f"where(not (x < {a} or x > {b}), {f}, 0)", f"{f}*({d.step(f'x - {a}')} - ({d.step(f'x - {b}')}))",
        f"where(abs(x - ({a} + {b})/2) < ({b} - {a})/2, {f}, 0)", f"{f}*({d.step(f'(x - {a})*({b} - x)')})",
        f"{f}*({d.step(f'min(x - {a}, {b} - x)')})",
    )  # fmt: skip
    return line(d, reference, 8, h=True, **force_or_potential(d, f"-{f}*min(max(x, {a}), {b})", force))


def window_in_time(d: Draw) -> Case:
    """A force between two times, perhaps a narrow window."""
    T, w, f = d.uniform("T", 0.5, 5), d.log("w", 1e-4, 2), d.uniform("f", -3, 3)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.f) if mode == 1 else Linear(),
        lambda p, mode: {
            0: [Exit(lambda q, v, t: p.T - t, to(1))], 1: [Exit(lambda q, v, t: p.T + p.w - t, to(2))], 2: [],
        }[mode],
        lambda p: 0,
    )  # fmt: skip
    force = d.choice(
        f"where(t > {T} and t < {T} + {w}, {f}, 0)",
        f"where(t < {T} or t > {T} + {w}, 0, {f})",
        f"{f}*({d.step(f't - {T}')} - ({d.step(f't - {T} - {w}')}))",
        f"where(not (t < {T}), where(t <= {T} + {w}, {f}, 0), 0)",
        f"{f}*({d.step(f'(t - {T})*({T} + {w} - t)')})",
    )
    return line(d, reference, 8, **d.choice({"forces": [force]}, {"potential": [f"-x*{force}"]}))


def gears(d: Draw) -> Case:
    """The acceleration changes at a velocity."""
    f, g, s = d.uniform("f", 1, 2), d.uniform("g", 0.2, 0.8), d.uniform("s", 2.6, 4)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.g if mode else p.f),
        lambda p, mode: [] if mode else [Exit(lambda q, v, t: p.s - v[0], to(1))],
        lambda p: 0,
    )
    force = d.choice(f"where(x_dot < {s}, {f}, {g})", f"{g} + ({f} - {g})*({d.step(f'{s} - x_dot')})")
    return line(d, reference, 6, forces=[force])


def governor(d: Draw) -> Case:
    """Driven below a velocity and braked above: it stays at that velocity."""
    f, g, s = d.uniform("f", 0.5, 2), d.uniform("g", 0.2, 2), d.uniform("s", 2.6, 4)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear() if mode else Linear(f=p.f),
        lambda p, mode: [] if mode else [Exit(lambda q, v, t: p.s - v[0], lambda _, q, v, t: (1, q, [p.s]))],
        lambda p: 0,
    )
    force = d.choice(f"where(x_dot < {s}, {f}, -{g})", f"{f} - ({f} + {g})*({d.step(f'x_dot - {s}')})")
    return line(d, reference, 8, forces=[force])


def thrust_until(d: Draw) -> Case:
    """Driven until a velocity is reached; there is no force above."""
    f, s = d.uniform("f", 0.5, 2), d.uniform("s", 2.6, 4)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear() if mode else Linear(f=p.f),
        lambda p, mode: [] if mode else [Exit(lambda q, v, t: p.s - v[0], lambda _, q, v, t: (1, q, [p.s]))],
        lambda p: 0,
    )
    return line(d, reference, 8, forces=[f"{f}*({d.step(f'{s} - x_dot')})"])


def relay(d: Draw) -> Case:
    """A relay with a switching line x + c v = 0: the motion slides along it into the origin."""
    u, c = d.uniform("u", 1, 3), d.uniform("c", 0.3, 1.5)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -0.5, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def met(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            # on the line ds/dt = v + c x'' and x'' = -u or +u: it holds where |v| < c u
            return ("slides" if abs(v[0]) < p.c * p.u else -mode), q, v

        def laws(mode: Any, q: Any, v: Any, t: Any) -> list[Linear]:
            return [Linear(c=1 / p.c) if mode == "slides" else Linear(f=-mode * p.u)]

        return pieces(
            1, [p.x0], [p.v0], laws,
            lambda mode: [] if mode == "slides" else [Exit(lambda q, v, t: mode * (q[0] + p.c * v[0]), met)],
            times[-1],
        ).truth(times)  # fmt: skip

    return line(d, reference, 8, forces=[f"-{u}*({d.sign(f'x + {c}*x_dot')})"])


def two_wells(d: Draw) -> Case:
    """U is the lesser of two parabolas: a cusp between two wells."""
    a, k = d.uniform("a", 0.5, 1.2), d.uniform("k", 1, 3)
    d.uniform("x0", 1.5, 2)
    d.uniform("v0", 1.5, 3)
    reference = in_pieces(
        lambda p, mode: Linear(f=mode * p.k * p.a, k=p.k),
        lambda p, mode: [above(0, -1) if mode > 0 else below(0, 1)],
        lambda p: 1,
    )
    u = d.choice(
        f"{k}/2*min((x - {a})**2, (x + {a})**2)", f"{k}/2*(abs(x) - {a})**2",
        f"-{k}/2*max(-(x - {a})**2, -(x + {a})**2)", f"where(x > 0, {k}/2*(x - {a})**2, {k}/2*(x + {a})**2)",
        f"{k}/2*(sqrt(x**2) - {a})**2",
    )  # fmt: skip
    return line(d, reference, 10, h=True, potential=[u])


def greater_of_two(d: Draw) -> Case:
    """U is the greater of two slopes."""
    f, g = d.uniform("f", 0.5, 2), d.uniform("g", 0.5, 2)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.f if mode > 0 else p.g),
        lambda p, mode: [above(0, -1) if mode > 0 else below(0, 1)],
        lambda p: 1,
    )
    u = d.choice(f"max({f}*x, -{g}*x)", f"-min(-{f}*x, {g}*x)", f"where(x > 0, {f}*x, -{g}*x)",
                 f"({f} - {g})/2*x + ({f} + {g})/2*abs(x)")  # fmt: skip
    return line(d, reference, 12, h=True, potential=[u])


def levels(d: Draw) -> Case:
    """Three slopes, nested."""
    a, b = d.uniform("a", 0.5, 1), d.uniform("b", 1.2, 2.5)
    f, g, e = d.uniform("f", -0.1, 0.5), d.uniform("g", -1, 1), d.uniform("e", -2, 1)
    start(d, (1, 2.5))
    reference = in_pieces(
        lambda p, mode: Linear(f=(p.f, p.g, p.e)[mode]),
        lambda p, mode: ([below(p.a, 1)], [above(p.a, 0), below(p.b, 2)], [above(p.b, 1)])[mode],
        lambda p: 0,
    )
    force = d.choice(
        f"where(x < {a}, {f}, where(x < {b}, {g}, {e}))",
        f"where(x > {b}, {e}, where(x > {a}, {g}, {f}))",
        f"where(x > {a} and not (x > {b}), {g}, where(x > {b}, {e}, {f}))",
    )
    return line(d, reference, 5, h=True, forces=[force])


def place_or_time(d: Draw) -> Case:
    """A force that acts beyond a place, or from a time on; not where the velocity is great."""
    a, T, f = d.uniform("a", 1, 3), d.uniform("T", 0.5, 2), d.uniform("f", 0.3, 1)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.f) if mode else Linear(),
        lambda p, mode: [] if mode else [below(p.a, 1), Exit(lambda q, v, t: p.T - t, to(1))],
        lambda p: 0,
    )
    force = d.choice(
        f"where(x > {a} or t > {T}, {f}, 0)",
        f"where(not (x < {a} and t < {T}), {f}, 0)",
        f"{f}*({d.step(f'max(x - {a}, t - {T})')})",
        f"where((x > {a} or t > {T}) and not (x_dot < -5), {f}, 0)",
    )
    return line(d, reference, 4, forces=[force])


def moving_front(d: Draw) -> Case:
    """A force behind a front that moves."""
    a, b, f = d.uniform("a", 1, 3), d.uniform("b", -0.5, 0.3), d.uniform("f", -1, 1)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(f=p.f) if mode else Linear(),
        lambda p, mode: [Exit(lambda q, v, t: (-1 if mode else 1) * (p.a + p.b * t - q[0]), to(1 - mode))],
        lambda p: 0,
    )
    return line(d, reference, 6, forces=[f"{f}*({d.step(f'x - {a} - {b}*t')})"])


def stiffness_at_a_time(d: Draw) -> Case:
    """The stiffness of a spring changes at a time."""
    k, j, T = d.uniform("k", 1, 4), d.uniform("j", 4, 20), d.uniform("T", 1, 4)
    d.uniform("x0", -2, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(k=p.j if mode else p.k),
        lambda p, mode: [] if mode else [Exit(lambda q, v, t: p.T - t, to(1))],
        lambda p: 0,
    )
    stiffness = d.choice(f"where(t < {T}, {k}, {j})", f"({k} + ({j} - {k})*({d.step(f't - {T}')}))")
    return line(
        d, reference, 8, **d.choice({"potential": [f"{stiffness}*x**2/2"]}, {"forces": [f"-x*{stiffness}"]})
    )


def square_wave(d: Draw) -> Case:
    """A force whose sign alternates."""
    f, w, phi = d.uniform("f", 0.5, 2), d.uniform("w", 1, 6), d.uniform("phi", 0.1, 3)
    start(d)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        return pieces(
            1, [p.x0], [p.v0], lambda mode, q, v, t: [Linear(f=mode * p.f)],
            lambda mode: [Exit(lambda q, v, t: mode * cosine2(p.w, p.phi, t), to(-mode))], times[-1],
        ).truth(times)  # fmt: skip

    return line(d, reference, 10, forces=[f"{f}*({d.sign(f'sin({w}*t + {phi})')})"])


def cosine2(w: Number, phi: Number, t: Any) -> Any:
    """sin(w t + phi), of doubles, too."""
    half = MP.pi / 2
    return cosine(MP.mpf(1), w * t + phi - half) if isinstance(t, MP.mpf) else cosine(
        MP.mpf(1), float(w) * t + float(phi) - float(half)
    )  # fmt: skip


def rectified(d: Draw) -> Case:
    """An alternating force, rectified: fully or one half."""
    f, w, phi = d.uniform("f", 0.5, 2), d.uniform("w", 1, 6), d.uniform("phi", 0.1, 3)
    start(d)
    full = d.choice(True, False)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def laws(mode: Any, q: Any, v: Any, t: Any) -> list[Linear]:
            scale = mode if full else (1 if mode > 0 else 0)
            return [Linear(a=scale * p.f, w=p.w, phi=p.phi - MP.pi / 2)]

        return pieces(
            1, [p.x0], [p.v0], laws,
            lambda mode: [Exit(lambda q, v, t: mode * cosine2(p.w, p.phi, t), to(-mode))], times[-1],
        ).truth(times)  # fmt: skip

    u = f"sin({w}*t + {phi})"
    return line(d, reference, 10, forces=[f"{f}*({d.absolute(u) if full else d.positive(u)})"])


def braking_zone(d: Draw) -> Case:
    """Viscous resistance beyond a place."""
    a, c = d.uniform("a", 0.5, 1.5), d.uniform("c", 0.2, 1)
    start(d)
    reference = in_pieces(
        lambda p, mode: Linear(c=p.c) if mode else Linear(),
        lambda p, mode: [] if mode else [below(p.a, 1)],
        lambda p: 0,
    )
    zone = d.step(f"x - {a}")
    return line(d, reference, 6, **d.choice(
        {"dissipation": [f"{c}*({zone})*x_dot**2/2"]}, {"forces": [f"-{c}*({zone})*x_dot"]},
    ))  # fmt: skip


def product_of_roots(d: Draw) -> Case:
    """U = k |(x - a)(x + a)|, under one root."""
    a, k = d.uniform("a", 0.4, 0.8), d.uniform("k", 0.5, 2)
    d.uniform("x0", 1, 1.5)
    d.uniform("v0", -2.5, 1)
    reference = in_pieces(
        lambda p, mode: Linear(k=2 * p.k if mode else -2 * p.k),
        lambda p, mode: (
            [Exit(lambda q, v, t: p.a + q[0], to(-1)), Exit(lambda q, v, t: p.a - q[0], to(1))] if not mode
            else [Exit(lambda q, v, t: mode * q[0] - p.a, to(0))]
        ),
        lambda p: 1,
    )  # fmt: skip
    u = d.choice(
        f"sqrt((x - {a})**2*(x + {a})**2)", f"abs(x**2 - {a}**2)", f"sqrt((x**2 - {a}**2)**2)",
        f"max(x**2 - {a}**2, {a}**2 - x**2)", f"abs(x - {a})*abs(x + {a})",
    )  # fmt: skip
    return line(d, reference, 4, h=True, potential=[f"{k}*{u}"])


TRIANGLES: dict[str, Callable[[Number], Number]] = {
    "asin(sin({u}))": lambda u: MP.asin(MP.sin(u)),
    "acos(cos({u}))": lambda u: MP.acos(MP.cos(u)),
    "asin(2*sin(({u})/2)*cos(({u})/2))": lambda u: MP.asin(MP.sin(u)),
    "acos(1 - 2*sin(({u})/2)**2)": lambda u: MP.acos(MP.cos(u)),
    "acos(cos({u})**2 - sin({u})**2)": lambda u: MP.acos(MP.cos(2 * u)),
    "sqrt(1 + sin({u}))": lambda u: MP.sqrt(1 + MP.sin(u)),
    "sqrt(1 - sin({u})**2)": lambda u: abs(MP.cos(u)),
    "sqrt(abs(sin({u})))": lambda u: MP.sqrt(abs(MP.sin(u))),
}
"""Waves with kinks at some multiples of a quarter period, as functions of the phase."""


def triangle_wave(d: Draw) -> Case:
    """A force of the time with kinks that stand in arcsines, arccosines and roots."""
    A, w, b = d.uniform("A", 0.5, 2), d.uniform("w", 0.5, 2), d.uniform("b", -3, 3)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -1, 1)
    text = d.choice(*TRIANGLES)
    wave = TRIANGLES[text]
    reference = pushed(
        lambda p: lambda t: p.A * wave(p.w * t + p.b),
        lambda p: [(k * MP.pi / 2 - p.b) / p.w for k in range(-2, 12)],
    )
    return line(d, reference, 6, **push(d, f"{A}*{text.format(u=f'{w}*t + {b}')}"))


KINDS = (
    on_from_a_place,
    window_in_space,
    window_in_time,
    gears,
    governor,
    thrust_until,
    relay,
    two_wells,
    greater_of_two,
    levels,
    place_or_time,
    moving_front,
    stiffness_at_a_time,
    square_wave,
    rectified,
    braking_zone,
    product_of_roots,
    triangle_wave,
)
