"""The keys of the system file, a row each: what each means, how it is read, and what it may depend on.

A new key is a new row. The effect of its value is described where it is used: a force in ``model.forces``.
Where a section has keys of its own, their table is beside its reader.
"""

from __future__ import annotations

from typing import Any

from lagrange_cli.spec.declarations import read_coordinates, read_parameters
from lagrange_cli.spec.fields import Reader, read_scalar, read_text, read_vector
from lagrange_cli.spec.kinds import CONFIGURATION, CONSTANT, PLACES, SOURCE, STATE, Kind, Rule
from lagrange_cli.spec.readers import Entries, Single, Terms
from lagrange_cli.spec.settings import read_solve, read_time
from lagrange_cli.spec.table import Rare, Row, Table

read_bodies = Rare("bodies.keys", "read_bodies")
read_draw = Rare("draw.keys", "read_draw")
read_events = Rare("events.keys", "read_events")
read_transformations = Rare("transformations", "read_transformations")
read_vanishing = Rare("vanishing", "read_vanishing")


def named(
    key: str,
    what: str,
    value: Reader,
    meaning: str,
    *,
    example: str,
    label: str = "",
    families: bool = True,
    **other: Any,
) -> Row:
    """The row of a section ``name: expression``: see ``readers.Entries`` and ``Row``."""
    label = label or what
    vector, several = value is read_vector, value is read_vanishing
    read = Entries(value, what, example, label, families=families, several=vector or several)
    return Row(key, read, meaning, label=label, vector=vector, several=several, **other)


