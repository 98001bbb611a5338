"""Integrals along a motion: the action and the ledgers, with pulses in L that act on no coordinate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Truth
from benchmarks.truth.course import integral
from benchmarks.truth.families.line import line
from benchmarks.truth.families.pulses import ROUNDED, SHAPES, marks, push, pushed, shaped, start, written
from benchmarks.truth.pieces import Linear

OUTPUTS = ("q", "v", "h", "action", "ledger")
ACTION, LEDGER_H, LEDGER_P = "diagnostics/action", "diagnostics/ledger/h", "diagnostics/ledger/p/x"


def balanced(truth: Truth, energy: Number, momentum: Number) -> Truth:
    """With ledgers, which are 0 beside an energy and a momentum of this size."""
    zeros = [MP.mpf(0)] * len(next(iter(truth.values.values())))
    return replace(
        truth, values={**truth.values, LEDGER_H: zeros, LEDGER_P: zeros},
        sizes={**truth.sizes, LEDGER_H: energy, LEDGER_P: momentum},
    )  # fmt: skip


def uniform(p: Numbers, times: Sequence[Number]) -> Truth:
    """A motion with constant velocity."""
    return Truth({"q/x": [p.x0 + p.v0 * t for t in times], "v/x": [p.v0 for _ in times]})


def function_of_time(d: Draw) -> Case:
    """A pulse in L that depends on the time alone."""
    force, values, far = shaped(d, 1e-5, 0.3, 10)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        f, action, before = values(p), [MP.mpf(0)], times[0]
        for t in times[1:]:
            action.append(action[-1] + integral(f, before, t, marks(p.T, p.w)) + p.v0**2 / 2 * (t - before))
            before = t
        truth = uniform(p, times)
        h = [p.v0**2 / 2 - f(t) for t in times]
        truth = replace(truth, values={**truth.values, ACTION: action, "diagnostics/h": h})
        sizes = {ACTION: p.A * p.w, "diagnostics/h": p.A}
        return balanced(replace(truth, sizes=sizes), p.A * (1 + ROUNDED * p.T / p.w), p.v0)

    return line(
        d, reference, far, outputs=OUTPUTS, momentum=True,
        **d.choice({"lagrangian": [force]}, {"potential": [f"-{force}"]}),
    )  # fmt: skip


def total_derivative_in_space(d: Draw) -> Case:
    """x_dot g(x) in L, which is a total derivative: it acts on nothing, but in the action."""
    text, shape = SHAPES[d.choice("gauss", "lorentz", "lorentz4", "sech2", "angle", "packet")]
    a, w, A = d.uniform("a", 0.2, 2), d.log("w", 1e-5, 0.3), d.uniform("A", 0.5, 3)
    d.uniform("x0", -1, 0)
    d.uniform("v0", 0.5, 1)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        truth = uniform(p, times)
        action = [
            p.v0**2 / 2 * t
            + integral(lambda x: p.A * shape((x - p.a) / p.w), p.x0, p.x0 + p.v0 * t, marks(p.a, p.w))
            for t in times
        ]
        truth = replace(truth, values={**truth.values, ACTION: action})
        steep = 1 + ROUNDED * p.a / p.w
        return balanced(truth, p.A * p.v0 * steep, p.A * steep)

    return line(
        d, reference, 4, outputs=OUTPUTS, h=True, lagrangian=[f"x_dot*{A}*{written(text, f'(x - {a})/{w}')}"]
    )


def total_derivative(d: Draw) -> Case:
    """d/dt A exp(-((x - c t)/w)^2) in L, written out."""
    A, c, w = d.uniform("A", 0.5, 2), d.uniform("c", -1, 1), d.log("w", 1e-3, 0.5)
    d.uniform("x0", -1, 1)
    d.uniform("v0", -2, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def inside(t: Number) -> Number:
            return p.A * MP.exp(-(((p.x0 + (p.v0 - p.c) * t) / p.w) ** 2))

        truth = uniform(p, times)
        action = [p.v0**2 / 2 * t + inside(t) - inside(MP.mpf(0)) for t in times]
        truth = replace(truth, values={**truth.values, ACTION: action}, sizes={ACTION: p.A})
        return balanced(truth, p.A * abs(p.v0) / p.w, p.A / p.w)

    u = f"((x - {c}*t)/{w})"
    return line(d, reference, 4, outputs=OUTPUTS, lagrangian=[f"-2*{A}*{u}*exp(-{u}**2)*(x_dot - {c})/{w}"])


def corner_in_time(d: Draw) -> Case:
    """A function of time with corners in L."""
    A, T = d.uniform("A", 0.5, 3), d.uniform("T", 1, 4)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        truth = uniform(p, times)
        action = [p.v0**2 / 2 * t + p.A * max(t - p.T, MP.mpf(0)) ** 2 / 2 for t in times]
        h = [p.v0**2 / 2 - p.A * max(t - p.T, MP.mpf(0)) for t in times]
        truth = replace(truth, values={**truth.values, ACTION: action, "diagnostics/h": h})
        return balanced(truth, p.A + p.v0**2, p.v0)

    u = d.positive(f"t - {T}")
    return line(
        d, reference, 6, outputs=OUTPUTS, momentum=True,
        **d.choice({"lagrangian": [f"{A}*({u})"]}, {"potential": [f"-{A}*({u})"]}),
    )  # fmt: skip


def jump_in_time(d: Draw) -> Case:
    """A function of time that jumps in L."""
    A, T = d.uniform("A", 0.5, 3), d.uniform("T", 1, 4)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        truth = uniform(p, times)
        action = [p.v0**2 / 2 * t + p.A * max(t - p.T, MP.mpf(0)) for t in times]
        return replace(truth, values={**truth.values, ACTION: action})

    u = d.step(f"t - {T}")
    return line(d, reference, 6, outputs=("q", "v", "action"), momentum=True, lagrangian=[f"{A}*({u})"])


def oscillator(d: Draw) -> Case:
    """The action of an oscillator, damped in some."""
    k = d.uniform("k", 0.5, 5)
    c = d.uniform("c", 0.05, 0.5) if d.choice(True, False) else None
    d.uniform("x0", -2, 2)
    d.uniform("v0", -2, 2)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        law = Linear(k=p.k, c=getattr(p, "c", 0))

        def at(t: Number) -> tuple[Number, Number]:
            return law.at(p.x0, p.v0, MP.mpf(0), t)

        def lagrangian(t: Number) -> Number:
            x, v = at(t)
            return (v**2 - p.k * x**2) / 2

        states, action, before = [at(t) for t in times], [MP.mpf(0)], times[0]
        for t in times[1:]:
            action.append(action[-1] + integral(lagrangian, before, t, [(before + t) / 2]))
            before = t
        energy = p.v0**2 + p.k * p.x0**2
        truth = Truth(
            {"q/x": [x for x, _ in states], "v/x": [v for _, v in states], ACTION: action},
            sizes={ACTION: energy},
        )
        return balanced(truth, energy, abs(p.v0) + p.k * abs(p.x0))

    resistance = [f"{c}*x_dot**2/2"] if c else []
    return line(d, reference, 6, outputs=OUTPUTS, h=True, potential=[f"{k}*x**2/2"], dissipation=resistance)


def ledgers_of_a_pulse(d: Draw) -> Case:
    """The ledgers of a motion that a pulse has pushed."""
    force, values, far = shaped(d, 1e-4, 0.3, 10)
    start(d)
    of = pushed(values, lambda p: marks(p.T, p.w))

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        truth = of(p, times)
        size = truth.sizes["v/x"] + abs(p.v0)
        work = p.A * (1 + abs(p.x0) + 10 * size)  # of dL/dt, which is as steep as the pulse
        return balanced(truth, size**2 + work * (1 + ROUNDED * p.T / p.w), size)

    return line(d, reference, far, outputs=("q", "v", "ledger"), **push(d, force))


def ledgers_of_friction(d: Draw) -> Case:
    """The work of dry friction."""
    mu = d.uniform("mu", 0.2, 1)
    d.uniform("x0", -1, 1)
    d.uniform("v0", 0.5, 3)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        left = [max(p.v0 - p.mu * t, MP.mpf(0)) for t in times]
        truth = Truth({"q/x": [p.x0 + (p.v0**2 - v**2) / (2 * p.mu) for v in left], "v/x": left})
        return balanced(truth, p.v0**2, p.v0)

    return line(
        d, reference, 1.6 * d.value("v0") / d.value("mu"), outputs=("q", "v", "ledger"),
        dissipation=[f"{mu}*({d.absolute('x_dot')})"],
    )  # fmt: skip


def power_of_a_distance(d: Draw) -> Case:
    """A fractional power of the distance from a time, or from a place, which has no series there."""
    A, P, T = d.uniform("A", 0.5, 3), d.uniform("P", 0.05, 1.9), d.uniform("T", 0.5, 3)
    d.uniform("x0", -1, 0)
    d.uniform("v0", 0.8, 2)
    in_space = d.choice(True, False)

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        def inside(u: Number) -> Number:
            return MP.sign(u) * abs(u) ** (1 + p.P) * p.A / (1 + p.P)

        first = p.x0 - p.T if in_space else -p.T
        change = [inside(first + (p.v0 if in_space else 1) * t) - inside(first) for t in times]
        action = [p.v0**2 / 2 * t + one for t, one in zip(times, change)]
        truth = uniform(p, times)
        return replace(truth, values={**truth.values, ACTION: action})

    term = f"x_dot*{A}*abs(x - {T})**{P}" if in_space else f"{A}*abs(t - {T})**{P}"
    return line(
        d, reference, 6, outputs=("q", "v", "action"), lagrangian=[term], h=in_space, momentum=not in_space
    )


KINDS = (
    function_of_time, total_derivative_in_space, total_derivative, corner_in_time, jump_in_time, oscillator,
    ledgers_of_a_pulse, ledgers_of_friction, power_of_a_distance,
)  # fmt: skip
