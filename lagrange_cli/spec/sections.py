"""The keys of the system file, a row each: what each means, how it is read, and what it may depend on.

A new key is a new row. What its value does is said where it is used: a force in ``model.forces``.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from lagrange_cli.spec.event_readers import (
    read_action,
    read_changes,
    read_direction,
    read_events,
    read_when,
)
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
from lagrange_cli.spec.kinds import CONFIGURATION, CONSTANT, STATE, Kind, Rule
from lagrange_cli.spec.readers import (
    entries,
    read_coordinates,
    read_parameters,
    read_solve,
    read_time,
    single,
    terms,
)
from lagrange_cli.spec.table import Row, Table


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
    """The row of a section ``name: expression``: see ``readers.entries`` and ``Row``."""
    label = label or what
    read = entries(value, what, example, label=label, families=families)
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
TIME = Table("time", (Row("unit", read_text, "the unit of t"),))
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
            also="end t_end tend tmax t_max tstop t_stop stop_time duration final until t1 tf t_final time t",
        ),
        Row(
            "samples",
            read_count,
            "the number of samples, evenly spaced [1001]",
            also="n N points n_samples num count steps n_steps sample",
        ),
        Row(
            "step",
            read_scalar,
            "the time between samples, in place of `samples`",
            also="dt h timestep time_step step_size stepsize interval",
        ),
        Row(
            "method", read_text, "the integration method [taylor]", also="solver integrator scheme algorithm"
        ),
        Row(
            "tolerance",
            read_number,
            "the relative error per step",
            also="tol rtol atol eps accuracy precision error",
        ),
        Row("outputs", read_words, "what is written, a list or `all`", also="output write save"),
        Row("unit", read_text, "the unit of t, unless `time` gives it"),
    ),
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
            also="variables vars coords coord dof dofs degrees_of_freedom generalized_coordinates unknowns q",
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
                STATE,
                "definitions may use coordinates, velocities, t, parameters and other definitions, "
                "but no particles",
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
            "potential",
            terms("potential"),
            "U(r, q, t), or U(q, q_dot, t) for potentials that depend on velocities; a mapping name -> "
            "expression is summed",
            also="U V potential_energy potentials Epot E_pot pot",
            label="potential",
        ),
        Row(
            "lagrangian",
            single("lagrangian"),
            "L(q, q_dot, t) itself, in place of `masses`, `embedding` and `potential`",
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
            "generalized_forces",
            "generalized force",
            read_scalar,
            "coordinate -> Q_k, added to the Q_k of `forces`",
            example="theta: -c*theta_dot",
            also="Q generalised_forces torques torque",
            of=Kind.COORDINATE,
            family="some",
            force=True,
        ),
        Row(
            "dissipation",
            single("dissipation"),
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
            also="observable quantities",
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
            "time",
            partial(read_time, TIME),
            "the unit of t: `{unit: d}`, or `d` for short ([units](#units))",
        ),
        Row(
            "solve",
            partial(read_solve, SOLVE),
            "defaults of the command line, see below",
            rule=Rule(CONSTANT, "times may use numbers and parameters"),
            also="integration integrator solver simulation run integrate settings",
        ),
    ),
    later={
        "bodies": "describe a rigid body by point masses, or give 'lagrangian' instead",
        "constraints": "choose coordinates that satisfy the constraint",
        "nonholonomic": "only unconstrained and holonomic systems in their own coordinates "
        "are solved for now",
    },
)
