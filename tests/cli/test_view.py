"""``lagrange view``: the page of a system, and what is refused."""

from __future__ import annotations

import json
from html import unescape

import h5py
import numpy as np
import pytest

from lagrange_cli.integrate.methods import stepper
from lagrange_cli.run.request import Request
from lagrange_cli.run.view import motion as shown_motion
from lagrange_cli.run.view import page
from lagrange_cli.run.view.motion import read_shown
from tests.support.command import SYSTEMS, lagrange
from tests.support.v8 import Engine, data_of, unpacked

HOSTILE = """
name: '</script><script>alert(1)</script> <b>& "x" \\u2028'
description: '<!-- <script> \\e[31m {{data}} -->'
parameters:
  k: {value: 1, unit: '<i>', description: '</script>'}
coordinates:
  x: {initial: 1.0}
masses: {m: 1}
embedding: {m: x}
potential: k*x**2/2
solve: {stop: 1}
"""


@pytest.mark.exhaustive(keep=0.5)
def test_a_page_is_written_beside_the_caller(tmp_path):
    found = lagrange("view", str(SYSTEMS / "pendulum.yaml"), "--json", "--stop", "2", cwd=tmp_path)
    report = json.loads(found.stdout)
    page = (tmp_path / "pendulum.html").read_text(encoding="utf-8")
    assert (found.returncode, report["output"], report["live"]) == (0, "pendulum.html", True)
    assert report["bytes"] == len(page.encode()) < 200_000
    assert data_of(page)["time"]["stop"] == 2
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_what_a_file_contains_is_text(tmp_path):
    """No name, unit or description becomes markup, and no text is taken for a place of the template."""
    (tmp_path / "x.yaml").write_text(HOSTILE.replace("\\e", "\\\\e"), encoding="utf-8")
    found = lagrange("view", str(tmp_path / "x.yaml"), "-o", "-", cwd=tmp_path)
    assert found.returncode == 0
    data = data_of(found.stdout)
    assert data["name"].startswith("</script><script>alert(1)")
    assert data["description"].endswith("{{data}} -->")
    assert found.stdout.count("<script") == 2
    assert "alert(1)</script>" not in found.stdout
    title = found.stdout.partition("<title>")[2].partition("</title>")[0]
    assert unescape(title) == data["name"]


def test_a_motion_without_an_end_lasts_for_a_while(tmp_path):
    (tmp_path / "x.yaml").write_text(HOSTILE.replace("solve: {stop: 1}", ""), encoding="utf-8")
    assert (
        data_of(lagrange("view", str(tmp_path / "x.yaml"), "-o", "-", cwd=tmp_path).stdout)["time"]["stop"]
        == 10
    )


@pytest.mark.exhaustive(keep=0.75)
def test_a_page_that_replays_tells_if_the_motion_was_not_computed_to_its_end(monkeypatch):
    text = (SYSTEMS / "pendulum.yaml").read_bytes()
    motion = read_shown(text, "pendulum.yaml", Request(times={"stop": "-60"}))
    assert page.view(motion).why.endswith(page.REPLAYED)
    for where, name, value in (
        (shown_motion, "PATIENCE", -1),
        (stepper, "POLL_SECONDS", 0),
        (stepper, "FIRST", 1),
    ):
        monkeypatch.setattr(where, name, value)
    assert "It ends at t = -" in page.view(motion).why


def test_another_file_of_the_name_is_kept(tmp_path):
    name = str(tmp_path / "kept.html")
    (tmp_path / "kept.html").write_text("mine")
    found = lagrange("view", str(SYSTEMS / "pendulum.yaml"), "-o", name, cwd=tmp_path)
    assert found.returncode == 5
    assert "already exists" in found.stderr
    assert (tmp_path / "kept.html").read_text() == "mine"
    assert (
        lagrange("view", str(SYSTEMS / "pendulum.yaml"), "-o", name, "--force", cwd=tmp_path).returncode == 0
    )


def test_a_directory_is_no_page(tmp_path):
    """The way out is the name of a page."""
    (tmp_path / "d.html").mkdir()
    found = lagrange("view", str(SYSTEMS / "pendulum.yaml"), "-o", "d.html", cwd=tmp_path)
    assert found.returncode == 5
    assert "d.html is a directory: name a file in it, such as d.html/NAME.html" in found.stderr


