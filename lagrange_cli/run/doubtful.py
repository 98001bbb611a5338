"""Places of a file that are allowed and perhaps not meant: units that contradict each other, equality that
rounding decides, names that nothing uses, and angles that are singular at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrange_cli.errors import Problem
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values


def contradicting_units(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each place of the file where units contradict each other."""
    from lagrange_cli.outputs.units import find_units
    from lagrange_cli.spec.source import Source

    conflicts = find_units(spec).conflicts
    if not conflicts:
        return ()
    source = Source(spec.filename, spec.text)
    return tuple(source.problem(one.place, one.message, one.hint) for one in conflicts)


def rounded_equalities(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each comparison of numbers by == or != that are not whole."""
    if "==" not in spec.text and "!=" not in spec.text:
        return ()
    from lagrange_cli.spec.equality import doubtful_equalities
    from lagrange_cli.spec.source import Source

    source, hint = Source(spec.filename, spec.text), "compare whole numbers, or write abs(a - b) < 1e-9"
    return tuple(
        source.problem(place, f"rounding may decide whether {comparison} holds", hint)
        for place, comparison in doubtful_equalities(spec)
    )


def unused_names(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each parameter, definition and size that nothing uses."""
    from lagrange_cli.spec.source import Source
    from lagrange_cli.spec.unused import unused

    source = Source(spec.filename, spec.text)
    return tuple(source.problem(*found) for found in unused(spec))


def singular_poses(spec: Spec, values: Values) -> tuple[Problem, ...]:
    """A warning for each body whose angles are singular at the start."""
    from lagrange_cli.run.singular import angles_at
    from lagrange_cli.spec.source import Source

    source = Source(spec.filename, spec.text)
    hint = "begin elsewhere, or use a quaternion: it has no such pose"
    found = angles_at(spec, values.parameters, spec.solve.start or 0.0, (*values.q, *values.v))
    return tuple(
        source.problem(
            spec.bodies[name].orientation.place,
            f"the angles of body '{name}' are singular at the start: the {function} of the second one is 0",
            hint,
        )
        for name, function in found.items()
    )
