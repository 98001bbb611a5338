"""Errors in a Python program name its arguments, not the options of the command line."""

from __future__ import annotations

import inspect

import pytest

import lagrange_cli as lagrange
from lagrange_cli.api.words import python_words
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"
FREE = {"coordinates": {"x": {"initial": 1}}, "lagrangian": "x_dot**2/2"}

MISTAKES = {
    "no end": (lambda: lagrange.solve(FREE), "no stop time given: add stop=10, or 'solve: {stop: 10}'"),
    "unknown": (lambda: lagrange.solve(PENDULUM, stop="soon"), "stop soon: unknown name 'soon'; known: m, g"),
    "value": (
        lambda: lagrange.solve(PENDULUM, set={"l": "2 m"}),
        "set l=2 m: number with a unit; write 2, or",
    ),
    "both": (
        lambda: lagrange.solve(PENDULUM, samples=5, step=1),
        "samples and step both set the sample times",
    ),
    "draws": (lambda: lagrange.sweep(PENDULUM, random={"l": ("normal", 1, 1)}), "add members=1000"),
    "tolerance": (lambda: lagrange.bench(PENDULUM, tolerances=["a"]), "tolerances must be a number, not 'a'"),
}


@pytest.mark.parametrize(("call", "message"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_told_in_words_of_python(call, message):
    with pytest.raises(lagrange.UsageError) as caught:
        call()
    assert message in str(caught.value) and "--" not in str(caught.value)


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    motion = lagrange.solve(PENDULUM, stop=1)
    motion.save(tmp_path / "a.h5")
    with pytest.raises(
        lagrange.FileError, match="already exists: force=True replaces it, or give another name"
    ):
        motion.save(tmp_path / "a.h5")
    with pytest.raises(lagrange.FileError, match="is a directory, not an output"):
        lagrange.load(tmp_path)


def test_expressions_stay_as_they_are():
    assert python_words("--set l=1--l: unknown name") == "set l=1--l: unknown name"
    assert python_words("a--b - --project-initial") == "a--b - project_initial"


def test_the_signatures_are_those_of_the_functions():
    assert [*inspect.signature(lagrange.solve).parameters][:2] == ["system", "set"]


RESULTS = {
    "solve": lambda: lagrange.solve(PENDULUM, stop=1),
    "grid": lambda: lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1),
    "draws": lambda: lagrange.sweep(PENDULUM, random={"l": ("uniform", 1, 2)}, members=3, stop=1),
    "table": lambda: lagrange.sweep(PENDULUM, table={"l": [1, 2]}, stop=1),
    "section": lambda: lagrange.section(PENDULUM, where="theta", crossings=2),
}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("made", RESULTS.values(), ids=RESULTS)
def test_a_result_is_shown_without_options(made):
    assert "--" not in f"{made()} {made()!r}"


FALL = {"coordinates": {"x": {"initial": 1}}, "lagrangian": "x_dot**2/2 + 1/x", "solve": {"stop": 2}}


def test_a_motion_that_ends_is_explained_in_words_of_python(tmp_path):
    with pytest.raises(lagrange.MotionError, match="end the run before it with stop, or") as caught:
        lagrange.solve(FALL)
    motion = caught.value.result
    motion.save(tmp_path / "fall.h5")
    for message in (str(caught.value), motion.message, lagrange.load(tmp_path / "fall.h5").message):
        assert "--" not in message
    assert "--stop" in motion.attributes["message"]  # as in the file that the command writes


def test_a_wrong_system_is_explained_in_words_of_python():
    free = {"coordinates": {"x": None}, "lagrangian": "x_dot**2/2"}
    with pytest.raises(lagrange.SpecError) as caught:
        lagrange.solve(free, stop=1)
    assert caught.value.problems[0].hint == "write x: {initial: 0.1}, or set={'x': 0.1}"
    assert caught.value.problems[0].hint in str(caught.value)


@pytest.mark.parametrize("draw", [lagrange.plot, lagrange.animate], ids=["plot", "animate"])
def test_a_system_is_no_result(draw):
    with pytest.raises(lagrange.UsageError, match=r"is a system file, not an output: give what"):
        draw(PENDULUM)
