"""``Target``: the name that an output will have; a file gets this name only when it is complete."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange_cli.errors import FileError
from lagrange_cli.integrate.ending import DONE
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.store.notes import Origin, Stamp

PARTS = 2
"""The most unfinished files at a time: the one being written, and the one that it continues."""


@dataclass(frozen=True)
class Target:
    """An output file that does not exist yet, or that may be replaced.

    ``shown`` is the name that the user gave, ``path`` the file that it leads to when links are followed. The
    output is written to ``temporary``, a hidden file in the same folder, and renamed when it is complete.
    There may be several such files: this is number ``part``. ``checkpoint`` is the file that says how to
    continue one of them. ``origin`` says what makes the output; it is noted when the output is complete.
    ``replaces`` is the stamp of an earlier output that the run may replace even without ``force``.
    ``earlier`` is the name of one that was not replaced, because the run did not come to its end.
    """

    shown: str
    path: Path
    force: bool
    part: int = 0
    origin: Origin | None = None
    replaces: Stamp | None = None
    earlier: str = ""

    @property
    def temporary(self) -> Path:
        """The hidden file beside the output that is written to."""
        return self.part_file(self.part)

    def part_file(self, part: int) -> Path:
        """The unfinished file of that number."""
        return self._beside(f"{part}.part" if part else "part")

    @property
    def checkpoint(self) -> Path:
        """The hidden file beside the output that says how to continue an unfinished one."""
        return self._beside("checkpoint")

    @property
    def longest(self) -> Path:
        """The longest of the hidden names: that of a checkpoint until it is complete."""
        return self._beside("checkpoint.new")

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

    @contextmanager
    def filled(self) -> Iterator[Path]:
        """A context within which the whole file is written to the place that it gives: then it gets its name,
        and otherwise nothing is left. Raises ``FileError``."""
        with self.claimed():
            self.discard()
            try:
                yield self.temporary
            except OSError as error:
                self.discard()
                raise unwritable(self.shown, error) from error
            except BaseException:
                self.discard()
                raise
            self.publish()

    def publish(self, status: str = "complete") -> Target:
        """Give the finished temporary file its name, and remove all unfinished files.

        Returns the target that has it: this one, or one beside an earlier output that is complete, where a
        run with this ``status`` is not. What may be replaced later is noted. Raises ``FileError``. If another
        file has taken the name in the meantime, the result stays in ``temporary``, and the message says so.
        """
        if self.path.exists() and not self.force and not self.replaceable():
            how = "appeared" if self.replaces is None else "was changed"
            raise FileError(
                f"{self.shown} {how} during this run and was not replaced; "
                f"the complete result is in {self.temporary}"
            )
        keep = status not in DONE and self.replaces is not None and not self.force
        found = self.apart(status) if keep else self
        try:
            self.temporary.replace(found.path)
        except OSError as error:
            where = f"; the complete result is in {self.temporary}" if self.temporary.exists() else ""
            raise FileError(f"{unwritable(found.shown, error)}{where}") from error
        if self.origin is not None and (keep or status in DONE):
            self.origin.note(found.path)
        self.clear()
        return found

    def apart(self, status: str) -> Target:
        """The target of a run with this ``status`` that must not replace the output: ``NAME_failed.h5``."""
        folder = Path(self.shown).parent
        shown = folder if os.path.realpath(folder) == str(self.path.parent) else self.path.parent
        for number in count(1):
            name = f"{self.path.stem}_{status}{'' if number == 1 else f'_{number}'}{self.path.suffix}"
            place = self.path.with_name(name)
            free = not os.path.lexists(place)
            if free or (self.origin is not None and not isinstance(self.origin.judge(place), str)):
                return replace(self, shown=str(shown / name), path=place, replaces=None, earlier=self.shown)
        raise AssertionError("unreachable")

    @property
    def replaced(self) -> bool:
        """Whether an earlier output of the same source is replaced."""
        return self.replaces is not None

    def replaceable(self) -> bool:
        """Whether the file of that name is still the earlier output that may be replaced."""
        if self.replaces is None:
            return False
        from lagrange_cli.store.notes import stamp_of

        with suppress(OSError):
            return stamp_of(self.path) == self.replaces
        return False

    def clear(self) -> None:
        """Remove everything unfinished."""
        for place in (self.checkpoint, *map(self.part_file, range(PARTS))):
            with suppress(OSError):
                place.unlink(missing_ok=True)

    def discard(self) -> None:
        """Remove the temporary file, if there is one."""
        with suppress(OSError):  # the error that led here is the one worth telling
            self.temporary.unlink(missing_ok=True)


def unwritable(name: str, error: Exception) -> FileError:
    """The error of a write that failed, in the operating system's words where it has any."""
    number = getattr(error, "errno", None)
    reason = os.strerror(number) if number else " ".join(str(error).split())
    return FileError(f"{name} could not be written: {reason}")
