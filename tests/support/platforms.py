"""Linux made to look like another platform, in a process of its own:

    python -m tests.support.platforms win32|darwin COMMAND ARGUMENTS...  [+ COMMAND ARGUMENTS...]

runs commands of ``lagrange`` one after the other in it, and ends with the highest of their statuses. What is
missing there is taken away once all libraries are in memory: they know this platform's ways only.
"""

from __future__ import annotations

import builtins
import ctypes
import mmap
import os
import pathlib
import signal
import sys
import types
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

LIBRARIES = (
    "click", "click.shell_completion", "h5py", "llvmlite.binding", "matplotlib.figure", "mpmath", "numpy",
    "numpy.random", "scipy.integrate", "sympy", "sympy.printing", "yaml", "tempfile", "traceback",
    "multiprocessing.connection", "multiprocessing.popen_spawn_posix", "multiprocessing.resource_tracker",
    "concurrent.futures.thread", "subprocess", "platform",
)  # fmt: skip
"""All that may be imported on the way."""
MISSING = {
    "win32": {
        os: (
            "fork", "forkpty", "kill", "killpg", "getuid", "geteuid", "getgid", "getegid", "getpgid", "chown",
            "fchown", "fchmod", "lchown", "mkfifo", "nice", "wait3", "wait4", "statvfs", "uname", "pread",
            "pwrite", "posix_spawn", "posix_fallocate", "posix_fadvise", "sched_getaffinity", "sync",
            "sysconf", "getloadavg", "set_blocking", "O_CLOEXEC", "O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK",
            "O_SYNC", "O_TMPFILE", "memfd_create",
        ),
        signal: (
            "SIGALRM", "SIGHUP", "SIGKILL", "SIGUSR1", "SIGUSR2", "SIGPIPE", "SIGQUIT", "SIGCHLD", "alarm",
            "setitimer", "getitimer", "ITIMER_REAL", "pause", "pthread_kill",
            "siginterrupt", "sigwait",
        ),
        mmap: ("PROT_READ", "PROT_WRITE", "PROT_EXEC", "MAP_PRIVATE", "MAP_SHARED", "MAP_ANONYMOUS"),
    },
    "darwin": {os: ("sched_getaffinity", "posix_fallocate", "memfd_create", "O_TMPFILE")},
}  # fmt: skip
"""By platform and module."""
MODULES = {"win32": ("fcntl", "grp", "pwd", "resource", "termios", "tty"), "darwin": ()}


def pretend(system: str) -> None:
    """From now on this process is on ``system``, as far as Python code can tell."""
    for library in LIBRARIES:
        import_module(library)
    locks = import_module("fcntl")
    sys.platform = system
    for module, names in MISSING[system].items():
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    for gone in MODULES[system]:
        sys.modules[gone] = None  # type: ignore[assignment]
    forbid_proc()
    if system == "win32":
        os.supports_dir_fd.clear()
        os.supports_fd.clear()
        os.O_BINARY = 0  # type: ignore[attr-defined]
        sys.modules["msvcrt"] = byte_locks(locks)
        os.path.expanduser("~")
        keep_open_files()
        ctypes.CDLL = library_by_name(ctypes.CDLL)  # type: ignore[assignment, misc]
    else:
        limits = import_module("resource")
        limits.setrlimit = refused  # as macOS refuses a limit of the address space


def refused(*arguments: object) -> None:
    raise ValueError("current limit exceeds maximum limit")


def forbid_proc() -> None:
    """There is no /proc."""
    known = builtins.open

    def opened(file: Any, *arguments: Any, **options: Any) -> Any:
        if isinstance(file, str) and file.startswith("/proc"):
            raise FileNotFoundError(2, os.strerror(2), file)
        return known(file, *arguments, **options)

    builtins.open = opened


def byte_locks(locks: Any) -> types.ModuleType:
    """The module ``msvcrt``, as far as it is used."""
    found: Any = types.ModuleType("msvcrt")
    found.LK_NBLCK, found.LK_UNLCK = 2, 0

    def locking(descriptor: int, mode: int, count: int) -> None:
        assert count > 0
        kind = locks.LOCK_EX | locks.LOCK_NB if mode == found.LK_NBLCK else locks.LOCK_UN
        locks.flock(descriptor, kind)

    found.locking = locking
    return found


def library_by_name(known: Any) -> Callable[..., Any]:
    """``ctypes.CDLL`` where there is no handle of the process itself."""

    def loaded(name: Any, *arguments: Any, **options: Any) -> Any:
        if name is None:
            raise TypeError("bad argument type for built-in operation")
        return known(name, *arguments, **options)

    return loaded


def keep_open_files() -> None:
    """No file that is open can be removed, replaced or renamed."""

    def kept(function: Callable[..., Any], count: int) -> Callable[..., Any]:
        def checked(*places: Any, **options: Any) -> Any:
            for place in places[:count]:
                if os.path.realpath(place) in opened_files():
                    raise PermissionError(13, "the file is in use", str(place))
            return function(*places, **options)

        return checked

    for name, count in (("unlink", 1), ("remove", 1), ("rename", 2), ("replace", 2)):
        setattr(os, name, kept(getattr(os, name), count))
    for name, count in (("unlink", 1), ("rename", 2), ("replace", 2)):
        setattr(pathlib.Path, name, kept(getattr(pathlib.Path, name), count))


def opened_files() -> set[str]:
    """The files that this process has open."""
    found = set()
    for descriptor in os.listdir("/proc/self/fd"):
        try:
            found.add(os.readlink(f"/proc/self/fd/{descriptor}"))
        except OSError:
            continue
    return found


def run(commands: Sequence[Sequence[str]]) -> int:
    """The highest status of the commands; ``interrupted solve ...`` is interrupted at its second look."""
    import lagrange_cli.cli.commands.solve as solving
    from lagrange_cli.cli.main import main
    from lagrange_cli.cli.signals import heed_endings
    from lagrange_cli.run.interrupts import Interrupts

    class Interrupted(Interrupts):
        looks = 0

        def __call__(self) -> bool:
            self.looks += 1
            return self.looks > 1

    heed_endings()
    status = 0
    for command in commands:
        cut = command[0] == "interrupted"
        solving.Interrupts = Interrupted if cut else Interrupts  # type: ignore[misc]
        status = max(status, main(command[1:] if cut else command))
    return status


def split(words: Sequence[str]) -> list[list[str]]:
    """The commands between plus signs."""
    commands: list[list[str]] = [[]]
    for word in words:
        if word == "+":
            commands.append([])
        else:
            commands[-1].append(word)
    return commands


if __name__ == "__main__":
    pretend(sys.argv[1])
    sys.exit(run(split(sys.argv[2:])))
