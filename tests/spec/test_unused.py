"""Parameters, definitions and sizes that nothing uses."""

from __future__ import annotations

from pathlib import Path

import pytest

from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.unused import unused

SYSTEM = """\
parameters: {P: 1, Q: {value: 2*P, unit: P}}
sizes: {N: 3}
coordinates: {x[i in range(N)]: {initial: 1}, y: {initial: 0, description: P Q}}
masses: {p[i in range(N)]: 1, b: 1}
positions: {p[i in range(N)]: x[i], b: y}
"""
SHIPPED = sorted(Path("systems").glob("*.yaml"))


def found(text):
    return [(place.line, message) for place, message, _ in unused(read_spec(text, "file.yaml"))]


def test_what_is_used_only_by_something_unused_is_told_apart():
    assert found(SYSTEM) == [
        (1, "parameter 'P' is used only in what is not used itself, such as 'Q'"),
        (1, "parameter 'Q' is not used"),
    ]


@pytest.mark.parametrize(
    "use",
    [
        "potential: {Q: Q*y}",
        "potential: sum(Q*x[i] for i in range(N))",
        "generalized_forces: {y: -Q*y_dot}",
        "dissipation: Q*y_dot**2/2",
        "definitions: {d: Q*y}\nobservables: {o: d}",
        "observables: {o[i in range(N)]: x[i]**Q}",
        "observables: {o: where(y > Q, 1, 0)}",
        "nonholonomic: {c: y_dot - Q*x_dot[0]}",
        "constraints: {c: y - Q*x[0]}",
        "events: {e: {when: y - Q}}",
        "events: {e: {when: y - 1, action: {set: {Q: 3}}}}",
        "events: {e: {when: y - 1, action: {set: {y_dot: -Q*y_dot}}}}",
        "draw: {curves: {wire: {at: [u, Q], u: [-1, 1]}}}",
        "draw: {sliders: {Q: [1, 2]}}",
        "transformations: {other: {coordinates: {z: {}}, replace: {y: Q*z}}}",
        "solve: {stop: Q}",
        "bodies: {d: {mass: 1, inertia: [1, 1, Q], position: [y, 0, 0], orientation: {euler: [y, 0, 0]}}}",
    ],
)
def test_each_section_uses_names(use):
    assert found(f"{SYSTEM}{use}\n") == []


def test_definitions_and_sizes_and_families_as_a_whole():
    text = """\
parameters: {k: [1, 2], c: [3, 4]}
sizes: {N: 3, M: N + 1, n: 2}
coordinates: {x[i in range(N)]: {initial: c[1]}}
masses: {p[i in range(N)]: 1}
positions: {p[i in range(N)]: x[i]}
definitions: {s[i in range(N)]: x[i]}
"""
    assert found(text) == [
        (1, "parameter 'k' is not used"),
        (6, "definition 's' is not used"),
        (2, "size 'M' is not used"),
        (2, "size 'n' is not used"),
    ]


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_example_systems_use_all_that_they_declare(path):
    assert found(path.read_text()) == []
