"""``Settings``: how a motion is to be integrated and sampled, from the file's ``solve`` and the options."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError, UsageError
from lagrange_cli.integrate.methods.table import AUTO, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.choice import chosen_method
from lagrange_cli.run.settings.methods import (
    abilities,
    able_to,
    check_method,
    either,
    resolve_method,
    resolve_tolerance,
)
from lagrange_cli.run.settings.outputs import default_outputs, optional_outputs, resolve_outputs
from lagrange_cli.run.settings.samples import check_count, sample_times

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.spec.event import Event
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import SolveDefaults, Spec


@dataclass(frozen=True)
class Settings:
    """A run's settings, checked: ``count`` samples, at ``start + i*step`` and the last at ``stop``."""

    start: float
    stop: float
    count: int
    step: float
    method: str
    tolerance: float
    outputs: frozenset[str]
    precision: str = DOUBLE
    portable: bool = False
    proven: bool = False
    optional: frozenset[str] = frozenset()
    """The outputs that are not requested by name: those that are not defined are left out, and those for
    which members of families would have to be written out that are too many."""
    by_default: bool = False
    """Whether there are observables that no one has asked for: those that are not defined are left out."""
    chosen_because: str = ""
    """Why ``--method auto`` means this method here, where several were considered."""
    automatic: bool = False
    """Whether the method is what ``--method auto`` means for any motion of the system, so that a trial may
    find another one (``run.trial``)."""
    explicit: str = ""
    """The method of ``--method auto`` without implicit steps, where a trial has chosen these."""
    as_before: float | None = None
    """The tolerance that is asked for, if the run extends another one, whose method and tolerance it has."""

    @property
    def wanted(self) -> float:
        """The tolerance that is asked for."""
        return self.tolerance if self.as_before is None else self.as_before

    @property
    def without_implicit(self) -> Settings:
        """The settings before a trial has chosen implicit steps."""
        return replace(self, method=self.explicit or self.method, tolerance=self.wanted)

    @property
    def method_shown(self) -> str:
        """The method, and the reason if it was chosen automatically."""
        return f"{self.method}, as {self.chosen_because}" if self.chosen_because else self.method

    @property
    def backward(self) -> bool:
        """Whether the motion is integrated backward in time."""
        return self.stop < self.start

    def compilation(
        self,
        *,
        ensemble: bool = False,
        few: bool = False,
        order: int | None = None,
        section: str = "",
        factor: int | None = None,
    ) -> Compilation:
        """What a program for such a run is compiled for; ``order`` and ``factor`` are those of a companion,
        ``section`` the kind of an ensemble's section, whose motions may be ``few``."""
        from lagrange_cli.integrate.compilation import Compilation

        return Compilation(
            self.method,
            self.tolerance,
            self.outputs,
            ensemble=ensemble,
            few=few,
            precision=self.precision,
            portable=self.portable,
            order=order,
            backward=self.backward,
            proven=self.proven,
            section=section,
            factor=factor,
            optional=self.optional,
            by_default=self.by_default,
        )


def merge(defaults: SolveDefaults, options: SolveDefaults) -> SolveDefaults:
    """The file's defaults, overruled by what the command line gives.

    A number of samples and a step are two ways to say one thing, so that either overrules both.
    """
    if options.samples is not None and options.step is not None:
        raise UsageError("--samples and --step both set the sample times: give one of them")
    given = {
        name: getattr(options, name)
        for name in ("start", "stop", "samples", "step", "method", "tolerance", "outputs")
        if getattr(options, name) is not None
    }
    if "samples" in given or "step" in given:
        given = {"samples": None, "step": None} | given
    return replace(defaults, **given)


