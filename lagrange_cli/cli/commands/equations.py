"""``lagrange equations``: L, the equations of motion, and what is conserved and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.console import emit, emit_json, run_each, stem
from lagrange_cli.cli.options.shared import shared_options, systems_argument
from lagrange_cli.cli.report.progress import Waiting

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.verify import Verification

FORMATS = ("text", "unicode", "latex", "json", "python")
FORMS = ("lagrange", "explicit", "hamilton", "matrix")
DIFFERS = 4
"""Exit status where printed and compiled equations are not the same."""


@click.command("equations")
@systems_argument
@click.option(
    "--format",
    "format_",
    type=click.Choice(FORMATS),
    help="How to write the equations [text]. LaTeX needs the package amsmath.",
)
@click.option(
    "--form",
    type=click.Choice(FORMS),
    default="lagrange",
    show_default=True,
    help="What to print: everything, the accelerations q_ddot alone, Hamilton's equations, or M a = f.",
)
@click.option(
    "--verify",
    "verifying",
    is_flag=True,
    help="Compare the printed equations with the compiled ones at random states. The exit status is "
    f"{DIFFERS} if they differ by more than 1e-12.",
)
@shared_options
def equations(
    systems: tuple[str, ...],
    format_: str | None,
    form: str,
    verifying: bool,
    overrides: dict[str, str],
    sizes: dict[str, str],
    as_json: bool,
    quiet: bool,
) -> int:
    """Print the Lagrangian, the equations of motion, momenta, energy function and conserved quantities.

    \b
    lagrange equations pendulum.yaml
    lagrange equations pendulum.yaml --form hamilton --format latex
    lagrange equations pendulum.yaml --format python > pendulum.py
    """
    if as_json and format_ not in (None, "json"):
        raise click.UsageError(f"--json and --format {format_} contradict each other")
    chosen = "json" if as_json else format_ or "text"
    many = len(systems) > 1 and chosen != "json"

    def show(system: str) -> int:
        status = show_system(system, overrides, sizes, chosen, form, verifying=verifying, quiet=quiet)
        if many and system != systems[-1]:
            emit("")
        return status

    return run_each(systems, show, as_json=chosen == "json")


def show_system(
    system: str,
    overrides: dict[str, str],
    sizes: dict[str, str],
    format_: str,
    form: str,
    *,
    verifying: bool,
    quiet: bool,
) -> int:
    """Print one system's equations; returns the exit status."""
    from lagrange_cli.cli.source import located, read_bytes, read_run
    from lagrange_cli.expression.symbolic import SympyAlgebra
    from lagrange_cli.limits import Work
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.values import resolve_parameters
    from lagrange_cli.symbolic.derive import derive_equations
    from lagrange_cli.symbolic.work import counting

    waiting = Waiting(stem(system), quiet=quiet)
    with waiting.stage("reading the system file"):
        spec, parameters = read_run(
            read_bytes(system),
            system,
            sizes,
            lambda spec, problems: resolve_parameters(spec, overrides, problems),
        )
    check_printed(spec)
    work = Work()
    with waiting.stage("deriving the equations of motion"), located(spec), counting(work):
        derived = derive_equations(build_model(spec, SympyAlgebra()))
    with waiting.stage("comparing with the compiled equations"):
        verification = verify_system(spec, derived, overrides) if verifying else None
    if format_ == "json":
        from lagrange_cli.symbolic.data import as_data

        with waiting.stage("writing the equations"), located(spec), counting(work):
            data = as_data(derived, form, parameters)
        emit_json(data | verdict(verification))
    else:
        with waiting.stage("writing the equations"), located(spec), counting(work):
            text = written(derived, format_, form, parameters)
        if verification is not None and not (quiet and verification.agrees):
            text += f"\n\n{comment(format_)}{verification}"
        emit(text)
    return 0 if verification is None or verification.agrees else DIFFERS


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


def written(derived: Equations, format_: str, form: str, parameters: dict[str, float]) -> str:
    """The equations in one of the formats for people and programs other than JSON."""
    if format_ == "python":
        from lagrange_cli.symbolic.source import as_python

        return as_python(derived, form, parameters)
    from lagrange_cli.symbolic.latex import as_latex
    from lagrange_cli.symbolic.layouts import as_text, as_unicode

    return {"text": as_text, "unicode": as_unicode, "latex": as_latex}[format_](derived, form)


def comment(format_: str) -> str:
    """How a line is kept out of the way of a format."""
    return {"latex": "% ", "python": "# "}.get(format_, "")


def verify_system(spec: Spec, derived: Equations, overrides: dict[str, str]) -> Verification:
    """Hold the printed equations against the compiled ones; only this needs the compiler."""
    from lagrange_cli.cli.source import derive_system
    from lagrange_cli.integrate.single_state import compiled_values
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.verify import verify

    values = resolve_values(spec, overrides)
    return verify(derived, compiled_values(derive_system(spec)), values.parameters, values.q, values.v)


def verdict(verification: Verification | None) -> dict[str, Any]:
    """The outcome of ``--verify`` for ``--json``."""
    if verification is None:
        return {}
    return {
        "verify": {
            "difference": verification.difference,
            "quantity": verification.quantity,
            "states": verification.states,
            "agrees": verification.agrees,
        }
    }
