"""The text of a system file to a ``Spec``."""

from __future__ import annotations

from lagrange_cli.spec.check import check
from lagrange_cli.spec.nodes import compose, decode
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import read_draft
from lagrange_cli.spec.spec import Spec


def read_spec(text: bytes | str, filename: str) -> Spec:
    """Read and check a system file; ``filename`` is used in messages and for the default name.

    Raises:
        SpecError: with every problem of the file, each with its place, unless it is not YAML at all.
    """
    source = decode(text, filename)
    problems = Problems(source)
    return check(read_draft(compose(source, problems), problems), problems)
