"""Pages and pictures in Python."""

import pytest

import lagrange_cli as lagrange
from lagrange_cli.api.plot import names_of
from tests.support.command import SYSTEMS
from tests.support.v8 import data_of

PENDULUM = SYSTEMS / "pendulum.yaml"


@pytest.mark.exhaustive(keep=0.25)
def test_a_motion_is_shown_on_a_page(tmp_path):
    page = lagrange.solve(PENDULUM, stop=1, set={"l": 2}).view()
    assert page.live and page.why == "" and "computes in the browser" in repr(page)
    page.save(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text(encoding="utf-8") == page.text
    with pytest.raises(lagrange.FileError, match="already exists"):
        page.save(tmp_path / "a.html")
    shown = page._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and shown.count('"') == 6
    assert lagrange.view(PENDULUM, stop=1, set={"l": 2}).text == page.text


@pytest.mark.exhaustive(keep=0.4)
def test_outputs_are_shown_on_a_page(tmp_path):
    swept = lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1, outputs=["q", "v"], samples=11)
    assert len(data_of(swept.view().text)["members"]) == 2
    lagrange.solve(PENDULUM, stop=1).save(tmp_path / "a.h5")
    assert not lagrange.load(tmp_path / "a.h5").view().live
    section = lagrange.section(PENDULUM, where="theta", crossings=1)
    with pytest.raises(lagrange.LagrangeError):
        section.view()


@pytest.mark.exhaustive(keep=0.15)
def test_motions_are_drawn_over_each_other(tmp_path):
    motions = [lagrange.solve(PENDULUM, stop=1, set={"theta": theta}) for theta in (0.1, 0.2)]
    picture = motions[0].plot()
    assert picture._repr_png_().startswith(b"\x89PNG") and "picture of pendulum" in repr(picture)
    both = lagrange.plot(*motions, y=["theta", "h"], labels=["small", "large"], inches=(4, 3))
    both.save(tmp_path / "a.svg")
    drawn = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert len(both.panels) == 2 and "large" in drawn
    with pytest.raises(lagrange.FileError, match="already exists"):
        both.save(tmp_path / "a.svg")
    with pytest.raises(lagrange.UsageError, match="the name must end in"):
        both.save(tmp_path / "a.jpeg")
    assert names_of([*motions, "run.h5"]) == ["pendulum 1", "pendulum 2", "run.h5"]


@pytest.mark.exhaustive(keep=0.25)
def test_sweeps_and_files_are_drawn(tmp_path):
    swept = lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1, outputs=["q", "v"], samples=11)
    swept.save(tmp_path / "a.h5")
    assert swept.plot("q").panels == lagrange.plot(tmp_path / "a.h5", what=["q"]).panels
    section = lagrange.section(PENDULUM, where="theta", crossings=3)
    assert section.plot().draw(".pdf").startswith(b"%PDF")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "plot needs a motion"),
        ({"results": [3]}, "not int"),
        ({"what": "q", "y": "h"}, "what and y both"),
        ({"what": "nosuch"}, "there is no such plot"),
        ({"labels": ["a", "b"]}, "there are 2 labels for 1 result"),
        ({"labels": 3}, "labels must be a list of texts, one for each result, not 3"),
    ],
)
def test_what_cannot_be_drawn_is_refused(given, message):
    given = dict(given)
    results = given.pop("results", [lagrange.solve(PENDULUM, stop=0.1)] if given else [])
    with pytest.raises(lagrange.UsageError, match=message):
        lagrange.plot(*results, **given)


@pytest.mark.exhaustive(keep=0.25)
def test_a_motion_is_a_film(tmp_path):
    motion = lagrange.solve(PENDULUM, stop=1)
    film = motion.animate(fps=5, size=(64, 48))
    assert (film.pictures, film.speed, film.seconds) == (6, 1.0, 1.2) and "film of pendulum" in repr(film)
    film.save(tmp_path / "a.mp4")
    with pytest.raises(lagrange.FileError, match="already exists"):
        film.save(tmp_path / "a.mp4")
    assert film._repr_html_().startswith('<video controls loop width="64" src="data:video/mp4;base64,')
    motion.save(tmp_path / "a.h5")
    film = lagrange.animate(tmp_path / "a.h5", fps=5, size=(64, 48))
    film.save(tmp_path / "b.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    nan, infinite = float("nan"), float("inf")
    for wrong in (
        *({"fps": fps} for fps in (0, nan, 1e-3, 1000, "few")),
        *({"speed": speed} for speed in (-1, nan, infinite)),
        *({"trail": trail} for trail in (-1, nan, infinite)),
        *({"size": size} for size in (3, (64, 0), (64.5, 48), ("a", 2))),
        *({"panels": panels} for panels in (["fase"], 3)),
        *({"begin": begin} for begin in (3, nan, "x")),
    ):
        with pytest.raises(lagrange.UsageError):
            motion.animate(**wrong)
