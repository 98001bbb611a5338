"""``lagrange schema``: a JSON Schema by which editors complete and check system files."""

from __future__ import annotations

import json

import click

from lagrange_cli.cli.console import emit


@click.command("schema")
def schema() -> None:
    """Print a JSON Schema of system files, with which editors complete and check their keys.

    \b
    lagrange schema > lagrange.schema.json

    The first line of a system file tells editors that know the YAML language server where it is:

    \b
    # yaml-language-server: $schema=lagrange.schema.json
    """
    from lagrange_cli.run.schema.file import schema as made

    emit(json.dumps(made(), indent=2, ensure_ascii=False))
