"""Measurements of ``lagrange`` against its peers: ``python -m benchmarks`` makes all of them, and
``python -m benchmarks.NAME`` one.

What is compared is measured in turns within one run, so that a machine that is busy is busy for all of
them, and every figure is a median over the turns.
"""
