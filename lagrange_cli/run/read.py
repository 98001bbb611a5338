"""From the content of a system file to its ``Spec`` and the numbers of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeVar

from lagrange_cli.errors import UsageError
from lagrange_cli.run.settings import check_defaults

if TYPE_CHECKING:
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import Spec

Numbers = TypeVar("Numbers")


def read_run(
    content: bytes,
    filename: str,
    sizes: Mapping[str, str] | None,
    numbers: Callable[[Spec, Problems], Numbers],
) -> tuple[Spec, Numbers]:
    """The system that the ``content`` of a file describes, and the numbers that it is run with.

    ``numbers`` finds them in the spec, and adds to the problems what is wrong with them; ``sizes`` replace
    those of the file; messages call the file ``filename``. All commands read a file in this way, so that none
    accepts what another refuses.

    Raises:
        SpecError: all problems of the file, of its ``solve`` section, and those that ``numbers`` adds.
        UsageError: the file is right, and what is asked of it is not.
    """
    from lagrange_cli.spec.read import examine

    spec, problems = examine(content, filename, sizes)
    check_defaults(spec, problems)
    try:
        found = numbers(spec, problems)
    except UsageError:
        problems.stop_if_any()
        raise
    problems.stop_if_any()
    return spec, found
