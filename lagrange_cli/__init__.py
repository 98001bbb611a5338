"""Lagrangian mechanics from a YAML file: the equations of motion, and the motion itself.

    import lagrange_cli as lagrange

    motion = lagrange.solve("pendulum.yaml", set={"l": 2}, stop=20)
    motion.t, motion.q["theta"], motion.h

and likewise for the other commands; docs/python.md has recipes. Below are the stages of the pipeline,
each a function from one frozen object to the next:

    spec = read_spec(text, "pendulum.yaml")                       # checked, nothing derived yet
    values = resolve_values(spec, {"l": "2"})                     # parameters and initial state, as run
    residual = derive(build_model(spec, GraphAlgebra()))          # the equations of motion
    prepared = prepare(residual, Compilation("taylor", tolerance=2.2e-16, outputs=frozenset({"q", "h"})))
    outcome = integrate(prepared, values, Times(0.0, 10.0, 1001, 0.01), emit, lambda: False)

(``integrate`` is ``lagrange_cli.integrate.run.integrate``), or

    equations = derive_equations(build_model(spec, SympyAlgebra()))  # for people to read

Each name is imported when it is first used, so that unused modules cost no time.
"""

TYPE_CHECKING = False  # as in typing, which takes longer to import than this package may (see __main__)
if TYPE_CHECKING:
    from typing import Any

    from lagrange_cli.api.animate import animate
    from lagrange_cli.api.bench import bench
    from lagrange_cli.api.check import check
    from lagrange_cli.api.equations import equations
    from lagrange_cli.api.example import example
    from lagrange_cli.api.load import load
    from lagrange_cli.api.motion import Motion
    from lagrange_cli.api.plot import plot
    from lagrange_cli.api.section import section
    from lagrange_cli.api.solve import solve
    from lagrange_cli.api.sweep import sweep
    from lagrange_cli.api.view import view
    from lagrange_cli.errors import (
        FileError,
        Interrupted,
        LagrangeError,
        LagrangeWarning,
        MissingPackage,
        MotionError,
        SpecError,
        UsageError,
    )
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.expression.symbolic import SympyAlgebra
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.prepare import prepare
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.symbolic.derive import derive_equations
    from lagrange_cli.version import __version__ as __version__

__all__ = [
    "Compilation",
    "FileError",
    "GraphAlgebra",
    "Interrupted",
    "LagrangeError",
    "LagrangeWarning",
    "MissingPackage",
    "Motion",
    "MotionError",
    "SpecError",
    "SympyAlgebra",
    "Times",
    "UsageError",
    "animate",
    "bench",
    "build_model",
    "check",
    "derive",
    "derive_equations",
    "equations",
    "example",
    "load",
    "plot",
    "prepare",
    "read_spec",
    "resolve_values",
    "section",
    "solve",
    "sweep",
    "view",
]

_HOMES = {
    "__version__": "version",
    "Compilation": "integrate.compilation",
    "Motion": "api.motion",
    "GraphAlgebra": "expression.graph_algebra",
    "SympyAlgebra": "expression.symbolic",
    "Times": "integrate.times",
    "build_model": "model.build",
    "derive": "mechanics.derive",
    "derive_equations": "symbolic.derive",
    "prepare": "integrate.prepare",
    "read_spec": "spec.read",
    "resolve_values": "spec.values",
    **{name: f"api.{name}" for name in ("bench", "check", "equations", "example", "load", "plot")},
    **{name: f"api.{name}" for name in ("animate", "section", "solve", "sweep", "view")},
    **dict.fromkeys(
        (
            "FileError",
            "Interrupted",
            "LagrangeError",
            "LagrangeWarning",
            "MissingPackage",
            "MotionError",
            "SpecError",
            "UsageError",
        ),
        "errors",
    ),
}


def __getattr__(name: str) -> "Any":
    """Import a name of ``__all__``, or the version, from where it lives."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
