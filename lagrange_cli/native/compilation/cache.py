"""``Cache``: compiled programs in a folder of the user, by a key of all that they depend on.

An entry is machine code that will be run. The folder and its entries must therefore belong to the user and be
writable by nobody else; others are ignored. A digest of key and content detects damage. An entry is written
under a temporary name and then renamed, so that any number of processes can share the folder without locks.
If the folder cannot be used, nothing is found or stored, and no error is raised.
"""

from __future__ import annotations

import os
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from lagrange_cli.records import dataclass

FOLDER, SWITCH = "LAGRANGE_CACHE_DIR", "LAGRANGE_NO_CACHE"
"""Environment variables: the folder, and a switch (``1``) that turns the cache off."""

LARGE = 2**22
"""Bytes above which the time to import ``hashlib`` is well spent."""
MAGIC = b"lagrange compiled program 1\n"
DIGEST = 32
SUFFIX, UNFINISHED = ".code", ".part"
LARGEST = 256 * 2**20
"""Bytes of all entries together."""
AFTERWARDS = 3 / 4
"""When they are exceeded, the oldest entries are removed until this part is left."""
ABANDONED = 3600.0
"""Seconds after which an unfinished file is taken to be abandoned."""
OTHERS_MAY_WRITE = stat.S_IWGRP | stat.S_IWOTH


class Refused(OSError):
    """The folder or a file in it is not private to the user; the message says why."""


@dataclass(frozen=True)
class CacheFile:
    """A file of the cache: its name, size in bytes, and when it was last used."""

    name: str
    size: int
    used: float


@dataclass(frozen=True)
class Cache:
    """Contents by key in ``folder``, at most ``largest`` bytes, with a ``suffix`` for what they are."""

    folder: str
    largest: int = LARGEST
    suffix: str = SUFFIX

    def load(self, key: str) -> bytes | None:
        """The object code stored under ``key``, if it is there and undamaged."""
        name = name_of(key, self.suffix)
        with suppress(OSError), self._opened() as place, place.open(name, os.O_RDONLY) as descriptor:
            check_private(os.fstat(descriptor), stat.S_ISREG)
            content = read(descriptor, self.largest)
            if os.utime in os.supports_fd:  # what was used last is evicted last
                with suppress(OSError):
                    os.utime(descriptor)
            return unpack(key, content)
        return None

    def store(self, key: str, payload: bytes) -> None:
        """Store ``payload`` under ``key`` if possible; the oldest entries are removed to make room."""
        content = pack(key, payload)
        if len(content) > self.largest:
            return
        with suppress(OSError):
            os.makedirs(self.folder, mode=0o700, exist_ok=True)
            with self._opened() as place:
                place.write(name_of(key, self.suffix), content)
                self._evict(place)

    def entries(self) -> list[CacheFile]:
        """All entries, the least recently used first.

        Raises ``OSError`` if the folder does not exist or cannot be used, ``Refused`` if it is not private.
        """
        with self._opened() as place:
            return place.entries(self.suffix)

    def clear(self) -> int:
        """Remove all entries and return their number. Raises ``OSError`` as ``entries`` does."""
        with self._opened() as place:
            found = place.entries(self.suffix)
            for entry in (*found, *place.entries(UNFINISHED)):
                place.remove(entry.name)
            return len(found)

    def _evict(self, place: _Place) -> None:
        entries = place.entries(self.suffix)
        total = sum(entry.size for entry in entries)
        if total > self.largest:
            for entry in entries:
                if total <= AFTERWARDS * self.largest:
                    break
                place.remove(entry.name)
                total -= entry.size
        for entry in place.entries(UNFINISHED):
            if entry.used < time.time() - ABANDONED:
                place.remove(entry.name)

    @contextmanager
    def _opened(self) -> Iterator[_Place]:
        """The folder, checked to be private; names are looked up in the folder that was checked."""
        if os.open not in os.supports_dir_fd:  # Windows, where a user's folders are private by default
            yield _Place(self.folder, None)
            return
        descriptor = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            check_private(os.fstat(descriptor), stat.S_ISDIR)
            yield _Place(self.folder, descriptor)
        finally:
            os.close(descriptor)


