"""One member of a sweep by itself: ``--member``."""

from __future__ import annotations

import h5py
import pytest

import lagrange_cli as lagrange
from lagrange_cli.errors import UsageError
from lagrange_cli.run.replay import member_of
from tests.support.command import SYSTEMS
from tests.support.command import lagrange as command


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    grid = ["--over", "l=1:2:3", "--over", "theta=0.5,1"]
    command("sweep", SYSTEMS / "pendulum.yaml", *grid, "--stop", 3, "-o", "sweep.h5", cwd=folder)
    command("solve", SYSTEMS / "pendulum.yaml", "--stop", 3, "-o", "one.h5", cwd=folder)
    return folder


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("number", [0, 3, 5])
def test_a_member_is_computed_again(sweep, number):
    found = member_of(sweep / "sweep.h5", number)
    assert float(found.times["stop"]) == 3
    set_to = {name: float(text) for name, text in found.values.items()}
    motion = lagrange.solve(found.content.decode(), set=set_to, stop=3)
    with h5py.File(sweep / "sweep.h5") as file:
        place = [int(axis[0]) for axis in (file["member"][...] == number).nonzero()]
        assert set_to["l"] == (1, 1.5, 2)[place[list(file["member"].shape).index(3)]]
        assert motion.q["theta"][-1] == pytest.approx(file["q/theta"][tuple(place)], abs=1e-12)


def test_a_member_that_is_not_there_is_refused(sweep):
    with pytest.raises(UsageError, match="are those from 0 to 5"):
        member_of(sweep / "sweep.h5", 6)
    with pytest.raises(UsageError, match="contains one motion, not a sweep"):
        member_of(sweep / "one.h5", 0)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("name", ["plot", "animate", "view"])
def test_commands_show_one_member(sweep, name):
    ending = {"plot": "svg", "animate": "gif", "view": "html"}[name]
    more = {"plot": ["--what", "q"], "animate": ["--to", 0.2, "--size", "64x48"], "view": []}[name]
    run = command(name, "sweep.h5", "--member", 4, *more, "-o", f"member.{ending}", cwd=sweep)
    assert f"member.{ending}" in run.stdout
    run = command(name, SYSTEMS / "pendulum.yaml", "--member", 4, cwd=sweep)
    assert run.returncode == 2
    assert "--member is for the output of a sweep" in run.stderr
