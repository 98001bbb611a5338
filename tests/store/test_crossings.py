"""The groups of events in the output file: what is read back, and the same bytes however it is written."""

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from lagrange_cli.errors import FileError
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from lagrange_cli.store import layout as layouts
from lagrange_cli.store.checkpoint import Checkpoint
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.layout import EventSeries, Layout, Series
from lagrange_cli.store.resume import Earlier
from lagrange_cli.store.writer import Writer
from tests.support.draws import examples

STOP, COUNT = 30.0, 31
ATTRIBUTES = {"generator": "test", "status": "complete"}


def event_of(name: str, *indices: str) -> EventSeries:
    """An event of a system with a coordinate x and a family u."""
    group = f"events/{name}"
    return EventSeries(
        name,
        (
            Series(f"{group}/t", unit="s", long_name="time"),
            *(Series(f"{group}/{index}", kind="i8") for index in indices),
            Series(f"{group}/q/x", unit="m"),
            Series(f"{group}/v/u", (3,), axes=("N",)),
        ),
        {"when": "x - 1", "direction": "rising", "action": "record"},
    )


LAYOUT = Layout(
    (Series("q/x"), Series("v/u", (3,), axes=("N",))),
    events=(event_of("floor"), event_of("wall", "i"), event_of("never"), event_of("twin")),
)
RATES = {"floor": 7.0, "wall": 3.0, "twin": 7.0}
"""EventSeries per unit of time: two events have theirs at the same times."""


def crossings(after: float, until: float, *, sense: float = 1.0) -> dict[str, np.ndarray]:
    """Those in after < t <= until, each series a recognizable function of the number."""
    chunk = {}
    for event in LAYOUT.events:
        rate = RATES.get(event.name, 0.0)
        numbers = np.arange(1, int(STOP * rate) + 1)
        numbers = numbers[(numbers > rate * after) & (numbers <= rate * until)]
        for series in event.series:
            values = numbers / rate * sense if series.path.endswith("/t") else numbers
            values = values.reshape(-1, *(1 for _ in series.shape)) * np.ones(series.shape)
            chunk[series.path] = values.astype(series.kind)
    return chunk


def samples(after: float, until: float, *, sense: float = 1.0) -> dict[str, np.ndarray]:
    """The samples at 0, 1, 2, ... in after < t <= until."""
    t = np.arange(0.0, COUNT)
    t = t[(t > after) & (t <= until)]
    return {"t": sense * t, "q/x": 2 * t, "v/u": t[:, None] * np.arange(3)}


def feed(writer: Writer, cuts, after: float = -1.0, *, sense: float = 1.0) -> None:
    """What a run hands over that is cut at these times: at some of them only crossings. Those at the very
    time of the cut come event by event, the last event first."""
    sampled = after
    for until, both in cuts:
        chunk = crossings(after, until, sense=sense)
        at = {path: chunk[f"{'/'.join(path.split('/')[:2])}/t"] == sense * until for path in chunk}
        writer.append_crossings({path: rows[~at[path]] for path, rows in chunk.items()})
        for event in reversed(LAYOUT.events):
            writer.append_crossings({one.path: chunk[one.path][at[one.path]] for one in event.series})
        after = until
        if both:
            writer.append(samples(sampled, until, sense=sense))
            sampled = until


def writer_of(path, *, sense: float = 1.0, part: int = 0) -> Writer:
    target = replace(find_target(str(path), force=True), part=part)
    return Writer(target, LAYOUT, Times(0.0, sense * STOP, COUNT, sense))


@pytest.fixture
def small(monkeypatch):
    """Chunks of four samples, and of 16 crossings."""
    monkeypatch.setattr(layouts, "ROWS", 4)
    monkeypatch.setattr(layouts, "CROSSINGS", 16)


def written(path, cuts=((STOP, True),), *, sense: float = 1.0) -> bytes:
    with writer_of(path, sense=sense) as writer:
        feed(writer, cuts, sense=sense)
        writer.close(ATTRIBUTES)
    return path.read_bytes()


def test_crossings_are_read_back_with_what_their_events_are(tmp_path):
    written(tmp_path / "out.h5", [(0.4, True), (7.2, False), (19.0, True), (STOP, True)])
    with h5py.File(tmp_path / "out.h5") as file:
        for path, values in (crossings(-1.0, STOP) | samples(-1.0, STOP)).items():
            np.testing.assert_array_equal(file[path][()], values)
            assert file[path].dtype == values.dtype
        assert dict(file["events/wall"].attrs) == LAYOUT.events[1].attributes
        assert file["events/wall/t"].is_scale and file["events/never/t"].shape == (0,)
        assert file["events/wall/q/x"].attrs["unit"] == file["events/wall/q/x"].attrs["units"] == "m"
        assert [next(iter(axis.values())).name for axis in file["events/wall/v/u"].dims] == [
            "/events/wall/t",
            "/N",
        ]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", ["floor", "wall", "never"])
