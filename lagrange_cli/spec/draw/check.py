"""The section ``draw`` as written to a ``Wanted``: what it names exists, and points are points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.draw.curves import Curves
from lagrange_cli.spec.draw.named import Named
from lagrange_cli.spec.draw.numbers import NUMBERS, RULE, ends, number
from lagrange_cli.spec.draw.points import SECTION, Points
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.wanted import View, Wanted


def check_draw(draft: Draft, names: Names, problems: Problems) -> Wanted:
    """What the section of a file asks for; what is wrong is added to ``problems``."""
    names.rules = {**names.rules, NUMBERS: RULE}
    given: Mapping[str, Any] = draft.sections[SECTION]
    points, named = Points(draft, names, problems), Named(draft, names, problems)
    drawn = Curves(draft, names, problems, points, named)
    camera = given.get("camera", {})
    curves = given.get("curves")
    return Wanted(
        rods=points.lines(given.get("rods"), "rods"),
        springs=points.lines(given.get("springs"), "springs"),
        points=points.points(given.get("points"), "points") or (),
        trails=points.points(given.get("trails"), "trails"),
        hidden=points.hidden(given.get("hide")),
        curves=None if curves is None else tuple(map(drawn.curve, curves)),
        colours=named.colours(given.get("colours", ()), points.particles),
        view=View(
            azimuth=number(names, camera.get("azimuth"), "azimuth of the camera"),
            elevation=number(names, camera.get("elevation"), "elevation of the camera"),
            bounds={
                axis: ends(names, one, f"bounds of {axis}")
                for axis, one in camera.get("bounds", {}).items()
                if one is not None
            },
            follow=points.point(camera.get("follow"), "follow of the camera"),
            up=camera.get("up", ""),
        ),
        sliders=named.sliders(given.get("sliders", ())),
    )
