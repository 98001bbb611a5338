"""The file of an ensemble, read back through h5py and xarray."""

import os
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from lagrange_cli.store import ensemble
from lagrange_cli.store.ensemble import EnsembleWriter
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.layout import Dimension, Layout, Series

MEMBERS = 10
TIMES = np.array([0.0, 0.5, 1.5])
LAYOUT = Layout(
    (
        Series("parameters/m[1]", unit="kg", long_name="mass", sampled=False),
        Series("initial/q/u", (2,), axes=("N",), sampled=False),
        Series("status", kind="S8", sampled=False),
        Series("steps", kind="i8", sampled=False),
        Series("q/u", (2,), axes=("N",)),
        Series("positions/bob", (2,), components=2),
    )
)
WORDS = np.array([b"complete", b"failed"])


def rows_of(index: np.ndarray) -> dict[str, np.ndarray]:
    """What the members have: recognizable functions of their numbers."""
    return {
        "parameters/m[1]": 0.5 * index,
        "initial/q/u": np.stack([index, -index], axis=1),
        "status": WORDS[index % 2],
        "steps": 7 * index,
        "q/u": index[:, None, None] + TIMES[:, None] * [1, 10],
        "positions/bob": index[:, None, None] - TIMES[:, None] * [1, 10],
    }


def write(path: Path, *pieces: list[int], layout: Layout = LAYOUT, dimensions=()) -> None:
    target = find_target(str(path), force=False)
    with EnsembleWriter(target, layout, members=MEMBERS, times=TIMES, dimensions=dimensions) as writer:
        for piece in pieces:
            index = np.array(piece)
            given = {one.path for one in layout.series}
            writer.write(index, {path: rows for path, rows in rows_of(index).items() if path in given})
        writer.write_messages(["done", "fell", "never"], np.arange(MEMBERS) % 2)
        writer.close({"name": "test"})


def test_what_is_written_in_any_order_is_read_back(tmp_path):
    write(tmp_path / "out.h5", [9, 3, 5, 4], [0, 1, 2], [6], [8, 7])
    with h5py.File(tmp_path / "out.h5") as file:
        for path, values in rows_of(np.arange(MEMBERS)).items():
            np.testing.assert_array_equal(file[path][()], values)
        assert file["message"][()].tolist() == [b"done", b"fell"] * 5
        assert file["parameters/m[1]"].attrs["unit"] == "kg"
        assert file.attrs["name"] == "test"
    assert os.listdir(tmp_path) == ["out.h5"]


def test_the_bytes_do_not_depend_on_the_order(tmp_path):
    write(tmp_path / "first.h5", list(range(MEMBERS)))
    write(tmp_path / "second.h5", [4], [9, 3, 5], [8, 7, 6], [2, 0, 1])
    assert (tmp_path / "first.h5").read_bytes() == (tmp_path / "second.h5").read_bytes()


GRID = (Dimension("a", 2, np.array([3.0, 4.0]), "m", "length", "parameters/a"), Dimension("draw", 5))


def test_a_grid_holds_the_same_numbers_in_the_same_order(tmp_path, monkeypatch):
    monkeypatch.setattr(ensemble, "BLOCK", 3)
    write(tmp_path / "flat.h5", [*range(MEMBERS)])
    write(tmp_path / "grid.h5", [9, 3, 5, 4], [0, 1, 2], [6], [8, 7], dimensions=GRID)
    write(tmp_path / "again.h5", [*range(MEMBERS)], dimensions=GRID)
    assert (tmp_path / "grid.h5").read_bytes() == (tmp_path / "again.h5").read_bytes()
    with h5py.File(tmp_path / "flat.h5") as flat, h5py.File(tmp_path / "grid.h5") as grid:
        for path in (*rows_of(np.arange(MEMBERS)), "message", "member"):
            assert grid[path].shape == (2, 5, *flat[path].shape[1:])
            np.testing.assert_array_equal(grid[path][()].reshape(flat[path].shape), flat[path][()])
        assert grid["draw"][()].tolist() == [0, 1, 2, 3, 4]
        assert grid["parameters/a"] == grid["a"] and grid["a"].attrs["unit"] == "m"
        assert dict(grid["a"].attrs)["long_name"] == "length"


@pytest.mark.parametrize("group", ["/", "parameters", "initial/q", "q", "positions"])
def test_xarray_finds_the_members_from_every_group(tmp_path, group):
    write(tmp_path / "out.h5", list(range(MEMBERS)))
    with xarray.open_dataset(tmp_path / "out.h5", group=group, engine="h5netcdf") as data:
        np.testing.assert_array_equal(data.coords["member"], np.arange(MEMBERS))
        assert all(array.dims[0] == "member" for array in data.data_vars.values())
        if group in ("q", "positions"):
            np.testing.assert_array_equal(data.coords["t"], TIMES)
            assert all(array.dims[1] == "t" for array in data.data_vars.values())


def test_members_can_be_selected_by_what_they_have(tmp_path):
    write(tmp_path / "out.h5", list(range(MEMBERS)))
    with (
        xarray.open_dataset(tmp_path / "out.h5", engine="h5netcdf") as root,
        xarray.open_dataset(tmp_path / "out.h5", group="q", engine="h5netcdf") as q,
    ):
        failed = q["u"].where(root["status"] == b"failed", drop=True)
        assert failed["member"].values.tolist() == [1, 3, 5, 7, 9]
        assert failed.sel(member=3, t=0.5, N=1) == 8


def test_no_quantity_hides_the_members(tmp_path):
    layout = Layout((*LAYOUT.series, Series("q/member", sampled=False)))
    path = tmp_path / "out.h5"
    with EnsembleWriter(find_target(str(path), force=False), layout, members=2, times=None) as writer:
        both = np.arange(2)
        values = rows_of(both) | {"q/u": np.zeros((2, 2)), "positions/bob": np.zeros((2, 2))}
        writer.write(both, values | {"q/member": both + 5.0})
        writer.close({})
    with xarray.open_dataset(path, group="q", engine="h5netcdf") as data:
        assert data["member"].dims == ("member_",) and data["member"].values.tolist() == [5, 6]


def test_nothing_is_left_of_a_file_that_is_not_closed(tmp_path):
    with (
        pytest.raises(ZeroDivisionError),
        EnsembleWriter(
            find_target(str(tmp_path / "out.h5"), force=False), LAYOUT, members=MEMBERS, times=TIMES
        ) as writer,
    ):
        writer.write(np.arange(3), rows_of(np.arange(3)))
        raise ZeroDivisionError
    assert os.listdir(tmp_path) == []
