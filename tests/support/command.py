"""Running the command as a user does: as a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SYSTEMS = ROOT / "systems"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error", "COLUMNS": "100"}


def lagrange(*arguments: str | Path, cwd: Path, **options) -> subprocess.CompletedProcess[str]:
    """Run ``lagrange`` and return its status and what it wrote."""
    command = [sys.executable, "-m", "lagrange_cli", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, **options)
