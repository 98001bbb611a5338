"""Which browser there is."""

from __future__ import annotations

import os
import shutil

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


def chromium() -> str | None:
    """Chromium, or a browser made of it; None where there is none."""
    found = (shutil.which(name) for name in (os.environ.get("LAGRANGE_CHROMIUM", ""), *NAMES) if name)
    return next(filter(None, found), None)
