"""What the families share: cases with one coordinate x, and coordinates that may stand beside it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from benchmarks.truth.case import MP, Case, Draw, Number, Numbers, Reference, System, Truth
from benchmarks.truth.pieces import Exit, Linear, Pieces, pieces

Kind = Callable[[Draw], Case]


def sixteenths(t: float) -> str:
    """A time nearby whose quarters are doubles."""
    return repr(max(1, math.ceil(t * 16)) / 16)


def line(
    d: Draw,
    reference: Reference,
    stop: float,
    *,
    potential: Sequence[str] = (),
    lagrangian: Sequence[str] = (),
    forces: Sequence[str] = (),
    dissipation: Sequence[str] = (),
    events: dict[str, str] | None = None,
    mass: str = "1",
    x: str = "x0",
    v: str = "v0",
    h: bool = False,
    momentum: bool = False,
    over: str = "x0",
    outputs: Sequence[str] = ("q", "v", "h"),
    samples: int = 5,
) -> Case:
    """A particle on a line."""
    system = System(
        {"x": (x, v)}, {"x": mass} if mass else {}, [*potential], [*lagrangian],
        {"x": [*forces]} if forces else {}, [*dissipation], events or {},
    )  # fmt: skip
    momenta = frozenset({"x"} if momentum else ())
    return Case(
        "",
        "",
        system,
        d.numbers,
        reference,
        sixteenths(stop),
        over,
        h and not (forces or dissipation),
        momenta,
        tuple(outputs),
        samples,
    )


def in_pieces(
    laws: Callable[[Numbers, Any], Linear],
    exits: Callable[[Numbers, Any], Sequence[Exit]],
    begin: Callable[[Numbers], Any],
) -> Reference:
    """The reference of a motion in pieces with one coordinate, from x0 and v0."""

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        found = in_modes(p, laws, exits, begin(p), times[-1])
        return found.truth(times)

    return reference


def in_modes(
    p: Numbers,
    laws: Callable[[Numbers, Any], Linear],
    exits: Callable[[Numbers, Any], Sequence[Exit]],
    begin: Any,
    stop: Number,
) -> Pieces:
    """The pieces themselves."""
    return pieces(
        begin, [MP.mpf(p.x0)], [MP.mpf(p.v0)],
        lambda mode, q, v, t: [laws(p, mode)], lambda mode: exits(p, mode), stop,
    )  # fmt: skip


def force_or_potential(d: Draw, potential: str, force: str) -> dict[str, Any]:
    """One of the two."""
    if d.choice(True, False):
        return {"potential": [potential]}
    return {"forces": [force]}


# -- coordinates beside x -----------------------------------------------------------------------------


def free(d: Draw) -> tuple[System, Reference, bool, bool]:
    """Moves uniformly: p_z is conserved."""
    z, u = d.uniform("z0", -2, 2), d.uniform("u0", -2, 2)

    def at(p: Numbers, times: Sequence[Number]) -> Truth:
        return Truth({"q/z": [p.z0 + p.u0 * t for t in times], "v/z": [p.u0 for _ in times]})

    return System({"z": (z, u)}, {"z": "1"}), at, True, True


def oscillating(d: Draw) -> tuple[System, Reference, bool, bool]:
    """On a spring."""
    z, u, k = d.uniform("z0", -2, 2), d.uniform("u0", -2, 2), d.uniform("kz", 0.5, 4)
    system = System({"z": (z, u)}, {"z": "1"}, [f"{k}*z**2/2"])
    return system, linear(lambda p: Linear(k=p.kz)), True, False


def driven(d: Draw) -> tuple[System, Reference, bool, bool]:
    """On a spring, driven: h is not conserved."""
    z, a, w = d.uniform("z0", -2, 2), d.uniform("az", 0.1, 1), d.uniform("wz", 1.2, 3)
    system = System({"z": (z, "0")}, {"z": "1"}, [f"z**2/2 - z*{a}*cos({w}*t)"])
    return system, linear(lambda p: Linear(k=1, a=p.az, w=p.wz), v=False), False, False


def damped(d: Draw) -> tuple[System, Reference, bool, bool]:
    """Slowed by friction."""
    z, u, c = d.uniform("z0", -2, 2), d.uniform("u0", 0.5, 2), d.uniform("cz", 0.1, 1)
    system = System({"z": (z, u)}, {"z": "1"}, dissipation=[f"{c}*z_dot**2/2"])
    return system, linear(lambda p: Linear(c=p.cz)), False, False


def linear(law: Callable[[Numbers], Linear], v: bool = True) -> Reference:
    """The reference of z under a linear law, from z0 and u0 (or at rest)."""

    def at(p: Numbers, times: Sequence[Number]) -> Truth:
        speed = p.u0 if v else MP.mpf(0)
        found = [law(p).at(p.z0, speed, MP.mpf(0), t) for t in times]
        return Truth({"q/z": [x for x, _ in found], "v/z": [u for _, u in found]})

    return at


BESIDE = free, oscillating, driven, damped


def beside(d: Draw, case: Case) -> Case:
    """The case with an independent coordinate z."""
    system, reference, h, momentum = d.choice(*BESIDE)(d)

    def both(p: Numbers, times: Sequence[Number]) -> Truth:
        one, other = case.reference(p, times), reference(p, times)
        return replace(one, values={**one.values, **other.values})

    return replace(
        case, system=case.system.merged(system), reference=both, h=case.h and h,
        momenta=case.momenta | ({"z"} if momentum else frozenset()),
    )  # fmt: skip
