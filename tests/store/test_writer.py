"""The output file, read back through h5py and xarray; and what happens where it cannot be written."""

import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lagrange_cli.errors import FileError
from lagrange_cli.integrate.times import Times
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.layout import MEMORY, ROWS, Layout, Series
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.writer import Writer
from tests.support.draws import examples

LAYOUT = Layout(
    (
        Series("q/theta", unit="rad", long_name="coordinate theta"),
        Series("v/theta", long_name="velocity of theta"),
        Series("diagnostics/h", long_name="energy function"),
        Series("positions/bob", (2,), long_name="position of bob", components=2),
        Series("positions/bead", (3, 2), long_name="position of bead[i]", axes=("N",), components=2),
        Series("observables/N", (3, 2), axes=("N", "index_2")),
        Series("observables/t_", (2, 2), axes=("index_2", "index_2_2")),
    )
)
ATTRIBUTES = {"generator": "test", "name": "pendulum", "spec": "x" * 100_000, "tolerance": 1e-16, "steps": 7}


def chunk_of(start: int, count: int) -> dict[str, np.ndarray]:
    """Samples start..start+count of t = 0, 0.5, 1 ..., each series a recognizable function of t."""
    t = 0.5 * np.arange(start, start + count)
    return {
        "t": t,
        "q/theta": 2 * t,
        "v/theta": t**2,
        "diagnostics/h": -t,
        "positions/bob": np.stack([t, 10 * t], axis=1),
        "positions/bead": t[:, None, None] * np.arange(6).reshape(3, 2),
        "observables/N": t[:, None, None] - np.arange(6).reshape(3, 2),
        "observables/t_": t[:, None, None] - np.arange(4).reshape(2, 2),
    }


def times_of(count: int) -> Times:
    """Those of the first samples."""
    return Times(0.0, 0.5 * (count - 1), count, 0.5)


def write(path: Path, *, pieces: tuple[int, ...] = (3, 0, 4), force: bool = False) -> None:
    with Writer(find_target(str(path), force=force), LAYOUT, times_of(sum(pieces))) as writer:
        start = 0
        for count in pieces:
            writer.append(chunk_of(start, count))
            start += count
        writer.close(ATTRIBUTES)


def test_what_is_appended_in_pieces_is_read_back_whole(tmp_path):
    write(tmp_path / "out.h5")
    with h5py.File(tmp_path / "out.h5") as file:
        for path, values in chunk_of(0, 7).items():
            np.testing.assert_array_equal(file[path][()], values)
        assert file["q/theta"].attrs["unit"] == "rad"
        assert file["q/theta"].attrs["long_name"] == "coordinate theta"
        assert "unit" not in file["v/theta"].attrs
        assert dict(file.attrs) == ATTRIBUTES


@pytest.mark.parametrize("pieces", [(4, 4), (8, 3), (3, 1, 4), (3, 13, 2), (4, 1, 7)])
def test_whole_chunks_of_the_file_and_parts_of_them_follow_one_another(tmp_path, pieces):
    rows, total = 4, sum(pieces)
    with Writer(find_target(str(tmp_path / "out.h5"), force=False), LAYOUT, times_of(rows)) as writer:
        for start, count in zip(np.cumsum([0, *pieces]), pieces):
            writer.append(chunk_of(start, count))
        writer.close(ATTRIBUTES)
    with h5py.File(tmp_path / "out.h5") as file:
        for path, values in chunk_of(0, total).items():
            assert file[path].chunks[0] == rows
            np.testing.assert_array_equal(file[path][()], values)


