"""``lagrange systems``: what is shipped, and a copy of one of them."""

from __future__ import annotations

import click

from lagrange_cli.cli.console import emit
from lagrange_cli.cli.options.completion import word
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.run import shipped


@click.command("systems")
@click.argument("name", required=False, shell_complete=lambda *asked: word(shipped.names())(*asked))
def systems(name: str | None) -> None:
    """List the example systems, or print the one called NAME.

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
        raise UsageError(
            f"there is no example system called {name!r}; {near_hint(name, known) or known_hint(known)}"
        )
    emit(shipped.text(name).removesuffix("\n"))
