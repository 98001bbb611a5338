"""Energies that jump with the parameters of a run, with those of a member, or with those that an action sets:
the force there is infinite, and no motion is defined."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.records import replace
from lagrange_cli.run.derive import located
from lagrange_cli.spec.content import groups_by_name, names_of, statements, written
from lagrange_cli.spec.spec import distinct
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.model.model import Model
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Spec

REMEMBERED = 1024
"""Values that actions set, of which it is remembered whether an energy jumps with them."""


def check_energies(spec: Spec, parameters: Mapping[str, float]) -> None:
    """Raise ``SpecError`` if an energy jumps with these values of the parameters."""
    if may_switch(spec) and not families_continuous(spec, parameters):
        from lagrange_cli.mechanics.switching.jumps import refuse_jumps_in_numbers

        with located(spec):
            refuse_all_jumps(spec)
            refuse_jumps_in_numbers(known(spec, parameters))


def check_members(spec: Spec, values: EnsembleValues) -> None:
    """Raise ``SpecError`` if an energy jumps with the values that a member has."""
    if not may_switch(spec) or families_continuous(spec):
        return
    from lagrange_cli.mechanics.switching.jumping_values import jumps_may_depend_on, may_jump
    from lagrange_cli.mechanics.switching.jumps import refuse_jumps_in_numbers

    with located(spec):
        model = refuse_all_jumps(spec)
        if not jumps_may_depend_on(model, values.differing):
            refuse_jumps_in_numbers(known(spec, values.of(0).parameters))
            return
        for member in may_jump(model, values.parameters, values.members).nonzero()[0].tolist():
            own = known(spec, values.of(member).parameters)
            refuse_jumps_in_numbers(own, f"member {member}")


def parameters_set(spec: Spec) -> set[str]:
    """The parameters that events set."""
    given = names_of(spec.parameters)
    events = groups_by_name(spec.events).values()
    acting = (
        one for one in events if any(x.key.name in given.bases for y in statements(one) for x in y.sets)
    )
    members = (event for one in acting for event in (one if isinstance(one, WrittenFamily) else [one]))
    return {name for event in members for name in event.changes if name in given}


def with_actions_judged(spec: Spec, prepared: Prepared) -> Prepared:
    """A check that ends a motion before an action that sets parameters with which an energy jumps."""
    names = parameters_set(spec)
    if not names or not may_switch(spec) or families_continuous(spec):
        return prepared
    from lagrange_cli.integrate.methods.taylor import TaylorMethod
    from lagrange_cli.mechanics.switching.jumping_values import jumps_may_depend_on

    if not isinstance(prepared.follower, TaylorMethod) or not jumps_may_depend_on(symbolic(spec), names):
        return prepared
    return replace(prepared, follower=replace(prepared.follower, jumping=judge(spec, prepared)))


def judge(spec: Spec, prepared: Prepared) -> Callable[[Array], str]:
    """What finds the energy that jumps with values of a program's parameters (see ``Judge``)."""
    from lagrange_cli.mechanics.switching.jumps import refuse_jumps_in_numbers

    names, found = prepared.machine.program.parameters, dict[tuple[float, ...], str]()

    def jumping(parameters: Array) -> str:
        values = tuple(parameters[: len(names)].tolist())
        if values not in found:
            if len(found) == REMEMBERED:
                found.clear()
            try:
                refuse_jumps_in_numbers(known(spec, dict(zip(names, values))))
                found[values] = ""
            except InfiniteForce as error:
                found[values] = error.name or error.key
        return found[values]

    return jumping


def may_switch(spec: Spec) -> bool:
    """Whether an energy or an event is written with a function that has jumps, or a position or a constraint
    with one that has kinks."""
    from lagrange_cli.expression.syntax import calls, plain_names
    from lagrange_cli.expression.vocabulary import KINKED

    definitions = [*written(spec.definitions)]
    energies = [*written(spec.potential), *([] if spec.lagrangian is None else [spec.lagrangian])]
    energies += [*written(spec.forces.get("dissipation", {})), *definitions]
    energies += [event.when for event in written(spec.events)]
    if any(calls(one.tree, ("where", "sign")) for one in distinct(energies)):
        return True
    places = [*written(spec.embedding), *written(spec.constraints), *written(spec.nonholonomic)]
    places += [x for body in spec.bodies.values() for x in body.expressions]
    defined = groups_by_name(spec.definitions).keys()
    if any(plain_names(one.tree) & defined for one in distinct(places)):
        places += definitions
    return any(calls(one.tree, KINKED) for one in distinct(places))


def families_continuous(spec: Spec, parameters: Mapping[str, float] | None = None) -> bool:
    """Whether what families have in common shows that nothing jumps, with these parameters or with any."""
    if not spec.coordinate_families:
        return False
    from lagrange_cli.families.continuity import continuous

    return continuous(spec, parameters)


def refuse_all_jumps(spec: Spec) -> Model[Node]:
    """Raises ``InfiniteForce`` for what jumps whatever the parameters are; gives the model that has them."""
    from lagrange_cli.mechanics.switching.jumps import refuse_jumps

    model = symbolic(spec)
    refuse_jumps(model)
    return model


def symbolic(spec: Spec) -> Model[Node]:
    """The model with symbols for parameters."""
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.model.build import build_model

    return build_model(spec, GraphAlgebra())


def known(spec: Spec, parameters: Mapping[str, float]) -> Model[Node]:
    """The model with these numbers in place of them."""
    from lagrange_cli.expression.graph_algebra import KnownParameters
    from lagrange_cli.model.build import build_model

    return build_model(spec, KnownParameters(parameters))
