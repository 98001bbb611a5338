"""Edit and rerun: which outputs of earlier runs are replaced, and which are kept."""

import json
import os
from pathlib import Path

import h5py
import pytest

import lagrange_cli.cli.commands.solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.run import solve as running
from lagrange_cli.store import notes
from tests.cli.test_resume import Nervous
from tests.support.command import SYSTEMS

TEXT = (SYSTEMS / "pendulum.yaml").read_text(encoding="utf-8")
EDITED = TEXT.replace("l: {value: 1.0", "l: {value: 2.0")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the output of a system file that has been edited since."""
    monkeypatch.chdir(tmp_path)
    Path("pendulum.yaml").write_text(TEXT, encoding="utf-8")
    return tmp_path


def solve(*options: str) -> int:
    return main(["solve", "pendulum.yaml", *options])


def edit() -> None:
    assert EDITED != TEXT
    Path("pendulum.yaml").write_text(EDITED, encoding="utf-8")


def test_what_an_earlier_run_of_the_file_has_written_is_replaced(folder, capsys):
    assert solve() == 0
    assert "replaced" not in capsys.readouterr().out
    edit()
    assert solve() == 0
    said = capsys.readouterr()
    assert (
        "wrote pendulum.h5 in" in said.out
        and "(replaced the result of an earlier run of this file)" in said.out
    )
    assert said.err == "" and sorted(os.listdir()) == ["pendulum.h5", "pendulum.yaml"]
    with h5py.File("pendulum.h5") as file:
        assert json.loads(file.attrs["parameters"])["l"] == 2.0
    assert solve("--json", "--stop", "30") == 0  # more is asked than before
    assert json.loads(capsys.readouterr().out)["replaced"] is True


def test_the_output_does_not_depend_on_where_the_file_is(folder):
    assert solve() == 0
    Path("elsewhere").mkdir()
    assert main(["solve", os.path.abspath("pendulum.yaml"), "-o", "elsewhere/other.h5"]) == 0
    assert Path("elsewhere/other.h5").read_bytes() == Path("pendulum.h5").read_bytes()


def test_one_of_a_link_to_the_file_is_replaced_too(folder):
    assert solve() == 0
    edit()
    Path("there").mkdir()
    Path("there/pendulum.yaml").symlink_to("../pendulum.yaml")
    assert main(["solve", "there/pendulum.yaml"]) == 0


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "command",
    [("plot", "--stop", "1"), ("view",), ("animate", "--stop", "0.1", "--speed", "0.5", "-o", "a.gif")],
)
def test_pictures_and_pages_say_so_too(folder, capsys, command):
    run = [command[0], "pendulum.yaml", *command[1:]]
    assert main(run) == 0
    assert "replaced" not in capsys.readouterr().out
    edit()
    assert main(run) == 0
    assert "(replaced the result of an earlier run of this file)" in capsys.readouterr().out
    assert main([*run, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["replaced"] is True


def test_sweeps_likewise(folder, capsys):
    run = ["sweep", "pendulum.yaml", "--over", "m=1,2"]
    assert main(run) == 0
    edit()
    assert main([*run, "--outputs", "q"]) == 0
    assert "(replaced the result of an earlier run" in capsys.readouterr().out
    assert main(run) == 5
    assert "already exists and was made with --outputs q: --force" in capsys.readouterr().err
    assert main(["solve", "pendulum.yaml", "-o", "pendulum_sweep.h5"]) == 5
    assert "and was made with 'lagrange sweep'" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.5)
def test_a_protected_one_is_kept(folder, capsys):
    assert solve() == 0
    Path("pendulum.h5").chmod(0o444)
    before = Path("pendulum.h5").read_bytes()
    edit()
    assert solve() == 5
    assert "pendulum.h5 already exists and is write-protected: --force" in capsys.readouterr().err
    assert Path("pendulum.h5").read_bytes() == before
    assert solve("--force") == 0


OTHERS = {
    "another time": (["--stop", "30"], [], "made with --stop 30"),
    "another value": (["--set", "m=2"], ["--set", "m=3"], "made with --set m=2"),
    "other samples": (["--samples", "7"], ["--step", "0.1"], "made with --samples 7"),
    "other numbers": (["--precision", "double-double", "--stop", "0.1"], ["--stop", "0.1"], "double-double"),
    "estimates": (["--certify"], [], "made with --certify --digits 6"),
    "other outputs": (["--outputs", "all"], ["--outputs", "q"], "made with --outputs all"),
}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("earlier", "later", "message"), OTHERS.values(), ids=OTHERS)
def test_a_run_that_was_asked_for_otherwise_is_kept(folder, earlier, later, message, capsys):
    assert solve(*earlier) == 0
    before = Path("pendulum.h5").read_bytes()
    edit()
    assert solve(*later) == 5
    error = capsys.readouterr().err
    assert "pendulum.h5 already exists and was" in error and message in error
    assert "--force replaces it, --output names another" in error
    assert Path("pendulum.h5").read_bytes() == before
    assert solve(*earlier) == 0  # the same again


def changed_data():
    with h5py.File("pendulum.h5", "r+") as file:
        file["q/theta"][0] = 7.0


def added_data():
    with h5py.File("pendulum.h5", "r+") as file:
        file["mine"] = [1.0]


def put_another_in_its_place():
    content = Path("pendulum.h5").read_bytes()
    Path("pendulum.h5").unlink()
    Path("pendulum.h5").write_bytes(content)


@pytest.mark.parametrize("change", [changed_data, added_data, put_another_in_its_place])
def test_an_output_that_was_changed_is_kept(folder, change, capsys):
    assert solve() == 0
    change()
    before = Path("pendulum.h5").read_bytes()
    assert solve() == 5
    assert "pendulum.h5 already exists: --force" in capsys.readouterr().err
    assert Path("pendulum.h5").read_bytes() == before


def test_an_output_that_is_changed_during_the_run_is_kept(folder, monkeypatch, capsys):
    assert solve() == 0

    def changing(*arguments, plain=running.prepare_all):
        added_data()
        return plain(*arguments)

    monkeypatch.setattr(running, "prepare_all", changing)
    assert solve() == 5
    assert "pendulum.h5 was changed during this run and was not replaced" in capsys.readouterr().err
    assert "mine" in h5py.File("pendulum.h5") and h5py.is_hdf5(".pendulum.h5.part")


def test_one_of_another_file_of_the_same_name_is_kept(folder, capsys):
    assert solve("-o", "out.h5") == 0
    Path("other").mkdir()
    Path("other/pendulum.yaml").write_text(TEXT, encoding="utf-8")
    assert main(["solve", "other/pendulum.yaml", "-o", "out.h5"]) == 5
    assert "out.h5 already exists: --force" in capsys.readouterr().err


def test_one_of_standard_input_is_kept(folder, monkeypatch):
    for status in (0, 5):
        with open("pendulum.yaml", encoding="utf-8") as file:
            monkeypatch.setattr("sys.stdin", file)
            assert main(["solve", "-"]) == status


def test_the_result_of_a_long_run_is_kept(folder, monkeypatch, capsys):
    assert solve() == 0
    monkeypatch.setattr(notes, "LONG", 0.0)
    assert solve() == 5
    assert "already exists and took " in capsys.readouterr().err


def test_without_notes_everything_is_kept(folder, monkeypatch, capsys):
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    assert [solve(), solve()] == [0, 5]
    monkeypatch.delenv("LAGRANGE_NO_CACHE")
    assert [solve(), solve("--force"), solve()] == [5, 0, 0]


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b'{"system": 3}', b"\xff", b"[" * 10**6])
def test_a_note_that_is_none_is_ignored(folder, content):
    assert solve() == 0
    kept = notes.notes()
    assert kept is not None and notes.read_note(folder / "pendulum.h5") is not None
    kept.store(str(folder / "pendulum.h5"), content)
    assert solve() == 5


def test_an_interrupted_run_is_kept_and_every_message_names_the_way_on(folder, monkeypatch, capsys):
    monkeypatch.setattr(solving, "Interrupts", Nervous)
    monkeypatch.setattr(Nervous, "patience", 1)
    assert solve("--stop", "1e5") == 130
    assert "interrupted at t = " in (error := capsys.readouterr().err) and "--resume continues" in error
    edit()
    assert solve() == 5
    error = capsys.readouterr().err
    assert "pendulum.h5 contains an interrupted run: --resume continues it" in error
    assert "--force replaces it, --output names another" in error


FALL = "coordinates: {r: {initial: 1.0, velocity: %s}}\nlagrangian: r_dot**2/2 + 1/r\nsolve: {stop: 10}\n"
ESCAPE, COLLISION = FALL % 2, FALL % 0


def write(text: str) -> bytes:
    """A system file with this text; returns the output that there is."""
    Path("pendulum.yaml").write_text(text)
    output = Path("pendulum.h5")
    return output.read_bytes() if output.exists() else b""


def test_what_failed_is_kept(folder):
    write(COLLISION)
    assert [solve(), solve()] == [4, 5]


def test_a_run_that_fails_does_not_replace_a_result_by_less(folder, capsys):
    write(ESCAPE)
    assert solve() == 0
    before = write(COLLISION)
    for _ in range(2):  # the second time there is an earlier failure
        capsys.readouterr()
        assert solve() == 4
        said = capsys.readouterr().out
        assert "wrote pendulum_failed.h5 in" in said
        assert "; pendulum.h5 is still the result of an earlier run" in said and "replaced" not in said
        assert Path("pendulum.h5").read_bytes() == before
        assert sorted(os.listdir()) == ["pendulum.h5", "pendulum.yaml", "pendulum_failed.h5"]
    with h5py.File("pendulum_failed.h5") as file:
        assert file.attrs["status"] == "failed" and 1 < file["t"][-1] < 1.12
    write(ESCAPE.replace("velocity: 2", "velocity: 3"))
    assert solve("--json") == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["replaced"] is True
    write(COLLISION)
    assert solve("--force", "--json") == 4
    told = json.loads(capsys.readouterr().out)
    assert (told["output"], told["kept"]) == ("pendulum.h5", None)
    with h5py.File("pendulum.h5") as file:
        assert file.attrs["status"] == "failed"


def test_no_other_file_is_in_the_way_of_what_failed(folder, capsys):
    Path("sub").mkdir()
    write(ESCAPE)
    assert solve("-o", "sub/out.h5") == 0
    write(COLLISION)
    Path("sub/out_failed.h5").write_text("mine")
    Path("sub/out_failed_2.h5").symlink_to("nowhere")
    assert solve("-o", "sub/out.h5", "--json") == 4
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (told["output"], told["kept"]) == ("sub/out_failed_3.h5", "sub/out.h5")
    assert Path("sub/out_failed.h5").read_text() == "mine"
    with h5py.File("sub/out_failed_3.h5") as file:
        assert file.attrs["status"] == "failed"


def test_an_interrupted_run_does_not_replace_a_result_and_can_be_continued(folder, monkeypatch, capsys):
    assert solve("--stop", "300") == 0
    edit()
    before = Path("pendulum.h5").read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(solving, "Interrupts", Nervous)
        patch.setattr(Nervous, "patience", 1)
        assert solve("--stop", "300") == 130
    way_on = "--resume --output pendulum_interrupted.h5"
    assert f"; {way_on} continues from there" in capsys.readouterr().err
    assert Path("pendulum.h5").read_bytes() == before
    assert solve("--stop", "300", *way_on.split()) == 0
    assert "continued from t = " in capsys.readouterr().out
    assert solve("--stop", "300") == 0
    assert Path("pendulum.h5").read_bytes() == Path("pendulum_interrupted.h5").read_bytes() != before


COMMANDS = {
    "run": ["solve", "pendulum.yaml", "-o", "run.csv"],
    "pendulum_sweep": ["sweep", "pendulum.yaml", "--over", "r=1,2"],
    "pendulum_section": ["section", "pendulum.yaml", "--where", "r - 0.5", "--direction", "either"],
    "table": ["section", "pendulum.yaml", "--where", "r - 0.5", "--stop", "3", "-o", "table.csv"],
    "grid": ["section", "pendulum.yaml", "--where", "r - 0.5", "--over", "r=1,2", "-o", "grid.h5"],
}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("stem", "command"), COMMANDS.items(), ids=COMMANDS)
def test_tables_sweeps_and_sections_that_fail_replace_nothing(folder, stem, command, capsys):
    stop = [] if "--stop" in command else ["--stop", "10"]
    write(ESCAPE)
    assert main([*command, *stop]) == 0
    [output] = set(os.listdir()) - {"pendulum.yaml"}
    before = Path(output).read_bytes()
    write(COLLISION)
    assert main([*command, *stop]) == 4
    apart = f"{stem}_failed{Path(output).suffix}"
    assert f"wrote {apart} in" in capsys.readouterr().out
    assert Path(output).read_bytes() == before and set(os.listdir()) == {"pendulum.yaml", output, apart}


def test_a_file_that_is_wrong_leaves_the_earlier_result(folder):
    assert solve() == 0
    before = write(TEXT.replace("l*sin(theta)", "l*sin(thta)"))
    assert solve() == 3
    assert Path("pendulum.h5").read_bytes() == before and len(os.listdir()) == 2
