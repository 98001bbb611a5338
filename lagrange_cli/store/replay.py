"""Finished outputs, read for plots, films and pages: their origin, and some of their samples.

Only the requested parts are read: some samples of a long motion, evenly spaced, or the initial values of the
members of a sweep. ``Result`` ensures that only data written by this program are read.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.store.result import Result, foreign

Array = NDArray[np.float64]
MAKER = "lagrange"
"""The beginning of the attribute ``generator``."""


@dataclass(frozen=True)
class Made:
    """What made an output: the text of the system file, sizes and parameters of the run, and how it ended.

    ``shape`` is that of a sweep's members by dimension, None where the output is that of one motion, which
    ``conserves`` h or does not. Motions go from ``start`` to ``stop``.
    """

    spec: str
    name: str
    sizes: Mapping[str, str]
    parameters: Mapping[str, float]
    status: str
    message: str
    shape: Mapping[str, int] | None
    conserves: bool
    start: float
    stop: float | None


@contextmanager
def opened(path: Path) -> Iterator[Result]:
    """The output; raises ``FileError`` where it cannot be read, is damaged, or is none of this program's."""
    with Result(str(path)) as result:
        try:
            yield result
        except (OSError, RuntimeError, KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
            raise foreign(str(path)) from error


def made(path: Path) -> Made:
    """What made the output.

    Raises ``FileError`` where it is no output of ours, and ``UsageError`` where it holds no motions.
    """
    with opened(path) as result:
        said = result.attributes
    if not str(said.get("generator", "")).startswith(MAKER) or "spec" not in said:
        raise FileError(f"{path} is not an output of lagrange")
    if "crossings" in said:
        raise UsageError(f"{path} contains a section, not a motion: view its system file instead")
    try:
        sizes, parameters, run = (parsed(said, name) for name in ("sizes", "parameters", "run"))
        shape = parsed(said, "sweep")["shape"] if "sweep" in said else None
        return Made(
            str(said["spec"]),
            str(said["name"]),
            {name: str(int(x)) for name, x in sizes.items()},
            {name: float(x) for name, x in parameters.items()},
            str(said["status"]),
            str(said["message"]),
            None if shape is None else {str(name): int(x) for name, x in shape.items()},
            math.isfinite(float(said["h_drift"])),
            float(run["start"]),
            None if run["stop"] is None else float(run["stop"]),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FileError(f"{path} is damaged: what made it cannot be read") from error


def parsed(said: Mapping[str, Any], name: str) -> Any:
    """An attribute that is JSON; an empty mapping where there is none."""
    return json.loads(str(said[name])) if name in said else {}


def samples(
    path: Path, names: Sequence[str], others: Mapping[str, str], most: int
) -> tuple[Array, Array, Array, dict[str, Array]]:
    """Samples of a motion, ``most`` numbers at most: t (n,), q and v (n, degrees), and others by name (n,).

    ``names`` are those of the coordinates, families among them once, ``others`` paths of datasets with the
    names of what is in them, in their order. The last sample is always there.

    Raises ``UsageError`` where the output has no coordinates.
    """
    with opened(path) as result:
        held = result.held
        if "t" not in held or not all(f"q/{name}" in held for name in names):
            raise UsageError(f"{path} has no coordinates: run 'lagrange solve' with --outputs q,v,p,h")
        listed = {name: at for name, at in others.items() if at in held}
        (count,) = held["t"].shape
        width = 1 + sum(2 * math.prod(held[f"q/{name}"].shape[1:]) for name in names) + len(listed)
        each = max(1, math.ceil(count * width / most))
        places = np.unique(np.r_[0:count:each, max(0, count - 1)])[: max(count, 0)]

        def rows(at: str) -> Array:
            shape = held[at].shape
            if shape[0] != count or math.prod(shape[1:]) > most:
                raise ValueError("not of this motion")
            if not count:
                return np.empty((0, math.prod(shape[1:])))
            part = ... if each == 1 else slice(None, None, each if each < count else None)
            found = np.asarray(result.read(at, part), dtype=np.float64)
            found = found.reshape(len(found), -1)
            last = np.asarray(result.read(at, count - 1), dtype=np.float64).reshape(1, -1)
            return found if len(found) == len(places) else np.concatenate([found, last])

        t = rows("t")[:, 0]
        q = np.concatenate([rows(f"q/{name}") for name in names], axis=1)
        if all(f"v/{name}" in held for name in names):
            v = np.concatenate([rows(f"v/{name}") for name in names], axis=1)
        else:
            v = np.gradient(q, t, axis=0) if len(t) > 1 else np.zeros_like(q)
        return t, q, v, {name: rows(at)[:, 0] for name, at in listed.items()}


def members(
    path: Path, shape: Mapping[str, int], names: Sequence[str], chosen: NDArray[np.int64]
) -> tuple[dict[str, Array], Array, Array]:
    """Members of a sweep, ``chosen`` by their numbers (m,): the parameters in which they differ, by name
    (m,), and q and v at their start (m, degrees)."""
    sizes = tuple(shape.values())
    count = math.prod(sizes)
    with opened(path) as result:

        def values(at: str, name: str = "") -> Array:
            if at not in result.held:
                raise KeyError(at)
            found = np.asarray(result.read(at), dtype=np.float64)
            if found.shape[: len(sizes)] != sizes:  # those of one dimension of a grid
                axis = [*shape].index(name if name in shape else f"{name}_")
                along = found.reshape([-1 if k == axis else 1 for k in range(len(sizes))])
                found = np.broadcast_to(along, sizes)
            some: Array = found.reshape(count, -1)[chosen]
            return some

        def state(kind: str) -> Array:
            return np.concatenate([values(f"initial/{kind}/{name}") for name in names], axis=1)

        # those of a grid are its dimensions, to which links lead
        given = result.within("parameters/") | result.linked("parameters/")
        varied = {name: values(at, name)[:, 0] for name, at in given.items()}
        return varied, state("q"), state("v")