@dataclass(frozen=True)
class _Place:
    """An open folder: names are looked up from ``descriptor``, or by their path where there is none."""

    folder: str
    descriptor: int | None

    def path(self, name: str) -> str:
        return name if self.descriptor is not None else os.path.join(self.folder, name)

    @contextmanager
    def open(self, name: str, flags: int) -> Iterator[int]:
        for extra in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"):
            flags |= getattr(os, extra, 0)
        descriptor = os.open(self.path(name), flags, 0o600, dir_fd=self.descriptor)
        try:
            yield descriptor
        finally:
            os.close(descriptor)

    def write(self, name: str, content: bytes) -> None:
        """A whole file, or none at all."""
        part = f"{os.getpid()}-{os.urandom(8).hex()}{UNFINISHED}"
        try:
            with self.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL) as descriptor:
                rest = memoryview(content)
                while rest:
                    rest = rest[os.write(descriptor, rest) :]
            os.replace(
                self.path(part), self.path(name), src_dir_fd=self.descriptor, dst_dir_fd=self.descriptor
            )
        except OSError:
            self.remove(part)
            raise

    def remove(self, name: str) -> None:
        with suppress(OSError):
            os.unlink(self.path(name), dir_fd=self.descriptor)

    def entries(self, suffix: str) -> list[CacheFile]:
        """The plain files of that suffix, the least recently used first."""
        found = []
        with os.scandir(self.folder if self.descriptor is None else self.descriptor) as files:
            for file in files:
                with suppress(OSError):
                    if file.name.endswith(suffix) and file.is_file(follow_symlinks=False):
                        status = file.stat(follow_symlinks=False)
                        found.append(CacheFile(file.name, status.st_size, status.st_mtime))
        return sorted(found, key=lambda entry: (entry.used, entry.name))


def find_cache(*, wanted: bool = True) -> Cache | None:
    """The user's cache, or None if it is switched off or has no folder."""
    folder = cache_folder()
    if not wanted or switched_off() or folder is None:
        return None
    return Cache(folder)


def switched_off() -> bool:
    """Whether the environment switches the cache off."""
    return os.environ.get(SWITCH, "") not in ("", "0")


def cache_folder() -> str | None:
    """The folder for compiled programs, in the platform's place for caches."""
    if chosen := os.environ.get(FOLDER):
        return os.path.abspath(chosen)
    if sys.platform == "win32":
        home = os.environ.get("LOCALAPPDATA", "")
    elif sys.platform == "darwin":
        home = os.path.expanduser("~/Library/Caches")
    else:
        home = os.environ.get("XDG_CACHE_HOME", "")
        if not os.path.isabs(home):  # as the XDG Base Directory Specification has it
            home = os.path.expanduser("~/.cache")
    return os.path.join(home, "lagrange-cli") if os.path.isabs(home) else None


def check_private(status: os.stat_result, kind: Any) -> None:
    """Raise ``Refused`` unless this is of that kind and only the user owns and can write to it."""
    if not kind(status.st_mode):
        raise Refused("it is not a directory or file of the expected kind")
    if hasattr(os, "geteuid"):
        if status.st_uid != os.geteuid():
            raise Refused("it belongs to another user")
        if status.st_mode & OTHERS_MAY_WRITE:
            raise Refused("other users may write to it")


def read(descriptor: int, largest: int) -> bytes:
    """The content of an open file, or nothing if it is larger than an entry."""
    size = os.fstat(descriptor).st_size
    content = os.read(descriptor, size) if size <= largest else b""
    while len(content) < size and (more := os.read(descriptor, size - len(content))):
        content += more
    return content


def name_of(key: str, suffix: str = SUFFIX) -> str:
    """The name of the entry of a key."""
    return digest(encoded(key)).hex() + suffix


def encoded(key: str) -> bytes:
    """A key as bytes, also where it is the name of a file whose name is no text."""
    return key.encode(errors="surrogatepass")


def pack(key: str, payload: bytes) -> bytes:
    """The content of an entry: what it is, a digest of the rest, the key and its length, the payload."""
    name = encoded(key)
    rest = len(name).to_bytes(8, "little") + name + payload
    return MAGIC + digest(rest) + rest


def unpack(key: str, content: bytes) -> bytes | None:
    """The payload, if this is the undamaged content of that key's entry."""
    start = len(MAGIC) + DIGEST
    known = content[:start] == MAGIC + digest(content[start:])
    head = len(encoded(key)).to_bytes(8, "little") + encoded(key)
    return content[start + len(head) :] if known and content[start:].startswith(head) else None


def digest(content: bytes | memoryview) -> bytes:
    """SHA-256, of all but large contents from the interpreter's own module: importing ``hashlib``, which is
    several times as fast, takes longer than all else here. Where it has been imported it is used."""
    small = len(content) < LARGE and "hashlib" not in sys.modules
    for module in ("_sha2", "_sha256", "hashlib") if small else ("hashlib",):
        with suppress(ImportError):
            value: bytes = import_module(module).sha256(content).digest()
            return value
    raise AssertionError("hashlib is part of Python")
