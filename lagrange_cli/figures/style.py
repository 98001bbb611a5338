"""How pictures look, and the files that they become: the same picture is the same file."""

from __future__ import annotations

import importlib.util
import io
import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import MissingPackage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".svg", ".pdf", ".png")
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""The colours of Okabe and Ito, which colour-blind readers can distinguish (Wong, Nature Methods 8, 2011)."""
MARKERS = "osD^vPX"
STYLE: Any = {
    "font.size": 10,
    "font.family": "sans-serif",
    "svg.fonttype": "none",
    "svg.hashsalt": "lagrange",  # the same picture is the same file
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "agg.path.chunksize": 10_000,  # a curve of very many points does not fit as a whole
}
DPI = 150
COMMANDS = re.compile(r"\\([A-Za-z]+)")
"""Commands in formulas."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw in this style; letters that fonts lack become boxes, without a warning for each."""
    import matplotlib

    log = logging.getLogger("matplotlib.mathtext")
    with matplotlib.rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        level = log.level
        log.setLevel(logging.ERROR)
        try:
            yield
        finally:
            log.setLevel(level)


def check_matplotlib(asked: str) -> None:
    """Raise ``MissingPackage`` where there is no matplotlib, which ``asked`` needs."""
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingPackage(asked, "matplotlib", "plot")


def rendered(figure: Figure, suffix: str, creator: str = "") -> bytes:
    """The file that a figure becomes, without the time at which it is made; ``creator`` is noted in it."""
    notes: dict[str, Any] = {}
    if suffix == ".svg":
        notes = {"Date": None, **({"Creator": creator} if creator else {})}
    elif suffix == ".pdf":
        notes = {"CreationDate": None, **({"Creator": creator} if creator else {})}
    elif creator:
        notes = {"Software": creator}
    drawn = io.BytesIO()
    figure.savefig(drawn, format=suffix[1:], dpi=DPI, metadata=notes or None)
    return drawn.getvalue()


def formula(text: str) -> str:
    """A text with formulas in it, as matplotlib can set it: as plain text where it cannot."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("path").parse(text)
    except ValueError:
        return text.replace("$", r"\$")
    return text


def plain(text: str) -> str:
    """A label without what only formulas have, and without control characters."""
    text = COMMANDS.sub(lambda found: "" if found[1] in ("mathrm", "dot", "ddot") else found[1], text)
    text = re.sub(r"[${}\\]", "", text)
    return "".join(one if one.isprintable() else "?" for one in text)
