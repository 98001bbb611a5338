"""Lagrangian mechanics from a YAML file: the equations of motion, and the motion itself."""

__version__ = "0.1.0"