def resolve_settings(
    spec: Spec,
    options: SolveDefaults,
    precision: str = DOUBLE,
    portable: bool = False,
    proven: bool = False,
    cached: bool = True,
) -> Settings:
    """The settings of a run: the options of the command line over the file's ``solve`` section. The method
    that was chosen before may be ``cached``.

    Raises ``UsageError``; the file's own section has been judged as it was read.
    """
    asked = merge(spec.solve, options)
    if asked.stop is None:
        raise UsageError("no stop time given: add --stop 10, or 'solve: {stop: 10}' to the file")
    start = 0.0 if asked.start is None else asked.start
    count, step = sample_times(start, asked.stop, asked.samples, asked.step)
    outputs = default_outputs(spec) if asked.outputs is None else asked.outputs
    named = resolve_outputs(outputs, has_particles=spec.lagrangian is None)
    method, why, tried = resolve_method(asked.method), "", False
    if method == AUTO:
        method, known = TAYLOR, resolve_tolerance(asked.tolerance, TAYLOR, precision)
        if precision == DOUBLE and not portable and not proven and asked.stop > start:
            method, why = chosen_method(spec, named, known, cached=cached)
            tried = True
    check_method(method, f"--precision {precision}", lambda row: precision in row.tolerances)
    if portable:
        check_method(method, "--portable", lambda row: row.portable)
    if proven:
        check_method(method, "--proven", lambda row: row.proves)
    for what, can in abilities(spec):
        check_method(method, what, can)
    if spec.events:
        check_events(spec.events, start, asked.stop)
    return Settings(
        start=start,
        stop=asked.stop,
        count=count,
        step=step,
        method=method,
        tolerance=resolve_tolerance(asked.tolerance, method, precision),
        outputs=named,
        chosen_because=why,
        automatic=tried,
        optional=optional_outputs(outputs),
        by_default=asked.outputs is None and "observables" in named,
        precision=precision,
        portable=portable,
        proven=proven,
    )


def check_events(events: Mapping[str, Event], start: float, stop: float) -> None:
    """Refuse actions in motions that are followed backward: they may not be undone."""
    acting = next((name for name, event in events.items() if event.changes), None) if stop < start else None
    if acting is not None:
        raise UsageError(
            f"the action of event {acting!r} cannot be undone in a motion that is integrated backward; "
            "choose a stop time after the start, or let the event only record"
        )


def check_defaults(spec: Spec, problems: Problems) -> None:
    """Add to ``problems`` what is wrong with the file's own ``solve`` section, whatever the options say."""
    from lagrange_cli.spec.source import WHOLE_FILE

    given = spec.solve
    has_particles = spec.lagrangian is None

    def check(key: str, judge: Callable[[], object]) -> bool:
        try:
            judge()
        except LagrangeError as error:
            place = given.places.get(key, given.places.get("stop", WHOLE_FILE))
            message, _, hint = str(error).partition("; ")
            problems.add_once(place, f"{message} in solve", hint)
            return False
        return True

    known = check("method", lambda: resolve_method(given.method))
    method = given.method if known else None
    for what, can in abilities(spec) if method is not None else ():
        able = able_to(can)
        if resolve_method(method) not in (AUTO, *able):
            message = f"{what} needs method {either(able)}, not {method}"
            problems.add_once(given.places["method"], message, f"write method: {able[0]}")
    named = resolve_method(method)
    check("tolerance", lambda: resolve_tolerance(given.tolerance, TAYLOR if named == AUTO else named))
    for name in given.outputs or ():
        check(f"outputs {name}", partial(resolve_outputs, (name,), has_particles=has_particles))
    times = [given.places[key] for key in ("start", "stop", "samples", "step") if key in given.places]
    if given.stop is not None and not given.pending and not any(map(problems.at, times)):
        stop, sampling = given.stop, "samples" if given.step is None else "step"
        fits = check(sampling, lambda: sample_times(given.start or 0.0, stop, given.samples, given.step))
        if fits and spec.events:
            check("stop", lambda: check_events(spec.events, given.start or 0.0, stop))
    elif given.samples is not None:
        samples = given.samples
        check("samples", lambda: check_count(samples))


def tell_empty(spec: Spec, settings: Settings, tell: Callable[[str], None]) -> None:
    """Report each output that was requested by name and is empty for this system."""
    for name in sorted(settings.outputs - settings.optional):
        section = OUTPUTS[name].section
        if section and not getattr(spec, section):
            what = section.removeprefix("all_")
            tell(f"{spec.name}: warning: output {name!r} is empty, as the file has no {what}")
