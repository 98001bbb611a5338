"""Events: impacts, billiards, kicks of velocities and parameters, what is recorded and what stops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, System, Truth
from benchmarks.truth.families.friction import cosine
from benchmarks.truth.families.line import line, sixteenths
from benchmarks.truth.pieces import Exit, Linear, pieces, to

RESTING = 1e-9
"""The speed below which a body that is pressed to a wall is taken to rest there."""


def hits(place: Any, restitution: Any, *, rising: bool, mode: Any = 0, name: str = "hit") -> Exit:
    """x meets a place and is thrown back."""
    sign = 1 if rising else -1
    return Exit(
        lambda q, v, t: sign * (place - q[0]),
        lambda _, q, v, t: (mode, [MP.mpf(place)], [-restitution * v[0]]),
        name,
    )


def set_velocity(value: str, when: str, direction: str = "") -> dict[str, str]:
    """The event ``hit`` that sets the velocity of x."""
    sense = f", direction: {direction}" if direction else ""
    return {"hit": f'{{when: "{when}"{sense}, action: {{set: {{x_dot: "{value}"}}}}}}'}


def bouncing_ball(d: Draw) -> Case:
    """A ball that loses a part of its velocity at every bounce."""
    g, e = d.uniform("g", 1, 10), d.uniform("e", 0.85, 1)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        return pieces(
            0, [p.x0], [p.v0], lambda mode, q, v, t: [Linear(f=-p.g)],
            lambda mode: [hits(0, p.e, rising=False)], times[-1],
        ).truth(times)  # fmt: skip

    flight = (8 * d.value("x0") / d.value("g")) ** 0.5
    events = set_velocity(f"-{e}*x_dot", "x", d.choice("falling", "falling", "either", ""))
    return line(d, reference, 2.5 * flight, potential=[f"{g}*x"], events=events)


def accumulating(d: Draw) -> Case:
    """Infinitely many bounces in a finite time; then the ball lies on the floor."""
    g, e = d.uniform("g", 1, 10), d.uniform("e", 0.2, 0.8)
    d.uniform("x0", 0.5, 2)
    d.uniform("v0", -1, 1)

    def end(p: Numbers) -> tuple[Number, Number]:
        speed = MP.sqrt(p.v0**2 + 2 * p.g * p.x0)
        first = (p.v0 + speed) / p.g
        return first + 2 * speed * p.e / (p.g * (1 - p.e)), speed

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        last, speed = end(p)
        x: list[Number | None] = []
        v: list[Number | None] = []
        first = (p.v0 + speed) / p.g
        for t in times:
            if t <= first:
                x.append(p.x0 + p.v0 * t - p.g * t**2 / 2)
                v.append(p.v0 - p.g * t)
            elif t >= last:
                x.append(MP.mpf(0))
                v.append(MP.mpf(0))
            else:
                begin, up = first, speed * p.e
                while begin + 2 * up / p.g < t:
                    begin, up = begin + 2 * up / p.g, up * p.e
                s = t - begin
                x.append(up * s - p.g * s**2 / 2)
                v.append(up - p.g * s)
        return Truth({"q/x": x, "v/x": v})

    from types import SimpleNamespace

    last, _ = end(SimpleNamespace(**{name: MP.mpf(value) for name, value in d.numbers.items()}))
    return line(
        d,
        reference,
        1.5 * float(last),
        potential=[f"{g}*x"],
        events=set_velocity(f"-{e}*x_dot", "x", "falling"),
    )


def billiard(d: Draw) -> Case:
    """Between two walls."""
    a, b = d.uniform("a", 0.5, 2), d.uniform("b", 0.5, 2)
    e = d.uniform("e", 0.6, 1)
    d.uniform("x0", -0.4, 0.4)
    d.uniform("v0", 1, 4)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        return pieces(
            0,
            [p.x0],
            [p.v0],
            lambda mode, q, v, t: [Linear()],
            lambda mode: [hits(p.a, p.e, rising=True), hits(-p.b, p.e, rising=False, name="other")],
            times[-1],
        ).truth(times)

    events = set_velocity(f"-{e}*x_dot", f"x - {a}", "rising")
    other = set_velocity(f"-{e}*x_dot", f"x + {b}", "falling")
    return line(d, reference, 8, events={**events, "other": other["hit"]})


def striking_oscillator(d: Draw) -> Case:
    """An oscillator that strikes a wall; where the spring presses it there, it may come to rest."""
    k, a, e = d.uniform("k", 1, 5), d.uniform("a", -0.5, 0.8), d.uniform("e", 0.7, 1)
    c = d.uniform("c", 0.01, 0.1)
    d.uniform("x0", -2, -1)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def struck(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            # what is left of infinitely many impacts when the speed is this small takes no time
            rests = p.a < 0 and v[0] < RESTING
            return (1, [p.a], [MP.mpf(0)]) if rests else (0, [p.a], [-p.e * v[0]])

        found = pieces(
            0, [p.x0], [p.v0], lambda mode, q, v, t: [Linear() if mode else Linear(k=p.k, c=p.c)],
            lambda mode: [] if mode else [Exit(lambda q, v, t: p.a - q[0], struck, "hit")], times[-1],
        )  # fmt: skip
        # the program stops counting impacts before they are infinitely many
        return (replace(found, events=[]) if found.starts[-1][1] else found).truth(times)

    return line(
        d, reference, 10, potential=[f"{k}/2*x**2"], dissipation=[f"{c}/2*x_dot**2"],
        events=set_velocity(f"-{e}*x_dot", f"x - {a}", "rising"),
    )  # fmt: skip


def kicked_rotor(d: Draw) -> Case:
    """Kicked once a period: the standard map, where it is regular."""
    K, T = d.uniform("K", 0.1, 0.7), d.uniform("T", 0.5, 2)
    d.uniform("x0", 0.3, 2)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        x: list[Number] = []
        v: list[Number] = []
        for t in times:
            at, speed, before = p.x0, p.v0, MP.mpf(0)
            k = 1
            while k * p.T < t:
                at += speed * (k * p.T - before)
                speed += p.K * MP.sin(at)
                before = k * p.T
                k += 1
            x.append(at + speed * (t - before))
            v.append(speed)
        return Truth({"q/x": x, "v/x": v})

    when = f"sin(pi*t/{T})"
    return line(d, reference, 12.3 * d.value("T"), events=set_velocity(f"x_dot + {K}*sin(x)", when))


def parameter_at_a_time(d: Draw) -> Case:
    """The stiffness is changed at a time."""
    k, m, T = d.uniform("k", 0.5, 4), d.uniform("m", 1.5, 4), d.uniform("T", 1, 4)
    d.uniform("x0", -2, 2)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        return pieces(
            0, [p.x0], [p.v0], lambda mode, q, v, t: [Linear(k=p.k * p.m if mode else p.k)],
            lambda mode: [] if mode else [Exit(lambda q, v, t: p.T - t, to(1), "switch")], times[-1],
        ).truth(times)  # fmt: skip

    return line(
        d, reference, 8, potential=[f"{k}/2*x**2"], over="k",
        events={"switch": f'{{when: "t - {T}", action: {{set: {{k: "{m}*k"}}}}}}'},
    )  # fmt: skip


def colliding_balls(d: Draw) -> Case:
    """Two balls that collide: both velocities are set from those before."""
    m, M = d.uniform("m", 0.5, 2), d.uniform("M", 0.5, 2)
    d.uniform("x0", -2, -0.5)
    d.uniform("v0", 0.5, 2)
    d.uniform("y0", 0.5, 2)
    d.uniform("w0", -1, 0.2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def exchanged(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            mean = (p.m * v[0] + p.M * v[1]) / (p.m + p.M)
            return 1, q, [2 * mean - v[0], 2 * mean - v[1]]

        return pieces(
            0, [p.x0, p.y0], [p.v0, p.w0], lambda mode, q, v, t: [Linear(), Linear()],
            lambda mode: [] if mode else [Exit(lambda q, v, t: q[1] - q[0], exchanged, "hit")], times[-1],
        ).truth(times, ("x", "y"))  # fmt: skip

    mean = f"2*({m}*x_dot + {M}*y_dot)/({m} + {M})"
    system = System(
        {"x": ("x0", "v0"), "y": ("y0", "w0")}, {"x": m, "y": M},
        events={"hit": f'{{when: "y - x", direction: falling, '
                f'action: {{set: {{x_dot: "{mean} - x_dot", y_dot: "{mean} - y_dot"}}}}}}'},
    )  # fmt: skip
    return Case("", "", system, d.numbers, reference, sixteenths(8), "x0", h=True)


def recorded(d: Draw) -> Case:
    """Crossings of a place, in one direction or both, are recorded."""
    k, a = d.uniform("k", 0.5, 5), d.uniform("a", -0.4, 0.4)
    d.uniform("x0", 0.8, 2)
    d.uniform("v0", -1, 1)
    direction = d.choice("rising", "falling", "either")

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        names = {1: "cross" if direction != "rising" else "", -1: "cross" if direction != "falling" else ""}
        return pieces(
            1, [p.x0], [p.v0], lambda mode, q, v, t: [Linear(k=p.k)],
            lambda mode: [Exit(lambda q, v, t: mode * (q[0] - p.a), to(-mode), names[mode])], times[-1],
        ).truth(times)  # fmt: skip

    return line(
        d, reference, 20, potential=[f"{k}/2*x**2"], h=True,
        events={"cross": f'{{when: "x - {a}", direction: {direction}, action: record}}'},
    )  # fmt: skip


def stopped(d: Draw) -> Case:
    """The motion is stopped where it comes to a place."""
    k, a = d.uniform("k", 0.5, 5), d.uniform("a", -0.4, 0.4)
    d.uniform("x0", 0.8, 2)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        found = pieces(
            1,
            [p.x0],
            [p.v0],
            lambda mode, q, v, t: [Linear(k=p.k)],
            lambda mode: [Exit(lambda q, v, t: mode * (q[0] - p.a), to(-mode), "end")][
                : 1 if mode > 0 else 0
            ],
            times[-1],
        )
        end = found.events[0][1]
        truth = found.truth(times)
        kept = {
            path: [x if t < end else None for t, x in zip(times, xs)] for path, xs in truth.values.items()
        }
        return replace(truth, values=kept, ends=end, steady=True)

    return line(
        d, reference, 8, potential=[f"{k}/2*x**2"], h=True,
        events={"end": f'{{when: "x - {a}", direction: {d.choice("falling", "either")}, action: stop}}'},
    )  # fmt: skip


def shaken_table(d: Draw) -> Case:
    """A ball on a table that moves up and down."""
    g, A, w, e = (
        d.uniform("g", 5, 10),
        d.uniform("A", 0.02, 0.1),
        d.uniform("w", 2, 6),
        d.uniform("e", 0.6, 0.9),
    )
    d.uniform("x0", 0.5, 1.5)
    d.uniform("v0", -1, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def bounced(mode: Any, q: list[Number], v: list[Number], t: Number) -> Any:
            table = -p.A * p.w * MP.sin(p.w * t)
            return 0, q, [table - p.e * (v[0] - table)]

        return pieces(
            0, [p.x0], [p.v0], lambda mode, q, v, t: [Linear(f=-p.g)],
            lambda mode: [Exit(lambda q, v, t: q[0] - (float(p.A) if not isinstance(t, MP.mpf) else p.A)
                               * cosine(p.w, t), bounced, "hit")], times[-1],
        ).truth(times)  # fmt: skip

    table = f"(-{A}*{w}*sin({w}*t))"
    flight = (8 * d.value("x0") / d.value("g")) ** 0.5
    return line(
        d, reference, 1.6 * flight, potential=[f"{g}*x"],
        events=set_velocity(f"{table} - {e}*(x_dot - {table})", f"x - {A}*cos({w}*t)", "falling"),
    )  # fmt: skip


def multiplied_out(d: Draw) -> Case:
    """A wall where a power that is multiplied out is 0."""
    a, e = d.uniform("a", 0.3, 2), d.uniform("e", 0.3, 1)
    d.uniform("x0", -1, 0)
    d.uniform("v0", 0.5, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        hit = (p.a - p.x0) / p.v0
        x = [p.x0 + p.v0 * t if t < hit else p.a - p.e * p.v0 * (t - hit) for t in times]
        return Truth({"q/x": x, "v/x": [p.v0 if t < hit else -p.e * p.v0 for t in times]})

    when = d.choice(
        f"x**3 - 3*{a}*x**2 + 3*{a}**2*x - {a}**3", f"(x - {a})*(x**2 - 2*{a}*x + {a}**2)",
        f"3*sin((x - {a})/9) - sin((x - {a})/3)",
    )  # fmt: skip
    return line(d, reference, 5, events=set_velocity(f"-{e}*x_dot", when))


KINDS = (
    bouncing_ball,
    accumulating,
    billiard,
    striking_oscillator,
    kicked_rotor,
    parameter_at_a_time,
    colliding_balls,
    recorded,
    stopped,
    shaken_table,
    multiplied_out,
)
