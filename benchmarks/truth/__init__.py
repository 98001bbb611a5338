"""Motions whose truth is known, with random numbers: ``python -m benchmarks.truth --seed N``."""
