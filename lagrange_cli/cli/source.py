"""From what the user typed for a system to its ``Spec``, and to its equations of motion."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from lagrange_cli.cli import shipped
from lagrange_cli.cli.console import STANDARD_INPUT, display_name
from lagrange_cli.errors import (
    FileError,
    NotReal,
    Problem,
    SingularCoordinate,
    SpecError,
    TooLarge,
    UsageError,
)
from lagrange_cli.limits import whole

if TYPE_CHECKING:
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import Spec

Numbers = TypeVar("Numbers")


def read_system(system: str, sizes: Mapping[str, str] | None = None) -> Spec:
    """Read and check a system file; ``sizes`` are those of ``--size``.

    Raises ``FileError`` where the file cannot be read and ``SpecError`` where it is wrong.
    """
    spec, _ = read_run(read_bytes(system), system, sizes, lambda spec, problems: None)
    return spec


def read_run(
    content: bytes,
    system: str,
    sizes: Mapping[str, str] | None,
    numbers: Callable[[Spec, Problems], Numbers],
) -> tuple[Spec, Numbers]:
    """A system and the numbers that it is run with, which ``numbers`` finds.

    All commands read a file in this way, so that none accepts what another refuses. The problems of the file,
    of its ``solve`` section and those that ``numbers`` adds are shown together.

    Raises ``SpecError``; ``UsageError`` where the file is right and the command line is not.
    """
    from lagrange_cli.run.settings import check_defaults
    from lagrange_cli.spec.read import examine

    spec, problems = examine(content, display_name(system), sizes)
    check_defaults(spec, problems)
    try:
        found = numbers(spec, problems)
    except UsageError:
        problems.stop_if_any()
        raise
    problems.stop_if_any()
    return spec, found


def derive_system(spec: Spec, *, exact: bool = False, portable: bool = False) -> Residual:
    """The equations of motion over the expression graph; if ``exact``, no number in them is
    rounded, if ``portable``, each in the same way everywhere.

    Raises ``SpecError`` at the coordinate that no kinetic energy depends on, if there is one.
    """
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model

    algebra = GraphAlgebra()
    if exact:
        from lagrange_cli.expression.exact import ExactGraphAlgebra

        algebra = ExactGraphAlgebra()
    elif portable:
        from lagrange_cli.expression.exact import PortableGraphAlgebra

        algebra = PortableGraphAlgebra()
    with located(spec):
        count = len(spec.coordinates)
        algebra.graph.work.charge(count**2, f"a mass matrix of {count} coordinates")
        return derive(build_model(spec, algebra))


@contextmanager
def located(spec: Spec) -> Iterator[None]:
    """Give what is found wrong in the course of deriving its place in the file."""
    try:
        yield
    except SingularCoordinate as error:
        from lagrange_cli.expression.vocabulary import velocity_name
        from lagrange_cli.spec.source import Source

        place = next(each.place for each in spec.coordinates if each.name == error.coordinate)
        hint = "use it in 'embedding', or leave it out"
        if spec.lagrangian is not None:
            velocity = velocity_name(error.coordinate)
            hint = f"let 'lagrangian' contain {velocity}**2, or leave the coordinate out"
        raise Source(spec.filename, spec.text).error(place, str(error), hint) from error
    except NotReal as error:
        raise SpecError(spec.filename, [Problem(0, 0, error.message, hint=error.hint)]) from error
    except TooLarge as error:
        from lagrange_cli.model.largest import largest_expression
        from lagrange_cli.spec.source import Source

        message, hint = error.message, error.hint
        found = largest_expression(spec)
        if found is None:
            raise SpecError(spec.filename, [Problem(0, 0, message, hint=hint)]) from error
        message += f"; this expression has {found.size} terms and factors with its definitions written out"
        raise Source(spec.filename, spec.text).error(found.place, message, hint) from error


def read_bytes(system: str) -> bytes:
    """The content of the file, or of standard input, up to one byte more than the reader accepts."""
    if system == STANDARD_INPUT:
        if sys.stdin is None or sys.stdin.closed:
            raise FileError("standard input is closed: give the name of a system file")
        return sys.stdin.buffer.read(whole("bytes") + 1)
    try:
        with Path(system).open("rb") as file:
            return file.read(whole("bytes") + 1)
    except FileNotFoundError as error:
        raise FileError(f"{system}: no such file{shipped_hint(system)}") from error
    except OSError as error:
        if Path(system).is_dir():  # no permission to read it is what Windows says
            raise FileError(f"{system} is a directory, not a system file") from error
        raise FileError(f"{system} could not be read: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in the name
        raise UsageError(f"{system!r} is not the name of a file: {error}") from error


def shipped_hint(system: str) -> str:
    """How to get the shipped system that was perhaps meant, or an empty text."""
    name = Path(system).stem
    if name not in shipped.names():
        return ""
    return f"\n  there is an example system of that name: lagrange systems {name} > {name}.yaml"
