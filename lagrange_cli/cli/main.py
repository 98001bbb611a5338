"""The command ``lagrange``: its subcommands, imported only when named, and the one place that exits."""

from __future__ import annotations

import atexit
import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NoReturn

import click

from lagrange_cli import limits
from lagrange_cli.cli.console import INTERRUPTED, complain, describe, discard_output
from lagrange_cli.cli.signals import heed_endings
from lagrange_cli.version import __version__

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

ARGUMENTS = {"begin": "from", "end": "to"}
"""Options that have another name in Python, by that name."""
COMMANDS = {
    "solve": "Integrate the motion and write it to an HDF5 file.",
    "sweep": "Integrate many motions, over a grid, random numbers or a table.",
    "section": "Find where motions cross a surface: Poincare and stroboscopic sections.",
    "plot": "Draw outputs, or the motion of a system.",
    "animate": "Make a film of a motion.",
    "view": "Write a web page that draws a system and computes its motion.",
    "equations": "Print L, the equations of motion, momenta and conserved quantities.",
    "check": "Validate a system file and classify the system.",
    "bench": "Compare methods and tolerances: run time against error.",
    "cache": "Show or clear the cache of compiled programs.",
    "systems": "List the example systems, or print one of them.",
    "schema": "Print a JSON Schema of system files, for editors.",
    "completion": "Print the completion script for bash, zsh or fish.",
}
"""Each command, with its purpose. It lives under its name in the module of that name in ``commands``."""


class LazyGroup(click.Group):
    """A group that imports a command's module when the command is asked for."""

    def list_commands(self, context: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command = getattr(import_module(f"lagrange_cli.cli.commands.{name}"), name)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, context: click.Context, arguments: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = arguments[0]
        if name not in COMMANDS and not name.startswith("-"):
            from lagrange_cli.expression.near import suggest

            known = suggest(name, COMMANDS)
            if name == "help":
                known = f"write lagrange {' '.join(arguments[1:2])} --help".replace("  ", " ")
            elif os.path.exists(name):
                known = f"a file follows its command, as in lagrange solve {name}"
            raise click.UsageError(f"there is no command {name!r}; {known}", context)
        return super().resolve_command(context, arguments)

    def shell_complete(self, context: click.Context, incomplete: str) -> list[CompletionItem[str]]:
        from click.shell_completion import CompletionItem

        found = [CompletionItem(name, help=purpose) for name, purpose in COMMANDS.items()]
        options = click.Command.shell_complete(self, context, incomplete)
        return [one for one in found if one.value.startswith(incomplete)] + options

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="lagrange")
def lagrange() -> None:
    """Lagrangian mechanics from a YAML file: the equations of motion, and the motion itself.

    `lagrange systems` lists example systems to start from.
    """
    limits.enforce()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit status; every error ends here, with a message."""
    if "_LAGRANGE_COMPLETE" in os.environ:
        from lagrange_cli.cli.shells import answer

        return answer(lagrange)
    try:
        status = lagrange.main(arguments, prog_name="lagrange", standalone_mode=False)
        flush_output()
    except click.ClickException as error:
        shown = unknown_option(error) if isinstance(error, click.NoSuchOption) else error
        shown.show()
        return error.exit_code
    except (BrokenPipeError, SystemExit):  # click exits when the reader of its help has hung up
        discard_output()
        return 0
    except (Exception, KeyboardInterrupt) as error:
        message, status = describe(error)
        complain(message)
    if status == INTERRUPTED and (reason := limits.time_over()):
        complain(reason)
    return status if isinstance(status, int) else 0


def unknown_option(error: click.NoSuchOption) -> click.UsageError:
    """The error with the options that were perhaps meant: those that have such a value, those that begin so,
    those that other programs call so, and those that are spelt nearly so."""
    from difflib import get_close_matches

    from lagrange_cli.spec.settings import SOLVE

    word, context = error.option_name.lstrip("-"), error.ctx
    message = f"there is no option {error.option_name!r}"
    parameters = context.command.params if context else []
    options = [one for parameter in parameters for one in parameter.opts]
    names = [one[2:] for one in options if one.startswith("--")]
    meant = [one for one in (ARGUMENTS.get(word), SOLVE.meant(word)[0]) if one in names][:1]
    found = meant or [one for one in names if len(word) > 1 and one.startswith(word)]
    for parameter in parameters:  # --csv for --format csv
        if isinstance(parameter.type, click.Choice) and word in parameter.type.choices:
            found = [f"{parameter.opts[0][2:]} {word}"]
    found = found or get_close_matches(word, names)
    hint = f"did you mean {' or '.join(f'--{one}' for one in found)}?" if found else ""
    if not hint and context is not None and isinstance(context.command, LazyGroup):
        hint = "options follow the command"
    return click.UsageError(f"{message}; {hint}" if hint else message, context)


def run() -> NoReturn:
    """The process ``lagrange``: the command line, and then out at once.

    By now every file is closed and all output written. To take the interpreter down piece by piece would
    take longer than to follow a short motion.
    """
    heed_endings()
    buffer_output()
    status = main()
    atexit._run_exitfuncs()  # what others have asked for at the end of the process, as coverage does
    os._exit(status)


def buffer_output() -> None:
    """Give standard output a buffer, which writes all that it is given.

    Without one (PYTHONUNBUFFERED=1), Python drops in silence what does not fit in at once, as on a full disk.
    """
    shown: Any = sys.stdout
    raw = getattr(shown, "buffer", None)
    if isinstance(raw, io.RawIOBase):
        told = {"encoding": shown.encoding, "errors": shown.errors}
        shown.detach()
        sys.stdout = io.TextIOWrapper(io.BufferedWriter(raw), **told, line_buffering=True)


def flush_output() -> None:
    """Write out what is still buffered while a failure can still be met."""
    if sys.stdout is not None:
        sys.stdout.flush()
