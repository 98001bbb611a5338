"""``plot``: pictures of motions, sweeps and sections."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, runtime_checkable

from lagrange_cli.api.given import flag_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.words import in_python
from lagrange_cli.errors import UsageError
from lagrange_cli.figures.style import check_matplotlib, plain
from lagrange_cli.run.plot import PlotRequest, check_format, page_of, write
from lagrange_cli.run.source import count_of
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.result import Result

if TYPE_CHECKING:
    from lagrange_cli.figures.panels import Page

CREATOR = "lagrange-cli"


@runtime_checkable
class Drawable(Protocol):
    """A result of ``solve``, ``sweep``, ``section`` or ``load``."""

    @property
    def name(self) -> str:
        """Its file name."""

    def _output(self, held: ExitStack) -> Path:
        """The output file, which is there until ``held`` is closed."""


Shown: TypeAlias = "Drawable | str | os.PathLike[str]"
"""What can be drawn: a result, or the name of an output file."""


class Picture:
    """A picture. A notebook shows it where it is the last value of a cell."""

    def __init__(self, page: Page, inches: tuple[float, float] | None) -> None:
        self._page, self._inches = page, inches

    @property
    def panels(self) -> tuple[str, ...]:
        """The titles of its panels."""
        return tuple(plain(panel.title or panel.y) for panel in self._page.panels)

    def draw(self, format: str = ".png") -> bytes:
        """The picture as the content of a file.

        Parameters
        ----------
        format : {".png", ".svg", ".pdf"}
        """
        from lagrange_cli.figures.draw import draw

        with WORKING:  # matplotlib's settings are those of the process
            return draw(self._page, check_format(f"picture{format}"), CREATOR, self._inches)

    @in_python
    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the picture to a file.

        Parameters
        ----------
        path : str or path
            Its name, which ends in ``.png``, ``.svg`` or ``.pdf``.
        force : bool
            Whether an existing file may be replaced.

        Raises
        ------
        UsageError
            The name has another ending.
        FileError
            The file exists, or cannot be written.
        """
        name = os.fspath(path)
        format = check_format(name)
        write(self.draw(format), find_target(name, force=flag_of("force", force)))

    def _repr_png_(self) -> bytes:
        return self.draw(".png")

    def __repr__(self) -> str:
        return f"<picture of {self._page.title}: {', '.join(self.panels)}>"


@in_python
def plot(
    *results: Shown,
    what: str | Iterable[str] | None = None,
    x: str | None = None,
    y: str | Iterable[str] | None = None,
    inches: tuple[float, float] | None = None,
    labels: Sequence[str] | None = None,
) -> Picture:
    """Draw results over each other, all of one kind.

    Parameters
    ----------
    *results : Motion, Sweep, Section, or path
        What is drawn; a path is that of an output file.
    what : sequence of str, optional
        The panels: ``["q", "phase", "drift"]``; by default what a physicist looks at first.
    x, y : str, optional
        In place of ``what``, quantities over another one, such as ``y=["theta", "h"]`` over ``x="t"``.
    inches : (float, float), optional
        The size of the picture.
    labels : sequence of str, optional
        What the results are called in the legend.

    Returns
    -------
    Picture
        A notebook shows it; ``save`` writes it to a file.

    Raises
    ------
    UsageError
        This cannot be drawn; the message says what can.
    MissingPackage
        There is no matplotlib.
    FileError
        A file cannot be read, or is no output of lagrange.
    """
    check_matplotlib("plot")
    if not results:
        raise UsageError("plot needs a motion, a sweep, a section, or the name of an output file")
    asked = PlotRequest(words(what), x, words(y))
    if asked.what and (x or y):
        raise UsageError("what and y both say what to draw: give one of them")
    if labels is not None and (isinstance(labels, str) or not isinstance(labels, Sequence)):
        raise UsageError(f"labels must be a list of texts, one for each result, not {labels!r:.60}")
    if labels is not None and len(labels) != len(results):
        said = count_of(len(labels), "label"), count_of(len(results), "result")
        raise UsageError(f"labels must be as many as the results: there are {said[0]} for {said[1]}")
    with ExitStack() as stack:
        opened = [stack.enter_context(Result(str(file_of(one, stack)))) for one in results]
        for result, name in zip(opened, map(str, labels or names_of(results))):
            result.name = name
        return Picture(page_of(opened, asked), inches)


def file_of(one: Any, held: ExitStack) -> Path:
    """The output file of a result; that of a motion is written for as long as ``held`` is open."""
    if isinstance(one, Drawable):
        return one._output(held)
    if isinstance(one, (str, os.PathLike)):
        path = Path(one)
        if path.suffix.lower() in (".yaml", ".yml"):
            raise UsageError(
                f"{path} is a system file, not an output: give what solve or sweep returns for it"
            )
        return path
    raise UsageError(f"plot draws motions, sweeps, sections and output files, not {type(one).__name__}")


def names_of(results: Sequence[Any]) -> list[str]:
    """What results are called: the name of the system or of the file, with a number where it is not alone."""
    names = [os.fspath(one) if isinstance(one, (str, os.PathLike)) else one.name for one in results]
    counts, seen = Counter(names), Counter[str]()
    found = []
    for name in names:
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if counts[name] > 1 else name)
    return found


def words(given: str | Iterable[str] | None) -> tuple[str, ...]:
    """``"q,drift"`` or ``["q", "drift"]`` as words."""
    listed = () if given is None else given.split(",") if isinstance(given, str) else given
    if not isinstance(listed, Iterable):
        raise UsageError(f"a list of names is expected, as in ['q', 'drift'], not {given!r:.60}")
    return tuple(str(word).strip() for word in listed if str(word).strip())
