"""Walls: springs that push from one side only, corners and kinks of potentials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, System, Truth
from benchmarks.truth.families.line import force_or_potential, in_pieces, line, sixteenths
from benchmarks.truth.pieces import Exit, Linear, pieces, to
from benchmarks.truth.roots import bracketed


def below(place: Number, mode: Any) -> Exit:
    """x rises through ``place``."""
    return Exit(lambda q, v, t: place - q[0], to(mode))


def above(place: Number, mode: Any) -> Exit:
    """x falls through ``place``."""
    return Exit(lambda q, v, t: q[0] - place, to(mode))


def one_sided_spring(d: Draw) -> Case:
    """A free particle against a spring that pushes from x = a on."""
    a, k = d.uniform("a", 1, 3), d.log("k", 3, 3000)
    d.uniform("x0", -1, 0.5)
    d.uniform("v0", 0.7, 3)
    reference = in_pieces(
        lambda p, mode: Linear() if mode == "free" else Linear(f=p.k * p.a, k=p.k),
        lambda p, mode: [below(p.a, "wall") if mode == "free" else above(p.a, "free")],
        lambda p: "free",
    )
    u = f"x - {a}"
    given = force_or_potential(d, f"{k}/2*({d.positive(u)})**2", f"-{k}*({d.positive(u)})")
    return line(d, reference, 4 + 6 / d.value("v0"), h=True, **given)


def box(d: Draw) -> Case:
    """Between two such springs."""
    a, k, b, j = d.uniform("a", 0.5, 2), d.log("k", 10, 1000), d.uniform("b", 0.5, 2), d.log("j", 10, 1000)
    d.uniform("x0", -0.4, 0.4)
    d.uniform("v0", 1, 3)
    reference = in_pieces(
        lambda p, mode: {
            "": Linear(),
            "right": Linear(f=p.k * p.a, k=p.k),
            "left": Linear(f=-p.j * p.b, k=p.j),
        }[str(mode)],
        lambda p, mode: {
            "": [below(p.a, "right"), above(-p.b, "left")],
            "right": [above(p.a, "")],
            "left": [below(-p.b, "")],
        }[str(mode)],
        lambda p: "",
    )
    right, left = d.positive(f"x - {a}"), d.positive(f"-{b} - x")
    given = force_or_potential(d, f"{k}/2*({right})**2 + {j}/2*({left})**2", f"-{k}*({right}) + {j}*({left})")
    return line(d, reference, 8, h=True, **given)


def ball_on_springy_floor(d: Draw) -> Case:
    """Falls and bounces from a floor that gives way."""
    g, k = d.uniform("g", 1, 10), d.log("k", 100, 10000)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.g) if mode == "air" else Linear(f=-p.g, k=p.k),
        lambda p, mode: [above(0, "floor") if mode == "air" else below(0, "air")],
        lambda p: "air",
    )
    return line(d, reference, 6, h=True, potential=[f"{g}*x", f"{k}/2*({d.positive('-x')})**2"])


def wedge(d: Draw) -> Case:
    """U = k |x - a|: parabolas."""
    k, a = d.uniform("k", 0.5, 3), d.uniform("a", -1, 1)
    d.uniform("x0", 1.2, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.k if mode == "right" else p.k),
        lambda p, mode: [above(p.a, "left") if mode == "right" else below(p.a, "right")],
        lambda p: "right",
    )
    u = f"x - {a}"
    return line(
        d, reference, 20, h=True, **force_or_potential(d, f"{k}*{d.absolute(u)}", f"-{k}*({d.sign(u)})")
    )


def damped_wall(d: Draw) -> Case:
    """A wall that also resists the velocity: its force jumps where it is met."""
    a, k, c = d.uniform("a", 1, 2), d.log("k", 30, 1000), d.uniform("c", 0.5, 4)
    d.uniform("x0", -1, 0.5)
    d.uniform("v0", 0.7, 3)
    reference = in_pieces(
        lambda p, mode: Linear() if mode == "free" else Linear(f=p.k * p.a, k=p.k, c=p.c),
        lambda p, mode: [below(p.a, "wall") if mode == "free" else above(p.a, "free")],
        lambda p: "free",
    )
    force = f"-({k}*(x - {a}) + {c}*x_dot)*({d.step(f'x - {a}')})"
    return line(d, reference, 6, forces=[force])


def dead_zone(d: Draw) -> Case:
    """An oscillator whose spring has play."""
    a, k = d.uniform("a", 0.2, 1), d.uniform("k", 1, 20)
    d.uniform("x0", 1.2, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear() if not mode else Linear(f=mode * p.k * p.a, k=p.k),
        lambda p, mode: (
            [below(p.a, 1), above(-p.a, -1)] if not mode else [above(p.a, 0) if mode == 1 else below(-p.a, 0)]
        ),
        lambda p: 1,
    )
    u = d.choice(
        f"(x - min(max(x, -{a}), {a}))", f"({d.positive(f'x - {a}')} - {d.positive(f'-x - {a}')})",
        f"where(x > {a}, x - {a}, where(x < -{a}, x + {a}, 0))",
        f"where(abs(x) > {a}, x - {a}*sign(x), 0)",
        f"where(x > {a} or x < -{a}, x - {a}*sign(x), 0)",
    )  # fmt: skip
    return line(d, reference, 12, h=True, **force_or_potential(d, f"{k}/2*{u}**2", f"-{k}*{u}"))


def saturated_spring(d: Draw) -> Case:
    """A force -k x that grows to a bound only."""
    a, k = d.uniform("a", 0.3, 1), d.uniform("k", 1, 10)
    d.uniform("x0", 1.1, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(k=p.k) if not mode else Linear(f=-mode * p.k * p.a),
        lambda p, mode: (
            [below(p.a, 1), above(-p.a, -1)] if not mode else [above(p.a, 0) if mode == 1 else below(-p.a, 0)]
        ),
        lambda p: 1,
    )
    u = d.choice(
        f"min(max(x, -{a}), {a})", f"max(min({a}, x), -{a})", f"(abs(x + {a}) - abs(x - {a}))/2",
        f"where(x > {a}, {a}, where(x < -{a}, -{a}, x))",
    )  # fmt: skip
    return line(d, reference, 15, h=True, forces=[f"-{k}*{u}"])


def bilinear_spring(d: Draw) -> Case:
    """Stiffer on one side than on the other."""
    k, j = d.uniform("k", 0.5, 4), d.uniform("j", 5, 20)
    d.uniform("x0", 0.2, 2)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(k=p.k if mode == "right" else p.j),
        lambda p, mode: [above(0, "left") if mode == "right" else below(0, "right")],
        lambda p: "right",
    )
    stiffness = f"where({d.choice('x > 0', 'x >= 0', 'not (x < 0)')}, {k}, {j})"
    return line(d, reference, 15, h=True, **force_or_potential(d, f"{stiffness}*x**2/2", f"-x*{stiffness}"))


def wall_in_time(d: Draw) -> Case:
    """A force that grows from a time on."""
    s, T = d.uniform("s", 0.5, 3), d.uniform("T", 1, 4)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -1, 1)
    reference = in_pieces(
        lambda p, mode: Linear(f=-p.s * p.T, g=p.s) if mode else Linear(),
        lambda p, mode: [] if mode else [Exit(lambda q, v, t: p.T - t, to(1))],
        lambda p: 0,
    )
    u = d.positive(f"t - {T}")
    return line(d, reference, 6, **force_or_potential(d, f"-x*{s}*({u})", f"{s}*({u})"))


def oblique_corner(d: Draw) -> Case:
    """U = k |x + y|: one combination moves on parabolas, the other uniformly."""
    k = d.uniform("k", 0.5, 2)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -1, 1)
    d.uniform("y0", 0.1, 2)
    d.uniform("w0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        found = pieces(
            1, [p.x0 + p.y0], [p.v0 + p.w0], lambda mode, q, v, t: [Linear(f=-2 * p.k * mode)],
            lambda mode: [Exit(lambda q, v, t: mode * q[0], to(-mode))], times[-1],
        )  # fmt: skip
        values: dict[str, list[Number]] = {"q/x": [], "v/x": [], "q/y": [], "v/y": []}
        for t in times:
            (u,), (s,) = found.at(t)
            difference, apart = p.x0 - p.y0 + (p.v0 - p.w0) * t, p.v0 - p.w0
            for name, value in (
                ("q/x", (u + difference) / 2), ("q/y", (u - difference) / 2),
                ("v/x", (s + apart) / 2), ("v/y", (s - apart) / 2),
            ):  # fmt: skip
                values[name].append(value)
        return Truth(values)

    system = System(
        {"x": ("x0", "v0"), "y": ("y0", "w0")}, {"x": "1", "y": "1"}, [f"{k}*{d.absolute('x + y')}"]
    )
    return Case("", "", system, d.numbers, reference, sixteenths(10), "x0", h=True)


def contact(d: Draw) -> Case:
    """Hertz's law: a wall whose force grows with a fractional power of how deep it is entered."""
    a, k = d.uniform("a", 1, 2), d.log("k", 10, 1000)
    n = d.choice("1.5", "2.5", "3.5", "1.25")
    d.uniform("x0", -1, 0.5)
    d.uniform("v0", 0.7, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        m = MP.mpf(n)
        deep = (p.v0**2 / (2 * p.k)) ** (1 / m)
        meets = (p.a - p.x0) / p.v0
        # 2 int du / sqrt(v^2 - 2 k u^m) = 2 deep/v int_0^1 ds / sqrt(1 - s^m)
        leaves = meets + 2 * deep / p.v0 * MP.beta(1 / m, MP.mpf(1) / 2) / m
        x, v = [], []
        for t in times:
            if t <= meets:
                x.append(p.x0 + p.v0 * t)
                v.append(p.v0)
            elif t >= leaves:
                x.append(p.a - p.v0 * (t - leaves))
                v.append(-p.v0)
            else:
                x.append(None)
                v.append(None)
        return Truth({"q/x": x, "v/x": v})

    u = d.positive(f"x - {a}")
    return line(d, reference, 3 + 6 / d.value("v0"), h=True, potential=[f"{k}*({u})**{n}"])


def power_of_distance(d: Draw) -> Case:
    """U = k |x|^n with a fractional n: a higher derivative of the force has no value at 0."""
    n = d.choice("1.5", "2.5", "3", "3.5", "5", "4.2")
    k = d.uniform("k", 0.5, 3)
    d.uniform("x0", 0.5, 1.5)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        m = MP.mpf(n)
        top = MP.sqrt(2 * p.k * p.x0**m)

        def since_centre(way: Number) -> Number:  # int_0^s du / sqrt(1 - u^m)
            return way * MP.hyp2f1(MP.mpf(1) / 2, 1 / m, 1 + 1 / m, way**m)

        quarter = p.x0 / top * MP.beta(1 / m, MP.mpf(1) / 2) / m
        x, v = [], []
        for t in times:
            number = int(MP.floor((t + quarter) / (2 * quarter)))
            after = t - 2 * quarter * number  # the turn
            away = (quarter - abs(after)) * top / p.x0
            way = bracketed(lambda s: away - since_centre(s), MP.mpf(0), MP.mpf(1)) if after else MP.mpf(1)  # noqa: B023
            sign = -1 if number % 2 else 1
            x.append(sign * way * p.x0)
            v.append((-sign if after > 0 else sign) * top * MP.sqrt(1 - way**m))
        return Truth({"q/x": x, "v/x": v})

    return line(d, reference, 10, h=True, potential=[f"{k}*({d.absolute('x')})**{n}"], v="0")


KINDS = (
    one_sided_spring,
    box,
    ball_on_springy_floor,
    wedge,
    damped_wall,
    dead_zone,
    saturated_spring,
    bilinear_spring,
    wall_in_time,
    oblique_corner,
    contact,
    power_of_distance,
)
