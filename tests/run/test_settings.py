"""How a run's settings follow from the file and the options."""

import math
import re
from dataclasses import dataclass, field

import numpy as np
import pytest

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS, OUTPUTS, PARTICLE_OUTPUTS
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.ensembles.ensemble import make_ensemble
from lagrange_cli.run.ensembles.members import Members
from lagrange_cli.run.request import Request
from lagrange_cli.run.sections.request import periods
from lagrange_cli.run.settings.samples import DEFAULT_SAMPLES, sample_times
from lagrange_cli.run.settings.settings import check_defaults, resolve_settings
from lagrange_cli.run.times import with_times
from lagrange_cli.spec.ensemble import resolve_ensemble
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.read import examine, read_spec
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import SolveDefaults
from lagrange_cli.spec.values import resolve_long_values, resolve_values


@dataclass
class SpecWith:
    """As much of a ``Spec`` as the settings depend on."""

    solve: SolveDefaults
    lagrangian: object = None
    observables: tuple = ()
    events: tuple = ()
    all_constraints: tuple = ()
    coordinates: tuple = ()
    coordinate_families: dict = field(default_factory=dict)


def resolve(file=SolveDefaults(stop=10.0), options=SolveDefaults(), **spec):  # noqa: B008 - frozen
    return resolve_settings(SpecWith(file, **spec), options)


def test_a_file_that_says_only_when_to_stop_gets_the_defaults():
    settings = resolve()
    assert (settings.start, settings.stop, settings.count) == (0.0, 10.0, DEFAULT_SAMPLES)
    assert (settings.method, settings.tolerance) == ("taylor", FULL_PRECISION)
    assert settings.outputs == set(DEFAULT_OUTPUTS)


def test_options_overrule_the_file():
    file = SolveDefaults(start=1.0, stop=10.0, samples=5, method="Radau", tolerance=1e-6, outputs=("q",))
    options = SolveDefaults(stop=3.0, step=0.5, method="bdf", tolerance=1e-8, outputs=("h", "t"))
    settings = resolve(file, options)
    assert (settings.start, settings.stop, settings.count, settings.step) == (1.0, 3.0, 5, 0.5)
    assert (settings.method, settings.tolerance, settings.outputs) == ("BDF", 1e-8, {"h"})


def test_samples_overrule_the_files_step():
    assert resolve(SolveDefaults(stop=1.0, step=0.1), SolveDefaults(samples=3)).step == 0.5


@pytest.mark.parametrize(
    ("stop", "step", "count"),
    [
        (20.0, 0.01, 2001),  # 20/0.01 rounds to 2000
        (0.3, 0.1, 4),  # 0.3/0.1 rounds to just below 3
        (1.0, 0.3, 5),  # 0, 0.3, 0.6, 0.9, 1
        (1.0, 0.6, 3),
        (1.0, 1.0, 2),
        (1e6, 0.1, 10_000_001),
    ],
)
def test_a_step_reaches_the_end_whether_or_not_it_divides_the_time(stop, step, count):
    assert sample_times(0.0, stop, None, step) == (count, step)


def test_declared_observables_are_written_unless_something_else_is_asked_for():
    assert resolve(observables=("x",)).outputs == {*DEFAULT_OUTPUTS, "observables"}
    assert resolve(options=SolveDefaults(outputs=("q",)), observables=("x",)).outputs == {"q"}


def test_samples_include_both_ends():
    assert sample_times(-1.0, 1.0, 5, None) == (5, 0.5)
    assert sample_times(1.0, -1.0, 5, None) == (5, -0.5)


@pytest.mark.parametrize("step", [0.25, -0.25])
def test_a_step_leads_to_the_stop_time_on_either_side(step):
    assert sample_times(0.0, -1.0, None, step) == (5, -0.25)


def test_all_outputs_are_those_the_system_has():
    assert resolve(options=SolveDefaults(outputs=("all",))).outputs == set(OUTPUTS)
    given = resolve(options=SolveDefaults(outputs=("all",)), lagrangian="L")
    assert given.outputs == set(OUTPUTS) - PARTICLE_OUTPUTS


def test_scipys_methods_have_a_default_tolerance_they_can_keep():
    assert resolve(options=SolveDefaults(method="DOP853")).tolerance > 100 * FULL_PRECISION


