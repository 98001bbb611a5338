"""Warnings, which point at the line of the program that has called the package."""

from __future__ import annotations

import sys
import warnings

from lagrange_cli.api.words import python_words
from lagrange_cli.errors import LagrangeWarning

PACKAGE = __name__.partition(".")[0]


def warn(message: str) -> None:
    """Give a warning, in the words of a Python program."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == PACKAGE:
        level, frame = level + 1, frame.f_back
    warnings.warn(python_words(message), LagrangeWarning, stacklevel=level)
