"""The formats an output can have, and how its name says which."""

from __future__ import annotations

import os

from lagrange_cli.errors import UsageError

HDF5, CSV = "hdf5", "csv"
FORMATS = HDF5, CSV
ENDINGS = {HDF5: ".h5", CSV: ".csv"}
OTHERS = frozenset(
    (
        ".txt", ".tsv", ".json", ".jsonl", ".yaml", ".yml", ".npy", ".npz", ".mat", ".xls", ".xlsx", ".ods",
        ".parquet", ".feather", ".pkl", ".pickle", ".zarr", ".fits", ".sqlite", ".db", ".png", ".svg", ".pdf",
        ".gif", ".mp4", ".gz", ".bz2", ".xz", ".zst", ".zip", ".tar",
    )
)  # fmt: skip
"""Endings that promise a format which is not written. (Any other ending is as good as .h5.)"""


def format_of(output: str | None, asked: str | None = None) -> str:
    """The format of an output: the one ``asked`` for with ``--format``, else what its name says.

    Raises ``UsageError`` where the name promises another one.
    """
    if asked is not None or output is None:
        return asked or HDF5
    stem, ending = os.path.splitext(output)
    if ending.lower() == ENDINGS[CSV]:
        return CSV
    if ending.lower() in OTHERS:
        stem = os.path.splitext(stem)[0] or stem
        raise UsageError(
            f"outputs are HDF5 or CSV, not {ending[1:]}: name the file {stem}.h5 or {stem}.csv "
            "(or say --format, to have it under this name)"
        )
    return HDF5