def test_xarray_finds_the_times_of_the_crossings_and_not_of_the_samples(tmp_path, name):
    written(tmp_path / "out.h5")
    times = crossings(-1.0, STOP)[f"events/{name}/t"]
    for group in ("", "/q", "/v"):
        with xarray.open_dataset(
            tmp_path / "out.h5", group=f"events/{name}{group}", engine="h5netcdf"
        ) as data:
            np.testing.assert_array_equal(data.coords["t"], times)
            assert all(array.dims[0] == "t" for array in data.data_vars.values())
    with xarray.open_dataset(tmp_path / "out.h5", group="q", engine="h5netcdf") as data:
        assert data.sizes["t"] == COUNT


CUTS = st.lists(
    st.tuples(st.floats(0.0, STOP) | st.sampled_from([9.0, 16.0]), st.booleans()), max_size=6
).map(lambda cuts: [*sorted(cuts), (STOP, True)])


@pytest.mark.exhaustive(keep=0.3)
@given(CUTS, st.sampled_from([1.0, -1.0]))
@example([(15.5, True), (16.0, False), (STOP, True)], 1.0)
@settings(examples(12), suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_the_bytes_do_not_depend_on_how_much_is_appended_at_a_time(tmp_path, small, cuts, sense):
    assert written(tmp_path / "a.h5", cuts, sense=sense) == written(tmp_path / "b.h5", sense=sense)


@pytest.mark.exhaustive(keep=0)
@given(CUTS, st.sampled_from([1.0, -1.0]), st.sampled_from(["killed", "interrupted", "further"]))
@settings(examples(12), suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_what_an_earlier_run_left_is_taken_over_to_the_same_bytes(tmp_path, small, cuts, sense, how):
    """The run is cut off, goes on, is cut off again and so on. What ``further`` continues from is trimmed to
    the numbers of samples and crossings at a time before its end."""
    expected = written(tmp_path / "whole.h5", sense=sense)
    out, before, reached, part = tmp_path / "out.h5", None, -1.0, 0
    for until, _ in cuts:
        with writer_of(out, sense=sense, part=part) as writer:
            if before is not None:
                counts = [len(crossings(-1.0, reached)[f"events/{one.name}/t"]) for one in LAYOUT.events]
                writer.restore(before, 4, len(samples(-1.0, reached)["t"]), counts)
            feed(writer, [(until, True)], reached, sense=sense)
            if until == STOP:
                writer.close(ATTRIBUTES)
                break
            state = Checkpoint({"part": 0}, writer.state())
            if how == "further":
                feed(writer, [(until + 1.5, True)], until, sense=sense)
                writer.finish()
                state = Checkpoint({"part": 0}, writer.pieces())
            elif how == "interrupted":
                writer.finish()
            writer.file.flush()
            left = tmp_path / f"left{part}"
            left.write_bytes((tmp_path / f".out.h5.{f'{part}.' if part else ''}part").read_bytes())
        before, reached, part = Earlier("out.h5", left, state), until, 1 - part
    assert out.read_bytes() == expected


def test_no_more_than_a_chunk_of_crossings_waits_in_memory(tmp_path, small):
    with writer_of(tmp_path / "out.h5") as writer:
        after = -1.0
        for until in np.arange(0.5, STOP, 0.5):
            feed(writer, [(until, True)], after)
            waiting = [len(rows) for name, rows in writer.state().items() if name.startswith("rest/events")]
            assert max(waiting) <= 16
            after = until


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize(
    "damage",
    [
        lambda arrays: arrays.pop("places/events/wall/i"),
        lambda arrays: arrays.pop("rest/events/wall/i"),
        lambda arrays: arrays.update({"rest/events/wall/i": np.zeros(3)}),
        lambda arrays: arrays.update({"places/events/floor/t": np.array(7)}),
        lambda arrays: arrays.update({"places/events/floor/t": arrays["places/events/floor/t"][1:]}),
        lambda arrays: arrays.update({"places/events/floor/t": arrays["places/events/floor/t"] + [0, 1]}),
        lambda arrays: arrays.update({"places/events/floor/t": -arrays["places/events/floor/t"]}),
        lambda arrays: arrays.update({"rest/events/floor/v/u": np.zeros((3, 4))}),
        lambda arrays: [arrays.pop(f"rest/{one.path}") for one in LAYOUT.events[0].series],
    ],
)
def test_crossings_that_were_changed_are_refused(tmp_path, small, damage):
    with writer_of(tmp_path / "out.h5") as writer:
        feed(writer, [(10.0, True)])
        writer.file.flush()
        arrays = writer.state()
        left = tmp_path / "left"
        left.write_bytes((tmp_path / ".out.h5.part").read_bytes())
    damage(arrays)
    counts = [len(crossings(-1.0, 10.0)[f"events/{one.name}/t"]) for one in LAYOUT.events]
    with writer_of(tmp_path / "out.h5") as writer, pytest.raises(FileError, match="is damaged"):
        writer.restore(Earlier("out.h5", left, Checkpoint({}, arrays)), 4, 11, counts)
