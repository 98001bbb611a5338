"""``bench``: methods and tolerances compared, each by its run time and its error."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.api.given import (
    Value,
    Values,
    check_lengths,
    count_of,
    finite_of,
    number_of,
    sizes_given,
    text_of,
    texts_of,
)
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.warned import warn
from lagrange_cli.api.words import in_python
from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.run.bench import Ranking, entries_of, rank_methods
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.ranking import as_object, as_text
from lagrange_cli.run.settings.methods import proper_name
from lagrange_cli.work_precision.measure import Rules
from lagrange_cli.work_precision.recommend import choose

if TYPE_CHECKING:
    from lagrange_cli.work_precision.measure import Result

SMALLEST_ERROR, LARGEST_ERROR = 1e-12, 0.1


class Bench:
    """The results of a comparison. ``str`` gives the table that the command prints.

    Attributes
    ----------
    results : tuple of Result
        For each method and tolerance ``seconds``, ``error``, ``steps``, ``evaluations`` and ``status``.
    recommended : Result or None
        The fastest one with the error wanted.
    because : str
        Why.
    """

    def __init__(self, ranking: Ranking) -> None:
        self._ranking = ranking
        self._choice = choose(ranking.results, ranking.wanted)

    @property
    def results(self) -> tuple[Result, ...]:
        """The measurements, method by method."""
        return self._ranking.results

    @property
    def recommended(self) -> Result | None:
        """The fastest one with the error wanted."""
        return self._choice.result

    @property
    def because(self) -> str:
        """The reason for the recommendation."""
        return self._choice.because

    def as_data(self) -> dict[str, Any]:
        """The object that ``lagrange bench --json`` prints."""
        return as_object(self._ranking)

    def __str__(self) -> str:
        return as_text(self._ranking)

    def __repr__(self) -> str:
        best = "none" if self.recommended is None else str(self.recommended.contender)
        return f"<bench of {self._ranking.name}: {best} ({self.because})>"


def named(methods: str | Iterable[str]) -> list[str]:
    """Methods by their names: ``"taylor,Radau"`` or ``["taylor", "Radau"]``."""
    given = methods.split(",") if isinstance(methods, str) else listed("methods", methods)
    return [proper_name(str(name).strip(), [*METHODS]) for name in given]


def listed(name: str, given: Iterable[Any]) -> list[Any]:
    """The items of an argument, at least one."""
    found = [*given] if isinstance(given, Iterable) and not isinstance(given, (str, bytes)) else []
    if not found:
        raise UsageError(f"{name} must be a list of at least one, not {given!r:.60}")
    return found


@in_python
def bench(
    system: System,
    *,
    error: float = 1e-9,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
    stop: Value | None = None,
    methods: Iterable[str] | None = None,
    tolerances: Iterable[float] | None = None,
    runs: int = 5,
    budget: float = 2.0,
) -> Bench:
    """Measure the run time and the error of each method at several tolerances.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    error : float
        The error of q, relative to its size, for which a method is recommended.
    set, size : mapping, optional
        Parameters and initial values, and sizes, by name.
    stop : float or str, optional
        When the motion ends; by default as the file says.
    methods, tolerances : sequence, optional
        What is compared; by default everything.
    runs : int
        Timed runs, of which the median is taken.
    budget : float
        Seconds for all runs of one method at one tolerance.

    Returns
    -------
    Bench

    Raises
    ------
    SpecError, UsageError, FileError
        As ``solve``.
    MotionError
        No useful part of the motion can be computed accurately enough.
    KeyboardInterrupt
        Ctrl-C was pressed.
    """
    from lagrange_cli.spec.values import resolve_values

    error, budget = number_of("error", error), number_of("budget", budget)
    if not SMALLEST_ERROR <= error <= LARGEST_ERROR:
        raise UsageError(
            f"error must be from {decimal(SMALLEST_ERROR)} to {decimal(LARGEST_ERROR)}, not {decimal(error)}"
        )
    runs = count_of("runs", runs)
    if not budget > 0:
        raise UsageError(f"budget must be a positive number of seconds, not {decimal(budget)}")
    names = None if methods is None else named(methods)
    tried = (
        None
        if tolerances is None
        else tuple(finite_of("tolerances", one) for one in listed("tolerances", tolerances))
    )
    overrides = texts_of("set", set)
    content, filename = content_of(system)
    spec, values = read_run(
        content, filename, sizes_given(size), lambda spec, problems: resolve_values(spec, overrides, problems)
    )
    check_lengths(spec, set)
    entries = entries_of(names, tried, len(spec.coordinates), constrained=bool(spec.all_constraints))
    until = None if stop is None else text_of("stop", stop)
    with Interrupts(alone=True) as interrupted:
        ranking = rank_methods(
            spec,
            values,
            until,
            error,
            entries,
            Rules(runs, budget),
            interrupted=interrupted,
            given=overrides,
            note=warn,
        )
        if interrupted():
            raise KeyboardInterrupt
    return Bench(ranking)
