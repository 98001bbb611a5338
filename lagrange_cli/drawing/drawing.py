"""``Drawing``: what is drawn of a system, in a page, a film or a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.node import Node
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.drawing.located import Located

FREE = ("curve 0", "curve 1")
"""The names of the parameters of curves; no name of a file is like them."""
TRAILS = 6
"""With more particles, only the last one leaves a trail."""


@dataclass(frozen=True)
class Dot:
    """A particle, or a point of the ``draw`` section: a disc at ``point``.

    ``mass`` is the number of its mass in ``Drawing.sizes``, None where it has none. ``group`` is the number
    of its family among all that have a colour of their own: equal groups have equal colours. ``label`` is
    written beside it.
    """

    name: str
    point: int
    mass: int | None
    group: int
    colour: str = ""
    label: str = ""


@dataclass(frozen=True)
class Line:
    """A rod, or a spring, between two points; or a ``thin`` line, such as a string or a wall."""

    ends: tuple[int, int]
    colour: str = ""
    thin: bool = False


@dataclass(frozen=True)
class Pivot:
    """A point that is held: a rod or a spring ends there. Its place may depend on t."""

    point: int


@dataclass(frozen=True)
class Locus:
    """A wire or a wall, or a surface: where ``point`` is as one or two coordinates run through ``ranges``,
    while the other coordinates and t are what they are.

    ``along`` are the numbers of these coordinates; those after the last coordinate are the numbers of what is
    ``Drawing.free``. A range is None where the coordinate has no bounds of its
    own: ``evaluate.fitted`` takes those of the motion. ``depends`` are the numbers of the other coordinates
    that it depends on, ``on_time`` says whether it depends on t: it stands still if it depends on neither.
    """

    point: int
    along: tuple[int, ...]
    ranges: tuple[tuple[float, float] | None, ...]
    depends: tuple[int, ...] = ()
    on_time: bool = False
    name: str = ""
    colour: str = ""


@dataclass(frozen=True)
class Solid:
    """A rigid body: a ``shape`` with its ``sizes``, whose third axis is ``axes[2]``.

    The shapes are those of ``spec.body.SOLIDS``: a sphere (radius), a cylinder (radius, height), a box (three
    edges), a disc (radius) and a rod (length). ``centre`` is a point; ``axes`` are three points of
    ``Drawing.points`` that are no places but the unit vectors e_1, e_2, e_3 of the body in space. ``sizes``
    are numbers of ``Drawing.sizes``.
    """

    name: str
    shape: str
    sizes: tuple[int, ...]
    centre: int
    axes: tuple[int, int, int]
    group: int
    colour: str = ""


@dataclass(frozen=True)
class Camera:
    """From where a drawing in space is seen, in degrees, and what is seen of it.

    ``bounds`` are the least and the greatest coordinates that are shown, None where those of the motion are.
    ``follow`` is the number of the point that stays in the middle; the bounds are from there then. ``window``
    has the bounds that the file gives, axis by axis, and None where it gives none.
    """

    azimuth: float = -60.0
    elevation: float = 20.0
    bounds: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    follow: int | None = None
    window: tuple[tuple[float, float] | None, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """What is drawn of a system.

    ``points`` are places of ``dimension`` components each, 2 (x to the right, y upward, or downward where
    ``up`` is "-y") or 3 (``up`` is "z", or "y"): nodes of one expression graph, in coordinates, t and
    parameters, by the names that the system file has for them (the first ones of a family are ``theta[0]``,
    ``t`` is the time). ``sizes`` are masses and lengths, in parameters alone. All else refers to these by
    number. Some points are directions: the axes of solids. ``places`` are the numbers of those that must be
    seen. Points of families are ``located`` by arrays; then there are no others.

    ``coordinates`` are the names of the coordinates in the order of q, ``free`` those of what runs along
    curves besides: points that curves are made of may depend on them. ``trails`` are the points that leave a
    trail. ``sliders`` are the ranges of parameters and initial values (``theta``, ``theta_dot``) that the
    file gives. ``abstract`` says that the file does not tell where anything is: coordinates are drawn on
    dials and axes. If ``scaled``, places are in the units of the file.
    """

    dimension: int
    up: str
    coordinates: tuple[str, ...]
    points: tuple[tuple[Node, ...], ...]
    sizes: tuple[Node, ...]
    places: tuple[int, ...]
    dots: tuple[Dot, ...] = ()
    rods: tuple[Line, ...] = ()
    springs: tuple[Line, ...] = ()
    pivots: tuple[Pivot, ...] = ()
    curves: tuple[Locus, ...] = ()
    solids: tuple[Solid, ...] = ()
    trails: tuple[int, ...] = ()
    camera: Camera = Camera()
    sliders: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    free: tuple[str, ...] = ()
    abstract: bool = False
    scaled: bool = True
    located: Located | None = None

    @property
    def count(self) -> int:
        """How many points there are."""
        return len(self.points) if self.located is None else self.located.count

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All components of all points, one after the other: what has to be evaluated along a motion."""
        return tuple(component for point in self.points for component in point)

    def data(self) -> dict[str, Any]:
        """The same as JSON: all but the expressions, of which there are ``points`` and ``sizes``."""
        return {
            "dimension": self.dimension,
            "up": self.up,
            "coordinates": list(self.coordinates),
            "free": len(self.free),
            "points": self.count,
            "sizes": len(self.sizes),
            "places": list(self.places),
            "dots": [_plain(one) for one in self.dots],
            "rods": [_plain(one) for one in self.rods],
            "springs": [_plain(one) for one in self.springs],
            "pivots": [_plain(one) for one in self.pivots],
            "curves": [_plain(one) for one in self.curves],
            "solids": [_plain(one) for one in self.solids],
            "trails": list(self.trails),
            "camera": _plain(self.camera),
            "sliders": {name: list(ends) for name, ends in self.sliders.items()},
            "scaled": self.scaled,
        }


def _plain(value: Any) -> Any:
    """Records as mappings, tuples as lists."""
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Dot | Line | Pivot | Locus | Solid | Camera):
        return {name: _plain(getattr(value, name)) for name in value.__record_fields__}  # type: ignore[union-attr]
    return value
