"""``Pictured``: the datasets by name, and the pictures, that every result has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrange_cli.api.group import Group, folder

if TYPE_CHECKING:
    from lagrange_cli.api.animate import Film
    from lagrange_cli.api.plot import Picture


class Pictured:
    """A result of ``solve``, ``sweep``, ``section`` or ``load``, which is a ``plot.Drawable``."""

    _arrays: Mapping[str, Any]
    """Its datasets by their paths."""

    @property
    def name(self) -> str:
        """Its file name."""
        raise NotImplementedError

    def _output(self, held: ExitStack) -> Path:
        """The output file, which is there until ``held`` is closed."""
        raise NotImplementedError

    def _missing(self, name: str) -> AttributeError:
        """Why an output is not there."""
        return AttributeError(f"{name!r} was not computed: name it in outputs")

    def _group(self, name: str) -> Group:
        group = Group(folder(name), self._arrays)
        if not len(group):
            raise self._missing(name)
        return group

    @property
    def q(self) -> Group:
        """The coordinates by name."""
        return self._group("q")

    @property
    def v(self) -> Group:
        """Their velocities by name."""
        return self._group("v")

    @property
    def p(self) -> Group:
        """The momenta by the names of the coordinates."""
        return self._group("p")

    def plot(
        self,
        what: str | Iterable[str] | None = None,
        *,
        x: str | None = None,
        y: str | Iterable[str] | None = None,
        inches: tuple[float, float] | None = None,
    ) -> Picture:
        """Draw it. It needs the extra ``plot``.

        Parameters
        ----------
        what : sequence of str, optional
            The panels, of ``q``, ``v``, ``p``, ``phase``, ``path``, ``drift``, ``energy``, ``ledger``, ...;
            by default what a physicist looks at first.
        x, y : str, optional
            In place of ``what``, quantities over another one: ``y=["theta", "h"]``.
        inches : (float, float), optional
            The size of the picture.

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
        """
        from lagrange_cli.api.plot import plot

        return plot(self, what=what, x=x, y=y, inches=inches)

    def animate(
        self,
        *,
        speed: float | None = None,
        fps: float = 30.0,
        begin: float | None = None,
        end: float | None = None,
        trail: float | None = None,
        panels: str | Iterable[str] | None = None,
        size: tuple[int, int] | None = None,
    ) -> Film:
        """A film of it: see ``lagrange_cli.animate``. It needs the extra ``animate``."""
        from lagrange_cli.api.animate import animate

        return animate(
            self, speed=speed, fps=fps, begin=begin, end=end, trail=trail, panels=panels, size=size
        )
