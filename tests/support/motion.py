"""From the text of a system file to its motion, as ``solve`` goes, and numbers of many digits beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from textwrap import dedent

import mpmath
import numpy as np
from numpy.typing import NDArray

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.parse import parse
from lagrange_cli.integrate import prepare as compiled
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.mechanics.contacts import derive_with_contacts
from lagrange_cli.mechanics.formulations import formulations
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.native.compilation.machine import QUICK
from lagrange_cli.native.program import Program
from lagrange_cli.records import replace
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values, resolve_values

SYSTEMS = Path(__file__).resolve().parents[2] / "systems"
BINDING = "\nconstraints:", "\nnonholonomic:", "quaternion:"
CONSTRAINED = [
    path.stem for path in sorted(SYSTEMS.glob("*.yaml")) if any(word in path.read_text() for word in BINDING)
]
"""The shipped systems with multipliers."""
NAMES = sorted({path.stem for path in SYSTEMS.glob("*.yaml")} - {*CONSTRAINED})
"""The shipped systems in independent coordinates."""
FULL = 2.0**-52
"""The tolerance of a run that asks for none."""
DEFAULT = ("q", "v", "p", "h")
DIGITS = 40


@dataclass(frozen=True)
class Motion:
    """Every sample of a run by path, the values it started from, and how it ended."""

    data: Mapping[str, NDArray[np.float64]]
    values: Values
    outcome: Outcome

    def __getitem__(self, path: str) -> NDArray[np.float64]:
        """A series; ``q/u[1,2]`` is one member of the dataset of a family."""
        base, _, indices = path.partition("[")
        return (
            self.data[base][(slice(None), *map(int, indices.rstrip("]").split(",")))]
            if indices
            else self.data[base]
        )

    @property
    def t(self) -> NDArray[np.float64]:
        return self.data["t"]


@cache
def spec_of(system: str) -> Spec:
    """A shipped system by name, or the text of a system file."""
    if "\n" not in system:
        return read_spec((SYSTEMS / f"{system}.yaml").read_bytes(), f"{system}.yaml")
    return read_spec(dedent(system), "system.yaml")


def model_of(system: str) -> Model[Node]:
    """Its model over the graph."""
    return build_model(spec_of(system), GraphAlgebra())


@cache
def residual_of(system: str) -> Residual:
    """Its equations."""
    return derive_with_contacts(model_of(system))


def prepare(residual: Residual, compilation: Compilation) -> Prepared:
    """Its equations, compiled at the level that takes a third of the time and gives the same bits."""
    return compiled.prepare(residual, compilation, QUICK)


@cache
def prepared(
    system: str,
    method: str = "taylor",
    tolerance: float = FULL,
    outputs: tuple[str, ...] = DEFAULT,
    ensemble: bool = False,
    backward: bool = False,
    precision: str = DOUBLE,
) -> Prepared:
    """Its compiled equations."""
    return prepare(
        residual_of(system),
        Compilation(
            method=method,
            tolerance=tolerance,
            outputs=frozenset(outputs),
            ensemble=ensemble,
            backward=backward,
            precision=precision,
        ),
    )


def each_formulation(system: str) -> dict[str, Residual]:
    """Its equations in every formulation that there is, the dearer ones too."""
    residual = residual_of(system)
    forms = formulations(residual.model, residual.graph, residual.conserved)
    return {name: replace(residual, **vars(form), formulation=name) for name, form in forms.items()}


def program_of(system: str, outputs: tuple[str, ...] = DEFAULT) -> Program:
    """Its compiled program."""
    return prepared(system, outputs=outputs).machine.program


def values_of(system: str, sets: Mapping[str, float] | None = None) -> Values:
    """Its parameters and initial state, with ``sets`` in place of the file's."""
    return resolve_values(spec_of(system), {name: repr(float(x)) for name, x in (sets or {}).items()})


def consistent(system: str, **sets: float) -> Values:
    """Its values, where its start follows from its constraints."""
    spec, given = spec_of(system), {name: repr(float(value)) for name, value in sets.items()}
    return consistent_values(spec, resolve_values(spec, given), 0.0, given)[1]


