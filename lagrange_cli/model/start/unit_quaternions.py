"""Quaternions whose initial values do not have length 1: the body has the orientation Q/|Q|.

The rates are divided by |Q|, too, and lose their component along Q, which is no rotation. So the angular
velocity in the body stays 2 Im(Q* dQ/dt)/|Q|^2, that of the given values: dQ/dt = Q (0, omega)/2 gives this
omega.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.operations import cross
from lagrange_cli.spec.bodies.norms import is_bound
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.spelling import spelled


def normalized(
    spec: Spec, q: Sequence[Any], v: Sequence[Any], open_q: Collection[int], off: float
) -> tuple[list[Any], list[Any], Mapping[str, float]]:
    """The state with quaternions of length 1, and the length that each had which is off by more than ``off``,
    by body.

    Quaternions with values that are not given (``open_q``) stay: their length is what finds these.

    Raises ``SpecError`` at a quaternion that is 0.
    """
    places, speeds, lengths = [*q], [*v], dict[str, float]()
    for body, numbers in quaternions(spec):
        if any(k in open_q for k in numbers):
            continue
        largest = max(abs(q[k]) for k in numbers)
        if largest == 0:
            raise no_direction(spec, body)
        direction = [q[k] / largest for k in numbers]
        size = sum(x * x for x in direction) ** 0.5
        length = largest * size
        if abs(float(length) - 1) <= off:
            continue
        unit = [x / size for x in direction]
        rates = [v[k] / length for k in numbers]
        for k, x, u in zip(numbers, unit, turning(unit, rates)):
            places[k], speeds[k] = x, u
        lengths[body] = float(length)
    return places, speeds, lengths


def turning(unit: Sequence[Any], rates: Sequence[Any]) -> list[Any]:
    """The rates less their part along the ``unit`` quaternion, up to rounding of what is left."""
    (w, *x), (w_dot, *x_dot) = unit, rates
    half = [w * v - w_dot * u - c for u, v, c in zip(x, x_dot, cross(x, x_dot))]  # Im(Q* dQ/dt) = omega/2
    return [-sum(u * o for u, o in zip(x, half)), *(w * o + c for o, c in zip(half, cross(x, half)))]


def quaternions(spec: Spec) -> Iterator[tuple[str, list[int]]]:
    """The bodies whose quaternion is made of four coordinates, and the numbers of these."""
    number = {one.name: k for k, one in enumerate(spec.coordinates)}
    for name, body in spec.bodies.items():
        if is_bound(body):
            entries = [spelled(one, spec.sizes).strip() for one in body.orientation.entries]
            if len(set(entries)) == len(entries) and all(entry in number for entry in entries):
                yield name, [number[entry] for entry in entries]


def no_direction(spec: Spec, body: str) -> SpecError:
    """A quaternion without direction."""
    place = spec.bodies[body].orientation.place
    message = f"the quaternion of body '{body}' is 0 at the start: it has no direction"
    return Source(spec.filename, spec.text).error(
        place, message, "let it begin at 1, 0, 0, 0, where the body's axes are those of space"
    )
