"""The equations of motion of a system of families, in which every family stays one.

Particles move along lines and circles, or L is quadratic in velocities: M is mostly constant and diagonal, so
that a_k = -dU/dq_k / M_k. Else it is taken in blocks (``coupled_masses``, ``curved_masses``), or along chains
and trees (``joints``). All that is said of a member is said once, however many there are. Systems of another
kind are derived member by member (``mechanics``).
"""

from __future__ import annotations

from contextlib import suppress
from typing import TypeAlias

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.families.arrays import Domain
from lagrange_cli.families.derivation import articulated, separate
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.records import replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec

FEWEST = 100
"""Terms of all sums below which members are written out. With more, loops compile and run faster."""
FEWEST_CURVED = 50
"""The same where M is no constant: there is more to do in each term."""
FEWEST_JOINTED = 12
"""Coordinates of chains and trees below which they are, too: about where both take as long a step."""
FEWEST_TURNING = 50
"""Coordinates of rigid bodies that hang on none below which they are, too."""
FEWEST_SLIDING = 60
"""The same of bodies with more coordinates than joints have: spins that fewer conserve are found."""
MOST_TURNING = 1000
"""Terms of forces on these up to which that is so. More, as of pairs of many points, take long to compile."""
FEWEST_SWITCHED = 50
"""The same where there are switches, which cost more one by one."""
FEWEST_NONHOLONOMIC = 60
"""Coordinates of chains and trees with constraints on velocities below which they are, too: what these
conserve is looked for in systems of up to so many (``mechanics.constrained.frobenius``)."""
FEWEST_BOUND = 12
"""Constraints, or terms of sums in them, below which they are, too, where forces have few terms: rods of a
chain take as long in both ways, constraints that are not coupled to others less time in loops from 6 on."""
FEWEST_COUPLED = 6
"""Contacts that depend on one another below which they are, too: each is an unknown of equations there."""
FEWEST_HELD = 8
"""Coordinates below which they are, too, where friction is beside constraints."""
MOST_WRITTEN_OUT = 150
"""Coordinates up to which they are, too, if some constraints follow from others in turn, and too much is
coupled."""
ALONE = 300
"""Operations of expressions that stand alone up to which they do no harm beside loops."""
SPARED = 3
"""How many times as much there has to be to do as is written singly, for loops to pay."""
Reason: TypeAlias = "tuple[str, ...]"
UNKNOWN = {"replaced": "coordinates that replace others", "massless": "coordinates without mass"}
"""Parts of a system that are derived member by member, and what they are called."""

_LATEST: list[tuple[Spec, type[GraphAlgebra], FamilySystem | None, Reason]] = []
"""The last two, which are asked for once more when they are compiled; and why there is none, if that is
known."""
_WHOLE: list[tuple[Spec, Spec]] = []
"""The last one with all constraints."""


