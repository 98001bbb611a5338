"""``Group``: datasets by name, as a group of the output file has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.outputs.catalog import OUTPUTS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Group(Mapping[str, "NDArray[np.float64]"]):
    """The datasets below a path of the output file, by the rest of their paths.

    ``motion.q["theta"]`` is the dataset ``/q/theta``. What lies deeper is reached by its path, or step by
    step: ``motion.ledger["p/theta"]``, ``motion.ledger["p"]["theta"]``.
    """

    def __init__(self, path: str, datasets: Mapping[str, NDArray[np.float64]]) -> None:
        self._path, self._datasets = path, datasets

    def __getitem__(self, name: str) -> Any:
        path = f"{self._path}{name}"
        if path in self._datasets:
            return self._datasets[path]
        if any(one.startswith(f"{path}/") for one in self._datasets):
            return Group(f"{path}/", self._datasets)
        names = [*self]
        hint = near_hint(str(name), names) or known_hint(names)
        raise KeyError(f"there is no '{path}'; {hint}")

    def __iter__(self) -> Iterator[str]:
        return (one[len(self._path) :] for one in self._datasets if one.startswith(self._path))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        shown = ", ".join(f"{name!r}: {self[name].shape}" for name in self)
        return f"<{self._path.rstrip('/') or 'datasets'} {{{shown}}}>"


def folder(name: str) -> str:
    """The path of the datasets of an output: ``q/``, ``diagnostics/p/``."""
    path = OUTPUTS[name].datasets.split()[0].strip("/")
    return f"{path.rpartition('/')[0]}/"


def is_group(name: str) -> bool:
    """Whether an output has several datasets."""
    return not OUTPUTS[name].datasets.endswith(f"/{name}")
