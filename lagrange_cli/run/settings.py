"""``Settings``: how a motion is to be integrated and sampled, from the file's ``solve`` and the options."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError, UsageError
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.integrate.methods.table import AUTO, METHODS, TAYLOR, MethodRow
from lagrange_cli.integrate.precision import DOUBLE, FULL_PRECISION
from lagrange_cli.limits import way_out, whole
from lagrange_cli.outputs.catalog import OUTPUTS, PARTICLE_OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.choice import chosen_method

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import Event, SolveDefaults, Spec

ALL = "all"
"""Every output that the system has."""

DEFAULT_SAMPLES = 1001
MOST_SAMPLES = whole("samples")
LOOSEST_TOLERANCE = 0.1


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
    """Those of the outputs that nobody asks for by name: they are left out as far as they are not defined."""
    chosen_because: str = ""
    """Why ``--method auto`` does not mean Taylor series here."""

    @property
    def method_shown(self) -> str:
        """The method, and why it was chosen where that needs saying."""
        return f"{self.method}, as {self.chosen_because}" if self.chosen_because else self.method

    @property
    def backward(self) -> bool:
        """Whether the motion is followed against the sense of time."""
        return self.stop < self.start

    def compilation(
        self,
        *,
        ensemble: bool = False,
        order: int | None = None,
        section: str = "",
        factor: int | None = None,
    ) -> Compilation:
        """What a program for such a run is compiled for; ``order`` and ``factor`` are those of a companion,
        ``section`` the kind of an ensemble's section."""
        from lagrange_cli.integrate.compilation import Compilation

        return Compilation(
            self.method,
            self.tolerance,
            self.outputs,
            ensemble=ensemble,
            precision=self.precision,
            portable=self.portable,
            order=order,
            backward=self.backward,
            proven=self.proven,
            section=section,
            factor=factor,
            optional=self.optional,
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
) -> Settings:
    """The settings of a run: the options of the command line over the file's ``solve`` section.

    Raises ``UsageError``; the file's own section has been judged as it was read.
    """
    asked = merge(spec.solve, options)
    if asked.stop is None:
        raise UsageError("no stop time given: add --stop 10, or 'solve: {stop: 10}' to the file")
    start = 0.0 if asked.start is None else asked.start
    count, step = sample_times(start, asked.stop, asked.samples, asked.step)
    outputs = default_outputs(spec) if asked.outputs is None else asked.outputs
    named = resolve_outputs(outputs, has_particles=spec.lagrangian is None)
    method, why = resolve_method(asked.method), ""
    if method == AUTO:
        method = TAYLOR
        if precision == DOUBLE and not portable and not proven and asked.stop > start:
            method, why = chosen_method(spec, named)
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
        optional=frozenset(OUTPUTS).difference(outputs) if ALL in outputs else frozenset(),
        precision=precision,
        portable=portable,
        proven=proven,
    )


def abilities(spec: Spec) -> Iterator[tuple[str, Callable[[MethodRow], bool]]]:
    """What in a system not every method can follow, and whether one can."""
    if spec.all_constraints:
        yield "a system with constraints", lambda row: row.constrains
    if spec.events:
        yield "a system with events", lambda row: row.finds_events


def check_events(events: Mapping[str, Event], start: float, stop: float) -> None:
    """Refuse actions in motions that are followed backward: they may not be undone."""
    acting = next((name for name, event in events.items() if event.changes), None)
    if stop < start and acting is not None:
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


def sample_times(start: float, stop: float, samples: int | None, step: float | None) -> tuple[int, float]:
    """How many samples there are, and how far apart.

    With ``step`` they are at start + i*step, and at ``stop``: the last interval is shorter where that is not
    a whole number of steps away, up to rounding. Else they divide the time from ``start`` to ``stop`` evenly.
    Where ``stop`` is before ``start``, the step that is returned is negative; the one given may be.
    """
    if not math.isfinite(start) or not math.isfinite(stop):
        raise UsageError(f"the motion must start and stop at finite times, not at {start} and {stop}")
    if stop == start:
        raise UsageError(f"the motion stops where it starts, at t = {start:g}: give another stop time")
    if step is None:
        count = DEFAULT_SAMPLES if samples is None else samples
        if count < 2:
            raise UsageError(f"at least 2 samples are needed, the start and the end, not {count}")
        check_count(count)
        return count, (stop - start) / (count - 1)
    if not math.isfinite(step) or step == 0:
        raise UsageError(f"the step between samples must be a positive number, not {step:g}")
    if step < 0 < stop - start:
        raise UsageError(
            f"a step of {step:g} leads away from stop = {stop:g}, which is after start = {start:g}: "
            "give a positive step"
        )
    step = math.copysign(step, stop - start)
    ratio = (stop - start) / step
    check_count(ratio)
    nearest = round(ratio)
    divides = abs(ratio - nearest) <= 1e-9 + 4 * FULL_PRECISION * ratio
    if nearest < 1 or (ratio < 1 and not divides):
        raise UsageError(
            f"the step between samples ({abs(step):g}) is longer than the motion ({abs(stop - start):g})"
        )
    return (nearest if divides else math.ceil(ratio)) + 1, step


