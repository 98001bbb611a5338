"""``Wanted``: the ``draw`` section, read and checked."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.source import Expression, Place

Range = tuple[Expression, Expression]
"""The least and the greatest value, in parameters."""
Path = tuple[Expression, ...]
"""Points one after the other, joined by lines."""


@dataclass(frozen=True)
class Course:
    """A curve or a surface: ``at`` is a point as the names of ``ranges`` run, as far as the motion goes where
    a range is None. Those that are ``free`` mean something here alone, the others are coordinates. Without
    ``ranges`` all coordinates run that the point depends on. Or lines join the points ``through``.
    """

    name: str
    place: Place
    at: Expression | None = None
    ranges: Mapping[str, Range | None] = field(default_factory=dict)
    free: frozenset[str] = frozenset()
    through: Path = ()


@dataclass(frozen=True)
class View:
    """From where the drawing is seen, in degrees, the bounds along some axes, what stays in the middle, and
    which axis is upright; what is not given is None or empty."""

    azimuth: Expression | None = None
    elevation: Expression | None = None
    bounds: Mapping[str, Range] = field(default_factory=dict)
    follow: Expression | None = None
    up: str = ""


@dataclass(frozen=True)
class Wanted:
    """What is None stays as it is found; ``points`` and ``colours`` are added. Points are expressions in q, t
    and parameters: a vector, or 0 for the origin. All names are those of members of families, which are
    written out.
    """

    rods: tuple[Path, ...] | None = None
    springs: tuple[Path, ...] | None = None
    points: tuple[Expression, ...] = ()
    trails: tuple[Expression, ...] | None = None
    hidden: frozenset[str] = frozenset()
    curves: tuple[Course, ...] | None = None
    colours: Mapping[str, str] = field(default_factory=dict)
    view: View = View()
    sliders: Mapping[str, Range] = field(default_factory=dict)
