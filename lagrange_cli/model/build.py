"""``Spec`` to ``Model`` over any algebra."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.algebra import Algebra, E, Undecided
from lagrange_cli.expression.syntax import ends_somewhere, parts
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.constraints import built_constraints
from lagrange_cli.model.forces.law import Action
from lagrange_cli.model.model import Event, Model, Particle
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.content import written
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Spec


def build_model(spec: Spec, algebra: Algebra[E]) -> Model[E]:
    """The system's expressions over ``algebra``, with dr/dt by the chain rule.

    Raises:
        SpecError: where the algebra finds a constant that does not exist, such as 1/0.
    """
    scope = Scope(spec, algebra)
    zero = algebra.number("0")
    masses = [(name, scope.scalar(spec.masses[name]), scope.velocity(name)) for name in spec.embedding]
    potential = scope.total([scope.scalar(term) for term in spec.potential.values()])
    lagrangian = None if spec.lagrangian is None else scope.scalar(spec.lagrangian)
    constraints = built_constraints(scope)
    action = action_of(scope)
    return Model(
        name=spec.name,
        algebra=algebra,
        coordinates=tuple(coordinate.name for coordinate in spec.coordinates),
        time=scope.time,
        q=scope.q,
        v=scope.v,
        parameters=scope.parameters,
        particles=(
            *(
                Particle(name, mass, scope.values[name], velocity, action.on_particles.get(name, ()))
                for name, mass, velocity in masses
            ),
            *rotating(scope, action),
            *(
                Particle(name, zero, (scope.replaced[name],), (scope.values[velocity_name(name)],), (force,))
                for name, force in action.generalized.items()
                if name in scope.replaced
            ),
        ),
        potential=potential,
        lagrangian=lagrangian,
        generalized_forces=tuple(action.generalized.get(one.name, zero) for one in spec.coordinates),
        dissipation=zero if action.dissipation is None else action.dissipation,
        observables={name: scope.scalar(expression) for name, expression in spec.observables.items()},
        families=spec.families,
        events=tuple(built_events(scope)),
        edges=tuple(edges_in(scope)) if isinstance(algebra, Undecided) else (),
        constraints=tuple(one for one in constraints if one.name not in spec.left_out),
        redundant=tuple(one for one in constraints if one.name in spec.left_out),
        spec=spec,
        replaced=scope.replaced,
    )


def edges_in(scope: Scope[E]) -> Iterable[E]:
    """What is positive within the domains of all functions that the equations of motion are made of."""
    spec = scope.spec
    sections = (spec.all_constraints, spec.definitions)
    every = chain(spec.in_motion(written), *map(written, sections))
    if not any(ends_somewhere(one) for each in every for one in parts(each.tree)):
        return ()
    from lagrange_cli.model.edges import built_edges

    return built_edges(scope)


def rotating(scope: Scope[E], action: Action[E]) -> list[Particle[E]]:
    """The particles that stand for the rotation of bodies."""
    if not scope.spec.bodies:
        return []
    from lagrange_cli.model.rigid_body import carriers

    return [one for name in scope.spec.bodies for one in carriers(scope, name, action.torques.get(name, ()))]


def built_events(scope: Scope[E]) -> Iterator[Event[E]]:
    """The events over the algebra.

    Raises:
        SpecError: where the argument of one turns out to be the same at all states.
    """
    varying = {scope.time, *scope.q, *scope.v}
    for name, event in scope.spec.events.items():
        argument = scope.scalar(event.when)
        found = scope.algebra.symbols(argument)  # multipliers among them are in scope from here on
        if varying.isdisjoint(found) and set(scope.multipliers).isdisjoint(found):
            raise never_changes(scope.spec, name)
        changes = {target: scope.scalar(value) for target, value in event.changes.items()}
        yield Event(name, argument, event.direction, event.stops, changes)


def never_changes(spec: Spec, name: str, what: str = "never changes") -> SpecError:
    """The error of an event whose expression is the same at all states."""
    message = f"event '{name}' needs an expression that becomes 0, but this one {what}"
    hint = "let it depend on a coordinate, a velocity or t"
    return Source(spec.filename, spec.text).error(spec.events[name].when.place, message, hint)


def action_of(scope: Scope[E]) -> Action[E]:
    """All forces besides the potential."""
    if not scope.spec.forces:
        return Action()
    from lagrange_cli.model.forces.table import FORCES  # which most short runs do not need

    return added(scope, (FORCES[key].act(scope, given) for key, given in scope.spec.forces.items()))


def added(scope: Scope[E], actions: Iterable[Action[E]]) -> Action[E]:
    """The sum of all forces."""
    on_particles: dict[str, tuple[E, ...]] = {}
    torques: dict[str, tuple[E, ...]] = {}
    generalized: dict[str, E] = {}
    dissipation: list[E] = []
    for action in actions:
        for name, force in action.on_particles.items():
            before = on_particles.get(name)
            pairs = zip(before, force, strict=True) if before else ()
            on_particles[name] = tuple(scope.total([*pair]) for pair in pairs) or force
        torques |= action.torques
        for name, given in action.generalized.items():
            generalized[name] = scope.total([generalized[name], given]) if name in generalized else given
        dissipation += [] if action.dissipation is None else [action.dissipation]
    return Action(on_particles, generalized, scope.total(dissipation) if dissipation else None, torques)
