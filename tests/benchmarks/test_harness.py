"""How benchmarks measure, and what they conclude."""

import sys
from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness.growth import binned, growth_exponent
from benchmarks.harness.processes import run_process
from benchmarks.harness.report import Report, Requirement, markdown_table, replaced_section
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns, processor_seconds
from benchmarks.peers.comparison import Measurement, comparison_table, medians


@pytest.mark.parametrize(
    ("value", "relation", "bound", "met"),
    [
        (1.0, "<", 1.0, False),
        (1.0, "<=", 1.0, True),
        (1.0, ">=", 1.0, True),
        (0.9, ">=", 1.0, False),
        (float("nan"), "<=", 1.0, False),
        (float("nan"), ">=", 1.0, False),
    ],
)
def test_a_figure_is_reached_if_its_relation_holds(value, relation, bound, met):
    requirement = Requirement("speed", value, relation, bound)
    assert requirement.met is met
    report = Report(("a table",), (requirement,))
    assert report.missed == (() if met else (requirement,))
    assert ("| NO" in report.text(())) is not met


def test_columns_are_as_wide_as_their_widest_cell():
    assert markdown_table(("a", "b"), [("long", "1")]).splitlines() == [
        "| a    | b |",
        "| ---- | - |",
        "| long | 1 |",
    ]


def test_a_section_is_replaced_and_nothing_else():
    document = (
        "# T\n\n<!-- one -->\nold\n<!-- end of one -->\n\n<!-- two -->\nkept\n<!-- end of two -->\nend\n"
    )
    once = replaced_section(document, "one", "new")
    assert once == document.replace("old", "\nnew\n")
    assert replaced_section(once, "one", "new") == once
    with pytest.raises(ValueError, match="no section 'three'"):
        replaced_section(document, "three", "new")


def test_turns_alternate():
    log = []
    results = in_turns({name: lambda name=name: log.append(name) or len(log) for name in "ab"}, 3)
    assert log == list("ababab")
    assert results == {"a": [1, 3, 5], "b": [2, 4, 6]}


def test_a_short_call_is_measured_many_times():
    calls = []
    spent = processor_seconds(lambda: calls.append(sum(range(10_000))))
    assert len(calls) > 1
    assert 0 < spent < 0.05


def test_medians_over_turns_and_ratios_to_ours():
    runs = [Measurement(seconds, 10 * seconds, 7, seconds / 8) for seconds in (1.0, 5.0, 2.0)]
    middle = medians(runs)
    assert middle == Measurement(2.0, 20.0, 7, 5 / 8)
    table = comparison_table({"ours": middle, "theirs": Measurement(4.0, 60.0, 9, 1e-12)}, "ours")
    assert [cell.strip() for cell in table.splitlines()[-1].split("|")[1:-1]] == [
        *("theirs", "4000", "2.0", "60000.0", "3.0", "9", "1.0e-12")
    ]


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_growth_of_a_power_of_time_is_its_exponent(exponent):
    times = np.linspace(0.01, 1.0, 2000)
    periods, errors = binned(times, (3.0 * times**exponent) ** 2, 30)
    assert growth_exponent(periods, errors) == pytest.approx(exponent, abs=0.01)
    assert np.all(np.diff(periods) > 0)


def test_bins_hold_every_sample_once():
    times, squares = np.arange(1.0, 1001.0), np.arange(1000.0)
    for bins in (1, 7):
        centres, _ = binned(times, squares, bins)
        assert len(centres) == bins
    assert binned(times, squares, 1)[1] == pytest.approx([np.sqrt(squares.mean())])


def test_a_process_says_what_it_printed_and_how_it_ended(tmp_path: Path) -> None:
    code = "import sys; print('out'); print('err', file=sys.stderr); sys.exit(3)"
    ended = run_process(("-c", code), tmp_path, {}, seconds=60.0, memory=4 << 30)
    assert (ended.status, ended.printed, ended.errors) == (3, "out\n", "err\n")
    assert ended.memory > 0


def test_a_process_over_its_limit_is_ended(tmp_path: Path) -> None:
    ended = run_process(("-c", "import time; time.sleep(600)"), tmp_path, {}, seconds=0.2)
    assert ended.status is None


def test_a_program_that_is_not_installed_is_reported_plainly(capsys: pytest.CaptureFixture[str]) -> None:
    measure = sys.modules[__name__].test_turns_alternate
    suite = Suite("speed", measure, packages=("numpy", "no-such-program"), runs=1)
    assert suite.main([]) == 1
    assert capsys.readouterr().err == "speed needs no-such-program: pip install '.[bench]'\n"


def test_a_suite_measures_the_parts_that_are_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    def measure(options: Namespace) -> Report:
        return Report(tuple(part for part in ("hoop", "pendulum") if options.only in part), ())

    one = Suite("some", measure, packages=(), runs=1, parts=("hoop", "pendulum"))
    assert one.main(["--only", "pend"]) == 0
    assert "pendulum" in (text := capsys.readouterr().out) and "hoop" not in text
    for wrong, message in (
        (["--only", "x"], "there are hoop, pendulum"),
        (["--only", "h", "--write"], "--write"),
    ):
        with pytest.raises(SystemExit):
            one.main(wrong)
        assert message in capsys.readouterr().err
