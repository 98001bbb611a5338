"""The line that says how far a run has come."""

import io
import math
import os
import subprocess
import sys
import threading
from contextlib import suppress
from types import SimpleNamespace

import pytest

from lagrange_cli import portions
from lagrange_cli.cli import progress
from lagrange_cli.cli.console import complain
from lagrange_cli.cli.progress import (
    Counter,
    Line,
    MeasuringProgress,
    Progress,
    Waiting,
    columns,
    duration,
    eraser,
    roughly,
)
from lagrange_cli.native.compilation import llvm
from lagrange_cli.portions import latest, portion
from lagrange_cli.run.timings import Stopwatch
from tests.support.command import PATIENCE, SYSTEMS, environment


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass as the test says; no thread updates a line by itself."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(portions.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(progress.threading.Thread, "start", lambda thread: None)
    return now


@pytest.fixture
def terminal(monkeypatch):
    """A terminal, and no line on it that is shown when the test is over."""
    terminal = Terminal()
    monkeypatch.setattr(Line, "shown", None)
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=terminal))
    return terminal


def lines(terminal: io.StringIO) -> list[str]:
    return [line.strip() for line in terminal.getvalue().split("\r") if line.strip()]


def test_members_their_rate_and_the_time_left(terminal, clock):
    line = Counter("hoop", 1000, "members", quiet=False)
    for passed, done in ((0.1, 0), (0.9, 0), (1.0, 250), (0.1, 260), (2.0, 500)):
        clock[0] += passed
        line.show(done)
    line.clear()
    assert lines(terminal) == [
        "hoop:   0%  0 of 1000 members",
        "hoop:  25%  250 of 1000 members, 132 per second, 6 s left",
        "hoop:  50%  500 of 1000 members, 125 per second, 4 s left",
    ]
    assert terminal.getvalue().endswith("\r")


def test_what_an_earlier_run_did_is_no_part_of_the_rate(terminal, clock):
    members = Counter("hoop", 1000, "members", quiet=False)
    for passed, done in ((0.0, 900), (10.0, 920)):
        clock[0] += passed
        members.show(done)
    motion = Progress("hoop", 0.0, 1000.0, quiet=False)
    for passed, t in ((0.0, 900.0), (10.0, 920.0)):
        clock[0] += passed
        motion.show(t)
    assert lines(terminal) == [
        "hoop:  92%  920 of 1000 members, 2 per second, 40 s left",
        "hoop:  92%  t = 920 of 1000, 40 s left",
    ]


@pytest.mark.parametrize(("start", "stop", "way"), [(1.0, 5.0, (2.0, 3.0)), (5.0, 1.0, (4.0, 3.0))])
def test_the_time_reached_and_the_time_left(terminal, clock, start, stop, way):
    line = Progress("hoop", start, stop, quiet=False)
    clock[0] += 1
    line.show(way[0])
    clock[0] += 30
    line.show(way[1])
    line.show(way[1])
    assert lines(terminal) == [
        f"hoop:  25%  t = {way[0]:g} of {stop:g}",
        f"hoop:  50%  t = 3 of {stop:g}, 1 min 0 s left",
    ]


def test_no_time_is_left_that_nobody_knows(terminal, clock):
    line = Progress("hoop", 0.0, 1.0, quiet=False)
    for passed, t in ((1.0, 0.5), (5.0, 0.5), (5.0, 0.4)):  # it stands, it is set back
        clock[0] += passed
        line.show(t)
    assert [line.count("left") for line in lines(terminal)] == [0, 0, 0]


def test_a_stage_is_shown_after_two_seconds(terminal, clock):
    waiting = Waiting("chain", quiet=False)
    with waiting.stage("derive"):
        for passed in (1.0, 0.9, 0.2, 3.0):
            clock[0] += passed
            waiting.update()
        with waiting.stage("compile"):
            clock[0] += 1
            waiting.update()
        with waiting.stage("integrate"):
            clock[0] += 1
            waiting.update()
        assert terminal.getvalue().endswith(" \r")  # taken away
    waiting.update()
    assert lines(terminal) == [
        "chain: deriving the equations of motion, 2 s",
        "chain: deriving the equations of motion, 5 s",
        "chain: compiling, 1 s",
    ]
    assert terminal.getvalue().endswith(" \r") and Line.shown is None


def test_the_stages_of_a_run_are_shown_in_words(terminal, clock):
    waiting = Waiting("chain", quiet=False)
    watch = Stopwatch(waiting.stage)
    for stage in ("import", "parse", "derive", "program", "compile", "integrate", "write"):
        with watch.stage(stage):
            clock[0] += 3
            waiting.update()
    assert lines(terminal) == [
        "chain: loading modules, 3 s",
        "chain: reading the system file, 3 s",
        "chain: deriving the equations of motion, 3 s",
        "chain: writing the program, 3 s",
        "chain: compiling, 3 s",
    ]
    assert {*watch.seconds} == {"import", "parse", "derive", "compile", "cache", "integrate", "write"}


