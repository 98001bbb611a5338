"""Films: pictures one after the other, as MP4, APNG or GIF, or as a folder of PNG files.

The same pictures give the same bytes with the same versions of ffmpeg and Pillow: nothing is encoded by
several threads, and neither times nor versions are noted.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from lagrange_cli.errors import MissingPackage

Add = Callable[[np.ndarray], None]
"""Adds a picture (height, width, 3) of bytes to a film."""
ENCODED = {
    ".mp4": (
        "-c:v", "libx264", "-preset", "medium", "-crf", "18", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", "-f", "mp4",
    ),
    ".apng": ("-c:v", "apng", "-pred", "mixed", "-plays", "0", "-f", "apng"),
}  # fmt: skip
"""The arguments of ffmpeg for each format."""
EXACT = ("-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1")
FORMATS = (*ENCODED, ".gif")
FRAMES = "folder"
"""The format of single pictures."""
SHADES = 192
"""Colours of a GIF: of all that it shows, the most frequent ones."""
GIF_PIXELS = 1_500_000_000
"""A GIF of more pixels in all would take too much memory."""


def check_film(asked: str) -> None:
    """Raise ``MissingPackage`` where a package is missing that ``asked`` needs."""
    for module, package in (
        ("matplotlib", "matplotlib"),
        ("imageio_ffmpeg", "imageio-ffmpeg"),
        ("PIL", "pillow"),
    ):
        if importlib.util.find_spec(module) is None:
            raise MissingPackage(asked, package, "animate")


@contextmanager
def film(path: Path, kind: str, fps: float, sample: np.ndarray) -> Iterator[Add]:
    """A film of the format ``kind`` that is written to ``path``, complete when the context ends.

    ``sample`` (k, height, width, 3) are some of its pictures: they tell the size, and the colours of a GIF.

    Raises ``OSError`` where it cannot be written, with the reason.
    """
    if kind == FRAMES:
        yield pictures(path)
    elif kind == ".gif":
        with gif(path, fps, sample) as add:
            yield add
    else:
        with encoded(path, kind, fps, sample) as add:
            yield add


def pictures(folder: Path) -> Add:
    """Writes each picture to its own file: ``0001.png``, ``0002.png``, ..."""
    from PIL import Image

    count = 0

    def add(picture: np.ndarray) -> None:
        nonlocal count
        count += 1
        Image.fromarray(picture).save(folder / f"{count:04d}.png")

    return add


@contextmanager
def gif(path: Path, fps: float, sample: np.ndarray) -> Iterator[Add]:
    """Collects the pictures in the colours of ``sample``, and writes them at the end.

    A GIF shows a picture for whole hundredths of a second: those of all pictures add up to the right time.
    """
    from PIL import Image

    shared = Image.fromarray(sample.reshape(-1, *sample.shape[2:])).quantize(SHADES)
    colors = np.array(shared.getpalette(), dtype=np.uint8).reshape(-1, 3)
    colors[colors.sum(axis=1, dtype=int).argmax()] = (
        255  # the background, which was mixed with its neighbours
    )
    shared.putpalette(colors.tobytes())
    frames: list[Any] = []

    def add(picture: np.ndarray) -> None:
        frames.append(Image.fromarray(picture).quantize(palette=shared, dither=Image.Dither.NONE))

    yield add
    if frames:
        ends = [round(100 * (k + 1) / fps) for k in range(len(frames))]
        shown = [10 * max(end - begin, 1) for begin, end in zip([0, *ends], ends)]
        with path.open("wb") as file:
            frames[0].save(
                file, "GIF", save_all=True, append_images=frames[1:], duration=shown, loop=0, optimize=False
            )


@contextmanager
def encoded(path: Path, kind: str, fps: float, sample: np.ndarray) -> Iterator[Add]:
    """Hands the pictures over to ffmpeg."""
    from imageio_ffmpeg import get_ffmpeg_exe

    height, width = sample.shape[1:3]
    source = (
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-s",
        f"{width}x{height}",
        "-r",
        f"{fps:.12g}",
        "-i",
        "-",
    )
    command = [ffmpeg(get_ffmpeg_exe), "-y", "-loglevel", "error", *source, *EXACT, *ENCODED[kind], str(path)]
    with started(command) as process:
        assert process.stdin is not None and process.stderr is not None
        stream = process.stdin

        def add(picture: np.ndarray) -> None:
            stream.write(np.ascontiguousarray(picture).data)

        try:
            yield add
        except BrokenPipeError:
            pass  # it says why
        except BaseException:
            process.kill()
            raise
        with suppress(BrokenPipeError):
            stream.close()
        said = process.stderr.read().decode("utf-8", "replace").strip().splitlines()
        if process.wait() != 0:
            # the first line says why, the others what follows from it
            why = re.sub(r"^\[[^]]*\] ", "", said[0]) if said else f"ended with status {process.returncode}"
            raise OSError(f"ffmpeg: {why}")


def started(command: Sequence[str]) -> subprocess.Popen[bytes]:
    """ffmpeg in another session: Ctrl-C is ours, and the film ends properly.

    Raises ``MissingPackage`` where it cannot be run.
    """
    try:
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
        )
    except (FileNotFoundError, PermissionError) as error:
        raise MissingPackage("an animation", "ffmpeg", "animate") from error


def ffmpeg(found: Callable[[], str]) -> str:
    """The path of ffmpeg; raises ``MissingPackage`` where there is none."""
    try:
        return found()
    except RuntimeError as error:
        raise MissingPackage("an animation", "ffmpeg", "animate") from error
