"""``equations``: the equations of motion as people read them, and their comparison with the compiled ones."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import derive_system, located
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.limits import Work
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.verify import Verification

FORMATS = ("text", "unicode", "latex", "json", "python")
FORMS = ("lagrange", "explicit", "hamilton", "matrix")


@dataclass(frozen=True)
class Derived:
    """The equations of motion of a system, derived by computer algebra; ``work`` bounds what is done with
    them."""

    spec: Spec
    equations: Equations
    work: Work

    @contextmanager
    def bounded(self) -> Iterator[None]:
        """A context for work on them; raises ``SpecError`` where it is too much."""
        from lagrange_cli.symbolic.work import counting

        with located(self.spec), counting(self.work):
            yield


def derive(spec: Spec, stage: Stage = untimed) -> Derived:
    """Derive the equations of motion, to be read.

    Raises ``SpecError`` where there are none, or they are too large.
    """
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.expression.symbolic import SympyAlgebra
    from lagrange_cli.limits import Work
    from lagrange_cli.mechanics.jumps import refuse_jumps
    from lagrange_cli.model.build import build_model
    from lagrange_cli.symbolic.derive import derive_equations
    from lagrange_cli.symbolic.work import counting

    check_printed(spec)
    work = Work()
    with stage("derive"), located(spec), counting(work):
        if re.search(r"\b(where|sign)\b", spec.text):
            refuse_jumps(build_model(spec, GraphAlgebra()))
        return Derived(spec, derive_equations(build_model(spec, SympyAlgebra())), work)


def check_printed(spec: Spec) -> None:
    """Raise ``SpecError`` for a system too large for its equations to be read, before any work is done."""
    from lagrange_cli.limits import way_out, whole
    from lagrange_cli.model.largest import largest_expression
    from lagrange_cli.spec.source import Source

    found = largest_expression(spec)
    if found is not None and found.size > whole("printed"):
        raise Source(spec.filename, spec.text).error(
            found.place,
            f"this expression has {found.size} terms and factors with its definitions written out: more than "
            f"'equations' prints ({whole('printed')})",
            f"'check' and 'solve' may work nevertheless, {way_out('printed')}",
        )


def as_data(derived: Derived, form: str, parameters: dict[str, float]) -> dict[str, Any]:
    """The equations in terms of JSON; ``form`` is one of ``FORMS``."""
    from lagrange_cli.symbolic.data import as_data

    with derived.bounded():
        return as_data(derived.equations, form, parameters)


def as_written(derived: Derived, format_: str, form: str, parameters: dict[str, float]) -> str:
    """The equations in one of the ``FORMATS`` other than JSON; ``form`` is one of ``FORMS``."""
    with derived.bounded():
        if format_ == "python":
            from lagrange_cli.symbolic.source import as_python

            return as_python(derived.equations, form, parameters)
        from lagrange_cli.symbolic.latex import as_latex
        from lagrange_cli.symbolic.layouts import as_text, as_unicode

        return {"text": as_text, "unicode": as_unicode, "latex": as_latex}[format_](derived.equations, form)


def verify_system(derived: Derived, overrides: Mapping[str, str]) -> Verification:
    """Compare the printed equations with the compiled ones at random states; only this needs the compiler."""
    from lagrange_cli.integrate.single_state import compiled_values
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.verify import verify

    values = resolve_values(derived.spec, dict(overrides))
    compiled = compiled_values(derive_system(derived.spec))
    return verify(derived.equations, compiled, values.parameters, values.q, values.v)
