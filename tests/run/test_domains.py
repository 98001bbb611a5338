"""Motions that begin where an energy has no value are refused, by every command, at their place."""

from __future__ import annotations

import pytest

from lagrange_cli.cli.main import main

OUTSIDE = """
name: a well
parameters: {a: 2}
coordinates: {x: {initial: 1}}
masses: {p: 1}
embedding: {p: [x]}
potential: x**2/2 + where(x > 9, log(x - 9), 0) - log(x - a)
"""
PLANE = """coordinates: {{x: {{initial: 0}}, y: {{initial: 1}}}}
masses: {{p: 1}}
embedding: {{p: [x, y]}}
potential: {potential}
generalized_forces: {{x: {force}}}
"""
TOLD = "log(x - a) has no value where the motion begins: x - a is -1"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "well.yaml").write_text(OUTSIDE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        ["check"], ["solve", "--stop", "1"], ["solve", "--stop", "1", "--precision", "double-double"],
        ["sweep", "--stop", "1", "--over", "x=1,1.5"], ["section", "--every", "1", "--crossings", "2"],
        ["bench", "--stop", "1"],
    ],
)  # fmt: skip
def test_a_logarithm_of_a_negative_number_is_no_energy(command, capsys):
    assert main([command[0], "well.yaml", *command[1:]]) == 3
    assert capsys.readouterr().err.startswith(f"well.yaml:7:51: {TOLD}\n")


def test_the_other_members_of_a_sweep_go_on(capsys):
    assert main(["sweep", "well.yaml", "--stop", "1", "--over", "x=3,1,4"]) == 4
    assert f"1 of 3 members failed; member 1 (x = 1): {TOLD}" in capsys.readouterr().err


@pytest.mark.parametrize("options", [["--set", "x=3"], ["--set", "a=0"]])
def test_where_it_has_a_value_the_motion_begins(options):
    assert main(["solve", "well.yaml", "--stop", "0.1", *options]) == 0


@pytest.mark.parametrize("command", [["check"], ["solve", "--stop", "1"]])
@pytest.mark.parametrize("y", ["0", "-1"])
def test_so_is_that_of_a_position_without_a_value(command, y, capsys, folder):
    (folder / "lost.yaml").write_text(
        f"coordinates: {{x: {{initial: 1}}, y: {{initial: {y}}}}}\nmasses: {{p: 1}}\n"
        "embedding: {p: [log(y), x]}\npotential: log(p.x) + y**2\n"
    )
    assert main([command[0], "lost.yaml", *command[1:]]) == 3
    assert "lost.yaml:4:12: the energy has no value where the motion begins" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("potential", "column", "told"),
    [
        ("y**2 - 1/x", 19, "1/x has no value where the motion begins: x is 0"),
        ("y**2 + sqrt(x - 2)", 19, "sqrt(x - 2) has no value where the motion begins: x - 2 is -2"),
        ("asin(x + 2)", 12, "asin(x + 2) has no value where the motion begins: x + 2 is 2"),
        ("where(y > 0, y**2*x**(-2), 0)", 30, "x**(-2) has no value where the motion begins: x is 0"),
        ("(x - y)**1.5", 12, "(x - y)**1.5 has no value where the motion begins: x - y is -1"),
    ],
)
def test_so_are_quotients_roots_and_powers_without_a_value(potential, column, told, capsys, folder):
    (folder / "a.yaml").write_text(PLANE.format(potential=potential, force=0))
    for command in (["check", "a.yaml"], ["solve", "a.yaml", "--stop", "1"]):
        assert main(command) == 3
        assert capsys.readouterr().err.startswith(f"a.yaml:4:{column}: {told}\n")


def test_so_are_forces_without_a_value(capsys, folder):
    (folder / "a.yaml").write_text(PLANE.format(potential="y**2", force="1/x"))
    assert main(["check", "a.yaml"]) == 3
    assert "a.yaml:5:25: 1/x has no value where the motion begins: x is 0\n" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "potential",
    [
        "x**2/x",
        "where(y > 2, (y - 2)**2/x, 0)",
        "y**2/y + x*x**3/x",
        "exp(-y/2e-3)",
        "exp(1e3*y)/(1 + exp(1e3*y))**2",
    ],
)
def test_what_cancels_or_does_not_count_is_no_obstacle(potential, folder):
    (folder / "a.yaml").write_text(PLANE.format(potential=potential, force="-x_dot/norm((1, x))"))
    assert main(["check", "a.yaml"]) == 0
    assert main(["solve", "a.yaml", "--stop", "0.1"]) == 0


BEYOND = ", or write max(0, x) if there is no force beyond"


@pytest.mark.parametrize(
    ("potential", "column", "told", "hint"),
    [
        ("y + x**1.5", 16, "x**1.5 has no Taylor series where the motion begins: x is 0", BEYOND),
        ("y + sqrt(x)", 16, "sqrt(x) has no derivative where the motion begins: x is 0", ""),
        ("abs(x)**0.5", 12, "abs(x)**0.5 has no derivative where the motion begins: abs(x) is 0", ""),
        ("norm((x, y - 1))", 12, "norm((x, y - 1)) has no derivative where the motion begins: it is 0", ""),
        ("acos(y)", 12, "acos(y) has no derivative where the motion begins: y is 1", ""),
    ],
)
def test_so_are_forces_without_a_series(potential, column, told, hint, capsys, folder):
    (folder / "a.yaml").write_text(PLANE.format(potential=potential, force=0))
    for command in (["check", "a.yaml"], ["solve", "a.yaml", "--stop", "1"]):
        assert main(command) == 3
        error = capsys.readouterr().err
        assert error.startswith(f"a.yaml:4:{column}: {told}\n")
        assert error.endswith(f"start from another state{hint}\n")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "potential",
    [
        "max(0, x)**1.5",
        "abs(x)**1.5",
        "where(x > 0, x**1.5, 0)",
        "sqrt(t)",
        "sqrt(x**2)",
        "sqrt(1 - cos(x))",
        "x*sqrt(max(0, t))",
    ],
)
def test_roots_that_go_on_beyond_and_those_without_a_force_are_no_obstacle(potential, folder):
    (folder / "a.yaml").write_text(PLANE.format(potential=f"y**2 + {potential}", force="-x_dot"))
    assert main(["check", "a.yaml"]) == 0
    assert main(["solve", "a.yaml", "--stop", "0.1"]) == 0
