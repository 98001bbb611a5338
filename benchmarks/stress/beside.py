"""Other programs on a scene, and the reference: ``python -m benchmarks.stress.beside SCENE PROGRAM OUT.npz``.

Each starts from the same doubles as lagrange and has the equations that sympy derives.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.motions.printed import Printed, printed_equations
from benchmarks.peers import printed
from benchmarks.stress.scene import QUADRUPLE, Scene
from benchmarks.stress.scenes import SCENES

Array = NDArray[np.float64]
DIGITS = 60
CLOSED = 201
"""At how many samples, spread evenly, closed forms are computed."""
PROGRAMS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "heyoka": ("heyoka", {}),
    "DOP853": ("scipy", {"method": "DOP853", "tolerance": 1e-12}),
    "Radau": ("scipy", {"method": "Radau", "tolerance": 1e-9}),
    "IAS15": ("rebound", {}),
}
"""Peers with their options, by the names of scenes."""


def equations_of(scene: Scene) -> Printed:
    """What ``lagrange equations`` prints."""
    return printed_equations(scene.text, scene.name, dict(each.split("=", 1) for each in scene.settings))


def times_of(scene: Scene) -> Array:
    """The sample times, as `lagrange solve` makes them."""
    from lagrange_cli.integrate.times import Times

    step = (scene.stop - scene.start) / (scene.samples - 1)
    return np.asarray(Times(scene.start, scene.stop, scene.samples, step).chunk(0, scene.samples))


def write_peer(scene: Scene, program: str, path: str) -> None:
    """States, steps and seconds."""
    peer, options = PROGRAMS[program]
    equations, times = equations_of(scene), times_of(scene)
    began = time.perf_counter()
    course = printed(peer, equations, times, **options).follow(equations.initial)
    seconds = time.perf_counter() - began
    np.savez(path, states=course.states.astype(np.float64), steps=course.steps, seconds=seconds)


def write_reference(scene: Scene, path: str) -> None:
    """q (n, samples) at ``which`` of the samples, and how far one rounding of the start moves it."""
    times = times_of(scene)
    if scene.reference == QUADRUPLE:
        which = np.arange(len(times))
        q, moved = in_quadruple(scene, times)
    else:
        which = np.unique(np.linspace(0, len(times) - 1, min(CLOSED, len(times))).astype(int))
        q, moved = in_closed_form(scene, times[which])
    np.savez(path, which=which, q=q.astype(np.float64), rounding=np.abs(moved - q).astype(np.float64))


def in_quadruple(scene: Scene, times: Array) -> tuple[Any, Any]:
    """q (n, samples) by heyoka, and from initial values that are changed by one rounding."""
    import heyoka as hy

    equations = equations_of(scene)
    follow = printed("heyoka", equations, times, quadruple=True).follow
    initial = [hy.real128(each) for each in equations.initial]
    moved = [each * hy.real128(1 + (-1) ** k * 2.0**-52) for k, each in enumerate(initial)]
    q, other = (
        follow(np.array(start, dtype=object)).states[: len(equations.q)] for start in (initial, moved)
    )
    return q, other


def in_closed_form(scene: Scene, times: Array) -> tuple[Any, Any]:
    """The same by the scene's closed form."""
    import mpmath as mp

    from lagrange_cli import read_spec, resolve_values

    mp.mp.dps = DIGITS
    exact = scene.reference
    assert callable(exact)
    values = resolve_values(
        read_spec(scene.text, scene.name), dict(each.split("=", 1) for each in scene.settings)
    )
    parameters = {name: mp.mpf(value) for name, value in values.parameters.items()}

    def at(scale: Any) -> Any:
        q, v = (
            tuple(mp.mpf(x) * (1 + (-1) ** k * scale) for k, x in enumerate(each))
            for each in (values.q, values.v)
        )
        found = [exact(parameters, q, v, mp.mpf(t)) for t in times]
        return np.array(found, dtype=object).T

    return at(0), at(mp.mpf(2) ** -52)


def main() -> None:
    """One program, or ``reference``, on one scene."""
    name, program, path = sys.argv[1:]
    scene = next(each for each in SCENES if each.name == name)
    if program == "reference":
        write_reference(scene, path)
    else:
        write_peer(scene, program, path)


if __name__ == "__main__":
    main()
