"""Pivots that are only rounding errors."""

from __future__ import annotations

FLOOR = 128.0
"""Units of rounding: a pivot smaller than this part of its diagonal entry is nothing else, and the matrix is
singular."""
