"""The text of a system file to a ``Spec``."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.spec.check import check
from lagrange_cli.spec.families import expand, resolve_sizes
from lagrange_cli.spec.nodes import compose, decode
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import read_draft
from lagrange_cli.spec.spec import Spec


def read_spec(text: bytes | str, filename: str, sizes: Mapping[str, str] | None = None) -> Spec:
    """Read and check a system file; ``filename`` is used in messages and for the default name.

    ``sizes`` replace those of the file, name to expression.

    Raises:
        SpecError: with every problem of the file, each with its place.
        UsageError: where ``sizes`` are not the file's, or no whole numbers greater than 0.
    """
    spec, problems = examine(text, filename, sizes)
    problems.stop_if_any()
    return spec


def examine(
    text: bytes | str, filename: str, sizes: Mapping[str, str] | None = None
) -> tuple[Spec, Problems]:
    """The same with all problems found; where there are any, the spec is what could be made out of the file.

    Raises:
        SpecError: where the file is not YAML, or so wrong that nothing else can be said of it.
        UsageError: as ``read_spec``.
    """
    source = decode(text, filename)
    problems = Problems(source)
    draft = read_draft(compose(source, problems), problems)
    numbers = resolve_sizes(draft, sizes or {}, problems)
    return check(expand(draft, numbers, problems), numbers, problems), problems
