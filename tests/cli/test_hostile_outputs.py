"""``--resume`` on what stands under the output's name, or beside it, whoever put it there.

Whatever it is, the command ends with a status that says what is wrong; nothing else is opened, waited for or
believed, and memory is bounded. Cases are drawn anew each time: a failure names its seed.
"""

from __future__ import annotations

import json
import math
import os
import random
import shutil
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import h5py
import numpy as np
import pytest

import lagrange_cli.cli.commands.solve as solving
import lagrange_cli.cli.commands.sweep as sweeping
from lagrange_cli.cli.console import EXIT_STATUS
from lagrange_cli.cli.main import main
from lagrange_cli.store import checkpoint as checkpoints
from lagrange_cli.store.checkpoint import LARGEST, MAGIC, Checkpoint, Unusable
from lagrange_cli.store.contents import STATUSES
from lagrange_cli.store.trusted import END, read_record, sealed
from tests.cli.test_resume import Nervous
from tests.support.command import SYSTEMS

DOUBLE, BALL = str(SYSTEMS / "double_pendulum.yaml"), str(SYSTEMS / "bouncing_ball.yaml")
RUNS = {
    "motion": ["solve", DOUBLE, "--stop", "100", "--samples", "3001", "--outputs", "q,v,h,ledger"],
    "sweep": ["sweep", DOUBLE, "--over", "theta1=0.5:2:60", "--stop", "200", "--jobs", "1"],
    "events": ["solve", BALL, "--stop", "4.5", "--outputs", "q,v,h,ledger"],
    "done": ["solve", DOUBLE, "--stop", "1"],
    "rested": ["solve", BALL, "--stop", "5"],
    "balls": ["sweep", BALL, "--over", "y=1,2", "--stop", "2", "--jobs", "1"],
}
"""Two motions and a sweep that are interrupted, and motions and a sweep that have come to their ends."""
DONE = ("done", "rested", "balls")
STRANGE: list[Any] = [
    None, True, "x", "", -1, 0, 7, 1.5, -0.5, 2**53, 2**64, 10**400, math.nan, math.inf, 1e308, [], {}, [[]],
    [1, 2, 3], ["a", "b"], {"a": None}, "\x1b[31m", "[" * 5000, "9" * 5000,
]  # fmt: skip
SAMPLE = 6
"""So many of the cases are given to the command, others each time."""


@pytest.fixture(scope="module")
def outputs(tmp_path_factory) -> dict[str, bytes]:
    """The file that each of ``RUNS`` leaves."""
    found = {}
    folder = tmp_path_factory.mktemp("outputs")
    for name, arguments in RUNS.items():
        with pytest.MonkeyPatch.context() as patch:
            if name not in DONE:
                patch.setattr(Nervous, "patience", 1)
                patch.setattr(solving, "Interrupts", Nervous)
                patch.setattr(sweeping, "Interrupts", Nervous)
            status = main([*arguments, "-o", str(folder / name), "--quiet"])
        assert status == (0 if name in DONE else 130)
        found[name] = (folder / name).read_bytes()
    return found


@pytest.fixture
def unopened(monkeypatch):
    """HDF5's library opens nothing that exists."""

    def refuse(*arguments: Any, **options: Any) -> Any:
        raise AssertionError("opened by HDF5's library")

    monkeypatch.setattr(h5py.h5f, "open", refuse)


def resumed(name: str) -> int:
    """The status of the command with ``--resume``."""
    return main([*RUNS[name], "-o", "out.h5", "--resume", "--quiet"])


def record_of(content: bytes) -> Checkpoint:
    """The record in an output."""
    Path("record.h5").write_bytes(content)
    return read_record(Path("record.h5"), "out.h5")


def with_record(record: Checkpoint) -> bytes:
    """An output with that record, and nothing else in it."""
    return b"\x89HDF\r\n\x1a\n" + sealed(record.pack(), 8)


def other(value: Any) -> Iterator[Any]:
    """Terms of JSON that differ from it in one place, or lack it, or have more."""
    yield from STRANGE
    if isinstance(value, dict):
        yield {**value, "more": 1}
        yield {**value, "\x1b[31m": next(iter(value.values()), 1)}
        for name, one in value.items():
            yield {key: x for key, x in value.items() if key != name}
            for strange in other(one):
                yield {**value, name: strange}
    elif isinstance(value, list):
        for i, one in enumerate(value):
            yield [*value[:i], *value[i + 1 :]]
            for strange in other(one):
                yield [*value[:i], strange, *value[i + 1 :]]


