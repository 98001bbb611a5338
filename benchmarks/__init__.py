"""Benchmarks of ``lagrange`` and other programs: ``python -m benchmarks`` runs all of them, and
``python -m benchmarks.NAME`` one.

Programs are measured in turns, so that a busy machine affects all of them alike. Every number is a median
over the turns.
"""
