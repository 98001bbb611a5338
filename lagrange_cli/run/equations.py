"""``equations``: the printed equations of motion."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import LagrangeError, SpecError, TooLargeSystem
from lagrange_cli.expression.syntax import names
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.derive import graph_model, located
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node
    from lagrange_cli.limits import Work
    from lagrange_cli.model.model import Model
    from lagrange_cli.run.coordinates import Covariance
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.equations import Conserved, Equations

FORMATS = ("text", "unicode", "latex", "json", "python")
STEPS_A_PAIR = 150
"""Steps of work that each entry of the mass matrix takes at least."""
STEPS_A_MEETING = 60
"""Steps that each two coordinates take at least which move the same component of a particle: of 70 beads in
a straight line each took 106, of fewer ones more."""
EMPTY: Mapping[str, str] = {}
FORMS = ("lagrange", "explicit", "hamilton", "matrix", "reactions", "vakonomic")


@dataclass(frozen=True)
class Derived:
    """The equations of motion of a system, derived by computer algebra; ``work`` bounds what is done with
    them."""

    spec: Spec
    equations: Equations
    work: Work
    covariance: Covariance | None = None
    """How they compare with those in the coordinates of the file, where these have been changed."""
    original: Spec | None = None
    """The system in the coordinates of the file, likewise."""
    coordinates: str = ""
    """The name of the transformation, likewise."""

    @contextmanager
    def bounded(self) -> Iterator[None]:
        """A context for work on them; raises ``SpecError`` where it is too much."""
        from lagrange_cli.symbolic.work import counting

        with located(self.spec), counting(self.work):
            yield


@dataclass(frozen=True)
class Begun:
    """Equations of motion whose derivation has begun: the system without constraints that depend on others,
    its model, and the energies and momenta that are ``noted`` by name so far."""

    spec: Spec
    model: Model[Any]
    noted: dict[str, Any]


def derive(
    spec: Spec,
    stage: Stage = untimed,
    overrides: Mapping[str, str] = EMPTY,
    most: float = math.inf,
    coordinates: str = "",
    begins: Callable[[Begun], None] | None = None,
    suits: Callable[[Equations], None] | None = None,
) -> Derived:
    """Derive the equations of motion for printing; ``overrides`` are values by name, as ``--set`` has them.
    It takes ``most`` steps of work (``limits.Work``). They are in the ``coordinates`` of a transformation of
    the file if one is named. What ``begins`` is told may be of use where they are too long. ``suits`` may
    refuse them before it is known what they conserve.

    Raises ``SpecError`` where there are none, or they are too large; ``UsageError`` where there is no such
    transformation.
    """
    if spec.first_order:
        from lagrange_cli.run.massless import written_out

        spec = written_out(spec)
    if coordinates:
        return derive_in(coordinates, spec, stage, overrides)
    from lagrange_cli.expression.exact import ExactGraphAlgebra
    from lagrange_cli.expression.symbolic import SympyAlgebra
    from lagrange_cli.limits import Work
    from lagrange_cli.model.build import build_model
    from lagrange_cli.symbolic.derive import derive_equations
    from lagrange_cli.symbolic.work import counting

    work = Work(most)
    check_printed(spec)
    with located(spec):
        work.foresee(least_steps(spec))
        work.foresee(STEPS_A_MEETING * meetings(spec))
    spec = spec if spec.replaced else independent(spec, overrides)
    with stage("derive"), located(spec), counting(work):
        _refuse(spec)
        model, noted = build_model(spec, SympyAlgebra()), dict[str, Any]()
        if begins is not None:
            begins(Begun(spec, model, noted))
        equations = derive_equations(model, noted)
        if suits is not None:
            suits(equations)
        further = further_conserved(graph_model(spec, ExactGraphAlgebra()), equations)
        conserved = (*equations.conserved, *further)
        quantities = {each.quantity for each in further}
        changing = tuple(each for each in equations.changing if each.quantity not in quantities)
        freedom = spec.degrees_of_freedom
        told = replace(equations, conserved=conserved, changing=changing, degrees_of_freedom=freedom)
        return Derived(spec, told, work)


def least_steps(spec: Spec) -> int:
    """The steps of work that the mass matrix takes at least: known without reading an expression."""
    return STEPS_A_PAIR * len(spec.coordinates) ** 2


def meetings(spec: Spec) -> int:
    """The pairs of coordinates that move the same component of a particle, counted for each component: the
    terms that entries of the mass matrix are made of."""
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.model.scope import Scope

    scope = Scope(spec, GraphAlgebra())
    components = (one for position in spec.embedding.values() for one in scope.vector(position))
    return sum(sum(one in scope.rates for one in scope.algebra.symbols(each)) ** 2 for each in components)


def _refuse(spec: Spec) -> None:
    """Raise the errors that ``check`` and ``solve`` find and the derivation of the printed equations does
    not."""
    jumping = re.search(r"\b(where|sign|abs|min|max|sqrt|norm)\b", spec.text)
    if not (jumping or spec.events or spec.bodies):
        return
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.model.build import build_model

    model = build_model(spec, GraphAlgebra())
    if jumping:
        from lagrange_cli.mechanics.switching.jumps import refuse_jumps

        refuse_jumps(model)
    if spec.events:
        from lagrange_cli.mechanics.switching.unchanging import refuse_unchanging

        refuse_unchanging(model)
    if spec.bodies:
        from lagrange_cli.mechanics.constrained.thin import refuse_idle

        refuse_idle(model)


def derive_in(coordinates: str, spec: Spec, stage: Stage, overrides: Mapping[str, str]) -> Derived:
    """The equations of motion in the coordinates of a transformation, compared with those of the file."""
    from lagrange_cli.run.coordinates import covariance, in_coordinates

    spec = independent(spec, overrides)
    derived = derive(in_coordinates(spec, coordinates), stage)
    with stage("compare"), derived.bounded():
        compared = covariance(spec, derived.spec, derived.equations, overrides)
    return replace(derived, covariance=compared, original=spec, coordinates=coordinates)


def further_conserved(model: Model[Node], equations: Equations) -> list[Conserved]:
    """Conserved quantities besides h and momenta of cyclic coordinates; ``model`` is that of the
    equations."""
    from lagrange_cli.mechanics.conservation import conservation
    from lagrange_cli.mechanics.conserved.symmetries import symmetries, total_energy
    from lagrange_cli.symbolic.equations import Conserved
    from lagrange_cli.symbolic.from_graph import from_graph
    from lagrange_cli.symbolic.order import Role
    from lagrange_cli.symbolic.textbook import neat

    known = conservation(model)[1]
    every = [*symmetries(model, known)]
    if model.spec is not None and any(any(names(one.value.tree)) for one in model.spec.parameters):
        from lagrange_cli.mechanics.conserved.related import related  # what formulas of parameters cause

        every += related(model, known, every)
    found = []
    if model.constraints and any(each.quantity == "T + U" for each in equations.changing):
        every += total_energy(model)
    for one in every:
        each, expression = one.conserved, from_graph(one.node)
        if expression is not None:
            expression = neat(expression, equations.order, Role.COORDINATE)
            found.append(Conserved(each.quantity, expression, each.because, each.breaks))
    return found


def independent(spec: Spec, overrides: Mapping[str, str]) -> Spec:
    """The system with constraints left out that depend on others at the start; as it is where there is no
    consistent one."""
    if not spec.all_constraints:
        return spec
    from lagrange_cli.run.start import consistent_values
    from lagrange_cli.spec.values import resolve_values

    with suppress(LagrangeError):
        values = resolve_values(spec, dict(overrides))
        return consistent_values(spec, values, spec.solve.start or 0.0, overrides)[0]
    return spec


def check_printed(spec: Spec) -> None:
    """Raise ``SpecError`` for a system too large for its equations to be read, before any work is done."""
    from lagrange_cli.limits import way_out, whole
    from lagrange_cli.model.largest import largest_expression
    from lagrange_cli.spec.source import Source

    try:
        found = largest_expression(spec)
    except SpecError as error:  # the file is right otherwise: it has been read
        raise TooLargeSystem(error.filename, [*error.problems]) from error
    if found is not None and found.size > whole("printed"):
        problem = Source(spec.filename, spec.text).problem(
            found.place,
            f"this expression has {found.size} terms and factors with its definitions expanded: more than "
            f"'equations' prints ({whole('printed')})",
            f"'check' and 'solve' may work nevertheless, {way_out('printed')}",
        )
        raise TooLargeSystem(spec.filename, [problem])


def as_data(derived: Derived, form: str, parameters: Mapping[str, float]) -> dict[str, Any]:
    """The equations in terms of JSON; ``form`` is one of ``FORMS``."""
    from lagrange_cli.symbolic.data import as_data

    with derived.bounded():
        return as_data(of_form(derived, form), form, parameters)


def of_form(derived: Derived, form: str) -> Equations:
    """The equations with what a form needs besides."""
    if form != "reactions":
        return derived.equations
    from lagrange_cli.run.reactions import with_reactions

    return with_reactions(derived.spec, derived.equations)


def as_written(derived: Derived, format_: str, form: str, parameters: Mapping[str, float]) -> str:
    """The equations in one of the ``FORMATS`` other than JSON; ``form`` is one of ``FORMS``."""
    with derived.bounded():
        equations = of_form(derived, form)
        if format_ == "python":
            from lagrange_cli.symbolic.source import as_python

            return as_python(equations, form, parameters)
        if format_ == "latex":
            from lagrange_cli.symbolic.latex import as_latex

            return as_latex(equations, form)
        from lagrange_cli.symbolic.layouts import as_text, as_unicode

        return {"text": as_text, "unicode": as_unicode}[format_](equations, form)


def as_page(derived: Derived) -> str:
    """The equations as a part of a web page: HTML in which every text is escaped."""
    with derived.bounded():
        from lagrange_cli.symbolic.mathml import as_mathml

        return as_mathml(derived.equations)
