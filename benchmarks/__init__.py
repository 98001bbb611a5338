"""Benchmarks of ``lagrange`` and other programs: ``python -m benchmarks`` runs all of them, and
``python -m benchmarks.NAME`` or ``python -m benchmarks NAME`` one.

``harness/`` measures and reports, ``peers/`` adapts other programs, each once, ``motions/`` says what is
integrated, and ``suites/`` what is measured. ``stress/`` makes docs/stability.md. ``tools/`` makes constants,
and compares the code of two versions.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
"""The checkout, which is what is measured."""
__path__.append(str(ROOT / "benchmarks" / "suites"))  # benchmarks.NAME is a suite
