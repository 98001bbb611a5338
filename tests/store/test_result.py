"""Outputs that are read for plots: what is in them, in parts; and files that are none."""

import os
import subprocess
import sys

import h5py
import numpy as np
import pytest

from lagrange_cli.errors import FileError
from lagrange_cli.store.result import Result
from tests.support.command import SYSTEMS, lagrange


@pytest.fixture(scope="module")
def output(tmp_path_factory):
    folder = tmp_path_factory.mktemp("result")
    path = folder / "run.h5"
    lagrange("solve", SYSTEMS / "pendulum.yaml", "--stop", "2", "-o", path, cwd=folder)
    return path


def test_a_result_has_what_the_file_has(output):
    with Result(str(output)) as result, h5py.File(output) as file:
        assert (result.kind, result.title) == ("motion", "pendulum")
        assert result.held["q/theta"].shape == file["q/theta"].shape
        assert (result.held["q/theta"].unit, result.held["q/theta"].axes) == ("rad", ("t",))
        np.testing.assert_array_equal(result.read("diagnostics/h"), file["diagnostics/h"][:])
        np.testing.assert_array_equal(result.read("q/theta", slice(5, 60, 7)), file["q/theta"][5:60:7])


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89HDF\r\n\x1a\n" + bytes(100)])
def test_another_file_is_refused(tmp_path, content):
    path = tmp_path / "other.h5"
    path.write_bytes(content)
    with pytest.raises(FileError, match="not an output of lagrange"):
        Result(str(path))


def test_a_file_that_was_cut_is_refused(output, tmp_path):
    path = tmp_path / "cut.h5"
    path.write_bytes(output.read_bytes()[:-50])
    with pytest.raises(FileError, match="not an output of lagrange, is damaged"):
        Result(str(path))


def test_a_file_without_permission_is_said_to_be_one(output, tmp_path, monkeypatch):
    path = tmp_path / "secret.h5"
    path.write_bytes(output.read_bytes())
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # the superuser may read all files
    with pytest.raises(FileError, match="could not be read: Permission denied"):
        Result(str(path))


def test_a_file_that_is_open_for_writing_elsewhere_is_said_to_be(output, tmp_path):
    path = tmp_path / "open.h5"
    path.write_bytes(output.read_bytes())
    writes = (
        "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print('open', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", writes, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None and other.stdout.readline() == b"open\n"
        with pytest.raises(FileError, match="is open for writing in another program: close it there"):
            Result(str(path))
        other.communicate()


def test_a_pipe_is_refused_at_once(tmp_path):
    path = tmp_path / "pipe.h5"
    os.mkfifo(path)
    with pytest.raises(FileError, match="not an output"):
        Result(str(path))
    with pytest.raises(FileError, match="is a directory, not an output"):
        Result(str(tmp_path))


def test_links_that_lead_elsewhere_are_not_followed(output, tmp_path):
    path = tmp_path / "linked.h5"
    path.write_bytes(output.read_bytes())
    with h5py.File(path, "a") as file:
        file["q/elsewhere"] = h5py.ExternalLink("/dev/zero", "/x")
        file["q/other"] = h5py.SoftLink("/q/theta")
        layout = h5py.VirtualLayout((3,), "f8")
        file.create_virtual_dataset("q/virtual", layout)
    try:
        with Result(str(path)) as result:
            assert [*result.within("q/")] == ["theta"]
    except FileError as error:  # the record is no longer near the end of the file
        assert "changed by another program" in str(error)
