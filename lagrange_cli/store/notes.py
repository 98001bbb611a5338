"""Notes on outputs: they tell a later run of the same system file which output it may replace.

A note has the system file that an output came from, the options, the duration of the run, and the size, time
and inode of the output, which show whether it was changed since; those of a folder are of all files in it.
Notes are stored in the folder of the cache, not in the output, because the bytes of an output depend on the
run alone. Without that folder, or if a note is lost, nothing is replaced.
"""

from __future__ import annotations

import json
import os
import stat
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from lagrange_cli.native.compilation.cache import Cache, find_cache
from lagrange_cli.records import dataclass, replace

SUFFIX = ".note"
LARGEST = 2**20
"""The most bytes of all notes together, which is enough for thousands."""
LONG = 60.0
"""The output of a run that took more seconds than this is replaced only with ``--force``."""

WRITABLE = stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH

Stamp = tuple[int, int, int]


@dataclass(frozen=True)
class Origin:
    """What makes an output: the ``system`` file (its real path) and the ``options`` given, as they are shown
    by what they set. ``began`` is when the run did, on the clock ``time.monotonic``. Notes are only ``kept``
    where the cache may be used."""

    system: str
    options: Mapping[str, str]
    began: float
    kept: bool = True

    def note(self, output: Path) -> None:
        """Keep a note on an output that is complete. (Nothing here fails.)"""
        cache = notes() if self.kept else None
        with suppress(OSError):
            stamp, seconds = stamp_of(output), time.monotonic() - self.began
            content = {
                "system": self.system, "options": dict(self.options), "seconds": seconds, "stamp": stamp,
            }  # fmt: skip
            if cache is not None:
                cache.store(str(output), json.dumps(content).encode())

    def judge(self, output: Path) -> Stamp | str:
        """The stamp of an existing output, if this run may replace it; else what is known against that, as a
        clause that follows ``it already exists``, or nothing."""
        content = read_note(output)
        if content is None or content["system"] != self.system:
            return ""
        try:
            stamp = stamp_of(output)
            protected = not os.stat(output).st_mode & WRITABLE
        except OSError:
            return ""
        if list(stamp) != content["stamp"]:
            return ""
        if protected:
            return " and is write-protected"
        other = [text for name, text in content["options"].items() if self.options.get(name) != text]
        if other:
            return f" and was made with {', '.join(other)}"
        if content["seconds"] > LONG:
            return f" and took {content['seconds']:.0f} s to compute"
        return stamp


def notes() -> Cache | None:
    """The folder of the notes."""
    cache = find_cache()
    return None if cache is None else replace(cache, largest=LARGEST, suffix=SUFFIX)


def read_note(output: Path) -> Mapping[str, Any] | None:
    """The note on an output, if there is one and it is sound."""
    cache = notes()
    payload = None if cache is None else cache.load(str(output))
    if payload is None:
        return None
    with suppress(ValueError, RecursionError):
        content = json.loads(payload)
        kinds = {"system": str, "options": dict, "seconds": float, "stamp": list}
        if isinstance(content, dict) and all(type(content.get(key)) is kind for key, kind in kinds.items()):
            return content
    return None


def stamp_of(output: Path) -> Stamp:
    """What shows that a file, or a file in a folder, has been written to, or replaced by another."""
    status = os.stat(output)
    if not stat.S_ISDIR(status.st_mode):
        return status.st_size, status.st_mtime_ns, status.st_ino
    from hashlib import blake2b  # OpenSSL takes time to load, and a single file has no need of it

    with os.scandir(output) as found:
        held = sorted((one.name, *stamp_of(Path(one.path))) for one in found)
    size = sum(one[1] for one in held)
    return size, int.from_bytes(blake2b(repr(held).encode(), digest_size=8).digest(), "big"), status.st_ino
