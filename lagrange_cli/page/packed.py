"""Bytes as text in a page."""

from __future__ import annotations

import base64
import zlib


def packed(content: bytes) -> str:
    """Bytes as text, compressed (RFC 1951)."""
    compressor = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS)
    return base64.b64encode(compressor.compress(content) + compressor.flush()).decode("ascii")
