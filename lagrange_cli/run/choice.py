"""``--method auto``: the method that suits a system.

A Taylor series costs the square of its order for every convolution of a force, a step of ias15 some 16
evaluations of the forces. So where every coordinate has many terms, as where all bodies act on each other,
ias15 may be faster at the same error: the operations of both are counted (``integrate.family_work``). It
also passes places where drag along a vector, -c |u| u, has no series, which Taylor series pass only if
members are written out. On chains, and beside switches such as contact, DOP853 does: there ias15 takes steps
that are far too short, or none. Where series would have to be proven with the members of a large system
written out, and forces that damp it are narrow, Radau takes their place: at a tolerance that its steps are
made for, it does not miss these forces, in loops. Everything else is followed by Taylor series.

The choice is kept beside compiled programs, so that equations are not derived for it again. It does not
depend on anything that is measured while it is made: the same command always chooses the same.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from lagrange_cli.expression.syntax import Binary, Call, Number, Tree, parts
from lagrange_cli.integrate.methods.table import MANY_BODIES, METHODS, MODERATE, STIFF, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

TERMS = 2
"""Terms of sums for each coordinate below which series are faster, whatever the terms are."""
LOW = 4
"""Powers of coordinates up to this one do not hide."""
ROOTS = frozenset({"sqrt", "norm"})
HIDING = ROOTS | {"exp"}
NARROW = HIDING | {"tanh", "atan", "sinh", "cosh"}
SINGULAR = NARROW | {"tan", "asin", "acos", "log", "atan2"}
LOOSE = 1e-9
"""The tightest tolerance at which steps of order 5 are few enough."""


def chosen_method(
    spec: Spec, outputs: Collection[str], tolerance: float | None = None, *, cached: bool = True
) -> tuple[str, str]:
    """The method for a tolerance, and why it is chosen (empty if nothing else is considered). If it may be
    ``cached``, it is kept for later runs."""
    if not spec.coordinate_families:
        return TAYLOR, ""
    from lagrange_cli.families.size import terms_of

    count, terms = len(spec.coordinates), terms_of(spec)
    finest, default = METHODS[MANY_BODIES].tolerances[DOUBLE]
    fine = default if tolerance is None else tolerance
    weighed = fine >= finest and (terms >= TERMS * count > 0 or may_hide(spec))
    damped = fine >= LOOSE and may_be_narrow(spec)
    proven = fine >= finest and may_be_singular(spec)
    if not weighed and not damped and not proven and not may_drag(spec):
        return TAYLOR, ""
    look = kept if cached else examined
    method, _, why = look(spec, outputs, fine if weighed else None, damped).partition(" ")
    return method, why


def kept(spec: Spec, outputs: Collection[str], tolerance: float | None, damped: bool) -> str:
    """What ``examined`` says, from a note if there is one."""
    from lagrange_cli.native.compilation.fingerprint import fingerprint
    from lagrange_cli.spec.structure import structure
    from lagrange_cli.store.notes import notes

    cache = notes()
    if cache is None:
        return examined(spec, outputs, tolerance, damped)
    try:
        key = json.dumps(["method", structure(spec), sorted(outputs), tolerance, damped, fingerprint()])
    except OSError:
        return examined(spec, outputs, tolerance, damped)
    known = cache.load(key)
    why = examined(spec, outputs, tolerance, damped) if known is None else known.decode()
    if known is None:
        cache.store(key, why.encode())
    return why


def may_drag(spec: Spec) -> bool:
    """Whether forces may contain the length of a velocity, as far as their form shows."""
    return any(
        (isinstance(one, Call) and one.function in ROOTS)
        or (isinstance(one, Binary) and one.operator == "**" and not is_plain(one.right))
        for one in parts_of_forces(spec)
    )


def may_be_narrow(spec: Spec) -> bool:
    """Whether forces may be narrow, as far as their form shows."""
    return any(isinstance(one, Call) and one.function in NARROW for one in parts_of_forces(spec))


def may_be_singular(spec: Spec) -> bool:
    """Whether energies, positions and constraints may have functions for which steps by series have to be
    proven, as far as their form shows."""
    sections = spec.definitions, spec.embedding, spec.constraints, spec.nonholonomic
    listed = [*spec.potential.values(), *([] if spec.lagrangian is None else [spec.lagrangian])]
    listed += [one for section in sections for one in distinct(written(section))]
    return any(
        isinstance(one, Call) and one.function in SINGULAR for given in listed for one in parts(given.tree)
    )


def parts_of_forces(spec: Spec) -> Iterator[Tree]:
    """The parts of all forces that no potential gives, and of definitions."""
    sections = (*spec.forces.values(), spec.definitions) if any(spec.forces.values()) else ()
    for section in sections:
        for one in distinct(written(section)):
            yield from parts(one.tree)


def may_hide(spec: Spec) -> bool:
    """Whether the potential has functions or powers for which steps by series may have to be proven."""
    listed = [*spec.potential.values(), *([] if spec.lagrangian is None else [spec.lagrangian])]
    trees = [one.tree for one in (*listed, *distinct(written(spec.definitions)))]
    return any(
        (isinstance(one, Call) and one.function in HIDING)
        or (isinstance(one, Binary) and one.operator == "**" and not is_low(one.right))
        for tree in trees
        for one in parts(tree)
    )


def is_low(exponent: object) -> bool:
    """Whether it is 2, 3 or 4."""
    return is_plain(exponent) and isinstance(exponent, Number) and int(exponent.text) <= LOW


def is_plain(exponent: object) -> bool:
    """Whether it is a whole number."""
    return isinstance(exponent, Number) and exponent.text.isdecimal()


def examined(spec: Spec, outputs: Collection[str], tolerance: float | None, damped: bool = False) -> str:
    """The method that suits a system, a space, and why. If there is no ``tolerance``, series are faster
    wherever they exist. It may be ``damped`` by narrow forces, and followed by implicit steps then."""
    from lagrange_cli.integrate.families import dragged, suited, unprovable

    weighed = TAYLOR
    system = None if tolerance is None else suited(spec, outputs)
    if tolerance is not None and system is not None:
        from lagrange_cli.integrate.family_work import work_of

        work = work_of(system)
        price, worth = work.price(tolerance), work.worth(tolerance)
        said = f"a Taylor step takes as long as {price} evaluations of the forces and replaces {worth}"
        if price > worth and (not work.few or work.repays(tolerance)):
            return f"{MANY_BODIES} {said}"
        weighed = TAYLOR if work.few else f"{TAYLOR} {said}"
    system = dragged(spec)
    if system is None:
        able = (MANY_BODIES, *((STIFF,) if damped else ()))
        other = next((one for one in able if unprovable(spec, outputs, one)), "")
        if other:
            return f"{other} steps by series would have to be proven, with members written out"
        return weighed
    plain = system.joints is None and system.smooth is None
    return f"{MANY_BODIES if plain else MODERATE} drag along a vector has no series where that is 0"
