"""From the content of a system file to its ``Spec``, and to its equations of motion.

Every mistake is shown at its place in the file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from lagrange_cli.errors import (
    InfiniteForce,
    NotLinear,
    NotReal,
    Problem,
    SingularCoordinate,
    SpecError,
    Spinning,
    TooLarge,
    TooLargeSystem,
    TooManyNumbers,
    Undetermined,
    UsageError,
)
from lagrange_cli.run.settings.settings import check_defaults
from lagrange_cli.spec.content import written
from lagrange_cli.spec.formulation import may_have_massless
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.expression.node import Node
    from lagrange_cli.limits import Work
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.model.model import Model
    from lagrange_cli.run.foresight import Measure
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import Place, Spec

FEW = 30
"""The number of coordinates up to which fractions take no noticeable time."""
MANY = 50
"""Coordinates from which on it is told what members are written out for."""
Numbers = TypeVar("Numbers")
Examine: TypeAlias = "Callable[[bytes, str, Mapping[str, str] | None], tuple[Spec, Problems]]"
"""Reads a file, as ``spec.read.examine`` does."""


def read_run(
    content: bytes,
    filename: str,
    sizes: Mapping[str, str] | None,
    numbers: Callable[[Spec, Problems], Numbers],
    read: Examine | None = None,
) -> tuple[Spec, Numbers]:
    """The system that the ``content`` of a file describes, and the numbers that it is run with.

    ``numbers`` finds them in the spec, and adds to the problems what is wrong with them; ``sizes`` replace
    those of the file; messages call the file ``filename``. All commands read a file in this way, so that none
    accepts what another refuses. ``read`` stands for ``spec.read.examine``, where files are kept that have
    been read.

    Raises:
        SpecError: all problems of the file, of its ``solve`` section, and those that ``numbers`` adds.
        UsageError: the file is right, but the request is not.
    """
    from lagrange_cli.spec.defaults import with_times

    if read is None:
        from lagrange_cli.spec.read import examine

        read = examine
    spec, problems = read(content, filename, sizes)
    if not problems.found and may_have_massless(spec):
        from lagrange_cli.run.massless import with_equations_of_the_massless

        spec = with_equations_of_the_massless(spec)
    check_defaults(spec, problems)
    try:
        found = numbers(spec, problems)
    except UsageError:
        problems.stop_if_any()
        raise
    if spec.solve.times:
        spec = with_times(spec, getattr(found, "times", {}), problems)
        check_defaults(spec, problems)
    problems.stop_if_any()
    return spec, found


def derive_system(
    spec: Spec,
    *,
    exact: bool = False,
    portable: bool = False,
    resting: bool = False,
    foresee: Callable[[Model[Node]], object] | None = None,
    measures: Callable[[], Sequence[Measure]] = list,
) -> Residual:
    """The equations of motion over the expression graph.

    If ``exact``, no number in them is rounded, nor where ``keeps_decimals`` asks for it; if ``portable``,
    all are rounded alike on every machine.
    If ``resting``, they hold for motions that rest at an event, too. ``foresee`` may refuse a model before
    its equations are derived, and the ``measures`` a large one from smaller ones.

    Raises ``SpecError`` if there are none, as where the kinetic energy does not depend on a velocity.
    """
    from lagrange_cli.run.foresight import foresee_sizes

    algebra = algebra_of(spec, exact=exact, portable=portable)

    def derive_smaller(smaller: Spec, most: int) -> tuple[Work, Residual]:
        numbers = algebra()
        work = numbers.graph.work
        work.most = min(work.most, most)
        return work, _derived(smaller, numbers, resting)

    with located(spec):
        foresee_sizes(spec, derive_smaller, measures)
        return _derived(spec, algebra(), resting, foresee)


def algebra_of(spec: Spec, *, exact: bool, portable: bool) -> type[GraphAlgebra]:
    """What the numbers of the equations are."""
    if portable and not exact:
        from lagrange_cli.expression.exact import PortableGraphAlgebra

        return PortableGraphAlgebra
    if exact or keeps_decimals(spec):
        from lagrange_cli.expression.exact import ExactGraphAlgebra

        return ExactGraphAlgebra
    from lagrange_cli.expression.graph_algebra import GraphAlgebra

    return GraphAlgebra


def _derived(
    spec: Spec, algebra: GraphAlgebra, resting: bool, foresee: Callable[[Model[Node]], object] | None = None
) -> Residual:
    """The equations with the numbers of an ``algebra``."""
    from lagrange_cli.mechanics.derive import derive

    if spec.first_order:
        from lagrange_cli.run.massless import written_out

        spec = written_out(spec)
    count, bound = len(spec.coordinates), len(spec.all_constraints)
    what = f"a mass matrix of {count} coordinates" + (f" and {bound} constraints" if bound else "")
    algebra.graph.work.charge((count + bound) ** 2 if bound else count, what)
    model = graph_model(spec, algebra)
    if foresee is not None:
        foresee(model)
    if resting and model.events:
        from lagrange_cli.mechanics.contacts import derive_with_contacts

        return derive_with_contacts(model)
    return derive(model)


def graph_model(spec: Spec, algebra: GraphAlgebra) -> Model[Node]:
    """The model over a graph; raises ``BeyondDoubles`` where a number of its expressions is no double."""
    from lagrange_cli.model.build import build_model

    model = build_model(spec, algebra)
    algebra.graph.check_numbers()
    return model


def keeps_decimals(spec: Spec) -> bool:
    """Whether the numbers in energies and forces should not be rounded before all is derived. The terms of a
    total time derivative cancel in the equations of motion only if products of decimals like 0.1 are exact;
    and (x - 0.1)/0.3 is 0 at the same place in every power and slope (see ``ExactGraph``)."""
    from lagrange_cli.expression.syntax import has_decimals

    if len(spec.coordinates) > FEW:
        return False
    lagrangian = () if spec.lagrangian is None else (spec.lagrangian,)
    forces = (one for given in spec.forces.values() for one in given.values())
    given = (*lagrangian, *spec.potential.values(), *forces, *written(spec.definitions))
    return any(has_decimals(one.tree) for one in distinct(given))


@contextmanager
def located(spec: Spec) -> Iterator[None]:
    """A context in which errors of the derivation become ``SpecError``, with their place in the file."""
    try:
        yield
    except SingularCoordinate as error:
        from lagrange_cli.expression.vocabulary import velocity_name
        from lagrange_cli.spec.problems import Problems
        from lagrange_cli.spec.source import Source

        problems = Problems(Source(spec.filename, spec.text))
        for each in spec.coordinates:
            if each.name in error.messages:
                hint = "let a position depend on it, or leave it out"
                if spec.lagrangian is not None:
                    velocity = velocity_name(each.name)
                    hint = f"let 'lagrangian' contain {velocity}**2, or leave the coordinate out"
                if error.together:
                    hint = "leave one of them out, or let constraints determine it"
                problems.add_once(each.place, error.messages[each.name], hint)
        raise SpecError(spec.filename, problems.found) from error
    except NotLinear as error:
        from lagrange_cli.spec.source import Source

        place, hint = spec.nonholonomic[error.constraint].place, "write one that is linear in the velocities"
        raise Source(spec.filename, spec.text).error(place, str(error), hint) from error
    except Spinning as error:
        from lagrange_cli.spec.source import Source

        way = f"'nonholonomic: {{spin: {error.body}.w3}}'"
        hint = f"write {way}, use angles that only give the direction of its axis, or give it a thickness"
        if error.only:
            hint = (
                "a rod lies along its third axis: with {euler: [a, pi/2, 0], sequence: zyx} it turns by a in "
            )
            hint += "the x-y plane"
        place = spec.bodies[error.body].place
        raise Source(spec.filename, spec.text).error(place, str(error), hint) from error
    except Undetermined as error:
        from lagrange_cli.spec.source import Source

        place = spec.all_constraints[error.constraint].place
        hint = "leave out a constraint that follows from the others, or the multiplier"
        raise Source(spec.filename, spec.text).error(place, str(error), hint) from error
    except InfiniteForce as error:
        from lagrange_cli.spec.source import Source

        hint = "let both sides be equal where the condition changes, or write a steep function, such as tanh"
        if error.kink:
            hint = "round it off, as max(0, x)**2 is, or let an event set velocities there"
        if error.key == "events":
            hint = "write what changes its sign there: x - 1 in place of sign(x - 1)"
        place = jumping(spec, error.key, error.name)
        raise Source(spec.filename, spec.text).error(place, str(error), hint) from error
    except NotReal as error:
        raise SpecError(spec.filename, [Problem(0, 0, error.message, hint=error.hint)]) from error
    except TooLarge as error:
        raise too_large(spec, error) from error


def too_large(spec: Spec, error: TooLarge) -> TooLargeSystem:
    """The error with the place of the largest expression of a file in which everything is written singly."""
    from lagrange_cli.model.largest import largest_expression
    from lagrange_cli.spec.source import Source

    message, hint = error.message, error.hint
    singly = not (isinstance(error, TooManyNumbers) or many_members(spec))
    found = largest_expression(spec) if singly else None
    if found is None:
        return TooLargeSystem(spec.filename, [Problem(0, 0, message, hint=hint)])
    message += f"; this expression has {found.size} terms and factors with its definitions expanded"
    problem = Source(spec.filename, spec.text).problem(found.place, message, hint)
    return TooLargeSystem(spec.filename, [problem])


def many_members(spec: Spec) -> bool:
    """Whether coordinates are families of many members: these make a system large, and no expression."""
    return bool(spec.coordinate_families) and len(spec.coordinates) >= MANY


def jumping(spec: Spec, key: str, name: str) -> Place:
    """Where it is written: the ``name`` of a section, or the first expression of a key that calls a function
    with a jump, or its first one."""
    from lagrange_cli.expression.syntax import calls

    if key == "events":
        return spec.events[name].when.place
    if name:
        section = spec.bodies if key == "embedding" and name in spec.bodies else getattr(spec, key)
        place: Place = section[name].place
        return place
    if key == "lagrangian":
        assert spec.lagrangian is not None
        return spec.lagrangian.place
    written = [*(spec.potential if key == "potential" else spec.forces[key]).values()]
    return next((one for one in written if calls(one.tree, ("where", "sign"))), written[0]).place
