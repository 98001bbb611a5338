"""``Model``: the system's expressions over one algebra, names resolved; nothing is derived yet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic

from lagrange_cli.expression.algebra import Algebra, E
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.spec import Family, Spec


@dataclass(frozen=True)
class Particle(Generic[E]):
    """A point mass: ``mass`` in parameters, ``position`` r(q, t) with 1 to 3 components,
    ``velocity`` = dr/dt = sum_k dr/dq_k q_dot_k + dr/dt in q, q_dot, t (same length), and the applied
    ``force`` F(q, q_dot, t) of the ``forces`` section (empty where there is none).

    Some stand for the rotation of a rigid ``body`` (see ``model.rigid_body``): their positions are
    directions, their masses moments of inertia."""

    name: str
    mass: E
    position: tuple[E, ...]
    velocity: tuple[E, ...]
    force: tuple[E, ...]
    body: str = ""


@dataclass(frozen=True)
class Event(Generic[E]):
    """What happens where the ``argument`` g(q, q_dot, t) becomes 0.

    ``direction`` is +1 where g must rise, -1 where it must fall, 0 where either counts. The motion ends there
    if it ``stops``. ``changes`` are new values of coordinates, velocities or parameters by name, functions of
    the state before.
    """

    name: str
    argument: E
    direction: int = 0
    stops: bool = False
    changes: Mapping[str, E] = field(default_factory=dict)


@dataclass(frozen=True)
class Constraint(Generic[E]):
    """An ``expression`` that stays 0: f(q, t) if it is ``holonomic``, otherwise g(q, q_dot, t), linear in
    the velocities.

    ``multiplier`` is the symbol of lambda: the generalized forces are lambda df/dq_k, or lambda dg/dq_dot_k.
    It is 0 of the equation of motion ``of`` a coordinate without mass (``run.massless``).
    """

    name: str
    expression: E
    multiplier: E
    holonomic: bool = True
    of: str = ""


@dataclass(frozen=True)
class Model(Generic[E]):
    """A mechanical system over the algebra ``algebra``.

    ``q`` and ``v`` are the symbols of the coordinates and their velocities (``theta``, ``theta_dot``),
    ``parameters`` the parameters' symbols by name, ``time`` the symbol ``t``. With a given ``lagrangian``
    there are no particles and ``potential`` is zero; otherwise ``lagrangian`` is None and
    L = sum m v^2/2 - ``potential``. ``generalized_forces[k]`` and ``dissipation`` are zero where not given.
    ``families`` says which names belong together, by section of the file and name. ``redundant`` are
    constraints that follow from the others: the equations of motion go without them. ``spec`` is what the
    model was built from. ``replaced`` are coordinates of the file as functions of others that replace them;
    a generalized force on one of them acts on a particle without mass that has it as its position.
    ``edges`` are positive where all functions of the file have values (see ``model.edges``).
    """

    name: str
    algebra: Algebra[E]
    coordinates: tuple[str, ...]
    time: E
    q: tuple[E, ...]
    v: tuple[E, ...]
    parameters: Mapping[str, E]
    particles: tuple[Particle[E], ...]
    potential: E
    lagrangian: E | None
    generalized_forces: tuple[E, ...]
    dissipation: E
    observables: Mapping[str, E]
    families: Mapping[str, Mapping[str, Family]] = field(default_factory=dict)
    events: tuple[Event[E], ...] = ()
    edges: tuple[E, ...] = ()
    constraints: tuple[Constraint[E], ...] = ()
    spec: Spec | None = None
    replaced: Mapping[str, E] = field(default_factory=dict)
    redundant: tuple[Constraint[E], ...] = ()
