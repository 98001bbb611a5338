"""Films: the pictures that go in come out, and the same ones are the same file."""

import os
import re
import subprocess

import numpy as np
import pytest
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image

from lagrange_cli.errors import FileError, MissingPackage
from lagrange_cli.figures.film import FRAMES, film
from lagrange_cli.store.find_target import find_target

WIDTH, HEIGHT, COUNT, FPS = 64, 48, 7, 12.5


def pictures():
    """A dark square that moves to the right by 4 pixels a picture."""
    found = np.full((COUNT, HEIGHT, WIDTH, 3), 255, dtype=np.uint8)
    for k, picture in enumerate(found):
        picture[16:32, 4 * k : 4 * k + 16] = (0, 64, 160)
    return found


def written(path, kind):
    frames = pictures()
    with film(path, kind, FPS, frames[::3]) as add:
        for one in frames:
            add(one)
    return path


def shown(path, kind):
    """The pictures of a film, and its length in seconds."""
    if kind == FRAMES:
        return np.array([np.asarray(Image.open(one)) for one in sorted(path.iterdir())]), COUNT / FPS
    if kind in (".gif", ".apng"):
        with Image.open(path) as image:
            frames, length = [], 0.0
            for k in range(image.n_frames):
                image.seek(k)
                frames.append(np.asarray(image.convert("RGB")))
                length += image.info["duration"] / 1000
        return np.array(frames), length
    form = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-")
    read = subprocess.run([get_ffmpeg_exe(), "-i", str(path), *form], capture_output=True, check=True)
    length = re.search(rb"Duration: 00:00:([0-9.]+)", read.stderr)
    return np.frombuffer(read.stdout, np.uint8).reshape(-1, HEIGHT, WIDTH, 3), float(length[1])


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("kind", [".mp4", ".gif", ".apng", FRAMES])
def test_what_goes_in_comes_out(kind, tmp_path):
    paths = [tmp_path / f"{name}{'' if kind == FRAMES else kind}" for name in "ab"]
    for path in paths:
        if kind == FRAMES:
            path.mkdir()
        written(path, kind)
    frames, length = shown(paths[0], kind)
    assert frames.shape == (COUNT, HEIGHT, WIDTH, 3)
    assert length == pytest.approx(COUNT / FPS, abs=0.011)
    difference = np.abs(frames.astype(int) - pictures())
    assert difference.max() <= (0 if kind in (".apng", FRAMES) else 90) and difference.mean() < 3
    if kind != FRAMES:
        assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_film_that_cannot_be_written_leaves_nothing(tmp_path):
    target = find_target(str(tmp_path / "a.mp4"), force=False)
    with (
        pytest.raises(FileError, match=r"a\.mp4 could not be written: .*(No such file|Not a directory)"),
        target.filled() as path,
    ):
        written(path / "there is no such folder", ".mp4")
    assert not any(tmp_path.iterdir())


def test_an_ffmpeg_that_cannot_be_run_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "gone"))
    with pytest.raises(MissingPackage, match="needs ffmpeg: pip install"):
        written(tmp_path / "a.mp4", ".mp4")


@pytest.mark.skipif(os.name != "posix", reason="a script stands for ffmpeg")
def test_the_first_thing_that_ffmpeg_says_is_the_reason(tmp_path, monkeypatch):
    """What it says afterwards follows from it."""
    script = tmp_path / "ffmpeg"
    said = "[out#0/mp4 @ 0x1] Error: No space left on device\n[out#0/mp4 @ 0x1] Nothing was written"
    script.write_text(f"#!/bin/sh\ncat > /dev/null\ncat >&2 <<END\n{said}\nEND\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(script))
    with pytest.raises(OSError, match=r"^ffmpeg: Error: No space left on device$"):
        written(tmp_path / "a.mp4", ".mp4")
