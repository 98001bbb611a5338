"""``view``: a web page that draws a system and computes its motion in the browser."""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from lagrange_cli.api.given import Value, Values, check_lengths, flag_of, request_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.words import in_python

if TYPE_CHECKING:
    from pathlib import Path

    from lagrange_cli.run.motion import Motion
    from lagrange_cli.run.view import page as pages

HEIGHT = 640
"""The height of a page in a notebook, in pixels."""


class Page:
    """A page that shows a system. A notebook shows it where it is the last value of a cell.

    Attributes
    ----------
    text : str
        The HTML, which needs no network.
    live : bool
        Whether it computes; else it replays one motion, and ``why`` says why.
    """

    def __init__(self, name: str, page: pages.Page) -> None:
        self.name, self._page = name, page

    @property
    def text(self) -> str:
        """The HTML."""
        return self._page.text

    @property
    def live(self) -> bool:
        """Whether the page computes."""
        return self._page.live

    @property
    def why(self) -> str:
        """Why it does not compute; empty if it does."""
        return self._page.why

    @in_python
    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the page to a file.

        Parameters
        ----------
        path : str or path
            Its name, such as ``pendulum.html``.
        force : bool
            Whether an existing file may be replaced.

        Raises
        ------
        FileError
            The file exists, or cannot be written.
        UsageError
            The name is that of another kind of file.
        """
        from lagrange_cli.run.request import check_page
        from lagrange_cli.run.view.page import write
        from lagrange_cli.store.find_target import find_target

        check_page(os.fspath(path))
        target = find_target(os.fspath(path), force=flag_of("force", force), ending=".html")
        write(self._page, target)

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {HEIGHT}px; border: 0"
        allowed = "allow-scripts allow-downloads"
        return f'<iframe srcdoc="{escape(self.text)}" style="{style}" sandbox="{allowed}"></iframe>'

    def __repr__(self) -> str:
        how = "computes in the browser" if self.live else f"replays one motion: {self.why}"
        return f"<page of {self.name}: {len(self.text) / 1000:.0f} kB, {how}>"


@in_python
def view(
    system: System,
    *,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
    start: Value | None = None,
    stop: Value | None = None,
    samples: int | None = None,
    project_initial: bool = False,
    cache: bool = True,
) -> Page:
    """Make a web page that draws a system and computes its motion.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    set, size, start, stop, samples, project_initial, cache
        As for ``solve``.

    Returns
    -------
    Page

    Raises
    ------
    SpecError, UsageError, FileError
        As for ``solve``.
    """
    from lagrange_cli.run.view.motion import read_shown

    request = request_of(
        set=set,
        size=size,
        times={"start": start, "stop": stop},
        samples=samples,
        project_initial=project_initial,
        cache=cache,
    )
    content, filename = content_of(system)
    with WORKING:
        motion = read_shown(content, filename, request)
        check_lengths(motion.spec, set)
        return page_of(motion)


def page_of(motion: Motion) -> Page:
    """The page of a motion."""
    from lagrange_cli.run.view.page import view as page

    with WORKING:
        return Page(motion.spec.name, page(motion))


def page_of_output(path: Path) -> Page:
    """The page of an output file: it replays the motion, or has the members on a slider."""
    from lagrange_cli.run.replay import view_output

    with WORKING:
        return Page(*view_output(path))