WRONG = {
    "stop at start": (SolveDefaults(stop=0.0), "the motion stops where it starts, at t = 0"),
    "stop is not a number": (SolveDefaults(stop=float("nan")), "finite"),
    "stop is infinite": (SolveDefaults(stop=float("inf")), "finite"),
    "zero samples": (SolveDefaults(stop=1.0, samples=0), "at least 2 samples"),
    "one sample": (SolveDefaults(stop=1.0, samples=1), "at least 2 samples"),
    "too many samples": (SolveDefaults(stop=1.0, samples=10**15), "more than"),
    "step of zero": (SolveDefaults(stop=1.0, step=0.0), "positive"),
    "negative step": (SolveDefaults(stop=1.0, step=-0.1), "leads away from stop = 1"),
    "step is not a number": (SolveDefaults(stop=1.0, step=float("nan")), "positive"),
    "step too small": (SolveDefaults(stop=1.0, step=1e-300), "more than"),
    "step too long": (SolveDefaults(stop=1.0, step=1.1), "longer than the motion"),
    "step much too long": (SolveDefaults(stop=1.0, step=1e20), "longer than the motion"),
    "step too long backward": (SolveDefaults(stop=-1.0, step=2.0), r"\(2\) is longer than the motion \(1\)"),
    "unknown method": (SolveDefaults(stop=1.0, method="rk4"), "known: auto, taylor, ias15, DOP853"),
    "misspelt method": (SolveDefaults(stop=1.0, method="tayler"), "did you mean 'taylor'"),
    "tolerance of zero": (SolveDefaults(stop=1.0, tolerance=0.0), "tolerance"),
    "negative tolerance": (SolveDefaults(stop=1.0, tolerance=-1e-9), "tolerance"),
    "tolerance is not a number": (SolveDefaults(stop=1.0, tolerance=float("nan")), "tolerance"),
    "loose tolerance": (SolveDefaults(stop=1.0, tolerance=1.0), "tolerance"),
    "too tight for scipy": (SolveDefaults(stop=1.0, method="LSODA", tolerance=1e-15), "tolerance"),
    "misspelt output": (SolveDefaults(stop=1.0, outputs=("q", "enrgy")), "did you mean 'energy'"),
    "unknown output": (SolveDefaults(stop=1.0, outputs=("zzz",)), "known: q, v, p, h"),
    "outputs joined by and": (SolveDefaults(stop=1.0, outputs=("q and v",)), "write q,v"),
}


@pytest.mark.parametrize(("wrong", "message"), WRONG.values(), ids=WRONG)
def test_what_the_command_line_asks_wrongly_is_a_usage_error(wrong, message):
    with pytest.raises(UsageError, match=message):
        resolve(options=wrong)


@pytest.mark.parametrize(("wrong", "message"), WRONG.values(), ids=WRONG)
def test_what_the_file_asks_wrongly_is_an_error_of_the_file(wrong, message):
    problems = Problems(Source("system.yaml", ""))
    check_defaults(SpecWith(wrong), problems)
    (problem,) = problems.found
    assert re.search(message, f"{problem.message}; {problem.hint}")
    assert "in solve" in problem.message


def test_all_that_the_file_asks_wrongly_is_shown_at_once_each_at_its_place():
    text = "coordinates: [x]\nlagrangian: x_dot**2/2 - thta\nsolve:\n  stop: 3\n  method: rk4\n  step: 4\n"
    text += "  outputs: [q, hh, T]\n  tolerance: 3\n"
    spec, problems = examine(text, "system.yaml")
    check_defaults(spec, problems)
    with pytest.raises(SpecError) as caught:
        problems.stop_if_any()
    assert [(one.line, one.column) for one in caught.value.problems] == [
        (2, 26), (5, 11), (6, 9), (7, 16), (7, 20), (8, 14),
    ]  # fmt: skip


def test_no_stop_at_all():
    with pytest.raises(UsageError, match="--stop"):
        resolve(SolveDefaults())


def test_samples_and_step_at_once():
    with pytest.raises(UsageError, match="one of them"):
        resolve(options=SolveDefaults(samples=3, step=0.1))


def test_a_lagrangian_has_no_particles_to_write():
    with pytest.raises(UsageError, match="has no output 'positions'"):
        resolve(options=SolveDefaults(outputs=("positions",)), lagrangian="L")


