"""Rigid bodies of families with indices: how those turn that are written alike, and the energy of it.

With angles T = omega . I omega/2 in the axes of the body. With quaternions and matrices, which need not be
normalized, T is that of the masses that stand for the rotation (see ``model.rigid_body``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import sympy

from lagrange_cli.expression.operations import cross
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.families.applied import ON_BODIES
from lagrange_cli.families.groups import group_of
from lagrange_cli.model.rigid_body import equimomental
from lagrange_cli.spec.spec import grouped
from lagrange_cli.symbolic.families.builder import Oriented, WrittenBuilder
from lagrange_cli.symbolic.families.derivatives import Meaning, Part, parts
from lagrange_cli.symbolic.families.frames import Frame, Kind
from lagrange_cli.symbolic.indexed.conditions import Loop

Product: TypeAlias = "tuple[sympy.Expr, sympy.Expr, sympy.Expr]"
"""A factor and two speeds: T is the sum of these products."""
AtRest: TypeAlias = "Callable[[sympy.Expr], sympy.Expr]"
"""What an expression is where all velocities are 0."""


def rotational(builder: WrittenBuilder, at_rest: AtRest | None = None) -> dict[tuple[Loop, ...], sympy.Expr]:
    """The kinetic energy of rotations, of the bodies that loops run through; with ``at_rest`` its terms of
    degree 2 in velocities minus those of degree 0."""
    found: dict[tuple[Loop, ...], sympy.Expr] = {}
    for name, group in builder.bodies.items():
        for kind in builder.of_family(group):
            for loops, one in builder.kinds(kind.loops, kind.frame, orienting(builder, name, kind)):
                found[loops] = found.get(loops, sympy.S.Zero) + energy(builder, one, at_rest)
    return found


def orienting(builder: WrittenBuilder, name: str, kind: Kind) -> Callable[[Frame], Oriented]:
    """What finds how the bodies of a family turn that members of a kind stand for."""

    def build(frame: Frame) -> Oriented:
        known = {**builder.sizes, **frame.arrays}
        return builder.oriented(name, kind.indices, [one.value(known) for one in kind.indices], frame)

    return build


def energy(builder: WrittenBuilder, one: Oriented, at_rest: AtRest | None) -> sympy.Expr:
    """The kinetic energy of a rotation, or what ``rotational`` makes of it."""
    if at_rest is None:
        return sympy.Add(*(factor * x * y for factor, x, y in products(builder, one)))
    return sympy.Add(
        *(factor * (x * y - x * at_rest(y) - y * at_rest(x)) for factor, x, y in products(builder, one))
    )


def products(builder: WrittenBuilder, one: Oriented) -> Iterator[Product]:
    """The products that the kinetic energy consists of."""
    half = sympy.Rational(1, 2)
    if one.form == "euler":
        spin, whole = one.turning.in_body, sympy.Add(*one.moments)
        for own, x in zip(one.moments, spin, strict=True):
            yield sympy.expand(half * (whole - own)), x, x
        for (i, j), between in one.products.items():
            yield -between, spin[i], spin[j]
        return
    for _, mass, _, velocity in equimomental(builder.algebra, one.turning, one.moments, one.products):
        for x in velocity:
            yield half * mass, x, x


def torques(builder: WrittenBuilder, name: str, meaning: Meaning) -> Iterator[Part]:
    """The parts of Q by the members of a family of coordinates that torques make: tau . domega/dq_dot, or
    those of the forces tau x e/2 at the tips of the axes e."""
    spec = builder.spec
    written = spec.forces.get(ON_BODIES, {})
    for family in grouped(written, {**spec.families.get("bodies", {}), **spec.families.get(ON_BODIES, {})}):
        for kind in builder.of_family(group_of(family, written)):
            turns = orienting(builder, family.name, kind)

            def build(frame: Frame, kind: Kind = kind, turns: Any = turns) -> Any:
                return builder.value(kind.tree, frame), turns(frame)

            for loops, (torque, one) in builder.kinds(kind.loops, kind.frame, build):
                yield from of_torque(torque, one, loops, name, meaning)


def of_torque(
    torque: Sequence[sympy.Expr], one: Oriented, loops: Sequence[Loop], name: str, meaning: Meaning
) -> Iterator[Part]:
    """Those of one torque."""
    if one.form == "euler":
        acting = [*zip(torque, one.turning.in_space, strict=True)]
        base = velocity_name(name)
    else:
        half = sympy.Rational(1, 2)
        acting = [
            (half * force, x)
            for axis in one.turning.axes
            for force, x in zip(cross(torque, axis), axis, strict=True)
        ]
        base = name
    for force, x in acting:
        for each in parts(x, base, meaning, loops):
            yield Part(force * each.factor, (*loops, *each.loops), each.indices)
