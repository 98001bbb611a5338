"""``animate``: the drawing of a motion as a film."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange_cli.api.folder import Folder
from lagrange_cli.api.given import finite_of, flag_of, is_whole
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.plot import Shown, file_of, words
from lagrange_cli.api.words import in_python
from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.figures.film import FRAMES, check_film
from lagrange_cli.run.animate import find_folder, format_of, write
from lagrange_cli.run.film_bounds import FASTEST, LEAST, MOST, SLOWEST
from lagrange_cli.run.monitor import Silence
from lagrange_cli.run.reel import FilmRequest, reel_of
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.result import Result

if TYPE_CHECKING:
    from lagrange_cli.run.reel import Reel

LARGEST = 2**25
"""Bytes of a film that a notebook holds."""


class Film:
    """A film. A notebook shows it where it is the last value of a cell.

    Attributes
    ----------
    pictures : int
        The number of its pictures.
    seconds : float
        How long it lasts.
    speed : float
        Units of t that pass in a second.
    """

    def __init__(self, reel: Reel) -> None:
        self._reel = reel

    @property
    def pictures(self) -> int:
        """The number of its pictures."""
        return self._reel.count

    @property
    def seconds(self) -> float:
        """The duration of the film."""
        return self._reel.count / self._reel.fps

    @property
    def speed(self) -> float:
        """Units of t that pass in a second."""
        return self._reel.speed

    @in_python
    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the film to a file.

        Parameters
        ----------
        path : str or path
            Its name, which ends in ``.mp4``, ``.gif`` or ``.apng``; without an ending, that of a folder for
            single pictures.
        force : bool
            Whether an existing film may be replaced.

        Raises
        ------
        UsageError
            The name has another ending, or the film is too large for it.
        FileError
            The file exists, or cannot be written.
        """
        name = os.fspath(path)
        kind = format_of(name)
        force = flag_of("force", force)
        target = find_folder(name, force=force) if kind == FRAMES else find_target(name, force=force)
        with WORKING:  # matplotlib's settings are those of the process
            write(self._reel, target, kind, Silence(), lambda: False)

    def _repr_html_(self) -> str | None:
        from base64 import b64encode

        folder = Folder()
        try:
            place = folder.path / "film.mp4"
            self.save(place)
            content = place.read_bytes()
        finally:
            folder.remove()
        if len(content) > LARGEST:
            return None
        source = f"data:video/mp4;base64,{b64encode(content).decode()}"
        return f'<video controls loop width="{self._reel.size[0]}" src="{source}"></video>'

    def __repr__(self) -> str:
        return f"<film of {self._reel.name}: {self.pictures} pictures, {decimal(self.seconds, 3)} s>"


def even_size(size: tuple[int, int] | None) -> tuple[int, int] | None:
    """The size of pictures, as films must have it. Raises ``UsageError`` for what is none."""
    if size is None:
        return None
    pair = size if isinstance(size, Sequence) and len(size) == 2 else ()
    if not pair or not all(is_whole(one) and LEAST <= one <= MOST for one in pair):
        raise UsageError(f"size must be two whole numbers from {LEAST} to {MOST}, not {size!r:.60}")
    width, height = map(int, pair)
    return width + width % 2, height + height % 2


@in_python
def animate(
    result: Shown,
    *,
    speed: float | None = None,
    fps: float = 30.0,
    begin: float | None = None,
    end: float | None = None,
    trail: float | None = None,
    panels: str | Iterable[str] | None = None,
    size: tuple[int, int] | None = None,
) -> Film:
    """A film of a motion, as ``lagrange animate`` makes it.

    Parameters
    ----------
    result : Motion, or path
        What is shown; a path is that of an output file.
    speed : float, optional
        Units of t that pass in a second; by default 1, or so many that the film has a reasonable length.
    fps : float
        Pictures a second.
    begin, end : float, optional
        The times at which the film begins and ends.
    trail : float, optional
        The part of the path that is shown, in units of t; 0 for none.
    panels : sequence of str, optional
        Panels beside the drawing, such as ``["phase", "energy"]``.
    size : (int, int), optional
        The size in pixels.

    Returns
    -------
    Film
        A notebook shows it; ``save`` writes it to a file.

    Raises
    ------
    UsageError
        The result cannot be shown; the message says why.
    MissingPackage
        A package is missing that films need.
    FileError
        The file cannot be read, or is no output of lagrange.
    """
    check_film("animate")
    fps = finite_of("fps", fps)
    times = {"speed": speed, "begin": begin, "end": end, "trail": trail}
    speed, begin, end, trail = (None if one is None else finite_of(name, one) for name, one in times.items())
    if not SLOWEST <= fps <= FASTEST:
        raise UsageError(
            f"fps must be a number from {decimal(SLOWEST)} to {decimal(FASTEST)}, not {decimal(fps)}"
        )
    if speed is not None and not speed > 0:
        raise UsageError(f"speed must be a number greater than 0, not {decimal(speed)}")
    if trail is not None and not trail >= 0:
        raise UsageError(f"trail must be a number of at least 0, not {decimal(trail)}")
    asked = FilmRequest(fps, speed, begin, end, trail, words(panels), even_size(size))
    with ExitStack() as stack, Result(str(file_of(result, stack))) as opened:
        opened.name = os.fspath(result) if isinstance(result, (str, Path)) else opened.title
        return Film(reel_of(opened, asked))
