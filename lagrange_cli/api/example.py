"""``example``: the system files that come with the package."""

from __future__ import annotations

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.run import shipped


def example(name: str) -> str:
    """The text of an example system, as ``lagrange systems NAME`` prints it.

    Parameters
    ----------
    name : str
        Its name, such as ``pendulum``.

    Raises
    ------
    UsageError
        There is no such system; the message lists the names.
    """
    names = shipped.names()
    if name not in names:
        hint = near_hint(str(name), names) or known_hint(names, limit=len(names))
        raise UsageError(f"there is no example system {name!r:.60}; {hint}")
    return shipped.text(name)
