"""``equations`` of large families, which are printed with their indices: no member is written out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import located
from lagrange_cli.run.equations import FORMS
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.families.description import FamilySystem
    from lagrange_cli.limits import Work
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.families.equations import FamilyEquations
    from lagrange_cli.symbolic.verify import Verification

INDEXED = FORMS[:2]
"""Forms in which families are printed with their indices."""


@dataclass(frozen=True)
class DerivedFamilies:
    """The equations of motion of a system of families; ``work`` bounds what is done with them."""

    system: FamilySystem
    equations: FamilyEquations
    work: Work

    @contextmanager
    def bounded(self) -> Iterator[None]:
        """A context for work on them; raises ``SpecError`` where it is too much."""
        from lagrange_cli.symbolic.work import counting

        with located(self.system.spec), counting(self.work):
            yield


def derive_families(spec: Spec, stage: Stage = untimed, most: float = math.inf) -> DerivedFamilies | None:
    """The equations of motion of a system that is one of families (``families.system``); None for any other.
    It takes ``most`` steps of work.

    Raises ``SpecError`` where they are too large.
    """
    if not spec.families.get("coordinates"):
        return None
    from lagrange_cli.families.system import family_system

    with stage("derive"), located(spec):
        system = family_system(spec)
        if system is None:
            return None
        from lagrange_cli.limits import Work
        from lagrange_cli.symbolic.families.equations import family_equations
        from lagrange_cli.symbolic.work import counting

        work = Work(most)
        with counting(work):
            equations = family_equations(system)
        return None if equations is None else DerivedFamilies(system, equations, work)


def families_as_data(derived: DerivedFamilies, parameters: Mapping[str, float]) -> dict[str, Any]:
    """The equations in terms of JSON."""
    from lagrange_cli.symbolic.families.report import as_data

    with derived.bounded():
        return as_data(derived.equations, parameters)


def families_as_written(
    derived: DerivedFamilies, format_: str, form: str, parameters: Mapping[str, float]
) -> str:
    """The equations in a format other than JSON; ``form`` is one of ``INDEXED``."""
    with derived.bounded():
        if format_ == "python":
            from lagrange_cli.symbolic.families.source import as_python

            return as_python(derived.equations, parameters)
        from lagrange_cli.symbolic.families.report import as_page

        return as_page(derived.equations, format_, form)


def verify_families(derived: DerivedFamilies, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations, read back, with those of the system and with the compiled ones."""
    from lagrange_cli.integrate.families import compiled_accelerations
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.families.verify import verify

    start = resolve_values(derived.system.spec, overrides)
    return verify(derived.system, derived.equations, compiled_accelerations(derived.system), start)
