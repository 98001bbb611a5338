"""System files from the fuzzer's grammar: every command ends as documented, and touches nothing else."""

from __future__ import annotations

import os
import signal
from contextlib import redirect_stderr, redirect_stdout, suppress
from random import Random

import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lagrange_cli.cli.main import main
from tests.fuzzing import fuzz, grammar, growth


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of the test's own, where faults show themselves."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAGRANGE_DEBUG", "1")
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    monkeypatch.setattr(
        fuzz, "PATIENCE", 1
    )  # what would take long is interrupted soon, and has as long to end
    return tmp_path


@pytest.mark.parametrize("text", ["1 + 1", "__import__('os').getcwd()", ("x", "y")])
def test_the_guard_sees_what_sympy_runs(text):
    with fuzz.GUARD.watching(), suppress(TypeError, ValueError, SyntaxError, sympy.SympifyError):
        sympy.sympify(text)
    seen, fuzz.GUARD.seen = fuzz.GUARD.seen, []
    assert any(one.startswith("sympy runs") for one in seen)


@pytest.mark.exhaustive(keep=0.15)
@settings(
    max_examples=12, derandomize=True, deadline=None, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(st.integers(0, 2**63))
def test_whatever_the_file_says(folder, seed):
    statuses = fuzz.feed(grammar.system(Random(seed)).encode(errors="replace"))
    assert set(statuses) <= set(fuzz.DOCUMENTED)
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}


@pytest.mark.exhaustive(keep=0)
@settings(
    max_examples=4, derandomize=True, deadline=None, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(st.integers(0, 2**63))
def test_what_grows(folder, seed):
    """Files that ask for a lot of work, little of which is allowed; ``hostile`` allows all of it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAGRANGE_LIMITS", "work=300000,printed=3000")
        statuses = fuzz.feed(growth.system(Random(seed))[1].encode())
    assert set(statuses) <= set(fuzz.DOCUMENTED)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    "path", sorted((fuzz.ROOT / "tests" / "fuzzing" / "corpus").glob("*.yaml")), ids=lambda path: path.stem
)
def test_what_was_found_before(folder, path):
    fuzz.feed(path.read_bytes())
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}


@pytest.mark.exhaustive(keep=2, most=100)
@pytest.mark.parametrize("name", sorted(fuzz.kept_inputs()))
def test_some_of_what_the_fuzzer_kept(folder, name):
    """Inputs that reach different code; all of them are where the next run of the fuzzer begins."""
    assert set(fuzz.feed(fuzz.kept_inputs()[name])) <= set(fuzz.DOCUMENTED)
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}


@pytest.mark.exhaustive(keep=0.25)
@settings(
    max_examples=20, derandomize=True, deadline=None, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(st.integers(0, 2**63))
def test_check_refuses_what_solve_refuses_in_the_same_words(folder, seed):
    (folder / "input.yaml").write_bytes(grammar.system(Random(seed)).encode(errors="replace"))
    refused = {}
    for command in (["check"], ["solve", "--stop", "1e-3", "--samples", "2", "-o", "out.h5", "--force"]):
        said = fuzz.Stream()
        with redirect_stdout(fuzz.Stream()), redirect_stderr(said):
            status = main([*command, "--quiet", "input.yaml"])
        refused[command[0]] = (status == 3, said.getvalue() if status == 3 else "")
    assert refused["check"] == refused["solve"]


def test_an_interrupt_of_which_nothing_would_come_is_repeated():
    """What is raised in a callback of the garbage collector is ignored; hypothesis has one."""

    def gc_callback() -> None:
        signal.raise_signal(signal.SIGPROF)

    reached = False
    with pytest.raises(KeyboardInterrupt), fuzz.limited():
        gc_callback()
        reached = True
        while True:
            pass
    assert reached


MISTAKES = """\
parameters: {k: 2, m: 1 kg}
constants: {g: 9.81}
coordinates: {x: {initial: 30 deg}, y: {velocity: 1}, z: {initial: 0}}
masses: {p: m, q: -1}
positions: {p: [x, y], q: [z, thta^2]}
potential: k*xdot**2 + m g*ln(p.y) + g*sin(x, y)
solve: {stop: 0, method: rk4, samples: 3, step: 1, outputs: [hh]}
"""


@pytest.mark.parametrize("command", ["check", "solve", "equations", "sweep", "bench"])
def test_all_mistakes_of_a_file_at_once(folder, command):
    (folder / "input.yaml").write_text(MISTAKES)
    said = fuzz.Stream()
    with redirect_stdout(fuzz.Stream()), redirect_stderr(said):
        status = main([command, "input.yaml", *(("--over", "k=1:2:3") if command == "sweep" else ())])
    found = [line.split(": ")[0] for line in said.getvalue().splitlines() if line.startswith("input.yaml:")]
    places = [
        "1:23", "2:1", "3:28", "3:37", "4:19", "5:31", "5:35", "6:14", "6:24", "6:28", "6:40",
        "7:15", "7:26", "7:49", "7:62",
    ]  # fmt: skip
    missing = {"equations": {"3:37"}, "sweep": {"3:37", "4:19"}}.get(command, set())
    assert status == 3
    assert found == [f"input.yaml:{place}" for place in places if place not in missing]


def test_a_mass_below_zero_is_named_in_any_precision(folder, capsys):
    (folder / "input.yaml").write_text(
        "coordinates: {x: {initial: 1}}\nparameters: {m: -1/3}\nmasses: {a: m}\npositions: {a: [x]}\n"
        "solve: {stop: 1}\n"
    )
    for precision in ("double", "double-double"):
        assert main(["solve", "input.yaml", "--precision", precision]) == 3
        assert "the value -0.333333 is not positive" in capsys.readouterr().err