SECTIONS = Table(
    "",
    (
        Row("name", read_text, "text; the file's name without `.yaml` by default", also="title system"),
        Row("description", read_text, "text", also="comment comments notes doc"),
        Row(
            "parameters",
            read_parameters,
            "name -> a number, an expression in other parameters (in any order, without cycles), a list of "
            "either, or `{value, unit, description}`",
            also="constants consts params param constant values",
            rule=Rule(CONSTANT, "parameters may use numbers and other parameters"),
            family="all",
        ),
        named(
            "sizes",
            "size",
            read_scalar,
            "name -> a positive integer, for [indexed families](#indexed-families)",
            example="N: 10",
            families=False,
        ),
        Row(
            "coordinates",
            read_coordinates,
            "a list of names, or name -> `{initial, velocity, unit, description}`. Their order is the order "
            "of q. `initial` and `velocity` are numbers or expressions in parameters. `initial` may be left "
            "out if constraints determine it; `velocity` is 0 by default",
            also="variables vars coords coord dof dofs degrees_of_freedom generalized_coordinates "
            "generalised_coordinates unknowns q",
            rule=Rule(CONSTANT, "initial values may use numbers and parameters"),
            family="all",
        ),
        named(
            "definitions",
            "definition",
            read_vector,
            "name -> an expression or `[x, y, z]` in everything that has a name: q, q_dot, t, parameters, "
            "particles, bodies and other definitions, see [below](#definitions)",
            example="omega: sqrt(g/l)",
            also="defs definition expressions functions let where",
            family="some",
        ),
        named(
            "masses",
            "mass",
            read_scalar,
            "particle -> an expression in parameters, greater than 0",
            example="bob: m",
            label="mass of",
            also="mass m",
            rule=Rule(
                CONSTANT,
                "masses and moments of inertia may use numbers and parameters; with a mass that changes, "
                "write 'lagrangian'",
            ),
            family="all",
        ),
        named(
            "embedding",
            "position",
            read_vector,
            "particle -> its position r(q, t), with 1, 2 or 3 components. Positions may contain other "
            "particles and bodies, see [below](#positions-of-other-particles). The two words mean the same",
            example="bob: [x, y]",
            label="position of",
            alias="positions",
            also="position r kinematics trajectories",
            rule=Rule(PLACES, "a position is r(q, t): coordinates, t, parameters and other positions only"),
            family="all",
        ),
        Row(
            "bodies",
            read_bodies,
            "rigid body -> `{mass, inertia, position, orientation}`, or a `solid` in place of `inertia`: see "
            "[below](#rigid-bodies)",
            also="body rigid_bodies rigid_body rigidbodies solids",
            label="body",
            rule=Rule(
                PLACES,
                "the position and orientation of a body contain coordinates, t, parameters and other "
                "positions only",
            ),
            family="all",
        ),
        Row(
            "potential",
            Terms("potential"),
            "U(r, q, t), or U(q, q_dot, t) for potentials that depend on velocities; a mapping name -> "
            "expression is summed",
            also="U V potential_energy potentials Epot E_pot pot",
            label="potential",
            rule=SOURCE,
        ),
        Row(
            "lagrangian",
            Single("lagrangian"),
            "L(q, q_dot, t) itself, in place of `masses`, `embedding`, `bodies` and `potential`",
            also="L lagrange Lagrangian lagrangean",
            rule=Rule(STATE, "a Lagrangian is L(q, q_dot, t): coordinates, velocities, t and parameters"),
        ),
        named(
            "forces",
            "force",
            read_vector,
            "particle -> the applied force as a vector; Q_k follows by d'Alembert's principle",
            example="bob: [0, -m*g]",
            label="force on",
            also="force external_forces applied_forces F",
            of=Kind.PARTICLE,
            family="some",
            force=True,
        ),
        named(
            "torques",
            "torque",
            read_vector,
            "rigid body -> the applied torque about its centre of mass, `[x, y, z]` in space",
            example="top: [0, 0, 1]",
            label="torque on",
            also="torque moments moment couples couple",
            of=Kind.BODY,
            family="some",
            force=True,
        ),
        named(
            "generalized_forces",
            "generalized force",
            read_scalar,
            "coordinate -> Q_k, added to the Q_k of `forces`",
            example="theta: -c*theta_dot",
            also="Q generalised_forces",
            of=Kind.COORDINATE,
            family="some",
            force=True,
        ),
        Row(
            "dissipation",
            Single("dissipation"),
            "Rayleigh's dissipation function D(q_dot); adds -dD/dq_dot_k to Q_k",
            also="rayleigh Rayleigh dissipation_function D",
            force=True,
        ),
        named(
            "observables",
            "observable",
            read_scalar,
            "name -> an expression whose values are written with the trajectory",
            example="height: bob.y",
            also="observable quantities measure measurements",
            family="some",
        ),
        named(
            "constraints",
            "constraint",
            read_vanishing,
            "name -> an expression f(r, q, t) that stays 0, or a vector that does: a holonomic constraint, "
            "with a Lagrange multiplier, see [below](#constraints)",
            example="rod: x**2 + y**2 - l**2",
            also="constraint holonomic holonomic_constraints closures closure loops restrictions",
            rule=Rule(
                PLACES,
                "a constraint is f(r, q, t), without multipliers: one in velocities is written under "
                "'nonholonomic'",
            ),
            family="some",
        ),
        named(
            "nonholonomic",
            "nonholonomic constraint",
            read_vanishing,
            "name -> an expression or a vector, linear in the velocities, that stays 0 (Lagrange and "
            "d'Alembert)",
            example="blade: y_dot*cos(theta) - x_dot*sin(theta)",
            also="nonholonomic_constraints velocity_constraints rolling anholonomic non_holonomic",
            rule=SOURCE,
            family="some",
        ),
        Row(
            "events",
            read_events,
            "name -> an expression, or `{when, direction, action}`: what happens where `when` becomes 0, "
            "see [below](#events)",
            also="event guards callbacks triggers impacts impact kicks sections section crossings collisions",
            family="some",
        ),
        Row(
            "draw",
            read_draw,
            "what `view`, `plot` and `animate` draw, in place of what they find by themselves: see "
            "[below](#the-drawing)",
            also="drawing picture sketch display visualization visualisation graphics view animate "
            "animation drawings",
            rule=Rule(PLACES, "a drawing may use coordinates, t, parameters and particles only"),
        ),
        Row(
            "transformations",
            read_transformations,
            "name -> `{coordinates, replace}`: other coordinates, for `equations --coordinates NAME`, see "
            "[below](#other-coordinates)",
            also="transformation transforms transform change_of_coordinates point_transformations",
            rule=Rule(
                CONFIGURATION, "write functions of the new coordinates, of those that stay, t and parameters"
            ),
        ),
        Row("time", read_time, "the unit of t: `{unit: d}`, or `d` for short ([units](#units))"),
        Row(
            "solve",
            read_solve,
            "defaults of the command line, see below",
            rule=Rule(CONSTANT, "times may use numbers and parameters"),
            also="integration integrator solver simulation run integrate settings options numerics",
        ),
    ),
)
