"""``lagrange completion``: the script by which a shell completes the command."""

from __future__ import annotations

import click

from lagrange_cli.cli.console import emit
from lagrange_cli.cli.shells import SHELLS, script


@click.command("completion")
@click.argument("shell", metavar="SHELL", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print a script that completes commands, options, files and names in bash, zsh or fish.

    Load it when the shell starts:

    \b
    eval "$(lagrange completion bash)"            in ~/.bashrc
    eval "$(lagrange completion zsh)"             in ~/.zshrc, after compinit
    lagrange completion fish | source             in ~/.config/fish/config.fish
    """
    emit(script(context.find_root().command, shell).rstrip("\n"))
