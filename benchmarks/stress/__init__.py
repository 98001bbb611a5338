"""Difficult motions for integrators: ``python -m benchmarks.stress --write`` writes docs/stability.md."""
