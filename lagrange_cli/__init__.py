"""Lagrangian mechanics from a YAML file: the equations of motion, and the motion itself.

The stages of the pipeline, each a function from one frozen object to the next:

    spec = read_spec(text, "pendulum.yaml")                       # checked, nothing derived yet
    values = resolve_values(spec, {"l": "2"})                     # parameters and initial state, as run
    residual = derive(build_model(spec, GraphAlgebra()))          # the equations of motion
    prepared = prepare(residual, Compilation("taylor", tolerance=2.2e-16, outputs=frozenset({"q", "h"})))
    outcome = integrate(prepared, values, Times(0.0, 10.0, 1001, 0.01), emit, lambda: False)

(``integrate`` is ``lagrange_cli.integrate.run.integrate``), or

    equations = derive_equations(build_model(spec, SympyAlgebra()))  # what a person reads

Each name is imported when it is first asked for, so that nothing is paid for what is not used.
"""

TYPE_CHECKING = False  # as in typing, which takes longer to import than this package may (see __main__)
if TYPE_CHECKING:
    from typing import Any

    from lagrange_cli.errors import FileError, LagrangeError, MotionError, SpecError, UsageError
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

__version__ = "0.1.0"

__all__ = [
    "Compilation",
    "FileError",
    "GraphAlgebra",
    "LagrangeError",
    "MotionError",
    "SpecError",
    "SympyAlgebra",
    "Times",
    "UsageError",
    "build_model",
    "derive",
    "derive_equations",
    "prepare",
    "read_spec",
    "resolve_values",
]

_HOMES = {
    "Compilation": "integrate.compilation",
    "GraphAlgebra": "expression.graph_algebra",
    "SympyAlgebra": "expression.symbolic",
    "Times": "integrate.times",
    "build_model": "model.build",
    "derive": "mechanics.derive",
    "derive_equations": "symbolic.derive",
    "prepare": "integrate.prepare",
    "read_spec": "spec.read",
    "resolve_values": "spec.values",
    **dict.fromkeys(("FileError", "LagrangeError", "MotionError", "SpecError", "UsageError"), "errors"),
}


def __getattr__(name: str) -> "Any":
    """Import a name of ``__all__`` from where it lives."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
