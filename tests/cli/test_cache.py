"""``solve`` with the cache of compiled programs, and ``lagrange cache``."""

import json
import os

import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.run.timings import STAGES, Stopwatch
from tests.support.command import SYSTEMS

HOOP = str(SYSTEMS / "rotating_hoop.yaml")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache, and a directory to write to."""
    monkeypatch.setenv("LAGRANGE_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "cache"


def solve(capsys, *arguments):
    assert main(["solve", HOOP, "--force", "--json", *arguments]) == 0
    with open("rotating_hoop.h5", "rb") as file:
        return json.loads(capsys.readouterr().out)["seconds"], file.read()


def info(capsys):
    assert main(["cache", "info", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_second_run_compiles_nothing_and_writes_the_same_bytes(capsys):
    first, written = solve(capsys)
    assert first["compile"] > 0 and first["derive"] > 0
    second, again = solve(capsys)
    assert second["compile"] == 0 and second["derive"] == 0
    assert written == again == solve(capsys, "--no-cache")[1]


@pytest.mark.exhaustive(keep=0.4)
def test_other_numbers_are_served_by_the_same_program(capsys):
    solve(capsys)
    for change in (["--set", "omega=3"], ["--set", "theta=1"], ["--stop", "1"], ["--samples", "7"]):
        seconds, written = solve(capsys, *change)
        assert seconds["compile"] == 0
        assert written == solve(capsys, *change, "--no-cache")[1]
    assert info(capsys)["entries"] == 1
    assert solve(capsys, "--tolerance", "1e-9")[0]["compile"] > 0


@pytest.mark.exhaustive(keep=0.4)
def test_a_damaged_program_is_rebuilt_in_silence(capsys, folder):
    _, written = solve(capsys)
    (entry,) = folder.glob("*.code")
    sound = entry.read_bytes()
    middle = len(sound) // 2
    for damaged in (b"", sound[:middle], sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1 :]):
        entry.write_bytes(damaged)
        seconds, again = solve(capsys)
        assert seconds["compile"] > 0 and again == written
        assert solve(capsys)[0]["compile"] == 0


@pytest.mark.parametrize("switch", [["--no-cache"], []], ids=["option", "environment"])
def test_without_the_cache_nothing_is_kept(capsys, folder, monkeypatch, switch):
    if not switch:
        monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    for _ in range(2):
        assert solve(capsys, *switch)[0]["compile"] > 0
    assert not folder.exists()


def test_a_folder_that_cannot_be_used_costs_a_compilation_and_no_word(capsys, folder):
    folder.write_text("a file")
    assert main(["solve", HOOP, "--quiet"]) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")
    assert info(capsys)["used"] is False


def test_info_counts_and_clear_removes(capsys, folder):
    empty = info(capsys)
    assert (empty["folder"], empty["used"], empty["entries"]) == (str(folder), True, 0)
    assert not folder.exists()
    solve(capsys)
    full = info(capsys)
    assert (full["entries"], full["bytes"]) == (1, sum(path.stat().st_size for path in folder.glob("*.code")))
    assert main(["cache", "clear"]) == 0
    assert capsys.readouterr().out == "removed 1 compiled program\n"
    assert main(["cache", "clear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"folder": str(folder), "removed": 0}
    assert solve(capsys)[0]["compile"] > 0


def test_clear_of_what_is_not_there(capsys):
    assert main(["cache", "clear"]) == 0
    assert capsys.readouterr().out == "removed 0 compiled programs\n"


def test_info_says_in_a_line_why_the_cache_is_not_used(capsys, folder, monkeypatch):
    folder.mkdir(mode=0o700)
    os.chmod(folder, 0o777)
    assert main(["cache", "info"]) == 0
    assert capsys.readouterr().out == f"folder: {folder}\nnot used: other users may write to it\n"
    assert main(["cache", "clear"]) == 5
    assert "could not be cleared: other users may write to it" in capsys.readouterr().err
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    assert main(["cache", "info"]) == 0
    assert "not used: LAGRANGE_NO_CACHE is set" in capsys.readouterr().out


def test_info_says_where_nothing_can_be_written(capsys, folder, monkeypatch):
    def never(_path, mode):
        return not mode & os.W_OK

    solve(capsys)
    monkeypatch.setattr("os.access", never)
    found = info(capsys)
    assert found["used"] and found["entries"] == 1
    assert found["reason"] == f"no permission to write in {folder}"
    assert main(["cache", "info"]) == 0
    assert f"no program is added: no permission to write in {folder}" in capsys.readouterr().out
    monkeypatch.setenv("LAGRANGE_CACHE_DIR", str(folder / "a" / "b"))
    found = info(capsys)
    assert not found["used"] and found["reason"] == f"no permission to write in {folder}"


def test_timings_show_each_stage_once(capsys):
    for hit in (False, True):
        assert main(["solve", HOOP, "--force", "--timings"]) == 0
        lines = capsys.readouterr().out.splitlines()
        table = [line for line in lines if line.startswith("  ") and " s" in line and line[14:21].strip()]
        names = [line[:12].strip() for line in table if line[12:20].strip().replace(".", "").isdigit()]
        skipped = {"derive", "compile"} if hit else set()
        stages = ["cache hit" if hit and name == "cache" else name for name in STAGES if name not in skipped]
        assert names == ["start", *stages, "total"]


def test_timings_say_nothing_where_quiet_is_asked_for(capsys):
    assert main(["solve", HOOP, "--timings", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_a_stage_within_another_stops_its_clock(monkeypatch):
    now = iter(range(100))
    monkeypatch.setattr("time.perf_counter", lambda: next(now))
    watch = Stopwatch()  # at 0
    with watch.stage("integrate"):  # 1 to 6
        with watch.stage("write"):  # 2 to 3
            pass
        with watch.stage("write"):  # 4 to 5
            pass
    assert watch.seconds["integrate"] == 3 and watch.seconds["write"] == 2
    assert watch.report()["total"] == 7
