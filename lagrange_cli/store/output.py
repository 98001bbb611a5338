"""``Output``: an HDF5 file that appears under its name when it is whole, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any

import h5py

from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target, unwritable


class Output:
    """A context in which ``file``, made by ``create`` over a sink, is written and then ``close``d.

    Leaving the context before that removes what was written. Nothing in the file depends on when or where
    it was written, so the same calls give the same bytes. Every method raises ``FileError`` where the file
    cannot be written.
    """

    def __init__(self, target: Target, create: Callable[[Sink], Any]) -> None:
        self._target = target
        try:
            self._sink = Sink(target.temporary)
        except OSError as error:
            raise unwritable(target.shown, error) from error
        try:
            self.file = create(self._sink)
        except BaseException:
            self.abandon()
            raise

    def check(self) -> None:
        """Raise what the sink has kept from HDF5."""
        if self._sink.error is not None:
            raise unwritable(self._target.shown, self._sink.error) from self._sink.error

    def close(self, attributes: Mapping[str, str | int | float]) -> None:
        """Write the root's attributes in their order, close the file and give it its name."""
        for name, value in attributes.items():
            self.file.attrs[name] = value
        self.file.close()
        self._sink.synchronize()
        self.check()
        self._sink.close()
        self._target.publish()

    def abandon(self) -> None:
        """Close and remove the unfinished file."""
        file = getattr(self, "file", None)
        if file:
            file.close()
        self._sink.close()
        self._target.discard()

    def __enter__(self) -> Output:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._sink.closed:
            self.abandon()


def open_file(sink: Sink, cache: int) -> Any:
    """An HDF5 file over ``sink`` with so many bytes of cache per dataset.

    (By default HDF5 keeps up to a megabyte for each of them, however many they are.)
    """
    return h5py.File(sink, "w", rdcc_nbytes=cache)