TIMED = """\
sizes: {N: 2}
parameters: {omega: 2.0, k: [1.0, 3.0]}
coordinates: {x: {initial: 1}}
definitions:
  period: 2*pi/rate
  rate: omega*k[0]
  ends: [period/2, sum(k[i] for i in range(N))]
  part[i in range(N)]: period*k[i]
  since[0]: 0.5*period
  since[i in range(1, N)]: since[i - 1] + k[i]
  speed: x_dot
  twice: 2*speed
lagrangian: x_dot**2/2 - k[0]*omega**2*x**2/2
solve: {stop: 1}
"""


def times_of(*pairs: str, parameters={"omega": 2.0, "k[0]": 1.0, "k[1]": 3.0}):  # noqa: B006
    spec = read_spec(TIMED, "system.yaml")
    texts = dict(pair.split("=", 1) for pair in pairs)
    return resolve_settings(spec, with_times(SolveDefaults(), texts, spec, parameters))


def test_times_are_numbers_or_expressions_in_parameters():
    settings = times_of("start=-pi/omega", "stop=10*2*pi/omega", "step=k[1]/N/100")
    assert (settings.start, settings.stop, settings.step) == (-math.pi / 2, 10 * math.pi, 0.015)
    assert settings.count == math.ceil(10.5 * math.pi / 0.015) + 1


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize(
    ("text", "stop"),
    [
        ("3*period", 3 * math.pi),
        ("ends.x + ends.y", math.pi / 2 + 4),
        ("part[1] - part[N - 2]", 2 * math.pi),
        ("since[1]", math.pi / 2 + 3),
        ("dot(ends, (0, 1))", 4.0),
    ],
)
def test_times_may_contain_definitions_that_are_constant(text, stop):
    for exact in (False, True):
        spec, parameters = read_spec(TIMED, "system.yaml"), {"omega": 2.0, "k[0]": 1.0, "k[1]": 3.0}
        found = with_times(SolveDefaults(), {"stop": text}, spec, parameters, exact=exact)
        assert found.stop == pytest.approx(stop, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("twice", "'twice' is not constant; times are numbers, or expressions in parameters"),
        ("ends", "expected a number, found a vector"),
        ("ends.z", "the definition 'ends' has no component 'z'; known: ends.x, ends.y"),
        ("part", "missing index on the family 'part'"),
        ("part[2]", "no member 'part\\[2\\]'"),
        ("period[0]", "'period' is not a family"),
        ("10*omga", "10.omga: unknown name 'omga'; did you mean 'omega'"),
        ("soon", "--stop soon: unknown name 'soon'"),
        ("2*x", "'x' is not constant; times are numbers, or expressions in parameters"),
        ("x_dot", "'x_dot' is not constant"),
        ("t", "'t' is the time; times are numbers"),
        ("k", "'k' is a list of parameters; take one of them, as k\\[0\\]"),
        ("k[2]", "no member 'k\\[2\\]'"),
        ("1/(omega - 2)", "--stop"),
        ("exp(1e4)", "--stop"),
        ("(1, 2)", "--stop"),
        ("2^3", "write \\*\\* for powers"),
        ("", "--stop"),
        ("inf", "finite"),
    ],
)
def test_a_time_that_has_no_value_is_a_usage_error(text, message):
    with pytest.raises(UsageError, match=message):
        times_of(f"stop={text}")


def test_members_of_a_sweep_have_the_same_times():
    for text, message in (("pi/omega", "'omega' differs"), ("period", "'period' differs")):
        with pytest.raises(UsageError, match=f"{message} between the members of the sweep"):
            times_of(f"stop={text}", parameters={"k[0]": 1.0, "k[1]": 3.0})


def test_the_period_of_a_section_may_be_a_definition():
    spec = read_spec(TIMED, "system.yaml")
    values = resolve_ensemble(spec, {}, {"omega": np.array([1.0, 4.0])})
    assert periods("period + ends.y", spec, values) == pytest.approx([2 * math.pi + 4, math.pi / 2 + 4])


OSCILLATOR = """\
parameters: {k: 4.0, m: 1.0}
coordinates: {x: {initial: 1}}
definitions: {period: 2*pi*sqrt(m/k)}
lagrangian: m*x_dot**2/2 - k*x**2/2
solve: {%s}
"""


