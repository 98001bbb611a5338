"""Kinds of motions, family by family: each is a function that draws a ``Case``."""
