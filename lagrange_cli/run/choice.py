"""``--method auto``: the method that suits a system.

A Taylor series costs the square of its order for every term of a sum, a step of ias15 some 15 evaluations.
So where every coordinate has many terms, as where all bodies attract each other, ias15 is faster at the same
error (docs/benchmarks.md). It also passes places where drag along a vector, -c |u| u, has no series, which
Taylor series pass only if members are written out. On chains, and beside switches such as contact, DOP853
does: there ias15 takes steps that are far too short, or none. Everything else is followed by Taylor series.

The choice is kept beside compiled programs, so that equations are not derived for it again.
"""

from __future__ import annotations

import json
from collections.abc import Collection
from typing import TYPE_CHECKING

from lagrange_cli.expression.syntax import Binary, Call, Number, parts
from lagrange_cli.integrate.methods.table import MANY_BODIES, MODERATE, TAYLOR
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

FEWEST = 60
"""Coordinates below which a system is followed by Taylor series, if these pass wherever it may come."""
TERMS = 4
"""Terms of sums for each coordinate from which on ias15 is faster: 25 bodies in space."""
ROOTS = frozenset({"sqrt", "norm"})


def chosen_method(spec: Spec, outputs: Collection[str], *, cached: bool = True) -> tuple[str, str]:
    """The method, and why it is not that of Taylor series (empty if it is). If it may be ``cached``, it is
    kept for later runs."""
    count, terms = len(spec.coordinates), 0
    if not spec.families.get("coordinates"):
        return TAYLOR, ""
    if count >= FEWEST:
        from lagrange_cli.families.size import terms_of

        terms = terms_of(spec)
    many = terms >= TERMS * count > 0
    if not many and not may_drag(spec):
        return TAYLOR, ""
    method, _, why = (kept if cached else examined)(spec, outputs, terms if many else 0).partition(" ")
    return method, why


def kept(spec: Spec, outputs: Collection[str], terms: int) -> str:
    """What ``examined`` says, from a note if there is one."""
    from lagrange_cli.native.compilation.fingerprint import fingerprint
    from lagrange_cli.spec.structure import structure
    from lagrange_cli.store.notes import notes

    cache = notes()
    if cache is None:
        return examined(spec, outputs, terms)
    try:
        key = json.dumps(["method", structure(spec), sorted(outputs), fingerprint()])
    except OSError:
        return examined(spec, outputs, terms)
    known = cache.load(key)
    why = examined(spec, outputs, terms) if known is None else known.decode()
    if known is None:
        cache.store(key, why.encode())
    return why


def may_drag(spec: Spec) -> bool:
    """Whether forces may contain the length of a velocity, as far as their form shows."""
    sections = (*spec.forces.values(), spec.definitions) if spec.forces else ()
    trees = [one.tree for section in sections for one in distinct(written(section))]
    return any(
        (isinstance(one, Call) and one.function in ROOTS)
        or (isinstance(one, Binary) and one.operator == "**" and not is_plain(one.right))
        for tree in trees
        for one in parts(tree)
    )


def is_plain(exponent: object) -> bool:
    """Whether it is a whole number."""
    return isinstance(exponent, Number) and exponent.text.isdecimal()


def examined(spec: Spec, outputs: Collection[str], terms: int) -> str:
    """The method that suits a system whose sums have so many ``terms``, if they are many, a space, and why it
    is another one than that of Taylor series."""
    from lagrange_cli.integrate.families import dragged, suits

    if terms and suits(spec, outputs):
        return f"{MANY_BODIES} its sums have {terms} terms for {len(spec.coordinates)} coordinates"
    system = dragged(spec)
    if system is None:
        return TAYLOR
    plain = system.joints is None and system.smooth is None
    return f"{MANY_BODIES if plain else MODERATE} drag along a vector has no series where that is 0"
