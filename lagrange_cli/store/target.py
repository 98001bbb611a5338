"""``Target``: the name an output will have, and how a file comes to stand under it only when whole."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass

PARTS = 2
"""Unfinished files that there may be at a time: what is being written, and what it is continued from."""


@dataclass(frozen=True)
class Target:
    """An output file that does not exist yet, or may be replaced.

    ``shown`` is the name as the user knows it, ``path`` where it leads (links followed). Everything is
    written to ``temporary``, beside it and so on the same disk, and then renamed. That is the ``part``-th
    of the hidden files that may stand there; ``checkpoint`` says what one of them can be continued from.
    """

    shown: str
    path: Path
    force: bool
    part: int = 0

    @property
    def temporary(self) -> Path:
        """The hidden file beside the output that is written to."""
        return self.part_file(self.part)

    def part_file(self, part: int) -> Path:
        """The unfinished file of that number."""
        return self._beside(f"{part}.part" if part else "part")

    @property
    def checkpoint(self) -> Path:
        """The hidden file beside the output that says how to go on with an unfinished one."""
        return self._beside("checkpoint")

    def _beside(self, ending: str) -> Path:
        return self.path.with_name(f".{self.path.name}.{ending}")

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """A context within which no other process writes this output; raises ``FileError`` where one does."""
        from lagrange_cli.store.lock import lock, unlock

        place = self._beside("lock")
        try:
            held = lock(place)
        except OSError as error:
            raise unwritable(self.shown, error) from error
        if held is None:
            raise FileError(
                f"{self.shown} is being written by another process: "
                "wait for it, or --output names another file"
            )
        atexit.register(unlock, place, held)
        try:
            yield
        finally:
            atexit.unregister(unlock)
            unlock(place, held)

    def publish(self) -> None:
        """Give the finished temporary file its name, and remove what it could have been continued from.

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
            where = f"; the result is whole in {self.temporary}" if self.temporary.exists() else ""
            raise FileError(f"{unwritable(self.shown, error)}{where}") from error
        self.clear()

    def clear(self) -> None:
        """Remove everything unfinished."""
        for place in (self.checkpoint, *map(self.part_file, range(PARTS))):
            with suppress(OSError):
                place.unlink(missing_ok=True)

    def discard(self) -> None:
        """Remove the temporary file, if there is one."""
        with suppress(OSError):  # the error that led here is the one worth telling
            self.temporary.unlink(missing_ok=True)


def find_target(name: str, *, force: bool, resume: bool = False) -> Target:
    """The target called ``name``, checked before any work is done for it.

    Raises ``FileError`` where something exists under the name (and neither ``force`` nor ``resume`` is
    given, or it is no plain file), or where no file can be made there.
    """
    try:
        path = Path(os.path.realpath(name))
        if path.is_dir():
            raise FileError(f"{name} is a directory: name a file in it, as {Path(name) / 'NAME.h5'}")
        if path.exists() and not path.is_file():
            raise FileError(f"{name} is no plain file and cannot be replaced by one")
        if path.exists() and not (force or resume):
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
