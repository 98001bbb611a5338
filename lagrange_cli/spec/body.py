"""What a system file says of rigid bodies: how inert they are, and how their axes stand."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.source import Expression, Place

SOLIDS = {"sphere": "r", "cylinder": "[r, h]", "box": "[a, b, c]", "disc": "r", "rod": "l"}
"""The homogeneous solids and their sizes; a cylinder, a disc and a rod have the body's third axis."""


@dataclass(frozen=True)
class Inertia:
    """The moments of inertia of a body: three principal moments, or nine entries row by row; or the sizes of
    the ``solid`` that it is. All are expressions in parameters."""

    solid: str
    entries: tuple[Expression, ...]
    place: Place

    @property
    def in_structure(self) -> tuple[object, ...]:
        return self.solid, self.entries

    def member(self, indices: Mapping[str, int]) -> Inertia:
        """That of a member of a family."""
        return replace(self, entries=tuple(replace(one, indices=indices) for one in self.entries))


@dataclass(frozen=True)
class Orientation:
    """How a body's axes stand: three angles in the ``sequence`` of their axes, a quaternion with its scalar
    first, or the nine entries of a matrix, row by row."""

    form: str
    sequence: str
    entries: tuple[Expression, ...]
    place: Place

    @property
    def in_structure(self) -> tuple[object, ...]:
        return self.form, self.sequence, self.entries

    def member(self, indices: Mapping[str, int]) -> Orientation:
        """That of a member of a family."""
        return replace(self, entries=tuple(replace(one, indices=indices) for one in self.entries))


@dataclass(frozen=True)
class Body:
    """What a rigid body has besides the mass and the position of its centre, which are with those of the
    particles."""

    inertia: Inertia
    orientation: Orientation
    place: Place

    @property
    def in_structure(self) -> tuple[object, ...]:
        return self.inertia, self.orientation

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """All of them."""
        return (*self.inertia.entries, *self.orientation.entries)

    def member(self, name: str, indices: Mapping[str, int]) -> Body:
        """A member of a family."""
        inertia, orientation = (one.member(indices) for one in (self.inertia, self.orientation))
        return replace(self, inertia=inertia, orientation=orientation)
