"""Run the checks of pages in a browser: ``python -m tests.browser [pytest's options]``."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.browser.chromium import chromium

if __name__ == "__main__":
    if chromium() is None:
        sys.exit("no chromium found: install one, or name it in LAGRANGE_CHROMIUM")
    sys.exit(pytest.main(["-q", str(Path(__file__).parent / "checks.py"), *sys.argv[1:]]))
