"""``lagrange systems``: what is shipped, and a copy of one of them."""

from __future__ import annotations

import click

from lagrange_cli.cli import shipped
from lagrange_cli.cli.report import emit
from lagrange_cli.errors import UsageError


@click.command("systems")
@click.argument("name", required=False)
def systems(name: str | None) -> None:
    """List the systems that are shipped, or write the one called NAME to standard output.

    \b
    lagrange systems pendulum > pendulum.yaml
    lagrange solve pendulum.yaml
    """
    known = shipped.names()
    if name is None:
        width = max(map(len, known), default=0)
        emit("\n".join(f"{known_name:{width}}  {shipped.summary(known_name)}" for known_name in known))
        return
    name = name.removesuffix(".yaml")
    if name not in known:
        raise UsageError(f"no system called {name!r} is shipped{near_matches(name, known)}")
    emit(shipped.text(name).removesuffix("\n"))


def near_matches(name: str, known: list[str]) -> str:
    """``: did you mean 'pendulum'?``, or the whole list where nothing is near."""
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=3)
    if near:
        return ": did you mean " + " or ".join(repr(match) for match in near) + "?"
    return "; there are " + ", ".join(known)