def check_count(count: float) -> None:
    """Refuse what no disk holds."""
    if count > MOST_SAMPLES:
        raise UsageError(
            f"{count:.3g} samples are more than the {MOST_SAMPLES:.0e} that can be written: "
            f"ask for fewer, {way_out('samples')}"
        )


def resolve_method(name: str | None) -> str:
    """The method's proper name, whatever case it was written in; ``AUTO`` where there is none."""
    return proper_name(AUTO if name is None else name, (AUTO, *METHODS))


def proper_name(name: str, methods: Sequence[str]) -> str:
    """The one of these methods that is meant, whatever case it is written in."""
    for method in methods:
        if method.lower() == name.lower():
            return method
    raise UsageError(f"unknown method {name!r}; {suggest(name, methods)}")


def either(names: Sequence[str]) -> str:
    """``a, b or c``."""
    return " or ".join(one for one in (", ".join(names[:-1]), names[-1]) if one)


def check_method(method: str, option: str, can: Callable[[MethodRow], bool]) -> None:
    """Refuse an option that a method cannot be used with, and say which it can."""
    able = able_to(can)
    if method not in able:
        raise UsageError(f"{option} needs method {either(able)}, not {method}: add --method {able[0]}")


def able_to(can: Callable[[MethodRow], bool]) -> list[str]:
    """The methods that can do something."""
    return [name for name, row in METHODS.items() if can(row)]


def resolve_tolerance(tolerance: float | None, method: str, precision: str = DOUBLE) -> float:
    """The tolerance asked for, if the method can take it; else the method's default."""
    tightest, default = METHODS[method].tolerances[precision]
    if tolerance is None:
        return default
    if not tightest <= tolerance <= LOOSEST_TOLERANCE:
        raise UsageError(
            f"the tolerance {tolerance:g} is out of range; "
            f"{method} takes {tightest:.3g} to {LOOSEST_TOLERANCE:g}"
        )
    return tolerance


def default_outputs(spec: Spec) -> tuple[str, ...]:
    """What is written where nobody says otherwise; it depends on the sections that the file has."""
    rows = (row for row in OUTPUTS.values() if row.default)
    return tuple(row.name for row in rows if not row.section or getattr(spec, row.section))


def tell_empty(spec: Spec, settings: Settings, tell: Callable[[str], None]) -> None:
    """Tell a line for each output that was asked for by name, and of which the system has nothing."""
    for name in sorted(settings.outputs - settings.optional):
        section = OUTPUTS[name].section
        if section and not getattr(spec, section):
            what = section.removeprefix("all_")
            tell(f"{spec.name}: warning: output {name!r} is empty, as the file has no {what}")


def resolve_outputs(names: Iterable[str], *, has_particles: bool) -> frozenset[str]:
    """The outputs asked for; ``all`` stands for every one that the system has."""
    known = frozenset(OUTPUTS) if has_particles else frozenset(OUTPUTS) - PARTICLE_OUTPUTS
    asked = set(names)
    for name in sorted(asked - known - {ALL, "t"}):
        if name in PARTICLE_OUTPUTS:
            raise UsageError(f"a system given by its 'lagrangian' has no output {name!r}")
        words = [word for word in name.replace("&", " ").replace(";", " ").split() if word != "and"]
        meant = f"write {','.join(words)}" if len(words) > 1 and known.issuperset(words) else ""
        if other := next((one for one, row in OUTPUTS.items() if name in row.also.split()), ""):
            meant = f"write {other}"
        raise UsageError(f"unknown output {name!r}; {meant or suggest(name, (*OUTPUTS, ALL))}")
    return known if ALL in asked else frozenset(asked & known)


def suggest(name: str, known: Iterable[str]) -> str:
    """What was perhaps meant, and what there is."""
    known = tuple(known)
    return " ".join(hint for hint in (near_hint(name, known), known_hint(known)) if hint)
