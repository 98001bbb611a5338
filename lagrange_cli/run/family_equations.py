"""``equations`` of large families, which are printed with their indices: no member is written out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.errors import TooLargeSystem, UsageError
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.derive import located
from lagrange_cli.run.equations import EMPTY, FORMS, Derived, as_data, as_written, derive, least_steps
from lagrange_cli.run.equations import as_page as members_as_page
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.families.description import FamilySystem
    from lagrange_cli.limits import Work
    from lagrange_cli.run.equations import Begun
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.families.equations import FamilyEquations

INDEXED = FORMS[:5]
"""Forms in which families are printed with their indices."""
WITH_MATRIX = "explicit", "hamilton", "matrix"
"""Those of them that may contain the mass matrix."""
MANY = 50
"""Coordinates from which on families are printed so, where M is diagonal and constant."""
FEW = 4
"""Members of a family whose equations are short when they are written out."""


@dataclass(frozen=True)
class DerivedFamilies:
    """The equations of motion of a system of families; ``work`` bounds what is done with them."""

    system: FamilySystem
    equations: FamilyEquations
    work: Work
    constrained: Spec | None = None
    """The file, where it has constraints or events besides."""

    @property
    def spec(self) -> Spec:
        """The file."""
        return self.constrained or self.system.spec

    @contextmanager
    def bounded(self) -> Iterator[None]:
        """A context for work on them; raises ``SpecError`` where it is too much."""
        from lagrange_cli.symbolic.work import counting

        with located(self.spec), counting(self.work):
            yield


def derive_printed(
    spec: Spec,
    form: str,
    stage: Stage = untimed,
    overrides: Mapping[str, str] = EMPTY,
    *,
    coordinates: str = "",
    indexed: bool | None = None,
    begins: Callable[[Begun], None] | None = None,
    suits: Callable[[Equations], None] | None = None,
) -> Printed:
    """The equations of motion, with indices where families are large, or too large to be written out, or as
    ``indexed`` says.

    Raises ``SpecError`` and ``UsageError`` as ``derive`` does, and ``UsageError`` where families cannot be
    written with indices as is asked.
    """
    if indexed:
        found = None if coordinates else _of_form(derive_families(spec, stage, small=True), form)
        if found is None:
            raise UsageError(f"no equations with indices: {why_members(spec, form, coordinates)}")
        return found
    indexed = indexed is None and form in INDEXED and not coordinates
    found = _of_form(derive_families(spec, stage), form) if indexed else None
    if found is None:
        try:
            with by_members(spec, form, coordinates):
                return derive(spec, stage, overrides, coordinates=coordinates, begins=begins, suits=suits)
        except TooLargeSystem:
            found = _of_form(derive_families(spec, stage, small=True), form) if indexed else None
            if found is None:
                raise
    return found


def in_form(derived: Printed, form: str) -> Printed:
    """The same equations for another form, for which they may have to be written out."""
    if isinstance(derived, Derived):
        return derived
    found = _of_form(derived, form) if form in INDEXED else None
    return derive_printed(derived.spec, form) if found is None else found


def _of_form(derived: DerivedFamilies | None, form: str) -> DerivedFamilies | None:
    """The equations if they have a form with indices. Raises ``UsageError`` where they have it in no way."""
    if derived is None:
        return None
    from lagrange_cli.expression.indices import Unsuited
    from lagrange_cli.expression.syntax import ExpressionError
    from lagrange_cli.symbolic.families.frames import Split

    known = derived.equations
    if form == "hamilton" and known.first_order:
        from lagrange_cli.symbolic.hamilton import no_hamiltonian

        raise no_hamiltonian()
    try:
        with derived.bounded():
            if form == "hamilton" or (form in WITH_MATRIX and known.accelerations is None):
                from lagrange_cli.symbolic.families.derive import with_matrix

                known = with_matrix(known, derived.system, derived.spec, driving=form == "hamilton")
            if form == "hamilton":
                from lagrange_cli.symbolic.families.hamilton import hamilton_form

                hamilton_form(known)
            if form == "reactions":
                from lagrange_cli.symbolic.families.reactions import reactions_of

                known = replace(known, reactions=reactions_of(derived.system, derived.constrained))
    except (Unsuited, Split, ExpressionError, ArithmeticError):
        return None
    return replace(derived, equations=known)


def derive_families(
    spec: Spec, stage: Stage = untimed, most: float = math.inf, *, small: bool = False
) -> DerivedFamilies | None:
    """The equations of motion of a large system that is one of families (``families.system``), or a ``small``
    one; None for any other. It takes ``most`` steps of work.

    Raises ``SpecError`` where they are too large.
    """
    if not spec.coordinate_families:
        return None
    if small and spec.massless:
        from lagrange_cli.run.massless import in_first_order

        spec = in_first_order(spec)
    if spec.constrained and acting(spec):
        return None
    from lagrange_cli.families.system import family_system, without_constraints

    with stage("derive"), located(spec):
        small = small or max(len(spec.coordinates), len(spec.events)) >= MANY
        if small or spec.constrained:
            system = without_constraints(spec)
        else:
            system = family_system(replace(spec, events={}) if spec.events else spec)
        if system is None:
            return None
        if spec.constrained and system.joints is None and not small:
            return None
        from lagrange_cli.limits import Work
        from lagrange_cli.symbolic.families.derive import family_equations
        from lagrange_cli.symbolic.work import counting

        work = Work(most)
        with counting(work):
            equations = family_equations(system, spec)
        return (
            None
            if equations is None
            else DerivedFamilies(system, equations, work, spec if spec.constrained or spec.events else None)
        )


def acting(spec: Spec) -> bool:
    """Whether events set something."""
    return spec.acts


Printed: TypeAlias = "Derived | DerivedFamilies"


@contextmanager
def by_members(spec: Spec, form: str, coordinates: str) -> Iterator[None]:
    """A context in which the equations of a system are written out, member by member: what is too large for
    that is said to be, with the reason why it is done and a way out.

    Raises ``SpecError``.
    """
    try:
        yield
    except TooLargeSystem as error:
        if not spec.coordinate_families:
            raise
        first, *others = error.problems
        hint = f"{why_members(spec, form, coordinates)}: {smaller(spec)}"
        raise TooLargeSystem(error.filename, [replace(first, hint=hint), *others]) from error


def why_members(spec: Spec, form: str, coordinates: str) -> str:
    """Why the equations are not printed with indices."""
    from lagrange_cli.families.system import UNKNOWN, without_constraints

    if not spec.coordinate_families:
        return "no coordinate has an index"
    if coordinates:
        return "in other coordinates every member is written out"
    if form not in INDEXED:
        return f"--form {form} writes out every member"
    parts = [what for part, what in UNKNOWN.items() if getattr(spec, part)]
    if parts:
        return f"with {parts[-1]} every member is written out"
    found = without_constraints(spec)
    if spec.constrained and acting(spec):
        return "with constraints and events that set something every member is written out"
    if found is not None:
        return "its conditions are too irregular to be printed with indices, so every member is written out"
    if spec.forces and without_constraints(replace(spec, forces={})) is not None:
        return "its forces are of a kind that is not printed with indices, so every member is written out"
    kinds = "masses without kinks, or chains and trees of 12 coordinates or more"
    return f"every member is written out, since printing with indices needs {kinds}"


def smaller(spec: Spec) -> str:
    """How to write out fewer members."""
    sizes = [name for name, size in spec.sizes.items() if size > FEW]
    way = f"choose fewer, such as --size {sizes[0]}={FEW}" if sizes else "write a smaller system"
    return f"{way}; 'check' and 'solve' may work nevertheless"


def data_of(derived: Printed, form: str, parameters: Mapping[str, float]) -> dict[str, Any]:
    """The equations in terms of JSON; ``form`` is one of ``FORMS``, with which they have been derived."""
    if isinstance(derived, DerivedFamilies):
        return families_as_data(derived, parameters, form)
    with by_members(derived.spec, form, derived.coordinates):
        return as_data(derived, form, parameters)


def written(derived: Printed, format_: str, form: str, parameters: Mapping[str, float]) -> str:
    """The equations in a format other than JSON, likewise."""
    if isinstance(derived, DerivedFamilies):
        if format_ != "python" or (form != "reactions" and not derived.equations.first_order):
            return families_as_written(derived, format_, form, parameters)
        with by_members(derived.spec, form, ""):  # a module has the forces on all members, or the multipliers
            derived = derive(derived.spec)
    with by_members(derived.spec, form, derived.coordinates):
        return as_written(derived, format_, form, parameters)


def families_as_data(
    derived: DerivedFamilies, parameters: Mapping[str, float], form: str = FORMS[0]
) -> dict[str, Any]:
    """The equations in terms of JSON; ``form`` is one of ``INDEXED``."""
    from lagrange_cli.symbolic.families import data

    with derived.bounded():
        return data.as_data(derived.equations, parameters, form)


def families_as_written(
    derived: DerivedFamilies, format_: str, form: str, parameters: Mapping[str, float]
) -> str:
    """The equations in a format other than JSON; ``form`` is one of ``INDEXED``."""
    with derived.bounded():
        if format_ == "python":
            from lagrange_cli.symbolic.families.source import as_python

            return as_python(derived.equations, parameters, form)
        from lagrange_cli.symbolic.families.report import as_page

        return as_page(derived.equations, format_, form)


def as_page(spec: Spec, most: float) -> str:
    """The equations as a part of a web page, with indices where families are large; at most so many steps of
    work. Raises ``SpecError`` and ``TooLarge`` where they are too large."""
    from lagrange_cli.limits import Work

    found = derive_families(spec, most=most)
    if found is None:
        Work(most).foresee(least_steps(spec))
        return members_as_page(derive(spec, most=most))
    from lagrange_cli.symbolic.families.report import as_mathml

    with found.bounded():
        return as_mathml(found.equations)
