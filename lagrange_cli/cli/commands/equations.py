"""``lagrange equations``: L, the equations of motion, and what is conserved and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.console import emit, emit_json, run_each, stem
from lagrange_cli.cli.options.shared import Given, given_options, systems_argument
from lagrange_cli.cli.progress import Waiting
from lagrange_cli.cli.source import read_system
from lagrange_cli.errors import TooLargeSystem, TooLong
from lagrange_cli.run.equations import FORMATS, FORMS

if TYPE_CHECKING:
    from lagrange_cli.run.coordinates import Covariance
    from lagrange_cli.run.equations import Begun
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.verify import Verification

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
    help="What to print: everything, the accelerations q_ddot alone, Hamilton's equations, M a = f, the "
    "forces of constraint on particles, or the vakonomic equations of nonholonomic constraints, which follow "
    "from Hamilton's principle and do not describe the motion.",
)
@click.option(
    "--coordinates",
    metavar="NAME",
    default="",
    help="Derive the equations in the coordinates of the transformation NAME of the file, and compare them "
    "with those in the file's own coordinates.",
)
@click.option(
    "--verify",
    "verifying",
    is_flag=True,
    help="Compare the printed equations with the compiled ones, and with those found by differentiating L "
    "directly, near the start, along the motion, and on both sides of switches and poles. The exit status is "
    f"{DIFFERS} if they differ by more than 1e-12.",
)
@given_options
def equations(
    systems: tuple[str, ...], format_: str | None, form: str, coordinates: str, verifying: bool, given: Given
) -> int:
    """Print the Lagrangian, the equations of motion, momenta, energy function and conserved quantities.

    Large families, such as a thousand bodies, are printed with their indices. What is too long to print
    is left out.

    \b
    lagrange equations pendulum.yaml
    lagrange equations pendulum.yaml --form hamilton --format latex
    lagrange equations pendulum.yaml --format python > pendulum.py
    """
    if given.as_json and format_ not in (None, "json"):
        raise click.UsageError(f"--json and --format {format_} contradict each other: give one of them")
    chosen = "json" if given.as_json else format_ or "text"
    many = len(systems) > 1 and chosen != "json"

    def show(system: str) -> int:
        status = show_system(system, given, chosen, form, coordinates, verifying=verifying)
        if many and system != systems[-1]:
            emit("")
        return status

    return run_each(systems, show, as_json=chosen == "json")


def show_system(
    system: str, given: Given, format_: str, form: str, coordinates: str, *, verifying: bool
) -> int:
    """Print one system's equations; returns the exit status."""
    from lagrange_cli.run.family_equations import data_of, derive_printed, written
    from lagrange_cli.spec.values import resolve_parameters

    waiting = Waiting(stem(system), quiet=given.quiet)
    spec, parameters = read_system(system, given, resolve_parameters, waiting.stage)
    begun: list[Begun] = []

    def suits(equations: Equations) -> None:
        if form == "explicit" and format_ not in ("json", "python"):
            from lagrange_cli.symbolic.report import refuse_unsolved

            refuse_unsolved(equations)

    try:
        derived = derive_printed(
            spec,
            form,
            waiting.stage,
            given.overrides,
            coordinates=coordinates,
            begins=begun.append,
            suits=suits,
        )
    except TooLargeSystem as error:
        from lagrange_cli.run.partial_equations import FORMATS as IN_PART
        from lagrange_cli.run.partial_equations import written_in_part

        readable = form == FORMS[0] and format_ in IN_PART and not (coordinates or verifying)
        if not (readable and begun and isinstance(error.__cause__, TooLong)):
            raise
        with waiting.stage("print"):
            text = written_in_part(begun[-1], format_)
        emit(text)
        return 0
    verification = None
    if verifying:
        with waiting.stage("verify"):
            from lagrange_cli.run.verification import verify_printed

            verification = verify_printed(derived, given.overrides)
    with waiting.stage("print"):
        if format_ == "json":
            data = data_of(derived, form, parameters)
        else:
            text = written(derived, format_, form, parameters)
    covariance = getattr(derived, "covariance", None)
    if format_ == "json":
        emit_json(data | covariant(covariance) | verdict(verification))
    else:
        for compared in (covariance, verification):
            if compared is not None and not (given.quiet and compared.agrees):
                text += f"\n\n{comment(format_)}{compared}"
        emit(text)
    agrees = all(one is None or one.agrees for one in (covariance, verification))
    return 0 if agrees else DIFFERS


def covariant(found: Covariance | None) -> dict[str, Any]:
    """The comparison with the file's coordinates for ``--json``."""
    if found is None:
        return {}
    return {"covariance": {"difference": found.difference, "states": found.states, "agrees": found.agrees}}


def comment(format_: str) -> str:
    """How a line is kept out of the way of a format."""
    return {"latex": "% ", "python": "# "}.get(format_, "")


def verdict(verification: Verification | None) -> dict[str, Any]:
    """The outcome of ``--verify`` for ``--json``."""
    if verification is None:
        return {}
    return {
        "verify": {
            "difference": verification.difference,
            "quantity": verification.quantity,
            "routes": verification.routes,
            "states": verification.states,
            "where": dict(verification.counted),
            "agrees": verification.agrees,
        }
    }