def other_arrays(arrays: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Arrays of which one is another."""
    for name, array in arrays.items():
        yield {key: one for key, one in arrays.items() if key != name}
        twice, values = np.concatenate([array, array]), (math.nan, math.inf, -1e308, 0.0)
        if array.dtype.kind == "i":
            values = (-1, 0, 2**62, 127)
        with np.errstate(all="ignore"):
            strange = [array[:0], array.T, array.ravel()[:-1], twice, array.astype("i1")]
            strange += [np.full_like(array, np.array(value).astype(array.dtype)) for value in values]
        yield from ({**arrays, name: one} for one in strange)
    yield {**arrays, "more": np.zeros(3)}


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("name", RUNS)
def test_a_record_of_other_contents_is_refused_or_harmless(folder, outputs, name, unopened, capsys):
    """Every part of it replaced by anything else, with the right digest."""
    record = record_of(outputs[name])
    heads = [*other(json.loads(json.dumps(record.head)))]
    assert len(heads) > 300
    passed, refused = [], []
    for head in heads:
        packed = Checkpoint(head, record.arrays).pack()
        try:
            Checkpoint.unpack(packed, "out.h5")
            passed.append(Checkpoint(head, record.arrays))
        except Unusable:
            refused.append(Checkpoint(head, record.arrays))
    assert len(refused) > len(heads) / 3 and passed
    assert not any('\\u001b[31m": ' in json.dumps(case.head) for case in passed)  # names go to the terminal
    seed = int.from_bytes(os.urandom(4), "little")
    chance = random.Random(seed)
    altered = [Checkpoint(record.head, arrays) for arrays in other_arrays(dict(record.arrays))]
    for cases, allowed in ((passed, {0, 5}), (refused, {5}), (altered, {0, 4, 5})):
        for case in chance.sample(cases, min(SAMPLE, len(cases))):
            content = outputs[name] if name in DONE else None
            content = with_record(case) if content is None else moved(content, case)
            Path("out.h5").write_bytes(content)
            status = resumed(name)
            error = capsys.readouterr().err
            where = f"seed {seed}: {str(case.head)[:2000]}"
            assert status in allowed and "Traceback" not in error and "report it" not in error, where
            if status == 5:
                assert Path("out.h5").read_bytes() == content, where


def moved(content: bytes, record: Checkpoint) -> bytes:
    """A finished output with another record."""
    place = content.rindex(MAGIC)
    return content[:place] + sealed(record.pack(), place)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("name", RUNS)
def test_a_damaged_output_is_refused_or_harmless(folder, outputs, name, unopened, capsys):
    """Bytes changed, cut off and added, most of them near the record."""
    seed = int.from_bytes(os.urandom(4), "little")
    chance = random.Random(seed)
    for _ in range(SAMPLE):
        content = bytearray(outputs[name])
        near = content.rindex(MAGIC)
        for _ in range(chance.choice((1, 1, 3))):
            low = chance.choice((0, near - 500, len(content) - 60))
            place = chance.randrange(low, len(content))
            kind = chance.randrange(4)
            if kind == 0:
                content[place] ^= chance.randrange(1, 256)
            elif kind == 1:
                content[place : place + 8] = chance.choice((0, 2**64 - 1, len(content))).to_bytes(8, "little")
            elif kind == 2:
                del content[place:]
            else:
                content[place:place] = END * chance.randrange(1, 5)
            if len(content) < 100:
                break
            near = max(500, min(near, len(content) - 1))
        Path("out.h5").write_bytes(content)
        status = resumed(name)
        error = capsys.readouterr().err
        assert status in (0, 5) and "Traceback" not in error and "report it" not in error, f"seed {seed}"
        if status == 5:
            assert Path("out.h5").read_bytes() == content


def structures(file: Any, pipe: str) -> Iterator[None]:
    """Puts into an output what leads elsewhere or asks for much, one after the other."""
    for path in ("t", "checkpoint", "q/theta1"):
        for kind in ("link", "virtual", "external", "chunk", "huge", "cycle", "compound", "text"):
            if path in file:
                del file[path]
            if kind == "link":
                file[path] = h5py.ExternalLink(pipe, "/t")
            elif kind == "virtual":
                layout = h5py.VirtualLayout(shape=(4,), dtype="u1")
                layout[:] = h5py.VirtualSource(pipe, "t", shape=(4,))
                file.create_virtual_dataset(path, layout)
            elif kind == "external":
                file.create_dataset(path, shape=(4,), dtype="u1", external=[(pipe, 0, 4)])
            elif kind == "chunk":
                made = file.create_dataset(
                    path, shape=(2**31,), dtype="u1", chunks=(2**31,), compression="gzip"
                )
                made.attrs["long_name"] = "the state from which lagrange --resume continues"
            elif kind == "huge":
                file.create_dataset(path, shape=(2**60,), dtype="u1", chunks=(2**10,))
            elif kind == "cycle":
                file[path] = h5py.SoftLink(f"/{path}")
            elif kind == "compound":
                file.create_dataset(path, shape=(3,), dtype=[("a", "f8"), ("b", h5py.string_dtype())])
            else:
                file.create_dataset(path, data=["x"] * 3, dtype=h5py.string_dtype())
            yield
    for name, value in (
        ("status", ["complete"] * 3), ("name", 7), ("generator", np.zeros(1000)), ("p_drift", "[" * 5000),
        ("spec", h5py.Reference()), ("message", np.zeros(3, dtype=[("a", "f8")])),
    ):  # fmt: skip
        del file.attrs[name]
        file.attrs[name] = value
        yield
    group = file
    for _ in range(500):
        group = group.create_group("g")
    yield


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", RUNS)
def test_what_leads_out_of_an_output_is_not_followed(folder, outputs, name, capsys):
    """Links, virtual datasets and external storage that lead to a pipe, chunks of gigabytes, cycles."""
    os.mkfifo("pipe")
    Path("changed.h5").write_bytes(outputs[name])
    count = 0
    with h5py.File("changed.h5", "r+") as file:
        for _ in structures(file, "pipe"):
            file.flush()
            shutil.copy("changed.h5", "out.h5")
            before = Path("out.h5").read_bytes()
            with mock.patch.object(h5py.h5f, "open", None):
                assert resumed(name) in (0, 5)  # a record that HDF5 has left alone is sound
            assert "Traceback" not in capsys.readouterr().err
            if name in DONE:
                assert Path("out.h5").read_bytes() == before
            count += 1
    assert count == 31
    assert os.path.exists("pipe")


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("name", ["out.h5", ".out.h5.checkpoint", ".out.h5.part", ".out.h5.1.part"])
@pytest.mark.parametrize("kind", ["pipe", "link", "loop", "folder", "sparse", "device"])
def test_what_is_no_plain_file_of_ours_is_not_read(folder, outputs, name, kind, unopened, capsys):
    record = record_of(outputs["motion"])
    for path, part in (("out.h5", -1), (".out.h5.checkpoint", 0)):
        head = {**record.head, "part": part}
        packed = Checkpoint(head, record.arrays).pack()
        Path(path).write_bytes(packed if part == 0 else with_record(Checkpoint(head, record.arrays)))
    Path(".out.h5.part").write_bytes(outputs["motion"])
    Path("precious").write_bytes(b"precious")
    if os.path.exists(name):
        os.remove(name)
    if kind == "pipe":
        os.mkfifo(name)
    elif kind == "folder":
        os.mkdir(name)
    elif kind == "sparse":
        with open(name, "wb") as file:
            file.write(b"\x89HDF\r\n\x1a\n")
            file.seek(2**36)
            file.write(b"\0" * 8 + LARGEST.to_bytes(8, "little") + END)
    else:
        os.symlink({"link": "precious", "loop": name, "device": "/dev/zero"}[kind], name)
    tracemalloc.start()
    status = resumed("motion")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    error = capsys.readouterr().err
    assert status in (0, 5) and "Traceback" not in error and "report it" not in error
    assert peak < 2**28, peak
    assert Path("precious").read_bytes() == b"precious"


def test_every_way_to_end_has_its_status():
    assert set(STATUSES) == set(EXIT_STATUS)


def test_a_head_of_many_values_is_refused_before_they_are_made(monkeypatch):
    from hashlib import sha256

    head = b"[" + b"[]," * 5_000_000 + b"[]]"
    rest = len(head).to_bytes(8, "little") + head
    content = MAGIC + sha256(rest).digest() + rest
    monkeypatch.setattr(checkpoints.json, "loads", None)
    with pytest.raises(Unusable):
        Checkpoint.unpack(content, "out.h5")


PLAIN = "coordinates: {theta1: {initial: 1}}\nlagrangian: theta1_dot**2/2 - theta1**2/2\nsolve: {stop: 1}\n"


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "command", [("view", "-o", "o.html"), ("plot", "-o", "o.png")], ids=lambda one: one[0]
)
def test_what_is_shown_of_a_changed_output_is_what_this_program_writes(folder, command, capsys):
    """With a sound record at its end, as an attacker can make one, the file is opened by HDF5's library."""
    Path("plain.yaml").write_text(PLAIN)
    assert main(["solve", "plain.yaml", "-o", "whole.h5", "--samples", "4"]) == 0
    record = record_of(Path("whole.h5").read_bytes()).pack()
    os.mkfifo("pipe")
    shutil.copy("whole.h5", "changed.h5")
    statuses = []
    with h5py.File("changed.h5", "r+") as file:
        for _ in structures(file, "pipe"):
            file.flush()
            content = Path("changed.h5").read_bytes()
            Path("out.h5").write_bytes(content + sealed(record, len(content)))
            statuses.append(main([command[0], "out.h5", *command[1:], "--force"]))
            assert statuses[-1] in (0, 2, 3, 5)
            assert "Traceback" not in (error := capsys.readouterr().err) and "report it" not in error
    assert len(statuses) == 31 and any(statuses)
