"""The suites, one a file of this folder: each module has a ``SUITE``, and is run by its name."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.harness.suite import Suite

SUITES = {
    "startup": "whole commands, relative to their imports",
    "shell": "the double pendulum as a whole command",
    "large": "20 to 1000 pendulums as a whole command, with empty caches",
    "derivation": "the equations of 2, 4 and 6 pendulums",
    "integration": "five motions, integration alone",
    "workprecision": "run time against error, for several tolerances: the figures",
    "chain": "5 to 1000 pendulums, integration alone",
    "bodies": "10 to 1000 bodies in space, integration alone",
    "lattices": "chains of up to 100,000 beads, lattices of up to 300 x 300",
    "choice": "whether --method auto chooses the fastest method, for 150 motions",
    "impacts": "an oscillator that hits a wall, integration alone",
    "switches": "an oscillator with dry friction, integration alone",
    "gas": "hard discs in a box as a whole command, with empty caches",
    "proofs": "narrow forces of small differences: the cost of proven steps",
    "stiff": "stiff motions by implicit methods, integration alone",
    "constraints": "constraints: run time against error, and chains",
    "elimination": "constraints: steps without the coordinates that linear ones give",
    "testset": "constraints: errors of problems that are known, and long motions",
    "ensemble": "ten thousand double pendulums",
    "section": "a million crossings of Henon-Heiles",
    "samples": "a hundred million samples to disk (4 GB, in the current directory)",
    "view": "pages of all shipped systems in a browser",
    "brouwer": "a million periods of an ellipse",
    "doubledouble": "double-double precision: three motions, integration alone",
    "portable": "the cost of --portable",
    "certified": "estimated errors beside true ones",
}
"""What each measures, in the order in which they are run."""


def suite(name: str) -> Suite:
    """The suite of that name."""
    found: Suite = import_module(f"{__name__}.{name}").SUITE
    return found
