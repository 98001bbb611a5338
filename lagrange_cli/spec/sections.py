"""The keys of the system file, a row each: what each means, how it is read, and what it may depend on.

A new key is a new row. What its value does is said where it is used: a force in ``model.forces``.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from lagrange_cli.spec.fields import (
    Reader,
    read_count,
    read_list,
    read_number,
    read_scalar,
    read_text,
    read_vector,
    read_words,
)
from lagrange_cli.spec.kinds import CONFIGURATION, CONSTANT, SOURCE, STATE, Kind, Rule
from lagrange_cli.spec.readers import (
    Entries,
    Single,
    Terms,
    read_coordinates,
    read_draw,
    read_parameters,
    read_solve,
    read_time,
)
from lagrange_cli.spec.spec import SOLIDS
from lagrange_cli.spec.table import Rare, Row, Table

read_bodies, read_inertia, read_orientation, read_solid = (
    Rare("body_readers", name) for name in ("read_bodies", "read_inertia", "read_orientation", "read_solid")
)
read_action, read_changes, read_direction, read_events, read_when = (
    Rare("event_readers", name)
    for name in ("read_action", "read_changes", "read_direction", "read_events", "read_when")
)
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
    read = Entries(value, what, example, label, families=families)
    return Row(key, read, meaning, label=label, vector=value is read_vector, **other)


PARAMETER = Table(
    "parameter",
    (
        Row(
            "value",
            read_list,
            "a number, an expression in other parameters, or a list of either",
            also="val default number is initial",
        ),
        Row("unit", read_text, "its [unit](#units)", also="units"),
        Row("description", read_text, "text", also="comment"),
    ),
)
COORDINATE = Table(
    "coordinate",
    (
        Row(
            "initial",
            read_scalar,
            "its value at the start, in parameters",
            also="value start init initial_value initial_position position x0 q0 at initially",
        ),
        Row(
            "velocity",
            read_scalar,
            "its velocity at the start, in parameters [0]",
            also="v0 speed initial_velocity initial_speed dot rate v vel qdot q_dot velocity0",
        ),
        Row("unit", read_text, "its [unit](#units)", also="units"),
        Row("description", read_text, "text", also="comment"),
    ),
)
ACTION = Table(
    "action",
    (
        Row(
            "set",
            read_changes,
            "name of a coordinate, a velocity or a parameter -> its new value",
            also="assign update change changes sets apply put",
        ),
    ),
)
EVENT = Table(
    "event",
    (
        Row(
            "when",
            read_when,
            "the expression that becomes 0",
            also="condition event events trigger function zero zeros g root at if on where expression expr "
            "guard crossing crosses cross of equation value quantity watch at_zero test",
        ),
        Row(
            "direction",
            read_direction,
            "`rising`, `falling` or `either`: how it passes 0 [either]",
            also="sign dir slope way",
        ),
        Row(
            "action",
            partial(read_action, ACTION),
            "`record`, `stop`, or `{set: {NAME: expression}}` [record]",
            also="do then effect actions response result",
        ),
    ),
)
BODY = Table(
    "body",
    (
        Row("mass", read_scalar, "its mass, an expression in parameters", also="m"),
        Row(
            "inertia",
            read_inertia,
            "its moments of inertia about the centre of mass: the three principal ones along its axes, or a "
            "symmetric 3x3 matrix, made of parameters",
            also="J moments inertia_tensor moment_of_inertia I moments_of_inertia tensor",
        ),
        Row(
            "solid",
            read_solid,
            "in place of `inertia`, a homogeneous solid with its sizes: "
            + ", ".join(f"`{{{name}: {sizes}}}`" for name, sizes in SOLIDS.items()),
            also="shape form geometry",
        ),
        Row(
            "position",
            read_vector,
            "its centre of mass `[x, y, z]` in q, t and parameters",
            also="r centre center com origin positions embedding",
        ),
        Row(
            "orientation",
            read_orientation,
            "`{euler: [a, b, c], sequence: zxz}`, `{quaternion: [w, x, y, z]}` or `{matrix: 3x3}`",
            also="rotation attitude angles R pose",
        ),
    ),
    {
        "write 'orientation: {euler: [phi, theta, psi]}'": "euler sequence euler_angles phi theta psi",
        "write 'orientation: {quaternion: [w, x, y, z]}'": "quaternion quat quaternions",
        "write 'orientation: {matrix: [[..], [..], [..]]}'": "matrix rotation_matrix dcm",
        "write 'inertia: [I1, I2, I3]'": "I1 I2 I3 Ixx Iyy Izz Ix Iy Iz A B C",
        "write 'solid: {sphere: r}'": "sphere ball radius",
        "write 'solid: {box: [a, b, c]}'": "box cuboid cube",
        "write 'solid: {cylinder: [r, h]}'": "cylinder",
        "write 'solid: {disc: r}'": "disc disk",
        "write 'solid: {rod: l}'": "rod length",
        "it follows from those of the coordinates": "velocity angular_velocity omega v",
        "write 'position: [x, y, z]'": "x y z",
    },
)
TRANSFORMATION = Table(
    "transformation",
    (
        Row(
            "coordinates",
            partial(read_coordinates, COORDINATE),
            "the new coordinates: a list of names, or name -> `{initial, unit, description}`",
            also="new variables coords q to",
        ),
        Row(
            "replace",
            Entries(read_scalar, "replaced coordinate", "x: r*cos(phi)", "coordinate"),
            "coordinate of the file -> its value as an expression in the new coordinates, t and parameters",
            also="replaces old replaced where from with map subs substitute substitution "
            "substitutions expressions inverse equations",
        ),
    ),
)
TIME = Table(
    "time",
    (Row("unit", read_text, "the unit of t", also="units in"),),
    {"it belongs under 'solve', as in 'solve: {stop: 10}'": "start stop step end from to t0 t1 tmax dt span"},
)
SOLVE = Table(
    "solve",
    (
        Row(
            "start",
            read_scalar,
            "the time at which the motion begins [0]",
            also="t0 begin t_start tstart start_time from",
        ),
        Row(
            "stop",
            read_scalar,
            "the time at which it ends; if that is before `start`, the motion is integrated "
            "[backward](output-file.md#datasets)",
            also="end t_end tend tmax t_max tstop t_stop stop_time duration final until t1 tf t_final time t "
            "to",
        ),
        Row(
            "samples",
            read_count,
            "the number of samples, evenly spaced [1001]",
            also="n N points npoints n_points num_points n_samples num_samples num count steps n_steps "
            "sample",
        ),
        Row(
            "step",
            read_scalar,
            "the time between samples, in place of `samples`",
            also="dt h delta_t deltat timestep time_step step_size stepsize interval",
        ),
        Row("method", read_text, "the integration method [auto]", also="solver integrator scheme algorithm"),
        Row(
            "tolerance",
            read_number,
            "the relative error per step",
            also="tol rtol atol eps accuracy precision error",
        ),
        Row("outputs", read_words, "what is written, a list or `all`", also="output write save"),
        Row("unit", read_text, "the unit of t, unless `time` gives it", also="units"),
    ),
    {
        "write 'start: 0' and 'stop: 10'": "t_span tspan span time_span interval range",
        "it is an option of the command line: see 'lagrange solve --help'": "format file filename jobs "
        "certify digits checkpoint portable resume force parallel target_error",
        "the steps of the integration follow from 'tolerance'": "max_step min_step first_step maxstep order",
        "write 'step' or 'samples': samples are evenly spaced": "times t_eval saveat grid every",
        "they are a section of their own, beside 'solve'": "events event",
    },
)
SECTIONS = Table(
    "",
    (
        Row("name", read_text, "text; the file's name without `.yaml` by default", also="title system"),
        Row("description", read_text, "text", also="comment comments notes doc"),
        Row(
            "parameters",
            partial(read_parameters, PARAMETER),
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
            partial(read_coordinates, COORDINATE),
            "a list of names, or name -> `{initial, velocity, unit, description}`. Their order is the order "
            "of q. `initial` and `velocity` (0 by default) are numbers or expressions in parameters",
            also="variables vars coords coord dof dofs degrees_of_freedom generalized_coordinates "
            "generalised_coordinates unknowns q",
            rule=Rule(CONSTANT, "initial values may use numbers and parameters"),
            family="all",
        ),
        named(
            "definitions",
            "definition",
            read_vector,
            "name -> an expression or `[x, y, z]` in q, q_dot, t, parameters and other definitions",
            example="omega: sqrt(g/l)",
            also="defs definition expressions functions let where",
            rule=Rule(
                STATE | {Kind.MULTIPLIER},
                "definitions may use coordinates, velocities, t, parameters, multipliers and other "
                "definitions, but no particles",
            ),
            family="all",
        ),
        named(
            "masses",
            "mass",
            read_scalar,
            "particle -> an expression in parameters, greater than 0",
            example="bob: m",
            label="mass of",
            also="mass m",
            rule=Rule(CONSTANT, "masses may use numbers and parameters"),
            family="all",
        ),
        named(
            "embedding",
            "position",
            read_vector,
            "particle -> its position r(q, t), with 1, 2 or 3 components. The two words mean the same",
            example="bob: [x, y]",
            label="position of",
            alias="positions",
            also="position r kinematics trajectories",
            rule=Rule(CONFIGURATION, "a position is r(q, t): coordinates, t and parameters only"),
            family="all",
        ),
        Row(
            "bodies",
            partial(read_bodies, BODY),
            "rigid body -> `{mass, inertia, position, orientation}`, or a `solid` in place of `inertia`: see "
            "[below](#rigid-bodies)",
            also="body rigid_bodies rigid_body rigidbodies solids",
            label="body",
            rule=Rule(
                CONFIGURATION,
                "the position and orientation of a body contain coordinates, t and parameters only",
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
            family="all",
        ),
        named(
            "constraints",
            "constraint",
            read_vanishing,
            "name -> an expression f(r, q, t) that stays 0: a holonomic constraint, with a Lagrange "
            "multiplier, see [below](#constraints)",
            example="rod: x**2 + y**2 - l**2",
            also="constraint holonomic holonomic_constraints closures closure loops restrictions",
            rule=Rule(
                CONFIGURATION | {Kind.PARTICLE},
                "a constraint is f(r, q, t): one in velocities is written under 'nonholonomic'",
            ),
            family="all",
        ),
        named(
            "nonholonomic",
            "nonholonomic constraint",
            read_vanishing,
            "name -> an expression, linear in the velocities, that stays 0 (Lagrange and d'Alembert)",
            example="blade: y_dot*cos(theta) - x_dot*sin(theta)",
            also="nonholonomic_constraints velocity_constraints rolling anholonomic non_holonomic",
            rule=SOURCE,
            family="all",
        ),
        Row(
            "events",
            partial(read_events, EVENT),
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
            rule=Rule(
                CONFIGURATION | {Kind.PARTICLE},
                "a drawing may use coordinates, t, parameters and particles only",
            ),
        ),
        Row(
            "transformations",
            partial(read_transformations, TRANSFORMATION),
            "name -> `{coordinates, replace}`: other coordinates, for `equations --coordinates NAME`, see "
            "[below](#other-coordinates)",
            also="transformation transforms transform change_of_coordinates point_transformations",
            rule=Rule(
                CONFIGURATION, "write functions of the new coordinates, of those that stay, t and parameters"
            ),
        ),
        Row(
            "time",
            partial(read_time, TIME),
            "the unit of t: `{unit: d}`, or `d` for short ([units](#units))",
        ),
        Row(
            "solve",
            partial(read_solve, SOLVE),
            "defaults of the command line, see below",
            rule=Rule(CONSTANT, "times may use numbers and parameters"),
            also="integration integrator solver simulation run integrate settings options numerics",
        ),
    ),
)
