"""The files of sections: of many motions, of one, and of one as a table; and their checkpoints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, BinaryIO

from lagrange_cli.integrate.checkpoint import Checkpointing
from lagrange_cli.records import replace
from lagrange_cli.run.attributes import series_of
from lagrange_cli.run.ensembles.ensemble import Ensemble
from lagrange_cli.run.ensembles.files import CROSSING

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.checkpoint import Schedule
    from lagrange_cli.integrate.ensemble.method import Kept
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.resume import Start
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import Series
    from lagrange_cli.store.target import Target

KEPT = "motion/"
"""What the names of arrays in a checkpoint begin with that a motion is continued from."""


class OfOneMotion:
    """Writes the crossings of one motion: ``append`` is what writes a chunk of them (see
    ``EnsembleFile``)."""

    events: Mapping[str, int] = {}

    def __init__(self, series: tuple[Series, ...], append: Callable[[dict[str, np.ndarray]], None]) -> None:
        self._crossings, self._append = MotionCrossings(series), append

    def of_members(self, schedule: Schedule) -> None:
        """See ``EnsembleFile``."""

    def write(self, index: np.ndarray, values: Mapping[str, Any]) -> None:
        """See ``EnsembleFile``."""
        if self._crossings.take(values):
            self._append(self._crossings.chunk)

    @property
    def found(self) -> np.ndarray:
        """See ``EnsembleFile``."""
        return self._crossings.count


class MotionFile(OfOneMotion):
    """The file of one motion: like that of ``solve``, with its crossings as the samples."""

    def __init__(
        self, ensemble: Ensemble, prepared: Prepared, start: Start, units: Mapping[str, str]
    ) -> None:
        from lagrange_cli.store.layout import Layout
        from lagrange_cli.store.writer import Writer

        assert ensemble.cut is not None
        layout = Layout(series_at(units, prepared), time_unit=units.get("t", ""))
        layout.check_size(ensemble.cut.kept.count, noun=CROSSING)
        times = replace(ensemble.times, count=ensemble.cut.kept.count, step=0.0)
        self.output = Writer(start.target, layout, times)
        super().__init__(layout.series, self.output.append)
        self._start = start
        self._last: Kept | None = None

    def of_motion(self, schedule: Schedule) -> Checkpointing[Kept]:
        """See ``EnsembleFile``."""
        begin, earlier = None, self._start.earlier
        if earlier is not None:
            arrays = earlier.checkpoint.arrays.items()
            begin = {name.removeprefix(KEPT): one for name, one in arrays if name.startswith(KEPT)}
        return Checkpointing(begin, schedule, self._keep)

    def _keep(self, kept: Kept) -> None:
        self._last = kept
        self.output.keep(self._checkpoint(kept))

    def _checkpoint(self, kept: Kept, *, inside: bool = False) -> Checkpoint:
        reached, arrays = kept["states"].shape[1], {f"{KEPT}{name}": one for name, one in kept.items()}
        return self._start.checkpoint({"reached": reached, "crossings": reached}, arrays, inside=inside)

    def close(
        self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome
    ) -> Target | None:
        """See ``EnsembleFile``."""
        last = None
        if outcome.status == "interrupted" and self._last is not None:
            last = self._checkpoint(self._last, inside=True)
        self.output.close({**attributes, "t_end": self._crossings.t_end}, last)
        return self.output.target


class CrossingsTable(OfOneMotion):
    """The crossings of one motion as CSV, in a file or a stream."""

    def __init__(
        self,
        ensemble: Ensemble,
        prepared: Prepared,
        start: Start,
        units: Mapping[str, str],
        stream: BinaryIO | None,
    ) -> None:
        from lagrange_cli.store.csv_file import CsvFile
        from lagrange_cli.store.layout import Layout

        series = series_at(units, prepared)
        if stream is None:
            assert ensemble.cut is not None
            Layout(series).check_size(ensemble.cut.kept.count, noun=CROSSING)
        self.output = CsvFile(start.target if stream is None else None, series, stream)
        super().__init__(series, self.output.append)

    def of_motion(self, schedule: Schedule) -> None:
        """See ``EnsembleFile``."""

    def close(
        self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome
    ) -> Target | None:
        """See ``EnsembleFile``."""
        self.output.close(outcome.status)
        return self.output.target


def series_at(units: Mapping[str, str], prepared: Prepared) -> tuple[Series, ...]:
    """The datasets at the crossings of one motion, with their units; those of times have low parts, too."""
    from lagrange_cli.store.layout import Series

    found = series_of(units, prepared)
    if prepared.machine.program.parts == 1:
        return found
    text = "low part of the time, to be added to /t"
    return (*found, Series("low/t", unit=units.get("t", ""), long_name=text))


class MotionCrossings:
    """The crossings of one motion, as the samples of ``series``."""

    def __init__(self, series: tuple[Series, ...]) -> None:
        import numpy as np

        self._paths = ["t", *(one.path for one in series)]
        self.count, self.t_end = np.zeros(1, dtype=np.int64), float("nan")
        self.chunk: dict[str, np.ndarray] = {}

    def take(self, values: Mapping[str, Any]) -> bool:
        """Whether there are any in what the motion has given."""
        if "crossings" not in values:
            return False
        self.count[:], self.t_end = values["crossings"], float(values["t_end"][0])
        self.chunk = {path: values[path][0][: self.count[0]] for path in self._paths}
        return True
