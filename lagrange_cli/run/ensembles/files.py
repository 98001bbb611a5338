"""The file of many motions, of a sweep or a section: members that have ended are in it, and are not followed
again where a run is continued."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from lagrange_cli.integrate.checkpoint import Checkpointing
from lagrange_cli.run.ensembles.contents import dimensions, series

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import numpy as np

    from lagrange_cli.integrate.checkpoint import Schedule
    from lagrange_cli.integrate.ensemble.method import Kept
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.ensembles.ensemble import Ensemble
    from lagrange_cli.run.resume import Start
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.target import Target

CROSSING = "crossing"
"""What a section has of each motion, in place of samples."""


class EnsembleFile(Protocol):
    """Where the numbers of motions go."""

    @property
    def output(self) -> AbstractContextManager[Any]:
        """The context in which the motions are followed."""

    @property
    def found(self) -> np.ndarray:
        """The numbers of crossings (members,) of a section."""

    @property
    def events(self) -> Mapping[str, int]:
        """How often events have happened in all members of a sweep."""

    def of_motion(self, schedule: Schedule) -> Checkpointing[Kept] | None:
        """The checkpoints of the only motion, if there are any."""

    def of_members(self, schedule: Schedule) -> Checkpointing[EnsembleOutcome] | None:
        """The checkpoints of many motions, which keep those that have ended, if there are any. Raises
        ``Unusable``."""

    def write(self, index: np.ndarray, values: Mapping[str, Any]) -> None:
        """Write what members ``index`` (b,) have given."""

    def close(
        self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome
    ) -> Target | None:
        """Complete the file; returns the target that was written, if it is a file."""


class MembersFile:
    """The file of many motions; that of a section has the dimension ``crossing`` in place of a time."""

    def __init__(
        self, ensemble: Ensemble, prepared: Prepared, start: Start, units: Mapping[str, str]
    ) -> None:
        import numpy as np

        from lagrange_cli.store.ensemble import EnsembleWriter
        from lagrange_cli.store.layout import Dimension

        times, crossings = ensemble.times, None
        sampled = ensemble.sampled and ensemble.cut is None
        if ensemble.cut is not None:
            crossings = Dimension(CROSSING, ensemble.cut.kept.count, long_name="crossing of the motion")
        self._start, self._members = start, ensemble.values.members
        self._section = ensemble.cut is not None
        self.found = np.zeros(self._members, dtype=np.int64)
        layout = layout_of(ensemble, prepared, units)
        if crossings is not None:
            layout.check_size(crossings.length, self._members, noun=CROSSING)
        else:
            layout.check_size(times.count if sampled else 1, self._members)
        self.output = EnsembleWriter(
            start.target,
            layout,
            members=self._members,
            times=times.chunk(0, times.count) if sampled else None,
            dimensions=dimensions(ensemble, units),
            samples=crossings,
        )

    @property
    def events(self) -> Mapping[str, int]:
        """See ``EnsembleFile``."""
        return self.output.crossings_of_events()

    def of_motion(self, schedule: Schedule) -> None:
        """See ``EnsembleFile``."""

    def of_members(self, schedule: Schedule) -> Checkpointing[EnsembleOutcome]:
        """See ``EnsembleFile``."""
        return Checkpointing(self._restored(), schedule, lambda one: self.output.keep(self._checkpoint(one)))

    def _restored(self) -> EnsembleOutcome | None:
        """How members had ended in the run that this one continues, if there is one; their numbers are put
        into the file."""
        from lagrange_cli.integrate.ensemble.outcome import UNFINISHED, EnsembleOutcome
        from lagrange_cli.store.checkpoint import damaged

        earlier = self._start.earlier
        if earlier is None:
            return None
        head, arrays = earlier.checkpoint.head, earlier.checkpoint.arrays
        try:
            begin = EnsembleOutcome.from_data(head.get("outcome"), arrays.get("endings"), self._members)
        except ValueError as error:
            raise damaged(earlier.shown) from error
        self.output.restore(earlier, begin.endings != UNFINISHED)
        if self._section:
            before = arrays.get("crossings")
            if before is None or before.dtype != self.found.dtype or before.shape != self.found.shape:
                raise damaged(earlier.shown)
            self.found[:] = before
        return begin

    def _checkpoint(self, outcome: EnsembleOutcome, *, inside: bool = False) -> Checkpoint:
        from lagrange_cli.integrate.ensemble.outcome import UNFINISHED

        reached, ended = self._members - outcome.count("interrupted"), outcome.endings != UNFINISHED
        content = {"outcome": outcome.as_data(), "regions": self.output.regions(ended)}
        further = {"crossings": self.found} if self._section else self.output.crossings()
        arrays = {"endings": outcome.endings, **further}
        return self._start.checkpoint({"reached": reached, **content}, arrays, inside=inside)

    def write(self, index: np.ndarray, values: Mapping[str, Any]) -> None:
        """See ``EnsembleFile``."""
        if "crossings" in values:
            self.found[index] = values["crossings"]
        self.output.write(index, values)

    def close(
        self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome
    ) -> Target | None:
        """See ``EnsembleFile``."""
        last = self._checkpoint(outcome, inside=True) if outcome.status == "interrupted" else None
        self.output.write_crossings()
        self.output.write_messages(endings, outcome.endings)
        self.output.close(attributes, last)
        return self.output.target


def layout_of(ensemble: Ensemble, prepared: Prepared, units: Mapping[str, str]) -> Layout:
    """The datasets of the ensemble, and the groups of its events."""
    from lagrange_cli.store.layout import EventSeries, Layout

    events: tuple[EventSeries, ...] = ()
    if ensemble.spec.events and ensemble.cut is None:
        from lagrange_cli.run.events import crossings_of

        events = crossings_of(ensemble.spec, prepared, units, ensemble=True)
    return Layout(series(ensemble, prepared, units), time_unit=units.get("t", ""), events=events)