def read_file(solve, overrides=None, resolve=resolve_values):
    content = (OSCILLATOR % solve).encode()
    return read_run(content, "file.yaml", None, lambda spec, found: resolve(spec, overrides or {}, found))


def of_file(solve, options=SolveDefaults(), **overrides):  # noqa: B008 - frozen
    spec, _ = read_file(solve, overrides)
    return resolve_settings(spec, options)


@pytest.mark.parametrize("resolve", [resolve_values, resolve_long_values])
def test_times_in_the_file_are_expressions_in_parameters_and_definitions(resolve):
    solve = "start: -period, stop: 10*period, step: sqrt(m)/k/10"
    spec, values = read_file(solve, resolve=resolve)
    settings = resolve_settings(spec, SolveDefaults())
    assert (settings.start, settings.stop, settings.step) == (-math.pi, 10 * math.pi, 0.025)
    assert of_file(solve, m="4").stop == 20 * math.pi
    assert of_file(solve, SolveDefaults(stop=3.0, samples=5)).stop == 3.0
    assert values.times == {"start": -math.pi, "stop": 10 * math.pi, "step": 0.025}


@pytest.mark.exhaustive(keep=0.75)
def test_times_that_are_not_known_yet_are_not_judged():
    assert of_file("start: -period, stop: 0").start == -math.pi
    assert of_file("stop: -k, step: -1/k").step == -0.25


@pytest.mark.parametrize(
    ("solve", "mistakes"),
    [
        ("stop: m - 1", [("m - 1", "stops where it starts, at t = 0")]),
        ("stop: 1, start: m", [("1", "stops where it starts, at t = 1")]),
        ("stop: m, step: -1/k", [("-1/k", "step must be greater than 0, not -0.25")]),
        ("stop: 1/(m - 1), step: sqrt(-k)", [("1/(m - 1)", "by zero"), ("sqrt(-k)", "not a real number")]),
        ("stop: m, step: k", [("k}", "is longer than the motion")]),
        ("stop: 1e300*k, step: m/k", [("m/k", "more than the")]),
        ("stop: m, step: 0.1/k, samples: 3", [("0.1/k", "cannot both be given")]),
        ("stop: exp(1000*k)", [("exp", "number")]),
        ("stop: m - 1, method: rk4", [("m - 1", "stops where it starts"), ("rk4", "unknown method")]),
    ],
)
def test_times_that_make_no_sense_are_mistakes_of_the_file_at_their_place(solve, mistakes):
    with pytest.raises(SpecError) as caught:
        read_file(solve)
    line = (OSCILLATOR % solve).splitlines()[-1]
    found = [(one.line, one.column, one.message) for one in caught.value.problems]
    assert [(row, column) for row, column, _ in found] == [(5, line.index(at) + 1) for at, _ in mistakes]
    assert all(message in one[2] for one, (_, message) in zip(found, mistakes, strict=True))


def test_an_option_that_leaves_a_time_without_a_value_is_what_is_blamed():
    with pytest.raises(UsageError, match=r"--set m=0\*k: division by zero in stop of solve"):
        read_file("stop: 1/m", {"m": "0*k"})


def ensemble(solve, swept, **request):
    spec, _ = read_run((OSCILLATOR % solve).encode(), "file.yaml", None, lambda spec, problems: None)
    values = np.array([1.0, 2.0, 3.0])
    members = Members({swept: values}, {swept: 3})
    return make_ensemble(spec, members, Request(**request)).settings


def test_members_of_a_sweep_share_the_times_of_the_file():
    assert ensemble("stop: period", "x").stop == math.pi
    for request in ({}, {"options": SolveDefaults(outputs=("q",))}):
        with pytest.raises(UsageError, match=r"'stop: period' in solve differs .* add --stop with a number"):
            ensemble("stop: period", "m", **request)
    assert ensemble("stop: period, step: period/10", "m", times={"stop": "3"}).stop == 3.0
    sampled = SolveDefaults(outputs=("q",))
    with pytest.raises(UsageError, match="'step: period/10' in solve differs"):
        ensemble("stop: period, step: period/10", "m", times={"stop": "3"}, options=sampled)
    with pytest.raises(SpecError, match="stops where it starts"):
        ensemble("stop: k - 4", "m")
