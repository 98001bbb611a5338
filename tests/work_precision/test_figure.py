"""Pictures: sound files that hold what is to be seen, the same each time; and those that cannot be drawn."""

from __future__ import annotations

import importlib.util
import os
import re
import xml.etree.ElementTree as ElementTree

import pytest

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.work_precision.figure import Curve, Picture, Point, check_picture, write_picture

SVG = "{http://www.w3.org/2000/svg}"
CURVES = (
    Curve("taylor", (Point(1e-6, 1e-4), Point(1e-9, 2e-4), Point(1e-13, 3e-4, bounded=True))),
    Curve("DOP853", (Point(1e-4, 1e-2), Point(1e-8, 1e-1))),
    Curve("Radau", (Point(1e-8, 1.05e-1),)),
)
PICTURE = Picture("a & b <c>", "error", CURVES, floor=1e-13, wanted=1e-9, chosen=CURVES[0].points[1])


def texts(path):
    root = ElementTree.parse(path).getroot()
    assert root.tag == f"{SVG}svg"
    return {"".join(each.itertext()).strip() for each in root.iter(f"{SVG}text")}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    path = tmp_path_factory.mktemp("drawn") / "a.svg"
    write_picture(str(path), PICTURE)
    return path


@pytest.mark.exhaustive(keep=0.15)
def test_an_svg_holds_title_axes_and_the_name_of_every_curve(drawn, tmp_path):
    expected = {"a & b <c>", "error", "run time (s)", "taylor", "DOP853", "Radau", "required error"}
    assert expected <= texts(drawn)
    again = tmp_path / "a.svg"
    write_picture(str(again), PICTURE)
    assert again.read_bytes() == drawn.read_bytes()


@pytest.mark.exhaustive(keep=0.25)
def test_names_of_curves_that_end_together_are_moved_apart(drawn):
    heights = {}
    for each in ElementTree.parse(drawn).getroot().iter(f"{SVG}text"):
        place = re.search(r"(?:rotate|translate)\(.* (-?[\d.]+)\)$", each.attrib.get("transform", ""))
        heights["".join(each.itertext()).strip()] = float(place[1] if place else "nan")
    assert heights["DOP853"] - heights["Radau"] >= 11  # points


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<?xml")])
def test_several_frames_and_other_formats(tmp_path, suffix, magic):
    path = tmp_path / f"a{suffix}"
    empty = Picture("nothing came to the end", "error", ())
    write_picture(str(path), PICTURE, empty)
    assert path.read_bytes().startswith(magic)


def test_a_picture_that_could_not_be_drawn_is_refused_before_any_work(tmp_path, monkeypatch):
    check_picture(str(tmp_path / "a.svg"))
    with pytest.raises(UsageError, match=r"must end in \.svg, \.pdf or \.png"):
        check_picture("a.yaml")
    with pytest.raises(FileError, match="there is no directory"):
        check_picture(str(tmp_path / "nosuch" / "a.svg"))
    with monkeypatch.context() as patch, pytest.raises(FileError, match="no permission to write"):
        patch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
        check_picture(str(tmp_path / "a.svg"))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"pip install 'lagrange-cli\[plot\]'"):
        check_picture(str(tmp_path / "a.svg"))


@pytest.mark.exhaustive(keep=0.2)
def test_a_file_that_cannot_be_written_is_an_error_of_its_own(tmp_path):
    (tmp_path / "a.svg").mkdir()
    with pytest.raises(FileError, match="could not be written"):
        write_picture(str(tmp_path / "a.svg"), PICTURE)
