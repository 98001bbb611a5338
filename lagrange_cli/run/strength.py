"""Whether the steps of a run must be proven because a singularity is so weak that a step might miss it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.syntax import Number, Tree, parts
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

ORDINARY = 1e-15
"""Where the product of the two smallest numbers, in units of the fastest velocity squared, is larger than
this, nothing is weak."""


def with_proofs(spec: Spec, settings: Settings, values: Iterator[Values]) -> Settings:
    """The settings, with steps that are proven if one of the motions needs it."""
    if settings.proven or settings.method != "taylor":
        return settings
    weak = any(suspicious(spec, one) and is_weak(spec, settings.start, one) for one in values)
    return replace(settings, proven=True) if weak else settings


def suspicious(spec: Spec, values: Values) -> bool:
    """Whether any number is so small that something may be weak."""
    forces = chain.from_iterable(map(written, spec.forces.values()))
    lagrangian = () if spec.lagrangian is None else (spec.lagrangian,)
    given = chain(lagrangian, written(spec.potential), forces, written(spec.definitions))
    numbers = chain(values.parameters.values(), *(literals(one.tree) for one in distinct(given)))
    smallest = sorted(abs(x) for x in numbers if x != 0)[:2]
    fastest = max((abs(v) for v in values.v), default=0.0)
    product = 1.0
    for x in smallest:
        product *= min(x, 1.0)
    return product <= ORDINARY * max(1.0, fastest * fastest)


def literals(tree: Tree) -> Iterator[float]:
    """The numbers that are written in an expression."""
    return (float(one.text) for one in parts(tree) if isinstance(one, Number))


def is_weak(spec: Spec, start: float, values: Values) -> bool:
    """Whether a singularity is weak where a motion begins."""
    from lagrange_cli.expression.graph_algebra import KnownParameters
    from lagrange_cli.mechanics.weakness import has_weak_singularity
    from lagrange_cli.model.build import build_model

    state = {TIME: start}
    for one, q, v in zip(spec.coordinates, values.q, values.v):
        state |= {one.name: q, velocity_name(one.name): v}
    try:
        return has_weak_singularity(build_model(spec, KnownParameters(values.parameters)), state)
    except SpecError:  # expressions without a value for these parameters are reported elsewhere
        return False
