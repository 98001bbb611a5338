"""The numbers of a run, and what --set may change."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import pytest

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import Values, resolve_long_values, resolve_parameters, resolve_values
from tests.support.files import PENDULUM, changed, underlined


def resolve(text: str = PENDULUM, **overrides: str) -> Values:
    return resolve_values(read_spec(text, "file.yaml"), overrides)


def test_values_as_written() -> None:
    assert resolve() == Values({"m": 1.0, "l": 0.5, "g": 9.81}, (0.1,), (0.0,))


def test_parameters_use_one_another_in_any_order() -> None:
    values = resolve(changed("m: 1", "m: 2*w\n  w: sqrt(g/l)"))
    assert values.parameters["m"] == 2 * math.sqrt(9.81 / 0.5)


def test_overrides_reach_what_depends_on_them() -> None:
    text = changed("m: 1", "m: 2*l").replace("initial: 0.1", "initial: l, velocity: -l")
    values = resolve(text, l="g/2", theta_dot="pi")
    assert values.parameters == {"l": 9.81 / 2, "g": 9.81, "m": 9.81}
    assert values.q == (9.81 / 2,)
    assert values.v == (math.pi,)


def test_an_override_may_turn_the_order_round() -> None:
    values = resolve(changed("m: 1", "m: 2*l"), l="g", g="3")
    assert values.parameters == {"m": 6.0, "l": 3.0, "g": 3.0}


def test_constants_may_come_from_definitions() -> None:
    text = (
        changed("initial: 0.1", "initial: at.y + unused*0")
        + "definitions: {two: 2*l, at: [0, two], unused: m}\n"
    )
    assert resolve(text).q == (1.0,)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("nosuch", "1", "--set nosuch=1: unknown name 'nosuch'; known: m, l, g, theta, theta_dot"),
        ("thata", "1", "did you mean 'theta'?"),
        ("θ_dot", "1", "did you mean 'theta_dot'?"),
        ("m", "", "empty expression"),
        ("m", "2x", "write 2*x"),
        ("m", "nan", "'nan' is not a finite number"),
        ("m", "1/0", "division by zero"),
        ("m", "1e308*10", "not a finite number"),
        ("m", "9**9**9**9", "out of bounds"),
        ("m", "theta", "'theta' is a coordinate; values are numbers, or expressions in parameters; known: m"),
        ("m", "bob.x", "'bob' is a particle; values are numbers"),
        ("m", "t", "'t' is the time; values are numbers"),
        ("t", "1", "--set t=1: 't' is the time; only parameters and initial values can be set; known: m, l"),
        ("stop", "1", "--set stop=1: 'stop' is an option; write --stop 1"),
        ("m", "(1, 2)", "a vector"),
        ("m", "2*m", "depends on itself: m -> m"),
        ("theta", "sqrt(-l)", "sqrt(-0.5) is not a real number"),
        ("theta", "(-l)**0.5", "not a real number"),
        ("m", "0", "--set m=0: the value 0 is not positive in mass of 'bob'; masses are greater than 0"),
        ("m", "-1", "the value -1 is not positive"),
    ],
)
def test_wrong_overrides_are_wrong_usage(name: str, value: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        resolve(PENDULUM, **{name: value})
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "piece", "message"),
    [
        ("m: 1", "m: 0", 9, "m", "the value 0 is not positive in mass of 'bob'"),
        ("m: 1", "m: -2", 9, "m", "the value -2 is not positive"),
        ("  bob: m", "  bob: l - 1", 9, "l - 1", "the value -0.5 is not positive"),
        ("  bob: m", "  bob: 1/(m - 1)", 9, "1/(m - 1)", "division by zero in mass of 'bob'"),
        ("m: 1", "m: l/(g - g)", 3, "l/(g - g)", "division by zero in parameter 'm'"),
        ("m: 1", "m: 2 + log(l - 1)", 3, "log(l - 1)", "log(-0.5) is not a real number"),
        ("m: 1", "m: (0 - l)**l", 3, "(0 - l)**l", "not a real number"),
        ("m: 1", "m: 1e308*g*g*g", 3, "1e308*g*g*g", "not a finite number"),
        ("m: 1", "m: exp(1000*g)", 3, "exp(1000*g)", "too large"),
        ("m: 1", "m: 1 + exp(-1000*g)", 3, "exp(-1000*g)", "too small"),
        ("m: 1", "m: 1 + 1e-200*g/1e200", 3, "1e-200*g/1e200", "too small"),
        ("m: 1", "m: 1 + (g*1e-100)**4", 3, "(g*1e-100)**4", "too small"),
        ("initial: 0.1", "initial: 1e-300*m*1e-300", 7, "1e-300*m*1e-300", "too small"),
        ("{initial: 0.1}", "{}", 7, "theta", "coordinate 'theta' has no initial value"),
        (
            "initial: 0.1",
            "initial: 1/(m - 1)",
            7,
            "1/(m - 1)",
            "division by zero in initial value of 'theta'",
        ),
    ],
)
def test_what_has_no_value_is_shown_at_its_place(
    old: str, new: str, line: int, piece: str, message: str
) -> None:
    with pytest.raises(SpecError) as caught:
        resolve(changed(old, new))
    (problem,) = caught.value.problems
    assert problem.line == line
    assert underlined(problem) == piece
    assert message in problem.message
    assert problem.hint


@pytest.mark.parametrize("resolved", [resolve_values, resolve_long_values])
def test_an_exponential_that_fades_is_0_in_an_initial_value(resolved: Callable[..., Values]) -> None:
    """Also where the whole value does; in a parameter, exp(-1000*g) is refused (see above)."""
    spec = read_spec(changed("initial: 0.1", "initial: m + 3*exp(-1000*g)"), "file.yaml")
    assert [float(x) for x in resolved(spec).q] == [1.0]
    spec = read_spec(changed("initial: 0.1", "initial: 3*exp(-1000*g)"), "file.yaml")
    assert [float(x) for x in resolved(spec).q] == [0.0]
    for exponent in (600, 720, 744.9, 746):  # from numbers to those that are hardly more than 0, and to 0
        spec = read_spec(changed("initial: 0.1", f"initial: 1e-9*exp(-{exponent}*m)"), "file.yaml")
        assert [float(x) for x in resolved(spec).q] == [pytest.approx(1e-9 * math.exp(-exponent), abs=1e-300)]


def test_the_hint_for_a_missing_initial_value_keeps_the_velocity() -> None:
    with pytest.raises(SpecError, match=r"write theta: \{initial: 0.1, velocity: ...\}, or --set theta=0.1"):
        resolve(changed("initial: 0.1", "velocity: 2"))


def test_an_override_mends_a_missing_initial_value() -> None:
    assert resolve(changed("{initial: 0.1}", "{}"), theta="0.2").q == (0.2,)


def test_everything_without_a_value_is_shown_at_once() -> None:
    text = changed("m: 1", "m: 0").replace("{initial: 0.1}", "{velocity: 1/(m*0)}")
    with pytest.raises(SpecError) as caught:
        resolve(text)
    assert [problem.line for problem in caught.value.problems] == [7, 7, 9]


def test_parameters_alone_need_no_initial_state() -> None:
    spec = read_spec(changed("{initial: 0.1}", "{}"), "file.yaml")
    assert resolve_parameters(spec, {"g": "l"}) == {"m": 1.0, "l": 0.5, "g": 0.5}


DEFINED = """
parameters: {k: 4.0, m: 1.0}
sizes: {N: 3}
coordinates: {x: {initial: 1}}
definitions:
  period: 2*pi*sqrt(m/k)
  ends: [period, 2]
  part[0]: period
  part[i in range(1, N)]: part[i - 1] + k
  moving: x + 1
