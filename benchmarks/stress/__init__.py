"""Motions chosen to break an integrator: ``python -m benchmarks.stress`` writes docs/stability.md."""
