"""``Target``: the name an output will have, and how a file comes to stand under it only when whole."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Target:
    """An output file that does not exist yet, or may be replaced.

    ``shown`` is the name as the user knows it, ``path`` where it leads (links followed). Everything is
    written to ``temporary``, beside it and so on the same disk, and then renamed.
    """

    shown: str
    path: Path
    force: bool

    @property
    def temporary(self) -> Path:
        """The hidden file beside the output that this process writes to."""
        return self.path.with_name(f".{self.path.name}.{os.getpid()}.part")

    def publish(self) -> None:
        """Give the finished temporary file its name.

        Raises ``FileError``; where another file has meanwhile taken the name, the result is left in
        ``temporary`` and the message says so.
        """
        if self.path.exists() and not self.force:
            raise FileError(
                f"{self.shown} appeared while this run was computing and is kept; "
                f"the result is whole in {self.temporary}"
            )
        try:
            self.temporary.replace(self.path)
        except OSError as error:
            self.discard()
            raise unwritable(self.shown, error) from error

    def discard(self) -> None:
        """Remove the temporary file, if there is one."""
        with suppress(OSError):  # the error that led here is the one worth telling
            self.temporary.unlink(missing_ok=True)


def find_target(name: str, *, force: bool) -> Target:
    """The target called ``name``, checked before any work is done for it.

    Raises ``FileError`` where something exists under the name (and ``force`` is not given, or it is no
    plain file), or where no file can be made there.
    """
    try:
        path = Path(os.path.realpath(name))
        if path.is_dir():
            raise FileError(f"{name} is a directory: name a file in it, as {Path(name) / 'NAME.h5'}")
        if path.exists() and not path.is_file():
            raise FileError(f"{name} is no plain file and cannot be replaced by one")
        if path.exists() and not force:
            raise FileError(f"{name} exists and is kept: --force replaces it, --output names another")
        folder = path.parent
        if not folder.is_dir():
            raise FileError(f"{name} cannot be written: there is no directory {folder}")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise FileError(f"{name} cannot be written: no permission to write in {folder}")
    except (OSError, ValueError) as error:  # a name too long, or with a NUL in it
        raise FileError(f"{name!r} cannot be written: {error}") from error
    return Target(name, path, force)


def unwritable(name: str, error: Exception) -> FileError:
    """The error of a write that failed, in the operating system's words where it has any."""
    number = getattr(error, "errno", None)
    reason = os.strerror(number) if number else " ".join(str(error).split())
    return FileError(f"{name} could not be written: {reason}")