@pytest.mark.exhaustive(keep=0.4)
@given(st.lists(st.integers(0, 11), min_size=1, max_size=8), st.integers(1, 7))
@settings(examples(15), suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_the_bytes_do_not_depend_on_how_many_samples_are_appended_at_a_time(tmp_path, pieces, rows):
    found = []
    for each in (pieces, (sum(pieces),)):
        with Writer(find_target(str(tmp_path / "out.h5"), force=True), LAYOUT, times_of(rows)) as writer:
            for start, count in zip(np.cumsum([0, *each]), each):
                writer.append(chunk_of(start, count))
            writer.close(ATTRIBUTES)
        found.append((tmp_path / "out.h5").read_bytes())
    assert found[0] == found[1]


def test_every_series_has_the_times_attached_as_its_dimension_scale(tmp_path):
    write(tmp_path / "out.h5")
    with h5py.File(tmp_path / "out.h5") as file:
        assert file["t"].is_scale
        for series in LAYOUT.series:
            assert file[series.path].dims[0][0] == file["t"]
        assert [letter.decode() for letter in file["positions/bob"].dims[1][0]] == ["x", "y"]


def test_a_family_has_a_scale_for_each_index_that_no_series_hides(tmp_path):
    write(tmp_path / "out.h5")
    with h5py.File(tmp_path / "out.h5") as file:
        scales = {
            path: [next(iter(axis.values())).name for axis in file[path].dims]
            for path in ("positions/bead", "observables/N", "observables/t_")
        }
        assert scales == {
            "positions/bead": ["/t", "/N_", "/xy"],
            "observables/N": ["/t", "/N_", "/index_2"],
            "observables/t_": ["/t", "/index_2", "/index_2_2"],
        }
        assert file["N_"][()].tolist() == [0, 1, 2]


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("group", ["q", "v", "diagnostics", "positions", "observables"])
def test_xarray_finds_the_times_from_every_group(tmp_path, group):
    write(tmp_path / "out.h5")
    with xarray.open_dataset(tmp_path / "out.h5", group=group, engine="h5netcdf") as data:
        np.testing.assert_array_equal(data.coords["t"], 0.5 * np.arange(7))
        assert all(array.dims[0] == "t" for array in data.data_vars.values())


def test_a_vector_can_be_selected_by_its_component(tmp_path):
    write(tmp_path / "out.h5")
    with xarray.open_dataset(tmp_path / "out.h5", group="positions", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["bob"].sel(xy="y"), 5.0 * np.arange(7))


@pytest.mark.exhaustive(keep=0.2)
def test_the_same_run_gives_the_same_bytes_at_another_time_and_under_another_name(tmp_path):
    write(tmp_path / "first.h5")
    time.sleep(1.1)  # HDF5's time stamps, were there any, count seconds
    write(tmp_path / "second.h5")
    assert (tmp_path / "first.h5").read_bytes() == (tmp_path / "second.h5").read_bytes()


def test_nothing_but_the_whole_file_is_left_beside_it(tmp_path):
    write(tmp_path / "out.h5")
    assert os.listdir(tmp_path) == ["out.h5"]


def test_the_file_has_the_permissions_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write(tmp_path / "out.h5")
    assert (tmp_path / "out.h5").stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert stat.S_ISREG((tmp_path / "out.h5").stat().st_mode)


def test_an_error_while_writing_leaves_no_file(tmp_path):
    with (
        pytest.raises(ZeroDivisionError),
        Writer(find_target(str(tmp_path / "out.h5"), force=False), LAYOUT, times_of(7)) as writer,
    ):
        writer.append(chunk_of(0, 3))
        assert os.listdir(tmp_path) == [".out.h5.part"]
        raise ZeroDivisionError
    assert os.listdir(tmp_path) == []


def test_a_file_that_appears_meanwhile_is_kept_and_the_result_too(tmp_path):
    out = tmp_path / "out.h5"
    with (
        pytest.raises(FileError, match="appeared during"),
        Writer(find_target(str(out), force=False), LAYOUT, times_of(3)) as writer,
    ):
        writer.append(chunk_of(0, 3))
        out.write_text("another's")
        writer.close(ATTRIBUTES)
    assert out.read_text() == "another's"
    with h5py.File(tmp_path / ".out.h5.part") as file:
        assert len(file["t"]) == 3


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    out = tmp_path / "out.h5"
    out.write_text("precious")
    with pytest.raises(FileError, match="--force"):
        find_target(str(out), force=False)
    assert out.read_text() == "precious"
    write(out, force=True)
    assert h5py.is_hdf5(out)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (".", "is a directory"),
        ("nowhere/out.h5", "there is no directory"),
        ("/dev/null", "not a regular file"),
        ("x" * 300, "cannot be written|could not be written"),
        ("a\0b", "cannot be written"),
    ],
)
def test_an_output_that_can_never_be_written_is_refused_at_once(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match=message):
        Writer(find_target(name, force=True), LAYOUT, times_of(1))
    assert os.listdir(tmp_path) == []


def test_a_link_is_followed_and_stays_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    link = tmp_path / "out.h5"
    link.symlink_to(tmp_path / "real" / "data.h5")
    write(link)
    assert link.is_symlink()
    assert h5py.is_hdf5(tmp_path / "real" / "data.h5")


FULL_DISK = """
import os, resource, sys
from tests.store.test_writer import write
from pathlib import Path
from lagrange_cli.errors import FileError
for limit in map(int, sys.argv[1:]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, 1_000_000))
    try:
        write(Path("out.h5"), pieces=(50_000, 50_000))
    except FileError as error:
        print(error, os.listdir())
"""


@pytest.mark.exhaustive(keep=0.15)
def test_a_full_disk_is_one_clear_error_and_leaves_nothing(tmp_path):
    limits = ("0", "1_000", "10_000", "1_000_000")
    root = Path(__file__).resolve().parents[2]
    run = subprocess.run(
        [sys.executable, "-c", FULL_DISK, *limits],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == "out.h5 could not be written: File too large []\n" * len(limits)


def test_a_write_that_failed_is_followed_by_no_other(tmp_path, monkeypatch):
    sink = Sink(tmp_path / "file")
    sink.write(b"abc")
    sink.error = OSError(28, "full")
    assert sink.write(b"def") == 3
    assert sink.tell() == 6
    sink.close()
    assert (tmp_path / "file").read_bytes() == b"abc"


def test_chunks_are_large_for_few_series_and_bounded_for_many():
    assert LAYOUT.chunk_rows(10**7) == ROWS
    assert LAYOUT.chunk_rows(1001) == 1001
    assert LAYOUT.chunk_rows(0) == 1
    many = Layout(tuple(Series(f"q/x{i}") for i in range(3000)))
    assert 64 <= many.chunk_rows(10**7) * 8 * 3001 <= MEMORY


def test_a_directory_that_has_been_removed_is_said_to_be(tmp_path, monkeypatch):
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    with pytest.raises(FileError, match="cannot be written: the current directory has been removed"):
        find_target("run.h5", force=False)