def test_the_time_left_of_a_stage_follows_from_what_is_done(terminal, clock):
    """At the rate so far; the elapsed time alone where nothing is known, or little is left."""
    waiting = Waiting("chain", quiet=False)
    with waiting.stage("derive"), portion(4) as work:
        for passed, done in (
            (3.0, None),
            (7.0, 1),
            (4.0, None),
            (6.0, 2),
            (10.0, 3),
            (8.0, None),
            (9.0, None),
        ):
            clock[0] += passed
            if done is not None:
                work.reach(done)
            waiting.update()
        with waiting.stage("import"):  # of which nothing is known
            clock[0] += 1.0
            waiting.update()
        work.reach(3.2)
        waiting.update()
    assert lines(terminal) == [
        f"chain: {text}"
        for text in (
            "deriving the equations of motion, 3 s",
            "deriving the equations of motion, 10 s, about 30 s left",
            "deriving the equations of motion, 14 s, about 30 s left",
            "deriving the equations of motion, 20 s, about 20 s left",
            "deriving the equations of motion, 30 s, about 10 s left",
            "deriving the equations of motion, 38 s",
            "deriving the equations of motion, 47 s",
            "loading modules, 1 s",
            "deriving the equations of motion, 48 s, about 10 s left",
        )
    ]
    assert latest() is None


def test_work_within_other_work_is_one_part_of_it(clock):
    with portion(4) as outer:
        outer.reach(1)
        with portion(10) as inner:
            clock[0] += 15
            inner.reach(5)
        assert latest() is outer
        assert outer.left(clock[0] + 1) == pytest.approx(24)  # 1.5 of 4 parts in 15 s


def test_compiling_says_how_long_llvm_is_going_to_take(terminal, clock, monkeypatch):
    """Its text is read in a known part of the time."""
    waiting = Waiting("chain", quiet=False)

    class Target:
        def emit_object(self, module):
            waiting.update()
            clock[0] += 6.0
            waiting.update()
            return b"code"

    def read(text):
        clock[0] += 4.0
        waiting.update()

    monkeypatch.setattr(llvm, "target_machine", lambda optimize: Target())
    monkeypatch.setattr(llvm.llvm, "parse_assembly", read)
    with waiting.stage("compile"):
        assert llvm.compile_text("", 0) == b"code"
    assert lines(terminal) == [
        "chain: compiling, 4 s",
        "chain: compiling, 4 s, about 20 s left",
        "chain: compiling, 10 s, about 10 s left",
    ]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(3.1, "5 s"), (7.4, "5 s"), (8, "10 s"), (44, "40 s"), (56, "1 min"), (150.1, "3 min"), (7100, "2 h")],
)
def test_estimates_have_no_more_digits_than_they_deserve(seconds, text):
    assert roughly(seconds) == f"about {text}"


def test_messages_take_the_line_away(terminal, clock, monkeypatch):
    monkeypatch.setattr("sys.stderr", terminal)
    line = MeasuringProgress("hoop", quiet=False)
    line.show(0, 2, "reference")
    complain("a warning")
    assert terminal.getvalue() == "\rhoop:   0%  reference\r" + " " * 21 + "\ra warning\n"


def test_a_process_that_ends_at_once_takes_its_line_away(terminal, clock):
    assert eraser() == b""
    line = MeasuringProgress("hoop", quiet=False)
    line.show(0, 2, "reference")
    assert eraser() == b"\r" + b" " * 21 + b"\r"
    line.clear()
    assert eraser() == b""


NAMES = {
    "short": "hoop",
    "long": "a long name " * 20,
    "wide": "振り子" * 30,
    "combining": "e\u0301" * 50,
    "control": "x\x1b[2J\ny",
}


