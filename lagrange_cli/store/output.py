"""``Output``: an HDF5 file that gets its name when it is complete, or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from lagrange_cli.errors import FileError
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target, unwritable

if TYPE_CHECKING:
    from lagrange_cli.store.checkpoint import Checkpoint

CHECKPOINT = "checkpoint"
"""The dataset with what an interrupted run can be continued from."""


class Output:
    """A context in which ``file``, made by ``create`` over a sink, is written and then ``close``d.

    ``target`` is where it goes, and when it has been closed, where it is. Leaving the context before that
    removes what was written, unless it can be continued from a checkpoint. Nothing in the file depends on
    when or where it was written, so the same calls give the same bytes. Every method raises ``FileError``
    where the file cannot be written.
    """

    def __init__(self, target: Target, create: Callable[[Sink], Any]) -> None:
        self.target = target
        self._kept = False
        self.last = float("nan")
        """The last sample time, where there is one for all."""
        target.discard()  # what was left behind, or put there to lead elsewhere
        try:
            self.sink = Sink(target.temporary)
        except OSError as error:
            raise unwritable(target.shown, error) from error
        try:
            self.file = create(self.sink)
        except BaseException:
            self.abandon()
            raise

    def check(self) -> None:
        """Raise what the sink has kept from HDF5."""
        if self.sink.error is not None:
            error = unwritable(self.target.shown, self.sink.error)
            left = self.target.checkpoint.exists()  # by this run, or by the one that it continues
            hint = "; --resume continues from the last checkpoint" if left else ""
            raise FileError(f"{error}{hint}") from self.sink.error

    def keep(self, checkpoint: Checkpoint) -> None:
        """Write a checkpoint beside the file, once what is in the file is on disk.

        Where there is no room for it, or no permission any more, the one before stays, and the run goes on.
        """
        from lagrange_cli.store.checkpoint import write_whole

        self.sink.synchronize()
        self.check()
        with suppress(OSError):
            write_whole(self.target.checkpoint, checkpoint.pack())
            self._kept = True

    def close(
        self,
        attributes: Mapping[str, str | int | float],
        checkpoint: Checkpoint | None = None,
        further: Checkpoint | None = None,
    ) -> None:
        """Write the root's attributes in their order, close the file and give it its name.

        With a ``checkpoint`` the file says how the run can be continued; with ``further``, how one that ends
        later goes on from a run that is complete.
        """
        from lagrange_cli.store.checkpoint import Checkpoint
        from lagrange_cli.store.trusted import sealed

        if checkpoint is not None:
            self._put_inside(checkpoint.pack())
        for name, value in attributes.items():
            self.file.attrs[name] = value
        self.file.close()
        if checkpoint is None:
            head = {"attributes": dict(attributes), "t": self.last}
            record = Checkpoint(head, {})
            if further is not None:
                record = Checkpoint({**head, "further": further.head}, further.arrays)
            self.sink.write(sealed(record.pack(), self.sink.seek(0, os.SEEK_END)))
        self.sink.synchronize()
        self.check()
        self.sink.close()
        self.target = self.target.publish(str(attributes.get("status")))

    def _put_inside(self, packed: bytes) -> None:
        """Make a record a dataset, as it must lie there (see ``trusted``)."""
        from lagrange_cli.store.trusted import sealed

        size = len(sealed(packed, 0))
        dataset = self.file.create_dataset(CHECKPOINT, shape=(size,), dtype="u1", dcpl=in_one_piece())
        dataset[:] = np.frombuffer(sealed(packed, dataset.id.get_offset()), dtype="u1")
        dataset.attrs["long_name"] = "the state from which lagrange --resume continues"
        dataset.make_scale(CHECKPOINT)

    def abandon(self) -> None:
        """Close the unfinished file, and remove it unless there is a checkpoint to continue it from."""
        file = getattr(self, "file", None)
        if file:
            file.close()
        self.sink.close()
        if not self._kept:
            self.target.discard()

    def __enter__(self) -> Output:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self.sink.closed:
            self.abandon()


def in_one_piece() -> Any:
    """The properties of a dataset that has its place in the file from the start, and is not filled there."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    return properties


def open_file(sink: Sink, cache: int) -> Any:
    """An HDF5 file over ``sink`` with so many bytes of cache per dataset.

    (By default HDF5 keeps up to a megabyte for each of them, however many they are.)
    """
    return h5py.File(sink, "w", rdcc_nbytes=cache)
