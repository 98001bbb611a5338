"""A lock that one process at a time holds, and that is released however the process ends."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

FLAGS = os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NOFOLLOW", 0)
TAKEN = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)


def lock(place: Path) -> int | None:
    """Lock the file ``place``, made for that; None where another process holds it. Raises ``OSError``."""
    while True:
        try:
            held = os.open(place, FLAGS, 0o666)
        except PermissionError:
            if fcntl is None and place.exists():  # what is being removed on Windows
                return None
            raise
        if not _locked(held):
            os.close(held)
            return None
        with suppress(FileNotFoundError):  # its holder has removed it in the meantime: once more
            if os.path.samestat(os.fstat(held), os.stat(place)):
                return held
        os.close(held)


def _locked(held: int) -> bool:
    try:
        if fcntl is not None:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            import msvcrt

            msvcrt.locking(held, msvcrt.LK_NBLCK, 1)
    except OSError as error:
        return error.errno not in TAKEN  # a file system without locks
    return True


def unlock(place: Path, held: int) -> None:
    """Remove the file, so that others can lock it again."""
    if fcntl is None:  # on Windows, what is open cannot be removed; if another has it by now, it stays
        os.close(held)
    with suppress(OSError):
        place.unlink()
    if fcntl is not None:
        os.close(held)
