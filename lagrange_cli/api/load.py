"""``load``: outputs that lie in files."""

from __future__ import annotations

import os
from pathlib import Path

from lagrange_cli.api.stored import Stored
from lagrange_cli.errors import FileError


def load(path: str | os.PathLike[str]) -> Stored:
    """Open an output of ``lagrange solve``, ``sweep`` or ``section``, or of ``save``.

    Parameters
    ----------
    path : str or path
        The name of the HDF5 file. Arrays are read from it when they are asked for.

    Returns
    -------
    Stored

    Raises
    ------
    FileError
        There is no such file, or it is no output of lagrange.
    """
    place = Path(path)
    if not place.exists():
        raise FileError(f"{place}: no such file")
    return Stored(place.absolute())
