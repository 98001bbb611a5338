"""``Request``: the options of a run, for any system."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.settings.settings import resolve_settings
from lagrange_cli.spec.spec import SolveDefaults

if TYPE_CHECKING:
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec

HDF5, CSV = "hdf5", "csv"
FORMATS = HDF5, CSV
"""The formats of an output."""
ENDINGS = {HDF5: ".h5", CSV: ".csv"}
PAGES = (".html", ".htm")
"""How the name of a page ends."""
OTHERS = frozenset(
    (
        ".txt", ".tsv", ".json", ".jsonl", ".yaml", ".yml", ".npy", ".npz", ".mat", ".xls", ".xlsx", ".ods",
        ".parquet", ".feather", ".pkl", ".pickle", ".zarr", ".fits", ".sqlite", ".db", ".png", ".svg", ".pdf",
        ".gif", ".mp4", ".gz", ".bz2", ".xz", ".zst", ".zip", ".tar",
    )
)  # fmt: skip
"""Endings of formats that are not written. Any other ending is taken to be that of an HDF5 file."""
TIMES = ("start", "stop", "step")
"""The times that may be given as expressions."""
SECONDS, COUNT = 10.0, 10**8
"""Seconds, and steps or members, between two checkpoints."""


@dataclass(frozen=True)
class Request:
    """The options of a run: those left open follow from the system file, or have a default.

    ``times`` (``start``, ``stop``, ``step``), ``overrides`` (parameters and initial values) and ``sizes`` are
    texts by name: numbers, or expressions in parameters. With ``cache``, the code compiled by an earlier run
    is used. ``resume`` continues an earlier run. A checkpoint is written every ``checkpoint`` seconds, and
    after ``checkpoint_count`` steps, or members of a sweep. Steps are ``proven`` whatever the
    system. Initial values are ``projected`` to the constraints however far off they are. ``format`` is
    that of the output. So many ``threads`` share the work of one motion, by default one for each processor.
    What is ``drawn`` has the observables that are defined, as by default.
    """

    options: SolveDefaults = SolveDefaults()
    times: Mapping[str, str] = {}
    overrides: Mapping[str, str] = {}
    sizes: Mapping[str, str] = {}
    cache: bool = True
    resume: bool = False
    checkpoint: float = SECONDS
    checkpoint_count: int = COUNT
    precision: str = DOUBLE
    portable: bool = False
    proven: bool = False
    projected: bool = False
    format: str = HDF5
    threads: int | None = None
    drawn: bool = False

    def settings(self, spec: Spec, parameters: Mapping[str, float]) -> Settings:
        """The settings of the run of ``spec`` with the values ``parameters``.

        Raises ``UsageError`` for settings that make no sense.
        """
        exact = self.portable or self.precision != DOUBLE
        asked = self.options
        if self.times:
            from lagrange_cli.run.times import with_times

            asked = with_times(asked, self.times, spec, parameters, exact=exact)
        found = resolve_settings(spec, asked, self.precision, self.portable, self.proven, self.cache)
        return replace(found, by_default=True) if self.drawn and spec.observables else found


def check_page(name: str) -> None:
    """Raise ``UsageError`` for the name of a page that ends like that of another kind of file."""
    if os.path.splitext(name)[1].lower() not in ("", *PAGES):
        raise UsageError(f"--output {name}: a page is written as HTML: give a name that ends in {PAGES[0]}")


def format_of(output: str | None, asked: str | None = None) -> str:
    """The format of an output: the one ``asked`` for with ``--format``, or the one of its name.

    Raises ``UsageError`` if the name ends like that of another format.
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
            "(or give --format to keep this name)"
        )
    return HDF5
