"""Dissipation that does not brake."""

from __future__ import annotations

import pytest

from lagrange_cli.run.doubtful import odd_dissipation
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.command import lagrange

SYSTEM = """\
parameters: {{c: 0.1, u: 5}}
coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}}}
masses: {{p: 1}}
positions: {{p: [x, y*2]}}
dissipation: {dissipation}
"""


def found(dissipation):
    spec = read_spec(SYSTEM.format(dissipation=dissipation), "file.yaml")
    problems = odd_dissipation(spec, resolve_values(spec).parameters)
    assert all(one.line == 5 for one in problems)
    return [one.message for one in problems]


@pytest.mark.parametrize(
    ("dissipation", "name"),
    [
        ("c*x_dot", "x_dot"),
        ("c*x_dot**2 + c*y_dot", "y_dot"),
        ("c*(y_dot - x_dot)", "x_dot"),
        ("c*p.vy", "y_dot"),
        ("c*x_dot*abs(x_dot)", "x_dot"),
        ("x**2*y_dot**3", "y_dot"),
    ],
)
def test_forces_that_do_not_change_direction_are_named(dissipation, name):
    assert found(dissipation) == [
        f"the dissipation is odd in {name}: its force does not change direction with it"
    ]


def test_forces_that_drive_the_motion_everywhere_are_named():
    assert found("-c*(x_dot**2 + y_dot**2)/2") == ["the dissipation is negative: its forces drive the motion"]


@pytest.mark.parametrize("dissipation", ["c", "c*x**2/2", "c*y/(1 + t**2)"])
def test_dissipation_without_velocities_is_named(dissipation):
    assert found(dissipation) == ["the dissipation contains no velocity: it exerts no force"]


@pytest.mark.parametrize("command", ["solve", "sweep --over u=1,2", "section --where x --crossings 1"])
def test_a_motion_that_nothing_brakes_is_reported(command, tmp_path):
    (tmp_path / "a.yaml").write_text(SYSTEM.format(dissipation="c*x"))
    done = lagrange(*command.split(), "a.yaml", "--stop", 1, cwd=tmp_path)
    assert "a.yaml: warning: the dissipation contains no velocity: it exerts no force; " in done.stderr


@pytest.mark.parametrize(
    "dissipation",
    [
        "c*x_dot**2/2",
        "c*abs(x_dot)",
        "abs(x_dot)**3/3",
        "c*(x_dot - u)**2/2",
        "c*(x_dot**2 - u*x_dot)",
        "c*abs(x_dot - u)",
        "c*abs(x_dot - y_dot)",
        "c*(x**2/1000**2 - 1)*x_dot**2/2",
        "c*max(x_dot, 0)**2",
        "c*sqrt(p.vx**2 + p.vy**2)",
        "log(cosh(x_dot))",
        "where(x_dot > 0, c*x_dot, -u*x_dot)",
        "x_dot*tanh(x_dot/0.01)",
    ],
)
def test_friction_of_every_kind_passes(dissipation):
    assert found(dissipation) == []