def follow(
    system: str,
    stop: float,
    samples: int = 101,
    *,
    start: float = 0.0,
    sets: Mapping[str, float] | None = None,
    outputs: tuple[str, ...] = DEFAULT,
    method: str = "taylor",
    tolerance: float = FULL,
    interrupted: Callable[[], bool] = lambda: False,
) -> Motion:
    """The motion from ``start`` to ``stop``, with ``samples`` samples evenly between."""
    ready = prepared(system, method, tolerance, outputs, backward=stop < start)
    return run(ready, values_of(system, sets), start, stop, samples, interrupted)


def run(
    ready: Prepared,
    values: Values,
    start: float,
    stop: float,
    samples: int,
    interrupted: Callable[[], bool] = lambda: False,
) -> Motion:
    """The motion of compiled equations."""
    chunks: dict[str, list[NDArray[np.float64]]] = {"t": []}

    def emit(chunk: Mapping[str, NDArray[np.float64]]) -> None:
        for path, samples in chunk.items():
            chunks.setdefault(path, []).append(np.array(samples))

    times = Times(start, stop, samples, (stop - start) / max(1, samples - 1))
    outcome = integrate(ready, values, times, emit, interrupted, emit_events=emit)
    data = {path: np.concatenate(parts) if parts else np.empty(0) for path, parts in chunks.items()}
    return Motion(data, values, outcome)


def samples_of(function: Callable[[mpmath.mpf], mpmath.mpf], times: Iterable[float]) -> list[mpmath.mpf]:
    """``function`` at each time, to ``DIGITS`` digits."""
    with mpmath.workdps(DIGITS):
        return [+function(mpmath.mpf(float(t))) for t in times]


def error(found: Iterable[float], known: Iterable[mpmath.mpf]) -> float:
    """The largest difference, relative to the largest known value: to the size of the motion."""
    with mpmath.workdps(DIGITS):
        pairs = [(mpmath.mpf(float(x)), y) for x, y in zip(found, known, strict=True)]
        return float(max(abs(x - y) for x, y in pairs) / max(abs(y) for _, y in pairs))


HUGE = 1e300
"""Arguments beyond this are refused where real values are asked for."""


class ManyDigits:
    """``Algebra[mpc]``: the expression language in mpmath's arithmetic, at its precision of the moment.

    Analytic where mpmath's own functions are not: ``atan2`` takes complex arguments. ``real`` refuses them.
    """

    def __init__(self, real: bool = False) -> None:
        self.real = real

    def number(self, text: str) -> mpmath.mpf:
        return mpmath.mpf(float(text))

    def pi(self) -> mpmath.mpf:
        return mpmath.mpf(np.pi)

    def symbol(self, name: str) -> mpmath.mpf:
        raise KeyError(name)

    def function(self, name: str, arguments: Sequence[mpmath.mpf]) -> mpmath.mpf:
        if self.real and any(isinstance(argument, mpmath.mpc) for argument in arguments):
            raise ValueError(f"{name} of a complex number")
        if self.real and any(abs(argument) > HUGE for argument in arguments):
            raise OverflowError(f"{name} of a huge number")  # for its sine, pi would need millions of digits
        if name in ("abs", "min", "max"):
            return {"abs": abs, "min": min, "max": max}[name](*arguments)
        if name == "atan2" and not self.real:
            y, x = arguments
            return -1j * mpmath.log((x + 1j * y) / mpmath.sqrt(x * x + y * y))
        return getattr(mpmath, name)(*arguments)

    def side(self, u: mpmath.mpf, at: int) -> int:
        if isinstance(u, mpmath.mpc):
            raise ValueError("complex numbers are compared")
        return 1 if u > 0 else -1 if u < 0 else at

    def diff(self, expression: mpmath.mpf, symbol: mpmath.mpf) -> mpmath.mpf:
        raise NotImplementedError


def evaluate(text: str, values: Mapping[str, mpmath.mpf], real: bool = False) -> mpmath.mpf:
    """The value of an expression of the language, to mpmath's precision."""
    return build(parse(text), values.__getitem__, ManyDigits(real))
