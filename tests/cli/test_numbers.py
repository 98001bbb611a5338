"""Options that take a number: what is none is refused by each of them, in each command."""

import click
import pytest

from lagrange_cli.cli.main import COMMANDS, LazyGroup

GROUP = LazyGroup()
OPTIONS = [
    (name, option)
    for name in COMMANDS
    for option in GROUP.get_command(click.Context(GROUP), name).params
    if isinstance(option.type, click.FloatRange)
]
ENDLESS = {"checkpoint", "budget"}
"""No checkpoints, and no limit of time."""


@pytest.mark.parametrize(
    ("name", "option"), OPTIONS, ids=[f"{name} {option.name}" for name, option in OPTIONS]
)
def test_what_is_no_number_is_refused(name, option):
    command = GROUP.get_command(click.Context(GROUP), name)
    words = ["nan", "x", *(() if option.name in ENDLESS else ("inf", "-inf", "1e400"))]
    for word in words:
        with pytest.raises(click.BadParameter, match=f"'{word}' is not a (finite )?number"):
            option.type_cast_value(click.Context(command), word)
