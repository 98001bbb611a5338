"""``lagrange cache``: the compiled programs that are stored, and how to remove them."""

from __future__ import annotations

import os
from typing import Any

import click

from lagrange_cli.cli.console import count_of, emit, emit_json
from lagrange_cli.errors import FileError
from lagrange_cli.expression.near import suggest
from lagrange_cli.native.compilation.cache import LARGEST, SWITCH, Cache, cache_folder, switched_off

MEBIBYTE = 2**20

as_json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object on standard output."
)


class Actions(click.Group):
    """A group that names its commands where there is no such command."""

    def resolve_command(
        self, context: click.Context, arguments: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = arguments[0]
        if name not in self.commands and not name.startswith("-"):
            raise click.UsageError(f"there is no command {name!r}; {suggest(name, self.commands)}", context)
        return super().resolve_command(context, arguments)


@click.group("cache", cls=Actions)
def cache() -> None:
    """Show or clear the cache of compiled programs.

    Compiled equations are stored on disk, so that a later run need not compile them again. Set
    LAGRANGE_CACHE_DIR to use another folder, or LAGRANGE_NO_CACHE=1 to use no cache.
    """


@cache.command("info")
@as_json_option
def info(as_json: bool) -> None:
    """Show the cache's folder and what it holds.

    This is the number of programs and their size, or the reason why the cache is not used.
    """
    found = describe_cache()
    if as_json:
        emit_json(found)
    else:
        emit(as_text(found))


@cache.command("clear")
@as_json_option
def clear(as_json: bool) -> None:
    """Remove all compiled programs."""
    folder = cache_folder()
    removed = 0
    if folder is not None:
        try:
            removed = Cache(folder).clear()
        except FileNotFoundError:
            pass
        except OSError as error:
            raise FileError(f"{folder} could not be cleared: {error.strerror or error}") from error
    if as_json:
        emit_json({"folder": folder, "removed": removed})
    else:
        emit(f"removed {count_of(removed, 'compiled program')}")


def describe_cache() -> dict[str, Any]:
    """The state of the cache in terms of JSON; ``reason`` says why it is not used, or not added to."""
    folder = cache_folder()
    found = {"folder": folder, "used": True, "reason": "", "entries": 0, "bytes": 0, "largest": LARGEST}
    if folder is None:
        return {**found, "used": False, "reason": "this platform has no known folder for caches"}
    if switched_off():
        return {**found, "used": False, "reason": f"{SWITCH} is set"}
    there, writable = nearest(folder)
    denied = "" if writable else f"no permission to write in {there}"
    try:
        entries = Cache(folder).entries()
    except FileNotFoundError:
        return {**found, "used": writable, "reason": denied}  # it will be made
    except OSError as error:
        return {**found, "used": False, "reason": str(error.strerror or error)}
    return {**found, "reason": denied, "entries": len(entries), "bytes": sum(entry.size for entry in entries)}


def nearest(folder: str) -> tuple[str, bool]:
    """The folder, or the nearest one above it that there is, and whether it may be written in."""
    there = os.path.abspath(folder)
    while not os.path.exists(there) and os.path.dirname(there) != there:
        there = os.path.dirname(there)
    return there, os.access(there, os.W_OK | os.X_OK)


def as_text(found: dict[str, Any]) -> str:
    """The same as text."""
    lines = [f"folder: {found['folder']}"]
    if not found["used"]:
        lines.append(f"not used: {found['reason']}")
    else:
        sizes = f"{found['bytes'] / MEBIBYTE:.1f} of {found['largest'] / MEBIBYTE:.0f} MiB"
        lines.append(f"{count_of(found['entries'], 'compiled program')}, {sizes}")
        if found["reason"]:
            lines.append(f"no program is added: {found['reason']}")
    return "\n".join(lines)
