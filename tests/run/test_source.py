"""Files that are not there: the one that was perhaps meant is named."""

from __future__ import annotations

import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.errors import FileError
from lagrange_cli.run.source import read_file

FILES = ("wedge.yaml", "chain_of_beads.yaml", "notes")


@pytest.fixture
def folder(tmp_path):
    for name in FILES:
        (tmp_path / name).write_text("a: 1")
    (tmp_path / "ladders.yaml").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("wedge.yml", "wedge.yaml"),
        ("wedge", "wedge.yaml"),
        ("Wedge.yaml", "wedge.yaml"),
        ("chain_of_bead.yaml", "chain_of_beads.yaml"),
        ("ladder.yaml", ""),  # a folder
        ("other", ""),
    ],
)
def test_a_file_of_a_similar_name_is_named(folder, monkeypatch, name, meant):
    for place in (folder / name, name):
        monkeypatch.chdir(folder)
        with pytest.raises(FileError) as caught:
            read_file(str(place))
        said = str(caught.value).partition(": no such file")[2]
        shown = str(folder / meant) if place != name else meant
        assert said == (f"\n  did you mean {shown}?" if meant else "")
        assert not meant or read_file(shown) == b"a: 1"


def test_a_folder_that_is_not_there_has_no_files():
    with pytest.raises(FileError, match=r"no such file$"):
        read_file("/nonexistent/a.yaml")


@pytest.mark.parametrize("name", ["foo", "infos", "Clear"])
def test_commands_of_a_group_are_named(capsys, name):
    assert main(["cache", name]) == 2
    assert (
        f"there is no command '{name}'" in (said := capsys.readouterr().err) and "known: info, clear" in said
    )