@pytest.mark.parametrize("width", [0, 1, 5, 20, 40, 80, 300])
@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_a_line_fits_the_terminal(terminal, clock, monkeypatch, width, name):
    widths = [width]
    monkeypatch.setattr(terminal, "fileno", lambda: 2)
    monkeypatch.setattr(progress.os, "get_terminal_size", lambda fd: os.terminal_size((widths[0], 24)))
    line = Counter(name, 1000, "members", quiet=False)
    for done in (500, 600, 700, 800):
        clock[0] += 1
        line.show(done)
        shown = terminal.getvalue().split("\r")[-1]
        assert columns(shown) <= max(0, (widths[0] or 80) - 1)
        assert shown.replace(" ", "").isprintable()
        if widths[0] == 80:
            assert f"{done} of 1000 members" in shown  # the name is cut first
        widths[0] = max(1, widths[0] // 2)  # someone makes the window smaller
    so_far = len(terminal.getvalue())
    line.clear()
    assert all(columns(piece) < widths[0] for piece in terminal.getvalue()[so_far:].split("\r"))


def test_in_a_narrow_terminal_the_time_left_stays(terminal, clock, monkeypatch):
    width = [80]
    monkeypatch.setattr(terminal, "fileno", lambda: 2)
    monkeypatch.setattr(progress.os, "get_terminal_size", lambda fd: os.terminal_size((width[0], 24)))
    members = Counter("double pendulum", 4000, "members", quiet=False)
    motion = Progress("double pendulum", 0.0, 2e6, quiet=False)
    members.show(0)
    motion.show(0.0)
    for width[0], done in ((80, 1000), (62, 1001), (40, 1002), (24, 1003), (12, 1004)):
        clock[0] += 10
        members.show(done)
        motion.show(500.0 * done)
    assert lines(terminal) == [
        "double pendulum:  25%  1000 of 4000 members, 100 per second, 30 s left",
        "double pendulum:  25%  t = 500000 of 2e6, 30 s left",
        "double pendulum:  25%  1001 of 4000 members, 1 min 0 s left",
        "double pendulum:  25%  t = 500500 of 2e6, 1 min 0 s left",
        "double pendulum:  25%, 1 min 30 s left",
        "double pendulum:  25%, 1 min 30 s left",
        "25%, 2 min 0 s left",
        "25%, 2 min 0 s left",
        "25%, 2 min",
        "25%, 2 min",
    ]


def test_a_letter_takes_as_many_columns_as_it_is_wide():
    assert [columns(text) for text in ("θ", "振", "e\u0301", "ｗ", "")] == [1, 2, 1, 2, 0]


@pytest.mark.parametrize(("terminal", "quiet"), [(io.StringIO(), False), (Terminal(), True)])
def test_nothing_is_said_where_nobody_watches(monkeypatch, clock, terminal, quiet):
    monkeypatch.setattr("sys.stderr", terminal)
    line, waiting = Counter("hoop", 10, "members", quiet=quiet), Waiting("hoop", quiet=quiet)
    with waiting.stage("derive"):
        clock[0] += 10
        waiting.update()
        line.show(5)
        line.clear()
    assert terminal.getvalue() == ""


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.2, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (125, "2 min 5 s"), (12000, "3 h 20 min"),
        (3600 * 50, "2 d 2 h"), (1e10, "3.2e2 years"), (1e300, "3.2e292 years"), (math.inf, "1e300 years"),
    ],
)  # fmt: skip
def test_durations(seconds, text):
    assert duration(seconds) == text


SLOW_STAGES = """
import sys, time
from lagrange_cli.cli.main import main
from lagrange_cli.cli import progress

progress.PATIENCE, progress.DELAY = 0, 1e-3
enter, update = progress.Waiting._enter, progress.Waiting.update

def enter_and_wait(self, text, *began):
    before, self.said = enter(self, text, *began), False
    while text is not None and self._line.enabled and not self.said:
        time.sleep(1e-3)
    return before

def update_and_note(self):
    update(self)
    self.said = True

progress.Waiting._enter, progress.Waiting.update = enter_and_wait, update_and_note
sys.exit(main(sys.argv[1:]))
"""
"""The command, where every stage lasts until it has been shown."""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")
@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (("check", "PENDULUM"), "deriving the equations of motion, "),
        (("equations", "PENDULUM"), "deriving the equations of motion, "),
        (("solve", "PENDULUM", "--no-cache"), "compiling, "),
        (("sweep", "PENDULUM", "--over", "theta=0,1", "--no-cache"), "compiling, "),
        (("bench", "PENDULUM", "--methods", "taylor", "--tolerances", "1e-6", "--runs", "1"), "reference"),
    ],
    ids=lambda x: x[0] if isinstance(x, tuple) else "",
)
def test_every_command_says_what_it_does_on_a_terminal(tmp_path, monkeypatch, command, shown):
    """In a narrow pseudo-terminal, in which at the end nothing is left of what was shown."""
    import fcntl
    import struct
    import termios

    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 60, 0, 0))
    arguments = [str(SYSTEMS / "pendulum.yaml") if each == "PENDULUM" else each for each in command]
    said = bytearray()
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW_STAGES, *arguments],
        cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=slave,
    )  # fmt: skip
    os.close(slave)
    reading = threading.Thread(target=lambda: read_all(master, said))
    reading.start()
    out, _ = process.communicate(timeout=PATIENCE)
    reading.join(PATIENCE)
    os.close(master)
    text = said.decode()
    assert process.returncode == 0, text
    assert out and b"\r" not in out
    pieces = text.split("\r")
    assert any(shown in piece for piece in pieces), text
    assert all(len(piece) < 60 for piece in pieces) and "\n" not in text
    assert pieces[-1] == "" and not pieces[-2].strip()


def read_all(master: int, said: bytearray) -> None:
    """What comes out of a pseudo-terminal, until nobody has it open any more."""
    with suppress(OSError):
        while piece := os.read(master, 65536):
            said.extend(piece)
