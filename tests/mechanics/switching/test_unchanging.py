"""Events whose expression is the same at all states, or jumps over 0, are refused at their place."""

from __future__ import annotations

import random
import re

import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.mechanics.derive import derive
from tests.support.command import lagrange
from tests.support.motion import model_of

SYSTEM = """
parameters: {{a: 2, b: 3}}
coordinates: {{x: {{initial: 0.3, velocity: 1}}, y: {{initial: 1}}}}
lagrangian: x_dot**2/2 + y_dot**2/2 - y**2/2
events: {{ e: "{when}" }}
"""
SAME = [
    "sin(u + v) - sin(u)*cos(v) - cos(u)*sin(v)",
    "(u + v)**2 - u**2 - 2*u*v - v**2",
    "cos(2*u) - 1 + 2*sin(u)**2",
    "exp(u + v) - exp(u)*exp(v)",
    "sqrt(u**2) - abs(u)",
    "tanh(u)*cosh(u) - sinh(u)",
]
QUANTITIES = ["x", "y", "x_dot", "t", "(x - y)", "(a*x)", "(x_dot*y + b)"]
JUMPS = [
    "sign(x - 1)",
    "where(x > 1, 1, -1)",
    "x*sign(y) + t",
    "where(y < x, x + 1, y)",
    "y_dot + where(t > 1, 1, 0)",
]
CONTINUOUS = [
    "max(0, x - 1) - 0.1",
    "where(x > 1, x - 1, 2*x - 2)",
    "abs(x) - 1",
    "where(a > b, x, y)",
    "atan2(y, x)",
]


@pytest.mark.parametrize("form", SAME)
@pytest.mark.parametrize("rest", ["{}", "{} + a - 1", "b*({})"])
def test_an_expression_that_is_the_same_at_all_states_is_refused(form: str, rest: str, request) -> None:
    source = random.Random(f"{request.config.option.seed} {form} {rest}")
    u, v = source.sample(QUANTITIES, 2)
    when = re.sub(r"\b[uv]\b", lambda found: {"u": u, "v": v}[found[0]], rest.format(form))
    with pytest.raises(SpecError, match=r"event 'e' .* never changes"):
        derive(model_of(SYSTEM.format(when=when)))


@pytest.mark.parametrize(
    "when", [*(f"{form} + (x - y)/1e6" for form in ("x - x", "sin(x)**2 + cos(x)**2")), *CONTINUOUS]
)
def test_others_are_not(when: str) -> None:
    derive(model_of(SYSTEM.format(when=when)))


@pytest.mark.parametrize("when", JUMPS)
@pytest.mark.parametrize("command", ["check", "solve"])
def test_an_expression_that_jumps_is_refused(tmp_path, when: str, command: str) -> None:
    (tmp_path / "a.yaml").write_text(SYSTEM.format(when=when))
    options = ["--stop", "1"] if command == "solve" else []
    done = lagrange(command, "a.yaml", *options, cwd=tmp_path)
    assert done.returncode == 3
    assert "event 'e' has an expression that jumps" in done.stderr and when in done.stderr


@pytest.mark.parametrize("command", ["check", "equations", "solve"])
def test_every_command_refuses_it(tmp_path, command: str) -> None:
    (tmp_path / "a.yaml").write_text(SYSTEM.format(when="sin(2*x) - 2*sin(x)*cos(x)"))
    options = ["--stop", "1"] if command == "solve" else []
    done = lagrange(command, "a.yaml", *options, cwd=tmp_path)
    assert done.returncode == 3
    assert "a.yaml:5:15: event 'e' needs an expression" in done.stderr and "never changes" in done.stderr
