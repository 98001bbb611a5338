"""Which constraints on velocities are holonomic after all, as far as ``check`` can tell."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.limits import whole

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from lagrange_cli.expression.node import Node
    from lagrange_cli.mechanics.constrained.frobenius import Integrability
    from lagrange_cli.model.model import Model
    from lagrange_cli.spec.spec import Spec


def velocity_constraints(
    spec: Spec, model: Model[Node] | None, parameters: Mapping[str, float]
) -> tuple[Integrability | None, dict[str, str]]:
    """Which constraints on velocities and combinations are integrable, and what these keep constant; nothing
    where that takes too much work. Without a ``model`` of all members, families decide it."""
    if not spec.nonholonomic.keys() - spec.massless.keys():
        return None, {}
    from lagrange_cli.mechanics.constrained.frobenius import MOST
    from lagrange_cli.mechanics.variables import graph_of

    if model is None or len(model.q) >= MOST:
        from lagrange_cli.families import frobenius
        from lagrange_cli.families.system import any_family_system

        system = any_family_system(spec)
        if system is not None:
            return frobenius.integrability(system, parameters), {}
    if model is None:
        return None, {}

    work = graph_of(model).work
    with work.apart():
        return work.attempt(whole("work"), partial(integrable, model, parameters)) or (None, {})


def undecided(spec: Spec, found: Integrability | None) -> Iterator[str]:
    """What is not decided of constraints on velocities, in a sentence."""
    if not spec.nonholonomic.keys() - spec.massless.keys():
        return
    known = {} if found is None else found.alone
    if all(one is None for one in known.values()):
        yield "whether the constraints on velocities are integrable: that takes too much work"
    elif found is not None and found.together is None and not all(known.values()):
        yield "whether combinations of constraints on velocities are integrable: that takes too much work"


def integrable(
    model: Model[Node], parameters: Mapping[str, float]
) -> tuple[Integrability | None, dict[str, str]]:
    """The same, whatever work it takes."""
    from lagrange_cli.mechanics.constrained.frobenius import integrability, integrable_forms
    from lagrange_cli.mechanics.variables import graph_of

    found = integrability(model, parameters)
    integrals = {}
    for name, form in integrable_forms(model, found).items():
        from lagrange_cli.symbolic.integrals import integral_of

        integral = integral_of(graph_of(model), form, (*model.q, model.time))
        if integral is not None:
            integrals[name] = integral
    return found, integrals
