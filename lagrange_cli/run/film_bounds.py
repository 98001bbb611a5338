"""The bounds of films, for the command and for Python."""

from __future__ import annotations

SLOWEST, FASTEST = 0.01, 240
"""Pictures a second: a GIF shows none for longer than 655 s."""
LEAST, MOST = 16, 7680
"""Pixels of a picture's edge."""
