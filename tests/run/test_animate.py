"""Films of motions: what is seen is where the motion is, and what cannot be shown is said."""

import json
import math

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from PIL import Image

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.figures.film import FRAMES
from lagrange_cli.figures.scene import shown_time
from lagrange_cli.records import replace
from lagrange_cli.run.animate import find_folder, write
from lagrange_cli.run.monitor import Silence
from lagrange_cli.run.reel import (
    FINER,
    FINEST,
    LONGEST,
    MOST_FRAMES,
    FilmRequest,
    finer_than,
    reel_of,
    usual_speed,
)
from lagrange_cli.run.sampling import Samples
from lagrange_cli.store.result import Result
from tests.support.command import SYSTEMS, lagrange
from tests.support.draws import examples

THROWN = """
name: thrown <b>$x$</b>
parameters: {g: 10}
coordinates: {x: {initial: 0, velocity: 2}, y: {initial: 0, velocity: 5}}
masses: {ball: 1}
positions: {ball: [x, y]}
potential: ball.y*g
solve: {stop: 1.5, samples: 16}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("films")
    (made / "thrown.yaml").write_text(THROWN)
    lagrange("solve", "thrown.yaml", "-o", "run.h5", cwd=made)
    lagrange("solve", "thrown.yaml", "--outputs", "h", "-o", "few.h5", cwd=made)
    lagrange("solve", "thrown.yaml", "--start", "1.5", "--stop", "0", "--set", "y=-3.75", "--set", "x=3",
             "--set", "y_dot=-10", "-o", "back.h5", cwd=made)  # fmt: skip
    lagrange("sweep", "thrown.yaml", "--over", "g=1:2:3", "-o", "sweep.h5", cwd=made)
    lagrange("section", "thrown.yaml", "--where", "y", "-o", "section.h5", cwd=made)
    return made


def reel(folder, name, **asked):
    with Result(str(folder / name)) as result:
        result.name = name
        return reel_of(result, FilmRequest(**{"fps": 10.0, **asked}))


@given(st.lists(st.floats(-3, 3), min_size=4, max_size=4), st.booleans())
@examples(30)
def test_between_samples_a_cubic_is_exact(coefficients, backward):
    cubic = np.polynomial.Polynomial(coefficients)
    t = np.array([0.0, 0.3, 0.5, 1.7, 2.0])[:: -1 if backward else 1]
    samples = Samples(t, cubic(t)[:, None], cubic.deriv()(t)[:, None])
    times = np.linspace(0, 2, 41)
    np.testing.assert_allclose(samples.at(times)[:, 0], cubic(times), atol=1e-12)


@given(st.floats(1e-12, 1e12))
@examples(100)
def test_a_film_lasts_reasonably_long(duration):
    speed = usual_speed(duration)
    assert 0.1 < duration / speed <= LONGEST
    assert speed == 1.0 or (f"{speed:.0e}"[0] in "125" and 10 < duration / speed < 40)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    ("name", "moment"), [("run.h5", lambda k: k / 10), ("back.h5", lambda k: 1.5 - k / 10)]
)
def test_the_ball_is_where_the_motion_is(folder, name, moment):
    film = reel(folder, name, trail=0.0, size=(480, 320))
    scene = film.scene()
    color = 255 * np.array(to_rgb(scene.colors[0]))
    assert film.count == 16 and film.unit == ""
    for number in (0, 7, 15):
        t = moment(number)
        picture = film.picture(scene, number).astype(float)
        rows, columns = np.nonzero(np.abs(picture - color).max(axis=2) < 40)
        expected = scene.axes.transData.transform((2 * t, 5 * t - 5 * t**2))
        assert math.dist((columns.mean(), 320 - rows.mean()), expected) < 1.5


@pytest.mark.exhaustive(keep=0.35)
def test_a_trail_is_the_path_so_far(folder):
    long, none = (reel(folder, "run.h5", trail=trail) for trail in (0.5, 0.0))
    assert long.finer == FINER and long.trail == 5 * FINER
    scene = long.scene()
    more = np.count_nonzero(long.picture(scene, 9) != none.picture(scene, 9))
    assert more > 200
    np.testing.assert_array_equal(long.picture(scene, 0), none.picture(scene, 0))


@pytest.mark.exhaustive(keep=0.4)
def test_a_trail_of_a_fast_film_has_the_samples_of_the_motion(folder):
    """Pictures 0.5 apart of a motion with samples 0.1 apart or so."""
    film = reel(folder, "run.h5", speed=5.0)
    with Result(str(folder / "run.h5")) as result:
        spacing = 1.5 / (result.held["t"].shape[0] - 1)
    assert film.count == 4 and film.finer == max(FINER, min(FINEST, round(0.5 / spacing)))
    np.testing.assert_allclose(film.t[:: film.finer], [0, 0.5, 1, 1.5], atol=1e-15)
    assert finer_than(1.0, 0.05, 10) == 20
    assert finer_than(1.0, 0.0, 10) == FINEST
    assert finer_than(1.0, 0.05, MOST_FRAMES) == FINER
    assert finer_than(0.01, 0.5, 10) == FINER


@pytest.mark.parametrize(
    ("t", "text"), [(0.5, "0.5"), (14610.0, "14610"), (-3653.0, "-3653"), (2e7, "2e+07")]
)
def test_the_clock_has_no_exponent_up_to_a_million(t, text):
    assert shown_time(t) == text


@pytest.mark.exhaustive(keep=0.65)
def test_a_part_of_a_motion_at_another_speed(folder):
    film = reel(folder, "run.h5", begin=0.45, end=0.75, speed=0.1, panels=("phase", "energy"))
    assert film.count == 31 and film.t[0] == 0.45 and film.t[-1] == pytest.approx(0.75)
    np.testing.assert_allclose(film.q[:, 1], 5 * film.t - 5 * film.t**2, atol=1e-13)
    assert [side.title for side in film.sides] == [
        "phase portrait of $x$",
        "phase portrait of $y$",
        "energies",
    ]
    assert film.picture(film.scene(), 3).shape == (600, 1200, 3)


@pytest.mark.parametrize(
    ("name", "asked", "message"),
    [
        ("few.h5", {}, "has no coordinates: solve again with --outputs q,v"),
        ("sweep.h5", {}, "contains the motions of a sweep"),
        ("section.h5", {}, "contains a section"),
        ("run.h5", {"begin": 2.0}, "--from 2: the motion of run.h5 goes from t = 0 to 1.5"),
        ("run.h5", {"begin": 1.0, "end": 0.5}, "exchange the two times"),
        ("run.h5", {"panels": ("fase",)}, "--panels fase: there is no such panel"),
        ("run.h5", {"panels": ("reactions",)}, "solve again with --outputs reactions"),
        ("run.h5", {"speed": 1e-6}, "pictures are too many"),
    ],
)
def test_what_cannot_be_shown(folder, name, asked, message):
    with pytest.raises(UsageError) as caught:
        reel(folder, name, **asked)
    assert message in str(caught.value)


def test_ctrl_c_ends_a_film_early(folder, tmp_path):
    film = reel(folder, "run.h5", size=(64, 48))
    looks = iter([False, False, True])
    made = write(
        film, find_folder(str(tmp_path / "frames"), force=False), FRAMES, Silence(), lambda: next(looks)
    )
    assert (made.pictures, made.count, made.whole) == (3, 16, False)
    assert sorted(one.name for one in tmp_path.glob("frames/*")) == ["0001.png", "0002.png", "0003.png"]


def test_a_folder_of_other_things_is_kept(tmp_path):
    (tmp_path / "frames").mkdir()
    find_folder(str(tmp_path / "frames"), force=False)
    (tmp_path / "frames" / "0001.png").write_text("")
    with pytest.raises(FileError, match="--force replaces its pictures"):
        find_folder(str(tmp_path / "frames"), force=False)
    find_folder(str(tmp_path / "frames"), force=True)
    (tmp_path / "frames" / "thesis.tex").write_text("")
    with pytest.raises(FileError, match=r"contains other files \(thesis\.tex\)"):
        find_folder(str(tmp_path / "frames"), force=True)


@pytest.mark.exhaustive(keep=0.75)
def test_a_folder_of_its_own_pictures_is_replaced(folder, tmp_path):
    """Without --force, as long as nobody has changed one of them."""

    def animated(*options, source=folder / "run.h5"):
        asked = ("--fps", "5", "--size", "64x48", "-o", "frames/")
        return lagrange("animate", source, *asked, *options, cwd=tmp_path)

    assert "replaced" not in animated().stdout
    again = animated("--to", "1")
    assert again.returncode == 0 and "replaced" in again.stdout
    assert len(list(tmp_path.glob("frames/*"))) == 6
    other = animated(source=folder / "back.h5")
    assert other.returncode == 5 and "--force replaces its pictures" in other.stderr
    picture = tmp_path / "frames" / "0003.png"
    picture.rename(picture.with_name("0033.png"))
    changed = animated()
    assert changed.returncode == 5 and "--force replaces its pictures" in changed.stderr
    assert len(list(tmp_path.glob("frames/*"))) == 6
    assert animated("--force").returncode == 0 and not list(tmp_path.glob("frames/0033.png"))


def test_pictures_that_appear_in_the_meantime_are_kept(folder, tmp_path):
    film = reel(folder, "run.h5", size=(64, 48))
    target = find_folder(str(tmp_path / "frames"), force=False)

    def meanwhile():
        target.path.mkdir(exist_ok=True)
        (target.path / "0001.png").write_text("mine")
        return False

    with pytest.raises(FileError, match="appeared during this run"):
        write(film, target, FRAMES, Silence(), meanwhile)
    assert [one.read_text() for one in target.path.iterdir()] == ["mine"]
    assert len(list(target.temporary.iterdir())) == 16


def test_a_long_output_is_read_in_parts(folder, monkeypatch):
    monkeypatch.setattr("lagrange_cli.run.sampling.MOST_NUMBERS", 30)
    with h5py.File(folder / "run.h5") as file:
        assert len(file["t"]) == 16
    film = reel(folder, "run.h5")
    np.testing.assert_allclose(film.q[:, 1], 5 * film.t - 5 * film.t**2, atol=1e-13)


@pytest.mark.exhaustive(keep=0.3)
def test_the_command(folder, tmp_path):
    system = SYSTEMS / "rotating_hoop.yaml"
    asked = ("--stop", "1", "--fps", "5", "--size", "65x48", "--panels", "q,energy")
    done = lagrange("animate", system, *asked, "-o", "a.gif", "--json", cwd=tmp_path)
    report = json.loads(done.stdout)
    assert done.returncode == 0 and report["pictures"] == report["of"] == 6 and report["speed"] == 1.0
    with Image.open(tmp_path / "a.gif") as image:
        assert image.size == (66, 48) and image.n_frames == 6
    done = lagrange("animate", folder / "run.h5", "-o", "b.mp4", "--size", "64x48", cwd=tmp_path)
    assert done.stdout == "thrown <b>$x$</b>: wrote b.mp4 (46 pictures, 1.53 s, in real time)\n"
    (tmp_path / "kept.mp4").write_text("mine")
    for arguments, status, message in (
        (["-o", "a.avi"], 2, "must end in .mp4, .apng, .gif, or in /"),
        (["-o", "kept.mp4"], 5, "already exists"),
        (["--stop", "3"], 2, "--stop is for the motion of a system file"),
        (["--size", "9x9"], 2, "must be from 16 to 7680"),
        (["--size", "big"], 2, "is neither pixels, as in --size 800x600"),
        (["-o", "none/a.mp4"], 5, "there is no directory"),
    ):
        done = lagrange("animate", folder / "run.h5", *arguments, cwd=tmp_path)
        assert done.returncode == status and message in done.stderr, done.stderr


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("size", [(640, 480), (400, 200), (1920, 1080)])
@pytest.mark.parametrize("name", ["a long name of a system " * 10, "W" * 200, "short"])
def test_a_title_ends_within_the_picture(folder, name, size):
    scene = replace(reel(folder, "run.h5"), name=name, size=size).scene()
    (title,) = [one for one in scene.canvas.figure.texts if one.get_fontweight() == "bold"]
    box, picture = title.get_window_extent(), scene.canvas.figure.bbox
    assert box.x0 >= 0 and box.x1 <= picture.x1
    shown = title.get_text().removesuffix("\N{HORIZONTAL ELLIPSIS}")
    assert name.startswith(shown) and len(shown) >= min(len(name), 20)
