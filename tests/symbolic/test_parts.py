"""Equations that are too long to print: what is short is printed as it is beside equations."""

from __future__ import annotations

import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.model.build import build_model
from lagrange_cli.symbolic import derive, parts

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


@pytest.mark.exhaustive(keep=0.2)
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


@pytest.mark.exhaustive(keep=0.6)
def test_what_was_derived_of_equations_that_are_too_long_is_not_derived_again(tmp_path, monkeypatch, capsys):
    """The model is built once with sympy, and no momentum that was found before is put in order again."""
    (tmp_path / "sledge.yaml").write_text(SLEDGE, encoding="utf-8")
    monkeypatch.setenv("LAGRANGE_LIMITS", "printed=180")
    built, tidied = [], []
    build, tidy = build_model, derive.tidy

    def counting_build(spec, algebra):
        built.append(algebra)
        return build(spec, algebra)

    def counting_tidy(expression, order):
        tidied.append(expression)
        return tidy(expression, order)

    monkeypatch.setattr("lagrange_cli.model.build.build_model", counting_build)
    for module in (derive, parts):
        monkeypatch.setattr(module, "tidy", counting_tidy)
    assert main(["equations", str(tmp_path / "sledge.yaml")]) == 0
    assert capsys.readouterr().out.count("too long") == 1
    assert sum(isinstance(one, SympyAlgebra) for one in built) == 1
    assert len({*map(str, tidied)}) == len(tidied)
