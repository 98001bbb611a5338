"""A right system file, and what becomes of it when a piece is changed."""

from __future__ import annotations

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.spec.read import read_spec

PENDULUM = """\
name: pendulum
parameters:
  m: 1
  l: {value: 0.5, unit: m}
  g: 9.81
coordinates:
  theta: {initial: 0.1}
masses:
  bob: m
embedding:
  bob: [l*sin(theta), -l*cos(theta)]
potential: m*g*bob.y
"""


def changed(old: str, new: str) -> str:
    """The pendulum with one piece replaced; the piece must be there exactly once."""
    assert PENDULUM.count(old) == 1
    return PENDULUM.replace(old, new)


def problems(text: str | bytes) -> list[Problem]:
    """What is wrong with a file."""
    try:
        read_spec(text, "file.yaml")
    except SpecError as error:
        return list(error.problems)
    return []


def underlined(problem: Problem) -> str:
    """The piece of the file that the carets stand under."""
    start = problem.column - 1
    return problem.excerpt[start : start + problem.length]
