"""Figures of the documents: the same bytes for the same numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from benchmarks import ROOT

FIGURES = ROOT / "docs" / "figures"


@contextmanager
def figure(name: str, width: float, height: float) -> Iterator[Any]:
    """The axes of a figure of so many inches, which is written to docs/figures at the end."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = name.partition("_")[0]
    from matplotlib import pyplot

    drawn, axes = pyplot.subplots(figsize=(width, height), layout="constrained")
    try:
        yield axes
        FIGURES.mkdir(exist_ok=True)
        drawn.savefig(FIGURES / f"{name}.svg", metadata={"Date": None})
    finally:
        pyplot.close(drawn)
