"""Faces of rigid bodies in films: they close, and those that face the viewer are seen."""

import math
from itertools import pairwise

import numpy as np
import pytest

from lagrange_cli.figures.solids import ROUND, faces, seen


def volume(corners):
    """What a face and the origin span, positive if it is counterclockwise from outside."""
    return sum(np.dot(corners[0], np.cross(one, other)) for one, other in pairwise(corners)) / 6


@pytest.mark.parametrize(
    ("shape", "sizes", "expected", "off"),
    [
        ("box", [1.0, 2.0, 3.0], 6.0, 1e-12),
        ("cylinder", [0.5, 3.0], 3.0 * ROUND / 2 * 0.25 * math.sin(2 * math.pi / ROUND), 1e-12),
        ("disc", [2.0], 0.1 * ROUND / 2 * 4.0 * math.sin(2 * math.pi / ROUND), 1e-12),
        ("rod", [6.0], 6.0 * 8 / 2 * 0.01 * math.sin(2 * math.pi / 8), 1e-12),
        ("sphere", [1.5], 4.5 * math.pi, 0.07),
    ],
)
def test_faces_close_and_look_outward(shape, sizes, expected, off):
    """Their volume, by Gauss's theorem, is that of the prism, or nearly that of the sphere."""
    found = faces(shape, np.array(sizes))
    assert sum(map(volume, found)) == pytest.approx(expected, rel=off)
    assert all(volume(one) >= -1e-15 for one in found)


@pytest.mark.parametrize(("toward", "count"), [((0, 0, 1), 1), ((1, 1, 0), 2), ((-1, 2, 3), 3)])
def test_the_faces_that_are_seen(toward, count):
    toward = np.array(toward) / np.linalg.norm(toward)
    centre, turned = np.array([5.0, 0.0, 0.0]), np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    found = seen("box", np.array([1.0, 2.0, 3.0]), centre, turned, toward)
    assert len(found) == count
    for corners, depth, brightness in found:
        assert depth == pytest.approx(np.mean(corners @ toward))
        assert (corners.mean(axis=0) - centre) @ toward > 0
        assert np.ptp(corners, axis=0).max() <= 3.0 and 0.0 < brightness <= 1.0