lagrangian: m*x_dot**2/2 - k*x**2/2
"""


@pytest.mark.parametrize(
    ("text", "value"), [("period", math.pi), ("ends.x*ends.y", 2 * math.pi), ("part[N - 1]", math.pi + 8)]
)
def test_initial_values_may_be_set_to_definitions_that_are_constant(text: str, value: float) -> None:
    spec = read_spec(DEFINED, "file.yaml")
    assert resolve_values(spec, {"x": text}).q[0] == pytest.approx(value, rel=1e-15)
    assert resolve_values(spec, {"x_dot": text}).v[0] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "value"), [("period", math.pi), ("2*ends.x", 2 * math.pi), ("part[N - 1] - 8", math.pi)]
)
def test_so_may_parameters_unless_the_definition_contains_them(text: str, value: float) -> None:
    spec = read_spec(DEFINED.replace("k: 4.0", "l: 3*j, j: 1.0, k: 4.0"), "file.yaml")
    assert resolve_parameters(spec, {"j": text})["j"] == pytest.approx(value, rel=1e-15)
    assert resolve_parameters(spec, {"j": text})["l"] == pytest.approx(3 * value, rel=1e-15)


def test_definitions_that_form_a_long_chain_set_parameters_too() -> None:
    spec = read_spec(DEFINED.replace("N: 3", "N: 5000").replace("k: 4.0", "j: 1.0, k: 4.0"), "file.yaml")
    assert resolve_parameters(spec, {"j": "part[N - 1] - period"})["j"] == pytest.approx(4 * 4999, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("x", "moving", "--set x=moving: 'moving' is not constant"),
        ("x", "ends.z", "the definition 'ends' has no component 'z'"),
        ("x", "ends", "expected a number, found a vector"),
        ("k", "moving", "--set k=moving: 'moving' is not constant"),
        ("k", "period", "--set k=period: depends on itself: k -> k"),
        ("m", "part[3]", "--set m=part[3]: "),
        ("l", "part[3]", "unknown name 'l'"),
    ],
)
def test_other_definitions_are_no_values(name: str, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=re.escape(message)):
        resolve_values(read_spec(DEFINED, "file.yaml"), {name: text})
