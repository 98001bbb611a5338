"""Conserved quantities that do not belong to a cyclic coordinate: found by Noether's theorem, and proven.

The candidates are displacements of all particles (translations, rotations, Galilean boosts), and combinations
of changes of coordinates by constants, by t, or linear ones, in time or along nonholonomic constraints.
Combinations are guessed from values at random states (``relations``). All results are proven (``noether``).
Polynomials of a higher degree in the velocities do not come from such a change (``hidden``, ``tops``,
``polynomial_integrals``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.conserved.combinations import MOST_COMBINED, combinations
from lagrange_cli.mechanics.conserved.displacements import about_the_centre, accelerated, displaced
from lagrange_cli.mechanics.conserved.found import Found, Symmetry
from lagrange_cli.mechanics.conserved.noether import Change, Noether
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.mechanics.conserved.polynomial_integrals import Integral

MOST_IN_POLYNOMIALS, MOST_WITH_BODIES, MOST_ON_A_LINE = 5, 7, 8
"""The largest numbers of coordinates for which polynomials are tried, without and with a rigid body."""
MOST_TURNED = 3
"""The largest number of coordinates for which they are tried in other axes."""
MOST_OSCILLATORS = 4
"""The largest number of coordinates of a linear system whose further energies are looked for."""
MOST_DRIVEN = 6
"""The largest number of coordinates of a driven linear system."""
ROUNDED = 2.0**-44
"""A value of a sum that is so much smaller than its terms is 0."""
WORTH = 2_500_000
"""Steps of work that each stage of the search may take."""
WORTH_OF_ALL = 3_000_000
"""Those that all stages may take together."""
WORTH_OF_POLYNOMIALS = 800_000
"""The same for conserved polynomials, which many systems do not have: half a second."""


def symmetries(model: Model[Node], known: Sequence[Conserved] = ()) -> tuple[Symmetry, ...]:
    """Conserved quantities beyond those ``known``, which are h and momenta of cyclic coordinates."""
    with graph_of(model).work.apart():
        return searched(model, known)


def searched(model: Model[Node], known: Sequence[Conserved]) -> tuple[Symmetry, ...]:
    """The same, stage by stage."""
    energy = model.potential if model.lagrangian is None else model.lagrangian
    if any(one.kind is Kind.SWITCH for one in reachable([energy])):
        from lagrange_cli.mechanics.switching.saturation import released  # if anything was saturated

        model = released(model)
    work = graph_of(model).work
    last = work.spent + WORTH_OF_ALL
    space = work.attempt(WORTH_OF_POLYNOMIALS, partial(in_space, model))
    model, note = space or (model, "")
    found = Found(model, known)
    found.place = note
    stages = (
        displaced,
        about_the_centre,
        idle,
        combinations,
        accelerated,
        damped,
        parts,
        in_other_axes,
        hidden,
        tops,
        polynomials,
        linear,
        pushed,
        rescaled,
        lasting,
        without_gauge,
    )
    for stage in stages:
        found.note = note if stage in (displaced, about_the_centre, hidden, polynomials) else ""
        worth = WORTH_OF_POLYNOMIALS if stage in (idle, in_other_axes, polynomials) else WORTH
        work.attempt(min(worth, last - work.spent), partial(stage, found))
    return tuple(found.symmetries)


def idle(found: Found) -> None:
    """Momenta and h on which forces of constraint might act, but do not."""
    if found.model.constraints:
        from lagrange_cli.mechanics.conserved.idle import undisturbed  # and numbers modulo a prime

        undisturbed(found)


def damped(found: Found) -> None:
    """What falls exponentially by drag."""
    if not all(map(is_zero, found.noether.energetics.applied)):
        from lagrange_cli.mechanics.conserved.damped import growing  # where there are forces outside L

        growing(found)


def parts(found: Found) -> None:
    """Energies of parts of the system."""
    if len(found.model.q) > 1:
        from lagrange_cli.mechanics.conserved.separation import parts  # of several coordinates

        parts(found)


def hidden(found: Found) -> None:
    """Quadratic functions of the velocities, of one particle or two."""
    components = sum(len(one.position) for one in found.model.particles)
    if "h" in found.names and len(found.model.q) == components > 1:
        from lagrange_cli.mechanics.conserved.hidden import hidden  # in a plane or in space

        hidden(found)


def linear(found: Found) -> None:
    """Energies of the derivatives of the motion of a linear system."""
    if found.model.constraints or "h" not in found.names or not 2 <= len(found.model.q) <= MOST_OSCILLATORS:
        return
    if found.noether.has_constant_masses:
        from lagrange_cli.mechanics.conserved.linear import of_derivatives  # of few coordinates

        of_derivatives(found)


def pushed(found: Found) -> None:
    """What a linear system keeps that a force of t drives, or all in a frame that turns."""
    model, energetics = found.model, found.noether.energetics
    given = union([energetics.lagrangian, *energetics.applied])
    driven = "h" not in found.names and given & model.time.symbols
    if model.constraints or not 1 <= len(model.q) <= MOST_DRIVEN:
        return
    if (driven or len(model.q) > 1) and found.noether.has_constant_masses:
        from lagrange_cli.mechanics.conserved import pushed  # with functions of t

        pushed.in_turning_frames(found)
        if driven:
            pushed.pushed(found)


def rescaled(found: Found) -> None:
    """What is conserved in units that change with t."""
    if "h" not in found.names:
        from lagrange_cli.mechanics.conserved import rescaled  # where t is in the equations, or drag

        rescaled.rescaled(found, searched)


def lasting(found: Found) -> None:
    """What events leave alone, although they change what it is made of."""
    if found.eventful and len(found.model.q) <= MOST_COMBINED:
        from lagrange_cli.mechanics.conserved.lasting import combined  # and numbers modulo a prime

        combined(found)


def total_energy(model: Model[Node]) -> tuple[Symmetry, ...]:
    """T + U, where it is not h, and is conserved nevertheless: with constraints that are at rest in space,
    in coordinates that move."""
    from lagrange_cli.mechanics.conserved.ansatz import has_smooth_forces
    from lagrange_cli.mechanics.conserved.residue_states import States

    noether, kinetic = Noether(model), Energetics(model).kinetic
    if kinetic is None or not has_smooth_forces(model, noether) or any(one.changes for one in model.events):
        return ()
    node, states = kinetic + model.potential, States(model, noether)
    if not graph_of(model).work.attempt(WORTH, lambda: states.conserves(node)):
        return ()
    return (
        Symmetry(Conserved("T + U", "T + U", "its rate of change is 0 where the constraints hold"), node),
    )


def in_space(model: Model[Node]) -> tuple[Model[Node], str] | None:
    """A system of few coordinates as one particle in a plane or in space, if it moves like one, and where
    that is."""
    size = sum(len(one.position) for one in model.particles)
    if model.constraints or len(model.q) not in (2, 3) or size == len(model.q):
        return None
    if any(one.body for one in model.particles):
        return None
    from lagrange_cli.mechanics.conserved.curvature import may_be_flat
    from lagrange_cli.mechanics.conserved.residue_states import States

    if not may_be_flat(States(model, Noether(model))):
        return None
    from lagrange_cli.mechanics.conserved.flat import as_text, flat_space

    found = flat_space(model)
    return None if found is None else (found, as_text(found))


def tops(found: Found) -> None:
    """The integral of a heavy top that belongs to no symmetry."""
    if found.model.spec is None or not found.model.spec.bodies or "h" not in found.names:
        return
    from lagrange_cli.mechanics.conserved.tops import kovalevskaya  # and all about bodies

    integral = kovalevskaya(found.model, found.noether)
    if integral is not None:
        each, node = integral
        found.store(replace(each, quantity=found.free_name(each.quantity)), node)


def on_motions(model: Model[Node], values: Mapping[str, float]) -> tuple[Conserved, ...]:
    """What motions conserve that begin at a state (``values`` of coordinates, velocities and parameters), and
    others do not."""
    if model.spec is None or not model.spec.bodies or any(event.changes for event in model.events):
        return ()
    from lagrange_cli.mechanics.conserved.tops import goryachev_chaplygin

    found = graph_of(model).work.attempt(WORTH, lambda: goryachev_chaplygin(model, Noether(model)))
    if found is None:
        return ()
    value, size = evaluate([found.level], values)
    return (found.conserved,) if abs(value[found.level]) <= ROUNDED * size[found.level] else ()


def polynomials(found: Found) -> None:
    """Other polynomials in the velocities."""
    freedoms = len(found.model.q) - len(found.model.constraints)
    turning = any(one.body for one in found.model.particles)
    if "h" not in found.names or freedoms < 2:
        return
    if len(found.model.q) > (MOST_WITH_BODIES if turning else MOST_ON_A_LINE):
        return
    from lagrange_cli.mechanics.conserved.polynomial_integrals import PolynomialIntegrals

    known = [*found.kept, *(one.node for one in found.symmetries), *found.plain]
    search = PolynomialIntegrals(found.model, found.noether, known)
    few = turning or len(found.model.q) <= MOST_IN_POLYNOMIALS
    for one in search.found() if few else search.of_pairs():
        hidden_symmetry(found, one)


def in_other_axes(found: Found) -> None:
    """Polynomials along the axes in which the potential is written."""
    if "h" not in found.names or found.model.constraints or not 2 <= len(found.model.q) <= MOST_TURNED:
        return
    if not found.noether.has_constant_masses:
        return
    from lagrange_cli.mechanics.conserved.turned import integrals  # of potentials with parameters in sums

    for one in integrals(found.model, found.noether, [*found.kept, *(one.node for one in found.symmetries)]):
        hidden_symmetry(found, one)


def hidden_symmetry(found: Found, one: Integral) -> None:
    """Add a conserved polynomial."""
    because = f"a hidden symmetry, of degree {one.degree} in the velocities: "
    because = because if one.degree > 1 else "linear in the velocities: "
    where = "where the constraints hold, " if found.model.constraints else ""
    because += f"{where}it is constant by the equations of motion{one.note}"
    found.store_integral(one.text, because, one.node)


def without_gauge(found: Found) -> None:
    """The quantities that L conserves without its terms that are a total time derivative dF/dt, which
    have no effect: in place of h that is h + dF/dt, in place of p_k it is p_k - dF/dq_k (partial
    derivatives)."""
    model, given = found.model, found.model.lagrangian
    lagrangian = -model.potential if given is None else given
    left = acting(model, found.graph, lagrangian)
    if left is lagrangian:
        return
    other = replace(model, potential=-left) if given is None else replace(model, lagrangian=left)
    energetics, (_, known) = Energetics(other), conservation(other)
    plain = {f"p_{name}": p for name, p in zip(model.coordinates, energetics.momenta)}
    nodes = [(each, {**plain, "h": energetics.energy_function}[each.quantity]) for each in known]
    nodes += [(one.conserved, one.node) for one in searched(other, known)]
    gone = lagrangian - left
    lacks = {f"p_{name}": -found.graph.diff(gone, v) for name, v in zip(model.coordinates, model.v)}
    (lacks["h"],) = substituted(found.graph, [gone], dict.fromkeys(model.v, found.graph.zero))
    for each, node in nodes:
        if found.is_known(
            node, Change(time=found.graph.one), [*found.kept, *(one.node for one in found.symmetries)]
        ):
            continue
        text = f"{each.quantity} = {each.expression}, of L without dF/dt"
        if each.quantity in lacks:
            text = joined([each.quantity, text_of(lacks[each.quantity])])
        because = f"without the terms of L that are a total time derivative dF/dt, {each.because}"
        found.store(Conserved(found.free_name(f"{each.quantity}_0"), text, because), node)
