"""Every way in which every method can end: what the command says, and what the file holds, for any reader."""

import json
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

import lagrange_cli.cli.commands.solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.run.interrupts import Interrupts

LINE = (
    "coordinates: {{x: {{initial: {x}, velocity: {v}}}}}\nmasses: {{p: 1}}\n"
    "embedding: {{p: {place}}}\npotential: {potential}\n"
)
COMPLETE = LINE.format(x=1, v=0, place="x", potential="x**2")
COLLISION = LINE.format(x=1, v=0, place="x", potential="-1/x")
FOLD = LINE.format(x=0, v=1, place="x**2", potential="0")  # no mass where the fold is
ROOT = LINE.format(x=1, v=-1, place="x", potential="2*x**2.5")
EDGE = LINE.format(x=1, v=-1, place="[x, x**1.5]", potential="0")
STEEP = LINE.format(x=1, v=0, place="x", potential="1e300*sqrt(x**2)")
STEEPEST = LINE.format(x=1, v=0, place="x", potential="-1e5*x**2")
UNSTABLE = LINE.format(
    x=1, v="-3*sqrt(2)", place="x", potential="-9*x**2"
)  # not doubles that keep to exp(-w*t)

OURS = ("taylor", "ias15", "DOP853", "Radau")
CASES = [
    *((method, COMPLETE, Ending.COMPLETE) for method in METHODS),
    *((method, COMPLETE, Ending.INTERRUPTED) for method in METHODS),
    *((method, UNSTABLE, Ending.TARGET_MISSED) for method in METHODS),
    *((method, FOLD, Ending.SINGULAR_MASS_MATRIX) for method in METHODS),
    *((method, ROOT, Ending.NOT_A_NUMBER) for method in METHODS),
    *((method, COLLISION, Ending.STEP_UNDERFLOW) for method in OURS),
    *((method, STEEPEST, Ending.OVERFLOW) for method in OURS),
    *((method, EDGE, Ending.EDGE) for method in OURS),
    ("BDF", COLLISION, Ending.METHOD_FAILED),
    ("LSODA", STEEP, Ending.METHOD_FAILED),
]
NAMED = {
    **{
        (method, FOLD): "the mass matrix is singular: no kinetic energy depends on x_dot (line 1)"
        for method in METHODS
    },
    **{(method, COLLISION): "the denominator x reaches 0 in -1/x (line 4)" for method in OURS},
    **{(method, EDGE): "x reaches 0 in x**1.5 (line 3)" for method in OURS},
    **{(method, ROOT): "x reaches 0 in x**2.5 (line 4)" for method in OURS},
}
"""What is said instead of the general sentence."""
EVENTS = {
    Ending.STOPPED,
    Ending.TOO_MANY_EVENTS,
    Ending.RECURRING,
    Ending.IDLE,
    Ending.DRAGGED,
    Ending.NO_CROSSING,
    Ending.NO_MASS,
    Ending.JUMP,
    Ending.CUT,
    Ending.OFF_CONSTRAINTS,
    Ending.INCONSISTENT,
    Ending.CRAWLING,
    Ending.STUCK,
    Ending.TOUCHING,
    Ending.UNDETERMINED,
    Ending.ILL_CONDITIONED,
    Ending.TOO_LONG,
}
"""Those of systems with events and contacts, of sections, of members, of masses and of times that are too
large, which have tests of their own."""
STATUS = {"complete": 0, "failed": 4, "interrupted": 130}


class Impatient(Interrupts):
    """Interrupts the run when it is asked a few times."""

    def __init__(self) -> None:
        super().__init__()
        self._left = 2

    def __call__(self) -> bool:
        self._left -= 1
        return self._left <= 0


def test_there_is_a_case_for_every_ending_of_every_method():
    """Steps are refined by scipy's methods until they fail, by ours until they are below the resolution of
    time; and scipy's pass over edges, with a warning."""
    own, theirs = {Ending.STEP_UNDERFLOW, Ending.OVERFLOW, Ending.EDGE}, {Ending.METHOD_FAILED}
    for method in METHODS:
        found = {ending for name, _, ending in CASES if name == method}
        assert found == set(Ending) - EVENTS - (theirs if method in OURS else own)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("method", "text", "ending"), CASES, ids=[f"{method} {ending.name}" for method, _, ending in CASES]
)
def test_an_ending_is_said_and_kept(tmp_path, monkeypatch, capsys, method, text, ending):
    monkeypatch.chdir(tmp_path)
    Path("line.yaml").write_text(text)
    if ending is Ending.INTERRUPTED:
        monkeypatch.setattr(solving, "Interrupts", Impatient)
    tolerance = [] if method in OURS else ["--tolerance", "1e-8"]
    stop = "20000" if ending is Ending.INTERRUPTED else "5"
    options = ["--stop", stop, "--method", method, *tolerance]
    if ending is Ending.TARGET_MISSED:
        options += ["--target-error", "1e-12"]
    status = main(["solve", "line.yaml", *options, "--samples", "501", "--outputs", "q,v,h,ledger", "--json"])
    said = capsys.readouterr()
    answer = json.loads(said.out)
    assert status == STATUS[ending.status]
    assert answer["status"] == ending.status and answer["message"].startswith(
        NAMED.get((method, text), ending.value)
    )
    assert (answer["message"] in said.err) is (status != 0) and "Traceback" not in said.err
    with h5py.File("line.h5") as file:
        assert (file.attrs["status"], file.attrs["message"]) == (ending.status, answer["message"])
        shapes = {len(dataset) for dataset in series(file)}
        assert shapes == {len(file["t"])}
        assert (len(file["t"]) == 501) is (ending is Ending.COMPLETE)
        t = file["t"][()]
        np.testing.assert_allclose(t, float(stop) / 500 * np.arange(len(t)), rtol=1e-15)
        assert not len(t) or t[-1] <= answer["t"]
    for group in (None, "q", "v", "diagnostics", "diagnostics/ledger"):
        with xarray.open_dataset("line.h5", group=group, engine="h5netcdf") as data:
            assert data.sizes["t"] == len(t)


def series(file: h5py.File) -> Iterator[h5py.Dataset]:
    """All datasets along t."""
    found = []
    file.visititems(lambda path, item: found.append(item) if isinstance(item, h5py.Dataset) else None)
    return (one for one in found if one.name != "/checkpoint")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("text", "ending"),
    [
        (COMPLETE, Ending.COMPLETE),
        (FOLD, Ending.SINGULAR_MASS_MATRIX),
        (ROOT, Ending.NOT_A_NUMBER),
        (COLLISION, Ending.STEP_UNDERFLOW),
    ],
    ids=lambda one: getattr(one, "name", ""),
)
def test_members_of_a_sweep_end_as_they_would_alone(tmp_path, monkeypatch, capsys, text, ending):
    monkeypatch.chdir(tmp_path)
    Path("line.yaml").write_text(text)
    assert (
        main(["sweep", "line.yaml", "--stop", "5", "--json", "--over", "x_dot=-1,-2"])
        == STATUS[ending.status]
    )
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == ending.status and answer[ending.status] == 2
    with h5py.File("line_sweep.h5") as file:
        assert (file.attrs["status"], file.attrs["message"]) == (ending.status, answer["message"])
        assert file["status"][()].tolist() == [ending.status.encode()] * 2
        assert file["message"][()].tolist() == [ending.value.encode()] * 2
    with xarray.open_dataset("line_sweep.h5", group="q", engine="h5netcdf") as data:
        assert data.sizes["x_dot_0"] == 2 and data["member"].values.tolist() == [0, 1]
