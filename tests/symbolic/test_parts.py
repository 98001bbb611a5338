"""Equations that are too long to print: what is short is printed as it is beside equations."""

from __future__ import annotations

import pytest

from lagrange_cli.cli.main import main

SLEDGE = """
name: sledge
parameters: {m: 2, g: 9.81}
coordinates: {x: {initial: 0}, y: {initial: 0}, a: {initial: 0.1, velocity: 1}, z: {initial: 0}}
masses: {one: m, two: m}
embedding:
  one: [x, y]
  two: [x + cos(a)*(2 + sin(x)), y + sin(a)*cosh(x), z]
potential: m*g*x
nonholonomic: {blade: x_dot*sin(a) - y_dot*cos(a)}
"""


@pytest.mark.parametrize("format_", ["text", "unicode"])
def test_what_is_short_is_printed_as_beside_equations(format_, tmp_path, monkeypatch, capsys):
    (tmp_path / "sledge.yaml").write_text(SLEDGE, encoding="utf-8")
    command = ["equations", str(tmp_path / "sledge.yaml"), "--format", format_]
    assert main(command) == 0
    whole = capsys.readouterr().out
    monkeypatch.setenv("LAGRANGE_LIMITS", "printed=120")
    assert main(command) == 0
    part = capsys.readouterr().out
    assert "too long to print; 'check' and 'solve' do not need them printed" in part
    above, _, below = part.partition("\nEquations of motion\n")
    left_out = [line for line in above.splitlines() if "too long" in line]
    kept = [line for line in above.splitlines() if "too long" not in line]
    assert left_out and len(kept) > 12
    assert set(kept) <= set(whole.splitlines())
    assert "  h = T + U: L does not depend on t explicitly" in below


@pytest.mark.parametrize("asked", [["--json"], ["--form", "matrix"], ["--verify"]])
def test_what_cannot_go_without_equations_is_refused(asked, tmp_path, monkeypatch, capsys):
    (tmp_path / "sledge.yaml").write_text(SLEDGE, encoding="utf-8")
    monkeypatch.setenv("LAGRANGE_LIMITS", "printed=120")
    assert main(["equations", str(tmp_path / "sledge.yaml"), *asked]) == 3
    assert "an expression of the equations has" in "".join(capsys.readouterr())
