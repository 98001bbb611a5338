"""Formulas of LaTeX as MathML."""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert

FUNCTION = re.compile(
    r"(<mi>(?:arc)?(?:sin|cos|tan|ln|exp)h?</mi>|<msup><mi>(?:sin|cos|tan)h?</mi><mn>\d+</mn></msup>)"
    r"(?=<m(?:i|n|sub|sup|over|frac))"
)
"""A function whose argument has no parentheses."""
FACTOR = re.compile(
    r"(</m(?:i|n|sub|sup|subsup|over|frac)>)(?=(?:<msup>)?<mi>(?:arc)?(?:sin|cos|tan|ln|exp)h?</mi>)"
)
"""What stands before a function."""
SPACE = r'\1<mspace width="0.17em"/>'


def mathml(tex: str, block: bool = False) -> str:
    """A formula for browsers; ``block`` says whether it stands on a line of its own.

    Raises ``ValueError`` where a part of it is not understood.
    """
    made: str = convert(tex, display="block" if block else "inline").replace(r"\_", "_")
    if "\\" in html.unescape(re.sub(r"<[^>]*>", "", made)):
        raise ValueError(f"not understood as a formula: {tex}")
    return FACTOR.sub(SPACE, FUNCTION.sub(SPACE, made))
