"""The line that says how far a run has come."""

import io

import pytest

from lagrange_cli.cli import progress
from lagrange_cli.cli.progress import MembersProgress, Progress, duration


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass as the test says."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def lines(terminal: io.StringIO) -> list[str]:
    return [line.strip() for line in terminal.getvalue().split("\r") if line.strip()]


def test_members_their_rate_and_the_time_left(monkeypatch, clock):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    line = MembersProgress("hoop", 1000, quiet=False)
    for passed, done in ((0.1, 10), (0.9, 0), (1.0, 250), (0.1, 260), (2.0, 500)):
        clock[0] += passed
        line.show(done)
    line.clear()
    assert lines(terminal) == [
        "hoop:   0%  0 of 1000 members, 0 a second",
        "hoop:  25%  250 of 1000 members, 125 a second, 6 s left",
        "hoop:  50%  500 of 1000 members, 122 a second, 4 s left",
    ]
    assert terminal.getvalue().endswith("\r")


def test_the_time_reached(monkeypatch, clock):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    line = Progress("hoop", 1.0, 5.0, quiet=False)
    clock[0] += 1
    line.show(2.0)
    assert lines(terminal) == ["hoop:  25%  t = 2 of 5"]


@pytest.mark.parametrize(("terminal", "quiet"), [(io.StringIO(), False), (Terminal(), True)])
def test_nothing_is_said_where_nobody_watches(monkeypatch, clock, terminal, quiet):
    monkeypatch.setattr("sys.stderr", terminal)
    line = MembersProgress("hoop", 10, quiet=quiet)
    clock[0] += 10
    line.show(5)
    line.clear()
    assert terminal.getvalue() == ""


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (125, "2 min 5 s"), (12000, "3 h 20 min")],
)
def test_durations(seconds, text):
    assert duration(seconds) == text