@pytest.mark.parametrize(("name", "hint"), [(".", "such as NAME.html"), ("x.png", "ends in .html")])
def test_a_page_has_the_name_of_a_page(tmp_path, name, hint):
    found = lagrange("view", str(SYSTEMS / "pendulum.yaml"), "-o", name, cwd=tmp_path)
    assert found.returncode in (2, 5) and hint in found.stderr and not list(tmp_path.iterdir())


def test_a_page_that_cannot_compute_says_why_and_replays(tmp_path):
    (tmp_path / "x.yaml").write_text(HOSTILE.replace("stop: 1", "stop: -1"), encoding="utf-8")
    data = data_of(lagrange("view", str(tmp_path / "x.yaml"), "-o", "-", cwd=tmp_path).stdout)
    assert "backward" in data["notice"]
    assert data["members"][0]["count"] > 100


def test_an_output_is_replayed(tmp_path):
    """The page has the samples of the file, the last one among them."""
    assert lagrange("solve", SYSTEMS / "pendulum.yaml", "--set", "l=2", cwd=tmp_path).returncode == 0
    report = json.loads(lagrange("view", "pendulum.h5", "--json", cwd=tmp_path).stdout)
    assert (report["output"], report["live"]) == ("pendulum.html", False)
    data = data_of((tmp_path / "pendulum.html").read_text(encoding="utf-8"))
    (member,) = data["members"]
    rows = np.frombuffer(unpacked(member["rows"]), dtype="<f8").reshape(-1, member["count"])
    with h5py.File(tmp_path / "pendulum.h5") as file:
        expected = [
            file[path][:] for path in ("t", "q/theta", "v/theta", "diagnostics/h", "diagnostics/p/theta")
        ]
    assert member["observed"] == ["h", "p_theta"]
    assert np.array_equal(rows, expected)
    assert {one["name"]: one["value"] for one in data["parameters"]}["l"] == 2


@pytest.mark.exhaustive(keep=0.4)
def test_a_sweep_has_its_members_on_the_page(tmp_path):
    sweep = "sweep", SYSTEMS / "pendulum.yaml", "--over", "theta=0.5:1.5:3", "--over", "l=1:2:2"
    assert lagrange(*sweep, "-o", "s.h5", cwd=tmp_path).returncode == 0
    page = lagrange("view", "s.h5", "-o", "-", cwd=tmp_path).stdout
    members = data_of(page)["members"]
    assert [one["label"] for one in members][:2] == [
        "1 of 6: l = 1, theta = 0.5",
        "2 of 6: l = 2, theta = 0.5",
    ]
    found = Engine(page).end(**members[3]["values"])
    with h5py.File(tmp_path / "s.h5") as file:
        assert abs(found["q"][0] - file["q/theta"][:].ravel()[3]) <= 1e-9


def test_what_is_no_output_or_has_no_motion_is_refused(tmp_path):
    def refused(*arguments):
        found = lagrange("view", *arguments, cwd=tmp_path)
        return found.returncode, found.stderr

    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["t"] = [1.0]
    status, message = refused("other.h5")
    assert (status, "is not an output of lagrange" in message) == (5, True)
    (tmp_path / "cut.h5").write_bytes((tmp_path / "other.h5").read_bytes()[:100])
    assert refused("cut.h5")[0] == 5
    (tmp_path / "text.h5").write_text("name: x")
    status, message = refused("text.h5")
    assert (status, "is not an output of lagrange" in message) == (5, True)
    henon = SYSTEMS / "henon_heiles.yaml"
    lagrange("section", henon, "--where", "x", "--crossings", "5", "-o", "cut.h5", "--force", cwd=tmp_path)
    status, message = refused("cut.h5")
    assert (status, "contains a section" in message) == (2, True)
    lagrange("solve", henon, "--outputs", "h", "-o", "h.h5", cwd=tmp_path)
    status, message = refused("h.h5")
    assert (status, "--outputs q,v,p,h" in message) == (2, True)
    status, message = refused("h.h5", "--set", "E=0.1")
    assert (status, "--set belongs to a system file" in message) == (2, True)
