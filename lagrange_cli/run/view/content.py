"""What is on a page: the description of a system, its drawing, its equations, and samples of its motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import LagrangeError, SpecError, TooLarge
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.view.motion import ViewedMotion
from lagrange_cli.version import __version__

if TYPE_CHECKING:
    from lagrange_cli.drawing.drawing import Drawing
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.spec.spec import Spec

FEWEST, MOST = 1001, 20001
"""Samples of a motion in the page."""
SAMPLES_A_STEP = 4
"""Samples of the motion of the file itself: enough to draw its path."""
NUMBERS = 2_000_000
"""Numbers in all samples of a page's motion."""
READING = 8_000_000
"""Steps of work for the printed equations: some 8 s."""
UNREADABLE = "The equations are too large for a page: lagrange equations prints their short parts."
DRAWN = 4_000
"""Nodes of all that is drawn one by one: a thousand rods, whose code takes some 10 s."""
MANY_DRAWN = 20_000
"""Coordinates of families that are drawn at once: a browser would not move more of them."""
RECORDED = 20_000
"""Numbers in a page that replays a motion."""
PLAYED = 200
"""Samples that should be among them."""


def drawn(motion: Motion, followed: ViewedMotion) -> Drawing | None:
    """What is drawn, with bounds that hold the motion; None where that would be too much.

    Raises ``SpecError`` for numbers of the section ``draw`` that make no sense.
    """
    from lagrange_cli.drawing.draw import at_once, draw
    from lagrange_cli.drawing.evaluate import extent, fitted
    from lagrange_cli.expression.node import reachable

    parameters = followed.along or motion.values.parameters
    given = motion.spec, motion.values, motion.settings.start
    count = 0 if motion.spec.draw is not None else len(motion.spec.coordinates)
    if count > MANY_DRAWN:
        return None
    try:
        drawing = at_once(*given) if count > DRAWN else draw(*given)  # each of them would have a node
        if drawing is None or (drawing.located is None and len(reachable(drawing.nodes)) > DRAWN):
            return None
        return fitted(drawing, extent(drawing, followed.t, followed.q, parameters), parameters)
    except TooLarge:
        return None
    except SpecError:
        if motion.spec.draw is not None:
            raise
        return None


def described(motion: Motion, drawing: Drawing | None, followed: ViewedMotion) -> dict[str, Any]:
    """The contents of a page on a system and its motion, as JSON."""
    spec, values, settings = motion.spec, motion.values, motion.settings
    units = units_of(spec)
    numbers = 4 * len(spec.coordinates) + 4 + (0 if drawing is None else drawing.count * drawing.dimension)
    most = max(FEWEST // 4, min(MOST, NUMBERS // numbers))
    count = max(settings.count, FEWEST, SAMPLES_A_STEP * followed.steps)
    return {
        "name": spec.name,
        "description": spec.description,
        "file": spec.filename.replace("\\", "/").rpartition("/")[2],
        "text": spec.text,
        "generator": f"lagrange {__version__}",
        "time": {
            "start": settings.start,
            "stop": settings.stop,
            "count": min(count, most),
            "steps": max(1, followed.steps),
            "unit": units.get("t", ""),
        },
        "parameters": [
            {
                "name": one.name,
                "value": values.parameters[one.name],
                "unit": units.get(f"parameters/{one.name}", one.unit),
                "description": one.description,
                "expression": expression_of(one.value),
                "fixed": family(one.name) in spec.tables,
            }
            for one in spec.parameters
        ],
        "coordinates": [
            {
                "name": one.name,
                "q": values.q[k],
                "v": values.v[k],
                "unit": units.get(f"q/{family(one.name)}", one.unit),
                "unitOfVelocity": units.get(f"v/{family(one.name)}", ""),
                "unitOfMomentum": units.get(f"diagnostics/p/{family(one.name)}", ""),
                "description": one.description,
                "expressions": [expression_of(one.initial), expression_of(one.velocity)],
                "reach": [largest(followed.q[:, k]), largest(followed.v[:, k])],
            }
            for k, one in enumerate(spec.coordinates)
        ],
        "velocities": [velocity_name(one.name) for one in spec.coordinates],
        "unitOfEnergy": units.get("diagnostics/h", ""),
        "constraints": list(spec.all_constraints),
        "message": followed.message,
        "drawing": None if drawing is None else drawing.data(),
    }


def expression_of(expression: Any) -> str:
    """The text of an expression in parameters; empty for a number, or where there is none."""
    if expression is None:
        return ""
    with suppress(ValueError):
        float(expression.text)
        return ""
    return str(expression.text)


def family(name: str) -> str:
    """``theta`` for ``theta[3]``."""
    return name.partition("[")[0]


def largest(column: Array) -> float:
    """The largest magnitude of finite numbers."""
    import numpy as np

    known = np.abs(column[np.isfinite(column)])
    return float(known.max()) if len(known) else 0.0


def units_of(spec: Spec) -> Mapping[str, str]:
    """Units by path."""
    from lagrange_cli.outputs.units import find_units

    return find_units(spec).texts


def recorded(followed: ViewedMotion) -> dict[str, Any]:
    """The samples of a motion for a page that replays it: every so many of them, and of many coordinates
    without the momenta."""
    import numpy as np

    from lagrange_cli.page.packed import packed

    observed = dict(followed.observed)
    rows = [followed.t, *followed.q.T, *followed.v.T]
    if (len(rows) + len(observed)) * PLAYED > RECORDED:
        observed = {name: row for name, row in observed.items() if name == "h"}
    rows += observed.values()
    each = max(1, math.ceil(len(followed.t) * len(rows) / RECORDED))
    places = np.unique(np.r_[0 : len(followed.t) : each, max(0, len(followed.t) - 1)])
    table = np.array([row[places] for row in rows], dtype="<f8")
    return {
        "label": "", "count": table.shape[1], "observed": list(observed), "rows": packed(table.tobytes()),
        "settings": settings_of(followed, table[0]),
    }  # fmt: skip


def settings_of(followed: ViewedMotion, t: Array) -> dict[str, Any]:
    """The parameters that actions have set, and from when on: at most one change from each of the times ``t``
    to the next, the last one."""
    import numpy as np

    along = followed.along
    if along is None or not len(along.times):
        return {"times": [], "changed": {}}
    kept = np.arange(len(along.times))
    if len(kept) > len(t):
        kept = np.unique(along.places(t)) - 1
        kept = kept[kept >= 0]
    changed = {name: values[kept].tolist() for name, values in along.changed.items()}
    return {"times": along.times[kept].tolist(), "changed": changed}


def written(spec: Spec) -> str:
    """The equations as HTML; a sentence where they are too large."""
    from html import escape

    from lagrange_cli.run.family_equations import as_page

    try:
        return as_page(spec, READING)
    except LagrangeError as error:
        large = isinstance(error, TooLarge) or isinstance(error.__cause__, TooLarge)
        return f"<p>{UNREADABLE if large else escape(str(error).splitlines()[0])}</p>"
