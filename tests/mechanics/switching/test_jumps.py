"""Energies that jump have no motion; those with kinks have one."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.switching.jumping_values import jumps_may_depend_on, may_jump
from lagrange_cli.mechanics.switching.jumps import refuse_jumps, refuse_jumps_in_numbers
from tests.support.command import lagrange
from tests.support.motion import model_of

SYSTEM = """
parameters: {{k: 2, m: 2}}
coordinates: {{x: {{initial: 0.3}}, y: {{initial: 1}}}}
masses: {{b: 1}}
embedding: {{b: [x, y]}}
potential: "{potential}"
dissipation: "{dissipation}"
"""


@pytest.mark.parametrize(
    "potential",
    [
        "sign(x)",
        "k*sign(x - y)*y",
        "where(x > 1, k, 0)",
        "where(x > 1, x**2, 2)",
        "where(x > y, x, 2*y)",
        "where(x > k, x, 2*k)",
        "where(x > 0 and y > 0, x, 0)",
        "where(x**2 + y**2 < 1, 0, 5)",
        "y*where(x_dot > 0, 1, 2)",
        "sqrt(x**2)/x",
    ],
)
def test_a_jump_is_refused(potential: str) -> None:
    with pytest.raises(InfiniteForce, match="'potential' has a jump"):
        derive(model_of(SYSTEM.format(potential=potential, dissipation="0")))


@pytest.mark.parametrize(
    "potential",
    [
        "x*sign(x)",
        "abs(x - y)*y",
        "k/abs(x - y) + 1/sqrt(x**2) + abs(y)**-0.5*m",
        "log(abs(x))",
        "(y/max(k + cosh(x), 6*k, 0.2**x))**3",
        "where(x > 0, 0.1 + 0.2, 0.3)",
        "max(0, x - k)**2 + min(x, y, 1)",
        "where(x > 1, x**2, 1)",
        "where(x > 1, x**2, 2*x - 1)",
        "where(x < 0.1, x**2*y, 0.01*y)",  # the last bits differ
        "where(x > k, x**2/2, m)",  # with these parameters
        "max(0, where(x > 1, k*x, m) - y)",
        "where(x > y, x, y)",
        "where(x > 0 and y > 0, x*y, 0)",
        "where(t > 1, x, 2*x + 5)",
        "where(k > 1, x, 5)",
    ],
)
def test_a_kink_is_not(potential: str) -> None:
    refuse_jumps(model_of(SYSTEM.format(potential=potential, dissipation="abs(x_dot) + max(0, y_dot)**3")))


@pytest.mark.parametrize(
    "term", ["where(t < 1, 0, 1)*x_dot*exp(-t)", "x_dot**2*sign(t - 2)/5", "x_dot*sign(x)*t"]
)
def test_a_momentum_that_jumps_is_refused(term: str) -> None:
    with pytest.raises(InfiniteForce, match="'lagrangian' has a jump"):
        derive(model_of(f"coordinates: {{x: {{initial: 1}}}}\nlagrangian: x_dot**2/2 + {term}"))


PLACED = """
parameters: {{k: 2, a: 1}}
coordinates: {{x: {{initial: 0.3, velocity: 1}}, y: {{}}}}
masses: {{b: 1, c: a}}
embedding: {{b: [x, {position}], c: [0, y]}}
{constraint}
"""
RUSH = "has a time at which velocities are infinite"
KINK, JUMP = "has a kink, where velocities jump and the force is infinite", "has a jump, where the force is"


@pytest.mark.exhaustive(keep=7)
@pytest.mark.parametrize(
    ("position", "constraint", "message"),
    [
        ("k*max(0, x - a)", "", f"the position of 'b' {KINK}"),
        ("max(x, t)", "", f"the position of 'b' {KINK}"),
        ("y + abs(t - a)", "", f"the position of 'b' {KINK}"),
        ("y + asin(sin(t))", "", f"the position of 'b' {KINK}"),
        ("where(x < a, 0, k)", "", f"the position of 'b' {JUMP}"),
        ("y + k*max(0, t - a)**0.5", "", f"the position of 'b' {RUSH}"),
        ("y*(1 + max(0, t - 1)**(1/3))", "", f"the position of 'b' {RUSH}"),
        ("y + abs(sin(t))**0.7", "", f"the position of 'b' {RUSH}"),
        ("y", "constraints: {f: 'y - max(0, t - a)**0.5'}", f"constraint 'f' {RUSH}"),
        ("y", "constraints: {f: 'y - k*max(0, x - a)'}", f"constraint 'f' {KINK}"),
        ("y", "constraints: {f: 'y - max(0, t - a)'}", f"constraint 'f' {KINK}"),
        ("y", "constraints: {f: 'y - sqrt((x - a)**2)'}", f"constraint 'f' {KINK}"),
        ("y", "constraints: {f: 'y - where(t < a, 0, 1)*x'}", f"constraint 'f' {JUMP}"),
        ("y", "nonholonomic: {g: 'y_dot - x_dot*where(x < a, 0, 1)'}", f"constraint 'g' {JUMP}"),
        ("y", "nonholonomic: {g: 'y_dot - where(t < a, 0, 1)'}", f"constraint 'g' {JUMP}"),
    ],
)
def test_velocities_that_would_have_to_jump_are_refused(position, constraint, message) -> None:
    with pytest.raises(InfiniteForce, match=message):
        derive(model_of(PLACED.format(position=position, constraint=constraint)))


@pytest.mark.parametrize(
    ("position", "constraint"),
    [
        ("y + sqrt(1 - cos(t))", ""),
        ("y", "constraints: {f: 'y - sqrt(1 - cos(t))'}"),
        ("y + abs(sin(x))*x", ""),
    ],
)
def test_kinks_at_many_places_are_refused_in_a_run(position, constraint) -> None:
    with pytest.raises(InfiniteForce, match=r"with the parameters of this run, .* has a kink"):
        refuse_jumps_in_numbers(model_of(PLACED.format(position=position, constraint=constraint)))


@pytest.mark.parametrize(
    ("position", "constraint"),
    [
        ("k*max(0, x - a)**2", ""),
        ("y + max(0, t - a)**1.5", ""),
        ("y + k*max(0, t - 1)**1.01", ""),
        ("y + where(t > 1, tanh(1e6*(t - 1)**2), 0)", ""),
        ("y", "nonholonomic: {g: 'y_dot - max(0, t - a)**0.5'}"),
        ("y", "constraints: {f: 'y - max(0, x - a)**2 - max(0, t - a)**2'}"),
        ("y", "nonholonomic: {g: 'y_dot - x_dot*max(0, x - a) - max(0, t - a)'}"),
    ],
)
def test_velocities_may_have_kinks(position, constraint) -> None:
    derive(model_of(PLACED.format(position=position, constraint=constraint)))


@pytest.mark.parametrize("constraint", ["abs(x) - k", "abs(x) - 1 - k", "where(x < 0, x + k, x - k)"])
def test_a_kink_that_the_constraint_keeps_away_from_does_no_harm(constraint) -> None:
    """In polar coordinates norm(p) is abs(r), and norm(p) = l has no kink at r = 0."""
    text = PLACED.format(position="y", constraint=f"constraints: {{f: '{constraint}'}}")
    derive(model_of(text))
    numbers = text.replace("{k: 2, a: 1}", "{}").replace("c: a", "c: 1")
    refuse_jumps_in_numbers(model_of(numbers.replace(constraint, constraint.replace("k", "2"))))


def test_whether_a_constraint_keeps_away_from_its_kink_is_decided_by_numbers(tmp_path) -> None:
    text = PLACED.format(position="y", constraint="constraints: {f: 'abs(x) - 1 + a'}")
    (tmp_path / "a.yaml").write_text(text)
    for a, code in (("0.7", 0), ("1", 3)):
        sets = [f"--set={one}" for one in (f"a={a}", "x=1-a", "x_dot=0", "y=0")]
        done = lagrange("check", "a.yaml", *sets, cwd=tmp_path)
        assert done.returncode == code
        assert ("constraint 'f' has a kink" in done.stderr) == bool(code)


def test_a_kink_by_the_numbers_of_a_run_is_refused_at_its_place(tmp_path) -> None:
    # Both sides meet, and have the same slope if k = 1.
    given = "y - where(x < 1, (x - 1)**2 + x - 1, k*(x - 1))"
    text = PLACED.format(position="y", constraint=f"constraints: {{f: '{given}'}}")
    (tmp_path / "a.yaml").write_text(text)
    told = "constraint 'f' has a kink"
    for k, code in (("1", 0), ("3", 3)):
        done = lagrange("check", "a.yaml", "--set", f"k={k}", "--set", "y=-0.21", cwd=tmp_path)
        assert done.returncode == code
        assert (told in done.stderr and "a.yaml:6:" in done.stderr) == bool(code)


def test_an_energy_may_be_switched_on() -> None:
    switched = "where(t < 1, 0, x**2) + where(t < 2, 0, 1)*max(0, t - 2)*x_dot"
    derive(model_of(f"coordinates: {{x: {{initial: 1}}}}\nlagrangian: x_dot**2/2 - {switched}"))


def test_friction_that_has_an_energy_which_jumps_is_refused() -> None:
    with pytest.raises(InfiniteForce, match="'dissipation' has a jump"):
        derive(model_of(SYSTEM.format(potential="where(t > 1, x, 5)", dissipation="where(x_dot > 0, 1, 2)")))


@pytest.mark.parametrize("command", ["equations", "check"])
def test_where_it_stands_is_shown(tmp_path, command) -> None:
    text = SYSTEM.format(potential="{a: x**2, b: 'where(x > 1, k, 0)'}", dissipation="0")
    (tmp_path / "wall.yaml").write_text(text.replace('"{a', "{a").replace('}"', "}"), encoding="utf-8")
    run = lagrange(command, "wall.yaml", cwd=tmp_path)
    assert run.returncode == 3
    assert "wall.yaml:6:26: 'potential' has a jump, where the force is infinite" in run.stderr


RUN = """
parameters: {a: 1, b: 1, k: 2}
coordinates: {x: {initial: 0.3, velocity: 0.1}, y: {initial: 1}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: "POTENTIAL"
solve: {stop: 0.1, samples: 2}
"""


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("potential", "jumps"),
    [
        ("where(x > a, k*(x - b), 0)", "b=1.5"),
        ("where(x > a, x**2 + y, b**2 + y)", "b=1.001"),
        ("k*where(x**2 + y**2 > a**2, x**2 + y**2 - b**2, 0)", "b=0.5"),
        ("where(x > a, k/(x + b), k/2/a)", "b=2"),
        ("where(x*y > a, sqrt(x*y), 1)*where(x + y > 3, 3, x + y)", "a=2"),
    ],
)
def test_a_jump_with_the_parameters_of_a_run_is_refused(tmp_path, potential, jumps):
    (tmp_path / "a.yaml").write_text(RUN.replace("POTENTIAL", potential))
    assert lagrange("solve", "a.yaml", cwd=tmp_path).returncode == 0
    refused = lagrange("solve", "a.yaml", "--set", jumps, "--force", cwd=tmp_path)
    assert refused.returncode == 3
    assert "a.yaml:6:" in refused.stderr
    assert "with the parameters of this run, 'potential' has a jump" in refused.stderr
    over = jumps.partition("=")[0] + "=1," + jumps.partition("=")[2]
    assert lagrange("sweep", "a.yaml", "--over", over, cwd=tmp_path).returncode == 3


@pytest.mark.parametrize(
    ("potential", "name", "jumping"),
    [
        ("where(x > a, k*(x - b), 0)", "b", 1.5),
        ("where(x > a, x**2 + y, b**2 + y)", "b", 1.001),
        ("k*where(x**2 + y**2 > a**2, x**2 + y**2 - b**2, 0)", "b", 0.5),
        ("where(x > a, k/(x + b), k/2/a)", "b", 2),
        ("where(x > 0, b*(b - 1), 0)", "b", 2),
        ("where(x > b, sin(k*x)**2 + cos(x*k)**2, a)", "a", 2),
    ],
)
def test_no_member_of_an_ensemble_that_jumps_is_missed(potential, name, jumping):
    model = model_of(RUN.replace("POTENTIAL", potential))
    refuse_jumps(model)
    assert jumps_may_depend_on(model, {name})
    values = {"a": 1.0, "b": 1.0, "k": 2.0, name: np.ones(5000)}
    values[name][4711] = jumping
    assert may_jump(model, values, 5000).nonzero()[0].tolist() == [4711]


@pytest.mark.parametrize("potential", ["max(0, x - a)**2", "k*where(x > b, (x - b)**3, 0)", "abs(x*a - b)"])
def test_whether_an_energy_jumps_does_not_depend_on_where_its_kink_is(potential):
    assert not jumps_may_depend_on(model_of(RUN.replace("POTENTIAL", potential)), {"a", "b", "k"})


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    "potential",
    [
        "where(x**2 + y**2 > a**2, sqrt(x**2 + y**2 - a**2), 0)",
        "k/abs(x**2 - a) + log(abs(x*y - a)) + where(x > 1000*a, (x - 1000*b)**2, 0)",
        "sign(x)*(exp(x) - 1) + where(x - 0.3 > 0.1 + 0.2 + a, (x - 0.6 - b)*1e9, 0)",
    ],
)
def test_a_pole_or_a_kink_is_no_jump(tmp_path, potential):
    (tmp_path / "a.yaml").write_text(RUN.replace("POTENTIAL", potential))
    refused = lagrange("solve", "a.yaml", cwd=tmp_path)
    assert "has a jump" not in refused.stderr


KICK = """
parameters: {a: 1, b: 1, k: 2}
coordinates: {x: {initial: 2, velocity: -0.3}}
masses: {p: 1}
embedding: {p: [x]}
potential: "where(x > a, k*(x - b), 0)"
events: {moves: {when: t - 0.1, action: {set: SET}}}
"""


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_motion_ends_before_an_action_that_makes_an_energy_jump(precision, tmp_path):
    (tmp_path / "a.yaml").write_text(KICK.replace("SET", "{b: 0.5}"))
    asked = ("--stop", "3", "--samples", "4", "--precision", precision)
    done = lagrange("solve", "a.yaml", *asked, cwd=tmp_path)
    assert done.returncode == 4
    said = "an action would make an energy jump at t = 0.1, where "
    assert said in done.stderr and "(event 'moves' makes 'potential' jump)" in done.stderr
    (tmp_path / "b.yaml").write_text(KICK.replace("SET", "{a: 0.5, b: 0.5}"))
    done = lagrange("solve", "b.yaml", *asked, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
