"""The tools that compare two versions: digests of object code, and times in turns."""

import json
import sys
from pathlib import Path

import pytest

from benchmarks import ROOT
from benchmarks.tools import versions
from benchmarks.tools.object_code import Code, code_of, compared, main

PROGRAM = "define double @{name}(double %x) {{\n  %y = fmul double %x, {factor}\n  ret double %y\n}}\n"


def program(name: str, factor: str) -> Code:
    """A function that multiplies."""
    return code_of(PROGRAM.format(name=name, factor=factor), 3)


def test_a_digest_is_that_of_the_code_whatever_its_functions_are_called() -> None:
    triple = program("triple", "3.0")
    assert triple.digest == program("threefold", "3.0").digest
    assert triple.digest != program("triple", "5.0").digest
    assert (triple.operations, [*triple.functions]) == (1, ["triple"])


def test_programs_that_differ_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    before = {"a": program("triple", "3.0"), "b": program("triple", "3.0")}
    after = {"a": program("triple", "3.0"), "b": program("threefold", "5.0"), "c": program("f", "1.0")}
    assert compared(before, after) == 2
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()[:2]] == ["b", "c"]


@pytest.mark.exhaustive(keep=0.15)
def test_the_object_code_of_a_system_is_that_of_the_next_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "before.json"
    chosen = ["object_code", "--systems", "pendulum", "--kinds", "rates"]
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "argv", [*chosen, "--write", str(file)])
    assert main() == 0
    monkeypatch.setattr(sys, "argv", [*chosen, "--compare", str(file)])
    assert main() == 0
    assert "0 of 4 programs differ" in capsys.readouterr().out
    data = json.loads(file.read_text(encoding="utf-8"))
    data["programs"]["pendulum rates q,v 3"]["digest"] = "another"
    data["made by"] = "another compiler"
    file.write_text(json.dumps(data), encoding="utf-8")
    assert main() == 1
    assert "1 of 4 programs differ" in capsys.readouterr().out


@pytest.mark.exhaustive(keep=0.35)
def test_versions_are_compared_by_the_commands_of_the_suites(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["versions", "--before", str(ROOT), "--runs", "1", "--only=--help"])
    versions.main()  # its exit status depends on times
    assert "| startup: lagrange --help | " in capsys.readouterr().out
    named = [command.name.partition(":")[0] for command in versions.commands()]
    assert set(named) == {"integration", "chain", "ensemble", "startup"}


@pytest.mark.exhaustive(keep=0.15)
def test_the_seconds_of_a_run_are_those_of_its_integration(tmp_path: Path) -> None:
    tmp_path.joinpath("systems").symlink_to(ROOT / "systems")
    solve = ("solve", "systems/pendulum.yaml", "--stop", "1", "--json", "--no-cache")
    whole, part = (versions.Command("pendulum", (*solve, "--force"), whole) for whole in (True, False))
    taken = [versions.seconds_of(one, False, ROOT, tmp_path) for one in (part, whole)]
    assert 0 < taken[0] < taken[1]


def test_sections_that_not_both_versions_know_are_left_out_for_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refusal(system: str, root: Path, folder: Path) -> str:
        """Neither version knows ``bodies``; the old one does not know ``time`` and ``draw`` either."""
        text = (folder / system).read_text(encoding="utf-8")
        unknown = [key for key in ("time", "draw") if f"\n{key}:" in text and root.name == "old"]
        if "\nbodies:" in text:
            return f"{system}: 'bodies' is not supported yet\n"
        return "".join(f"{system}:{n}:1: unknown key '{key}'\n" for n, key in enumerate(unknown, 40))

    monkeypatch.setattr(versions, "refusal", refusal)
    places = {name: (tmp_path / name, tmp_path / f"in_{name}") for name in ("new", "old")}
    for _, folder in places.values():
        (folder / "systems").mkdir(parents=True)
    system = "systems/solar_system.yaml"
    assert versions.given_to_both(system, places) == ["time", "draw"]
    whole = (ROOT / system).read_text(encoding="utf-8")
    for _, folder in places.values():
        text = (folder / system).read_text(encoding="utf-8")
        assert text == whole.replace("time: {unit: d}\n", "").replace("draw: {trails: all}\n", "") != whole
    with pytest.raises(versions.NotRead, match="'bodies' is not supported yet"):
        versions.given_to_both("systems/coin.yaml", places)
