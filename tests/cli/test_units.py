"""The units in output files, and how xarray reads them."""

from __future__ import annotations

import subprocess
import sys

import h5py
import pytest
import xarray

from tests.support.command import SYSTEMS, environment, lagrange

SLOW = """\
time: {unit: days}
parameters: {m: {value: 1, unit: kg}, v: {value: 2, unit: km/d}}
coordinates: {x: {initial: 0, velocity: v, unit: km}, y: {initial: 1, unit: hours}}
masses: {cart: m}
embedding: {cart: [x]}
potential: m*(y_dot*x_dot - y_dot**2)
observables: {trip: x + v*t, waiting: 2*y}
solve: {stop: 2, step: 0.5, outputs: all}
"""


def attributes(path) -> dict[str, tuple[str | None, str | None]]:
    """The attributes ``unit`` and ``units`` of all datasets."""
    found = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = item.attrs.get("unit"), item.attrs.get("units")

    with h5py.File(path) as file:
        file.visititems(visit)
    return found


@pytest.mark.exhaustive(keep=0.8)
def test_every_dataset_of_a_run_has_its_unit(tmp_path):
    run = lagrange("solve", SYSTEMS / "pendulum.yaml", "--outputs", "all", "--certify", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    energy, angular = ("kg*m^2/s^2", "kg m2 s-2"), ("kg*m^2/s", "kg m2 s-1")
    angle, rate, force = ("rad", "rad"), ("rad/s", "rad s-1"), ("kg*m/s^2", "kg m s-2")
    assert attributes(tmp_path / "pendulum.h5") == {
        "t": ("s", "s"),
        "q/theta": angle,
        "v/theta": rate,
        "positions/bob": ("m", "m"),
        "reactions/bob": force,
        "xy": (None, None),
        **{f"diagnostics/{name}": energy for name in ("h", "conserved/h", "T", "U", "energy", "ledger/h")},
        **{f"diagnostics/{name}": angular for name in ("p/theta", "ledger/p/theta", "action")},
        "diagnostics/error/q/theta": angle,
        "diagnostics/error/v/theta": rate,
        "diagnostics/error/as_run/q/theta": angle,
        "diagnostics/error/as_run/v/theta": rate,
        "diagnostics/error/reactions/bob": force,
        "diagnostics/error/as_run/reactions/bob": force,
    }


def test_every_dataset_of_a_sweep_has_its_unit(tmp_path):
    system = SYSTEMS / "spherical_pendulum.yaml"
    grid = ("--over", "l=1,2", "--over", "phi_dot=1,2", "--random", "m=uniform(1,2)", "--members", "2")
    run = lagrange("sweep", system, *grid, "--outputs", "v,h,p", "--samples", "3", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    found = attributes(tmp_path / "spherical_pendulum_sweep.h5")
    units = {name: unit for name, (unit, _) in found.items()}
    assert units["t"] == units["t_end"] == "s"
    assert (units["parameters/m"], units["l"], units["phi_dot_0"]) == ("kg", "m", "rad/s")
    assert (units["initial/q/phi"], units["initial/v/phi"], units["v/theta"]) == ("rad", "rad/s", "rad/s")
    assert units["diagnostics/h"] == units["diagnostics/drift/h"] == "kg*m^2/s^2"
    assert units["diagnostics/p/phi"] == units["diagnostics/drift/p/phi"] == "kg*m^2/s"
    assert all(found[name] == (None, None) for name in ("status", "message", "steps", "member"))


@pytest.mark.exhaustive(keep=0.3)
def test_xarray_reads_times_as_numbers(tmp_path):
    """It would make durations of ``days`` and ``hours``."""
    (tmp_path / "slow.yaml").write_text(SLOW)
    assert lagrange("solve", "slow.yaml", cwd=tmp_path).returncode == 0
    assert attributes(tmp_path / "slow.h5")["t"] == ("days", "d")
    for group in ("q", "v", "observables", "diagnostics", "positions"):
        with xarray.open_dataset(tmp_path / "slow.h5", group=group, engine="h5netcdf") as data:
            assert data.t.dtype == "f8" and data.t.attrs["units"] == "d"
            assert data.t.values.tolist() == [0, 0.5, 1, 1.5, 2]
            assert all(one.dtype == "f8" for one in data.data_vars.values())
            if group == "observables":
                assert (data.trip.attrs["units"], data.waiting.attrs["units"]) == ("km", "h")


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("text", ["days since 2000-01-01", "widths of the gap"])
def test_a_unit_that_is_a_text_is_no_date_to_xarray(tmp_path, text):
    (tmp_path / "a.yaml").write_text(
        SLOW.replace("{unit: days}", text).replace("unit: km}", f"unit: {text}}}")
    )
    assert lagrange("solve", "a.yaml", cwd=tmp_path).returncode == 0
    found = attributes(tmp_path / "a.h5")
    assert found["t"] == found["q/x"] == (text, None) and found["v/x"] == (None, None)
    with xarray.open_dataset(tmp_path / "a.h5", group="q", engine="h5netcdf") as data:
        assert data.t.dtype == data.x.dtype == "f8"


@pytest.mark.exhaustive(keep=0.4)
def test_a_file_without_units_looks_for_none(tmp_path):
    (tmp_path / "a.yaml").write_text("coordinates: {x: {initial: 1}}\nmasses: {a: 1}\nembedding: {a: [x]}\n")
    script = "import sys; from lagrange_cli.cli.main import main; "
    script += "main(['solve', 'a.yaml', '--stop', '1']); print(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert not {"lagrange_cli.outputs.units", "lagrange_cli.model.units"} & set(run.stdout.split())
    assert set(attributes(tmp_path / "a.h5").values()) == {(None, None)}
