"""Where an output goes: the name is checked before any work is done for it."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange_cli.errors import FileError
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from lagrange_cli.store.notes import Origin, Stamp


def find_target(
    name: str, *, force: bool, resume: bool = False, origin: Origin | None = None, ending: str = ".h5"
) -> Target:
    """The target called ``name``, checked before any work is done for it.

    Raises ``FileError`` if no file can be made there, if the name is that of something other than a regular
    file, or if it is that of a file that a run of this ``origin`` may not replace and neither ``force`` nor
    ``resume`` is given. ``ending`` is that of an example of a name.
    """
    replaces: Stamp | None = None
    try:
        if not name:
            raise FileError("the output has no name: give --output a name, or leave it out")
        path = Path(os.path.realpath(name))
        if path.is_dir():
            example = f"NAME{path.suffix or ending}"
            raise FileError(f"{name} is a directory: name a file in it, such as {Path(name) / example}")
        if os.path.exists(name) and not path.is_file():
            raise FileError(f"{name} is not a regular file: --output names a file to write")
        if path.exists():
            found = "" if origin is None else origin.judge(path)
            if not isinstance(found, str):
                replaces = found
            elif not (force or resume):
                raise kept(name, path, found)
        check_folder(name, path)
        target = Target(name, path, force, origin=origin, replaces=replaces)
        with suppress(FileNotFoundError):
            os.lstat(target.longest)
        return target
    except FileNotFoundError as error:  # a name without a folder has no path then
        raise FileError(f"{name} cannot be written: the current directory has been removed") from error
    except (OSError, ValueError) as error:  # a name too long, or with a NUL in it
        if getattr(error, "errno", None) == errno.ENAMETOOLONG:
            what = "its name is too long (the hidden files beside it have longer names)"
            raise FileError(f"{name} cannot be written: {what}; --output names another") from error
        raise FileError(f"{name!r} cannot be written: {error}") from error


def check_folder(name: str, path: Path) -> None:
    """Raise ``FileError`` unless something can be made in the folder of this ``path``."""
    folder = path.parent
    if not folder.is_dir():
        raise FileError(f"{name} cannot be written: there is no directory {folder}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(f"{name} cannot be written: no permission to write in {folder}")


def kept(name: str, path: Path, why: str) -> FileError:
    """The error for an existing output that is not replaced, which says what the output is."""
    from lagrange_cli.store.resume import interrupted

    if interrupted(path):
        return FileError(
            f"{name} contains an interrupted run: --resume continues it, "
            "--force replaces it, --output names another"
        )
    return FileError(f"{name} already exists{why}: --force replaces it, --output names another")
