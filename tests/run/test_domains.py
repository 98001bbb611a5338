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
