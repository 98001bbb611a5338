"""Two uncoupled motions side by side, each of another family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from benchmarks.truth.case import Case, Draw, Number, Numbers, Truth, replaced
from benchmarks.truth.families import barriers, friction, integrals, pulses, rest, switches, walls
from benchmarks.truth.families.line import Kind

LONG_FROM = 30.0
"""Motions that take longer than this are not followed beside others."""


def side_by_side(d: Draw, ones: Sequence[Kind], others: Sequence[Kind]) -> Case:
    """A motion of some kind in x and one of another kind in y."""
    one = drawn(d, ones)
    first, second = dict(d.numbers), Draw(d.source)
    other = drawn(second, others)
    names = {"x": "y", **{name: f"{name}_y" for name in second.numbers}}
    d.numbers = {**first, **{f"{name}_y": value for name, value in second.numbers.items()}}

    def reference(p: Numbers, times: Sequence[Number]) -> Truth:
        from types import SimpleNamespace

        mine = SimpleNamespace(**{name: getattr(p, name) for name in first})
        theirs = SimpleNamespace(**{name: getattr(p, f"{name}_y") for name in second.numbers})
        a, b = one.reference(mine, times), other.reference(theirs, times)
        return Truth(
            {**a.values, **{path.replace("/x", "/y"): x for path, x in b.values.items()}},
            sizes={**a.sizes, **{path.replace("/x", "/y"): x for path, x in b.sizes.items()}},
        )

    momenta = one.momenta | {replaced(name, names) for name in other.momenta}
    return replace(
        one, system=one.system.merged(other.system.renamed(names)), numbers=d.numbers, reference=reference,
        h=one.h and other.h, momenta=frozenset(momenta),
        stop=one.stop if float(one.stop) <= float(other.stop) else other.stop,
    )  # fmt: skip


def drawn(d: Draw, kinds: Sequence[Kind]) -> Case:
    """A case of one of these kinds, with one coordinate and not too long."""
    while True:
        d.numbers.clear()
        case = d.choice(*kinds)(d)
        if [*case.system.coordinates] == ["x"] and float(case.stop) <= LONG_FROM and case.system.masses:
            return case  # type: ignore[no-any-return]


SMOOTH = (*integrals.KINDS, *rest.KINDS)


def wall_and_switch(d: Draw) -> Case:
    """Both with kinks and jumps, each at its own times."""
    return side_by_side(d, walls.KINDS, switches.KINDS)


def wall_and_smooth(d: Draw) -> Case:
    """A wall beside a smooth motion."""
    return side_by_side(d, walls.KINDS, SMOOTH)


def friction_and_pulse(d: Draw) -> Case:
    """Friction beside a pulse."""
    return side_by_side(d, friction.KINDS, pulses.KINDS)


def friction_twice(d: Draw) -> Case:
    """Two uncoupled blocks."""
    return side_by_side(d, friction.KINDS, friction.KINDS)


def pulse_and_barrier(d: Draw) -> Case:
    """A pulse beside a barrier."""
    return side_by_side(d, pulses.KINDS, barriers.KINDS)


def switch_and_smooth(d: Draw) -> Case:
    """A switch beside a smooth motion."""
    return side_by_side(d, switches.KINDS, SMOOTH)


def barrier_and_smooth(d: Draw) -> Case:
    """A barrier beside a smooth motion."""
    return side_by_side(d, barriers.KINDS, SMOOTH)


KINDS = (
    wall_and_switch,
    wall_and_smooth,
    friction_and_pulse,
    friction_twice,
    pulse_and_barrier,
    switch_and_smooth,
    barrier_and_smooth,
)
