"""The limits of a system file: every limit that a user may change, with its number.

``LAGRANGE_LIMITS=members=100000,seconds=60`` moves some. What keeps a recursive reader from running out of
stack (how deep an expression may be nested) is fixed, and stands where it is checked.
"""

from __future__ import annotations

import gc
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import TooLarge, UsageError

T = TypeVar("T")

VARIABLE = "LAGRANGE_LIMITS"
DEFAULTS = {
    "bytes": 1_000_000,  # of a system file
    "values": 50_000,  # in a system file, its aliases written out
    "members": 500_000,  # of all families but definitions
    "terms": 200_000,  # of all sums that are written out
    "pairs": 2_000_000,  # of all sums that are not; members of definitions
    "size": 1_000_000,  # nodes of an expression, its definitions and powers written out
    "nodes": 750_000,  # of the equations: 20 s and 1.2 GB to derive
    "work": 20_000_000,  # steps of a derivation: some 20 s
    "convolutions": 60_000,  # an order of a Taylor series: 120 bodies that all attract each other
    "numbers": 100_000_000,  # of the Taylor series of families, or the matrices of implicit steps: 800 MB
    "instructions": 800_000,  # of compiled code: 20 s and 1.3 GB
    "printed": 100_000,  # terms and factors of an expression that 'equations' prints
    "exponent": 64,  # (1 + x)**64 written out still fits a page
    "samples": 10**10,
    "events": 10**7,  # crossings in a motion
    "output": 4000,  # MB of samples in an output
    "runs": 10**8,  # members of a sweep
    "patience": 1_000_000,  # steps of a motion without a crossing of the section
    "seconds": math.inf,  # of a command
    "memory": math.inf,  # MB of address space of a process
}
LEAST_MEMORY = 500
"""MB of address space: what the libraries take before there is any work."""
_BEGAN = time.monotonic()


def limit(name: str) -> float:
    """A limit, as the environment sets it; raises ``UsageError`` if that makes no sense."""
    return chosen().get(name, DEFAULTS[name])


def whole(name: str) -> int:
    """A limit that is a whole number."""
    return int(limit(name))


class Work:
    """How many elementary steps deriving a system has taken, counted rather than timed.

    A step is about a microsecond of work, and a term or factor in memory costs at least one: so both time
    and memory are bounded by the limit ``work``, or by ``most`` where that is less.
    """

    __slots__ = ("cut", "most", "nodes", "spent", "tried", "tried_nodes")

    def __init__(self, most: float = math.inf) -> None:
        self.spent = self.tried = 0
        """Steps; those of attempts, which larger systems may do without."""
        self.nodes = self.tried_nodes = 0
        """Terms and factors that were made, likewise."""
        self.cut = 0
        """Attempts that were given up."""
        self.most = min(limit("work"), most)

    def charge(self, steps: int, what: str = "deriving the equations") -> None:
        """Count ``steps`` more; raises ``TooLarge`` where the limit is passed, by ``what``."""
        self.spent += steps
        if self.spent > self.most:
            self._refuse(what)

    def foresee(self, steps: int, what: str = "deriving the equations") -> None:
        """Raise ``TooLarge`` where so many steps more are certain to pass the limit."""
        if self.spent + steps > self.most:
            self._refuse(what)

    def _refuse(self, what: str) -> None:
        most = f"more than {self.most:.0f} steps of work"
        raise TooLarge(f"{what} takes {most}", "write a smaller system, " + way_out("work"))

    def attempt(self, steps: int, function: Callable[[], T]) -> T | None:
        """The result of ``function``, or None if it would take more than so many steps."""
        before, tried, tried_nodes = self.most, self.tried - self.spent, self.tried_nodes - self.nodes
        self.most = min(before, self.spent + steps)
        try:
            return function()
        except TooLarge:
            self.cut += 1
            return None
        finally:
            self.most = before
            self.tried, self.tried_nodes = tried + self.spent, tried_nodes + self.nodes

    @contextmanager
    def apart(self) -> Iterator[None]:
        """A context for work on equations that have been derived: it may take as many steps as the limit
        allows, and does not count there."""
        before, room = self.spent, self.most - self.spent
        self.most = before + limit("work")
        try:
            yield
        finally:
            self.most = self.spent + room


def allow_nodes(count: float) -> None:
    """Raise ``TooLarge`` where equations have so many terms and factors that this is too many."""
    if count > whole("nodes"):
        message = f"the equations have more than {whole('nodes')} terms and factors that differ"
        raise TooLarge(message, "write a smaller system, " + way_out("nodes"))


def way_out(name: str) -> str:
    """How to change the limit, for a hint."""
    return f"or raise the limit: {VARIABLE}={name}=..."


def chosen() -> dict[str, float]:
    """The limits that the environment sets."""
    found = {}
    for item in filter(None, os.environ.get(VARIABLE, "").split(",")):
        name, _, text = (part.strip() for part in item.partition("="))
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if name not in DEFAULTS or not 0 < value < math.inf:
            known = ", ".join(DEFAULTS)
            raise UsageError(
                f"{VARIABLE}: {item.strip()!r} is not a limit; write NAME=NUMBER with NAME one of {known}"
            )
        found[name] = value
    return found


def enforce() -> None:
    """From now on, let the operating system end what takes too long (as Ctrl-C does) or too much memory."""
    limits = chosen()
    if "memory" in limits:
        if limits["memory"] < LEAST_MEMORY:
            raise UsageError(f"{VARIABLE}: the command needs at least {LEAST_MEMORY} MB of memory")
        limit_memory(int(limits["memory"] * 1e6))
    if "seconds" in limits:
        limit_time(limits["seconds"])


def limit_memory(size: int) -> None:
    """Let this process have so many bytes of address space; raises ``UsageError`` where that cannot be."""
    try:
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        soft = size if hard == resource.RLIM_INFINITY else min(size, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    except (ImportError, AttributeError, ValueError, OSError) as error:  # Windows has none, macOS refuses it
        raise UsageError(
            f"{VARIABLE}: the memory of a process cannot be limited on this platform: leave 'memory' out"
        ) from error


def limit_time(seconds: float) -> None:
    """Interrupt this process, as Ctrl-C does, after so many seconds."""
    import signal

    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, seconds)
    else:  # Windows
        import _thread
        import threading

        timer = threading.Timer(seconds, _thread.interrupt_main)
        timer.daemon = True
        timer.start()


def time_over() -> str:
    """The message when this process has used up its seconds; else nothing."""
    seconds = limit("seconds")
    return (
        f"The time limit is reached: {VARIABLE}=seconds={decimal(seconds)}"
        if time.monotonic() - _BEGAN >= seconds
        else ""
    )


@contextmanager
def uncollected() -> Iterator[None]:
    """A context in which no garbage is collected: reading and deriving make many objects, and hardly any
    garbage. (To look for it took a fifth of the time.)"""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
