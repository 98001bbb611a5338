"""``Motion``: what ``solve`` returns."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.api.given import flag_of
from lagrange_cli.api.group import Group, is_group
from lagrange_cli.api.pictures import Pictured
from lagrange_cli.api.words import in_python, python_words
from lagrange_cli.outputs.catalog import OUTPUTS

if TYPE_CHECKING:
    from contextlib import ExitStack
    from pathlib import Path

    import numpy as np
    import xarray
    from numpy.typing import NDArray

    from lagrange_cli.api.view import Page
    from lagrange_cli.integrate.outcome import Estimated
    from lagrange_cli.run.memory import Followed

    Array = NDArray[np.float64]


class Motion(Pictured):
    """A motion, with all its outputs.

    Arrays have the n sample times along their first axis, in the units of the system file. They cannot be
    written to; ``motion.t.copy()`` can.

    Attributes
    ----------
    t : ndarray, shape (n,)
        The sample times.
    q, v, p : Group
        Coordinates, velocities and momenta p_k = dL/dq_dot_k by name: ``motion.q["theta"]``, shape (n,); of a
        family ``theta[i in range(N)]`` shape (n, N).
    h : ndarray, shape (n,)
        The energy function, sum q_dot_k p_k - L.
    T, U, energy, action, positions, ledger, ... : ndarray or Group
        The other outputs, if ``outputs`` names them.
    events : Group
        The crossings of each event: ``motion.events["floor"]["t"]``.
    status : str
        ``complete``; ``stopped``, where an event ended the motion; ``failed`` or ``interrupted``, where the
        motion is that of an exception.
    message : str
        How the motion ended, as the command says it.
    notes : tuple of str
        The other messages of the command.
    units : mapping of str to str
        The units of datasets by their paths, as far as they are known: ``motion.units["q/theta"]``.
    certificate : Estimated or None
        The estimated error, if it was requested: ``trusted_until``, ``error``, ``trusted_until_as_run``,
        ``error_as_run``.
    """

    def __init__(self, followed: Followed, units: Mapping[str, str], notes: tuple[str, ...]) -> None:
        self._followed, self.units, self.notes = followed, units, notes
        self._arrays: Mapping[str, Array] = followed.samples

    @property
    def name(self) -> str:
        """The name of the system."""
        return self._followed.motion.spec.name

    @property
    def status(self) -> str:
        """The status of its end, in a word."""
        status: str = self._followed.outcome.ending.status
        return status

    @property
    def message(self) -> str:
        """How it ended, in a sentence."""
        return python_words(self._followed.outcome.message)

    @property
    def certificate(self) -> Estimated | None:
        """The estimated error, if it was requested."""
        return self._followed.outcome.estimated

    @property
    def parameters(self) -> dict[str, float]:
        """The values of the parameters."""
        return dict(self._followed.motion.values.parameters)

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the output file: ``method``, ``tolerance``, ``steps``, ``h_drift``, ..."""
        from lagrange_cli.run.attributes import attributes

        followed = self._followed
        said = attributes(followed.made_by, followed.outcome, followed.motion.settings)
        parsed = ("parameters", "sizes", "run", "p_drift", "final", "events", "singular")
        return {name: json.loads(str(x)) if name in parsed else x for name, x in said.items()}

    @property
    def datasets(self) -> Group:
        """Everything by the paths of the output file: ``motion.datasets["diagnostics/h"]``."""
        return Group("", {**self._followed.samples, **self._followed.crossings})

    @property
    def t(self) -> Array:
        """The sample times (n,)."""
        return self._dataset("t")

    @property
    def h(self) -> Array:
        """The energy function (n,)."""
        return self._dataset("h")

    @property
    def error(self) -> Group:
        """The estimated error of each sample by path (``motion.error["q/theta"]``), if it was requested."""
        if self.certificate is None:
            raise AttributeError("error")
        return Group("diagnostics/error/", self._followed.samples)

    @property
    def events(self) -> Group:
        """The crossings of events by their names."""
        return Group("events/", self._followed.crossings)

    def __getattr__(self, name: str) -> Any:
        if name not in OUTPUTS:
            without = "there is no estimated error: solve with certify=True"  # Python asks here, too
            raise AttributeError(without if name == "error" else f"a motion has no {name!r}")
        return self._group(name) if is_group(name) else self._dataset(name)

    def __dir__(self) -> list[str]:
        computed = self._followed.motion.settings.outputs.difference(self._followed.outcome.left_out)
        return sorted({*super().__dir__(), *computed})

    def __repr__(self) -> str:
        return f"<motion of {self.name}: {len(self._arrays.get('t', ()))} samples, {self.message}>"

    def _dataset(self, name: str) -> Array:
        path = "t" if name == "t" else OUTPUTS[name].datasets.strip("/")
        if path not in self._arrays:
            raise self._missing(name)
        return self._arrays[path]

    def _missing(self, name: str) -> AttributeError:
        asked = self._followed.motion.settings.outputs
        if name in self._followed.outcome.left_out:
            return AttributeError(f"{name!r} was not computed: it is left out of 'all', as the notes say")
        if name in asked or name == "t":
            what = "there are no samples" if not self._arrays else "this system has none"
            return AttributeError(f"{name!r} was not computed: {what}")
        listed = ", ".join(repr(one) for one in OUTPUTS if one in asked or one == name)
        return AttributeError(f"{name!r} was not computed: solve with outputs=[{listed}]")

    @in_python
    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the motion to a file: the same bytes as those of ``lagrange solve -o``.

        Parameters
        ----------
        path : str or path
            The name of an HDF5 file, or of a table if it ends in ``.csv``.
        force : bool
            Whether an existing file may be replaced.

        Raises
        ------
        FileError
            The file exists, or cannot be written.
        UsageError
            The name is that of another kind of file.
        """
        from lagrange_cli.run.memory import save
        from lagrange_cli.run.request import format_of
        from lagrange_cli.store.find_target import find_target

        name = os.fspath(path)
        form = format_of(name)
        target = find_target(name, force=flag_of("force", force))
        save(self._followed, target, form)

    def to_xarray(self) -> xarray.DataTree:
        """The motion as a tree of xarray's datasets, with the names, units and axes of the output file.

        ``tree["q"].theta`` is the coordinate over ``t``. It needs the extra ``xarray``.

        Raises
        ------
        MissingPackage
            There is no xarray.
        """
        from lagrange_cli.api.trees import tree_of

        layout = self._followed.layout
        told = {name: x for name, x in self.attributes.items() if not isinstance(x, Mapping)}
        return tree_of(layout, {**self._arrays, **self._followed.crossings}, told)

    def _output(self, held: ExitStack) -> Path:
        """See ``plot.Drawable``."""
        from lagrange_cli.api.folder import Folder

        folder = Folder()
        held.callback(folder.remove)
        self.save(folder.result)
        return folder.result

    def view(self) -> Page:
        """A web page that draws the system and computes this motion, and others, where it is read.

        Returns
        -------
        Page
            A notebook shows it; ``save`` writes it to a file.
        """
        from lagrange_cli.api.view import page_of

        return page_of(self._followed.motion)