def family_system(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem | None:
    """The system, if it is of this kind and has many terms; None otherwise, also where something is wrong:
    who goes through its members finds what. Numbers are those of an ``algebra``. What is written singly is a
    domain of one: where no coordinate is repeated, loops save nothing."""
    if not spec.coordinate_families:
        return None
    found = any_family_system(spec, algebra)
    if found is None or (spec.nonholonomic and found.q.count < fewest_bound(found)):
        return None
    if found.joints and found.joints.count:
        return found
    if found.q.count >= FEWEST_HELD and found.bonds is not None and rests(found):
        return found
    if found.bodies:
        least = FEWEST_SLIDING if found.curved else FEWEST_TURNING
        few = found.q.count < least and found.terms <= MOST_TURNING
    elif found.coupled is not None and found.coupled.count >= FEWEST_COUPLED:
        few = False
    elif found.bonds is not None:
        few = found.bonds.terms < FEWEST_BOUND and found.terms < FEWEST
    else:
        watched = sum(one.domain.count for one in found.events.arguments.terms) if found.events else 0
        least = FEWEST_CURVED if found.curved else FEWEST
        few = found.terms + watched < (least if found.smooth is None else FEWEST_SWITCHED)
    return None if few or mostly_single(found) else found


def rests(system: FamilySystem) -> bool:
    """Whether friction may hold coordinates."""
    modes = None if system.smooth is None else system.smooth.modes
    return modes is not None and modes.halts is not None


def fewest_bound(system: FamilySystem) -> int:
    """Coordinates below which members are written out where there are constraints on velocities, and M is no
    constant. Where joints are sums of coordinates, M couples all of them, which takes long to compile."""
    if system.joints is not None:
        return FEWEST_NONHOLONOMIC if system.joints.relative is None else FEWEST_JOINTED
    return FEWEST_NONHOLONOMIC if system.curved else 0


def mostly_single(system: FamilySystem) -> bool:
    """Whether loops would save little: most of the operations are those of expressions that stand alone."""
    nodes: dict[Domain, list[Node]] = {}
    for total in system.acting:
        for one in total.terms:
            nodes.setdefault(one.domain, []).append(one.node)
    sizes = {domain: sum(1 for _ in reachable(own)) for domain, own in nodes.items()}
    single = sum(size for domain, size in sizes.items() if domain.count == 1)
    return single > ALONE and SPARED * single > sum(domain.count * size for domain, size in sizes.items())


def any_family_system(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem | None:
    """The same, however few terms it has."""
    return _latest(spec, algebra)[0]


def reason(spec: Spec) -> Reason:
    """What members are written out for, and a way to do without, where that is known."""
    return _latest(spec, GraphAlgebra)[1]


def _latest(spec: Spec, algebra: type[GraphAlgebra]) -> tuple[FamilySystem | None, Reason]:
    found: FamilySystem | None
    why: Reason
    for known, numbers, found, why in _LATEST:
        if known is spec and numbers is algebra:
            return found, why
    found, why = None, ()
    if not any(getattr(spec, part) for part in UNKNOWN):
        try:
            found = made(spec, algebra)
        except Unsuited as error:
            why = error.args
        except (Differ, ExpressionError, TooLarge, ArithmeticError):
            pass
    _LATEST[:] = [(spec, algebra, found, why), *_LATEST[:1]]
    return found, why


def with_first_order(spec: Spec) -> Spec:
    """A system with coordinates without mass as one of first order, if it is followed in loops; or itself."""
    names = [*names_of(spec.coordinates)]
    found = family_system(replace(spec, first_order=(*names,)))
    if found is None or found.first_order is None:
        return spec
    spec = replace(spec, first_order=tuple(names[k] for k in found.first_order.rows.tolist()))
    _LATEST[:] = [(spec, GraphAlgebra, replace(found, spec=spec), ())]
    return spec


def with_all_constraints(spec: Spec) -> Spec:
    """The same where none is left out: those that follow from others are treated as if this were in turn."""
    for known, whole in _WHOLE:
        if known is spec:
            return whole
    _WHOLE[:] = [(spec, replace(spec, in_turn=spec.left_out))]
    return _WHOLE[0][1]


def without_constraints(spec: Spec) -> FamilySystem | None:
    """The system that a file describes without its constraints and events, if it is of this kind."""
    if not spec.constrained and not spec.events:
        return any_family_system(spec)
    return any_family_system(replace(spec, constraints={}, nonholonomic={}, left_out=(), events={}))


def made(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem:
    """The system. Raises ``Unsuited`` where it is of another kind.

    Constraints that follow from others in turn are kept. Where that is not possible, members are written out,
    unless they are too many: then the same constraints are left out everywhere.
    """
    if not spec.in_turn:
        return of_any_kind(spec, algebra)
    turns = {*spec.in_turn}
    left_out, in_turn = (tuple(i for i in spec.left_out if (i in turns) is kept) for kept in (False, True))
    with suppress(Unsuited, Differ):
        found = of_any_kind(replace(spec, left_out=left_out, in_turn=in_turn), algebra)
        if found.bonds is not None and found.bonds.surplus:
            return replace(found, spec=spec)
    if len(spec.coordinates) <= MOST_WRITTEN_OUT:
        raise Unsuited
    return replace(of_any_kind(replace(spec, in_turn=()), algebra), spec=spec)


def of_any_kind(spec: Spec, algebra: type[GraphAlgebra]) -> FamilySystem:
    """The system, of the first kind that it is of; raises ``Unsuited``."""
    try:
        return separate(spec, algebra())
    except (Unsuited, Differ) as error:
        if error.args:
            raise
    why: Unsuited | Differ | None = None
    if spec.lagrangian is None and len(spec.coordinates) >= FEWEST_JOINTED:
        for platforms in (False, True):
            try:
                return articulated(spec, algebra(), platforms=platforms)
            except (Unsuited, Differ) as error:
                why = why or error
    for curved in (False, True):
        try:
            return separate(spec, algebra(), coupled=True, curved=curved)
        except (Unsuited, Differ) as error:
            if error.args:
                raise
            why = why or error
    assert why is not None
    raise why
