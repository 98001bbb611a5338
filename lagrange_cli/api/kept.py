"""``Kept``: a system file that has been read, and the programs compiled for it, for later calls.

A call with other numbers parses, derives and compiles nothing again. Any number of threads may use it; one of
them at a time makes what is missing.
"""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Hashable, Mapping
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from lagrange_cli.run.attributes import units_of
from lagrange_cli.run.jumps import check_energies
from lagrange_cli.run.prepare import nothing, prepare_run
from lagrange_cli.run.start import NOTHING, Begin, consistent_values
from lagrange_cli.spec.problems import Problems

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

T = TypeVar("T")

MOST_SYSTEMS, MOST_PROGRAMS, MOST_VALUES = 32, 32, 200
"""Kept systems, each with its programs and its checked values."""

WORKING = threading.RLock()
"""Held while a system is read, derived or compiled, since these steps share caches of their own."""
LOOKING = threading.RLock()
"""Held for a moment while something kept is looked for."""


def hold() -> None:
    """Wait until no other thread holds a lock. In a process that was forked these would never be released,
    since it has no other threads."""
    WORKING.acquire()
    LOOKING.acquire()


def release() -> None:
    """The end of ``hold``, in both processes; Ctrl-C may have cut that short."""
    try:
        LOOKING.release()
    finally:
        WORKING.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=hold, after_in_parent=release, after_in_child=release)


class Recent(Generic[T]):
    """Things by key, of which those used last are kept."""

    def __init__(self, most: int) -> None:
        self._most, self._found = most, OrderedDict[Hashable, T]()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """The value kept under the key; it is made if there is none."""
        with LOOKING:
            if key in self._found:
                self._found.move_to_end(key)
                return self._found[key]
        with WORKING:
            with LOOKING:
                if key in self._found:  # another thread has made it in the meantime
                    return self._found[key]
            made = make()
            with LOOKING:
                self._found[key] = made
                while len(self._found) > self._most:
                    self._found.popitem(last=False)
        return made

    def clear(self) -> None:
        """Keep nothing."""
        with LOOKING:
            self._found.clear()


class Kept:
    """A system file as it was read with certain sizes, and what belongs to it."""

    def __init__(self, content: bytes, filename: str, sizes: Mapping[str, str]) -> None:
        self._content, self._filename, self._sizes = content, filename, sizes
        self._read = Recent[tuple["Spec", Problems]](1)
        self._programs = Recent["Prepared"](MOST_PROGRAMS)
        self._judged = Recent[bool](MOST_VALUES)
        self._starts = Recent[tuple["Spec", "Values", Begin]](MOST_VALUES)
        self._units = Recent[tuple[Mapping[str, str], tuple[str, ...]]](1)

    def read(self, content: bytes, filename: str, sizes: Mapping[str, str] | None) -> tuple[Spec, Problems]:
        """As ``spec.read.examine``; a file that has problems is read again, as more are added to them."""
        from lagrange_cli.spec.read import examine

        spec, problems = self._read.get(None, lambda: examine(self._content, self._filename, self._sizes))
        if problems.found:
            with WORKING:
                return examine(self._content, self._filename, self._sizes)
        return spec, Problems(problems.source)

    def begin_at(
        self, spec: Spec, values: Values, t: float, given: Collection[str], *, forced: bool, exact: bool
    ) -> tuple[Spec, Values, Begin]:
        """As ``consistent_values``, for the spec that was read."""
        if not spec.restricted:
            return spec, values, NOTHING

        def find() -> tuple[Spec, Values, Begin]:
            return consistent_values(spec, values, t, given, forced=forced, exact=exact)

        if exact:  # then the values have more digits than doubles show
            with WORKING:
                return find()
        numbers = tuple(values.parameters.items()), values.q, values.v, t
        return self._starts.get((numbers, frozenset(given), forced), find)

    def prepare(
        self,
        spec: Spec,
        settings: Settings,
        stage: Stage,
        *,
        cached: bool,
        order: int | None = None,
        factor: int | None = None,
        meanwhile: Callable[[], object] = nothing,
    ) -> Prepared:
        """As ``prepare_run``, for the spec that was read."""
        asked = settings.compilation(order=order, factor=factor)
        waited = False

        def wait() -> None:
            nonlocal waited
            waited = True
            meanwhile()

        def make() -> Prepared:
            return prepare_run(
                spec, settings, stage, cached=cached, order=order, factor=factor, meanwhile=wait
            )

        found = self._programs.get((spec.left_out, spec.in_turn, spec.tied, spec.faint, asked), make)
        if not waited:
            meanwhile()
        return found

    def check(self, spec: Spec, parameters: Mapping[str, float]) -> None:
        """As ``check_energies``."""

        def judge() -> bool:
            check_energies(spec, parameters)
            return True

        self._judged.get(tuple(parameters.items()), judge)

    def units(self, spec: Spec) -> tuple[Mapping[str, str], tuple[str, ...]]:
        """The units of datasets by path, and what the user is told about them."""

        def find() -> tuple[Mapping[str, str], tuple[str, ...]]:
            told: list[str] = []
            return units_of(spec, told.append), tuple(told)

        return self._units.get(None, find)


SYSTEMS = Recent[Kept](MOST_SYSTEMS)


def keep(content: bytes, filename: str, sizes: Mapping[str, str]) -> Kept:
    """What is kept of a system file."""
    key: Any = content, filename, tuple(sizes.items())
    return SYSTEMS.get(key, lambda: Kept(content, filename, sizes))
