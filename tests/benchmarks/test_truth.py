"""The truth suite: its references, and that what is wrong is called wrong."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import pytest

from benchmarks.truth.case import MP
from benchmarks.truth.course import Course
from benchmarks.truth.drawing import FAMILIES, cases
from benchmarks.truth.judge import REFUSED, RIGHT, WRONG, judge, verdict
from benchmarks.truth.known import Known
from benchmarks.truth.pieces import Exit, Linear, pieces, to
from benchmarks.truth.roots import root_of
from benchmarks.truth.running import SOLVE, Ran, command, run


@pytest.fixture(scope="module")
def pendulum():
    """A case that is right."""
    return next(cases(5, 1, ["pendulum"]))


def judged(case, folder: Path, change: float = 0.0, ended: int = 0, **told):
    """What is thought of a run of the case whose x at the end is changed, and which says what is told."""
    ran = run(command(case, SOLVE, write(case, folder)), folder)
    output = folder / f"{case.name}-{SOLVE}.h5"
    with h5py.File(output, "r+") as file:
        file["q/x"][-1] += change
    said = {**json.loads(ran.printed), **told}
    return verdict(case, SOLVE, Ran(ended, json.dumps(said), ""), output, Known(case))


def write(case, folder: Path) -> Path:
    file = folder / f"{case.name}.yaml"
    file.write_text(case.text)
    return file


@pytest.mark.exhaustive(keep=0)
def test_what_is_off_is_wrong(pendulum, tmp_path):
    assert judged(pendulum, tmp_path).verdict == RIGHT
    off = judged(pendulum, tmp_path, 1e-6)
    assert (off.verdict, off.because.partition("(")[0]) == (WRONG, "q/x")
    assert judged(pendulum, tmp_path, float("nan")).verdict == WRONG


@pytest.mark.exhaustive(keep=0.2)
def test_a_false_claim_is_wrong(pendulum, tmp_path):
    assert judged(replace(pendulum, h=False), tmp_path).because.startswith("h is said to be conserved")
    assert "p_x is said" in judged(pendulum, tmp_path, p_drift={"x": 0.0}).because
    assert "warning" in judged(pendulum, tmp_path, warning="it may all be wrong").because


@pytest.mark.exhaustive(keep=0.25)
def test_a_refusal_must_be_true(pendulum, tmp_path):
    said = "the steps are too short at t = 20; ..."
    assert judged(pendulum, tmp_path, ended=4, status="failed", message=said).verdict == REFUSED
    false = "a collision at t = 20; ..."
    assert judged(pendulum, tmp_path, ended=4, status="failed", message=false).verdict == WRONG
    refused = Ran(3, json.dumps({"message": "pendulum.yaml:3: unknown"}), "")
    assert verdict(pendulum, SOLVE, refused, tmp_path, Known(pendulum)).verdict == REFUSED
    assert verdict(pendulum, SOLVE, Ran(None, "", ""), tmp_path, Known(pendulum)).verdict == WRONG
    assert verdict(pendulum, SOLVE, Ran(1, "", "Traceback"), tmp_path, Known(pendulum)).verdict == WRONG


@pytest.mark.exhaustive(keep=0.5)
def test_an_end_must_be_where_it_is(tmp_path):
    case = next(cases(5, 1, ["vanishing_mass"]))
    end = float(case.truth([MP.mpf(0)]).ends)
    assert judge(case, [SOLVE], tmp_path)[0].verdict == RIGHT
    early = judged(case, tmp_path, ended=4, t=end * 0.99)
    assert (early.verdict, early.because.partition(" at")[0]) == (WRONG, "ended")
    assert "does not say when" in judged(case, tmp_path, ended=4, message="it ends").because
    assert "but the motion ends" in judged(case, tmp_path, status="complete").because


def test_a_linear_law_satisfies_its_equation():
    law = Linear(
        f=MP.mpf("0.3"),
        k=MP.mpf(2),
        c=MP.mpf("0.4"),
        a=MP.mpf("0.7"),
        w=MP.mpf("1.3"),
        phi=1,
        g=MP.mpf("0.1"),
    )
    for one in (law, replace(law, k=0), replace(law, k=0, c=0), replace(law, c=MP.mpf(5)), replace(law, c=0)):
        x, v = one.at(MP.mpf(1), MP.mpf("0.2"), MP.mpf("0.5"), MP.mpf("0.5"))
        assert abs(x - 1) + abs(v - MP.mpf("0.2")) < MP.mpf(10) ** -35
        t = MP.mpf(2)
        x, v = one.at(MP.mpf(1), MP.mpf("0.2"), MP.mpf("0.5"), t)
        with MP.workdps(60):
            rate = MP.diff(lambda s, one=one: one.at(MP.mpf(1), MP.mpf("0.2"), MP.mpf("0.5"), s)[1], t)
        force = one.f + one.g * t - one.k * x - one.c * v + one.a * MP.cos(one.w * t + one.phi)
        assert abs(rate - force) < MP.mpf(10) ** -15


def test_pieces_find_every_exit():
    """A wedge: parabolas, a quarter period of sqrt(2) each."""
    found = pieces(
        1, [MP.mpf(1)], [MP.mpf(0)], lambda mode, q, v, t: [Linear(f=-mode)],
        lambda mode: [Exit(lambda q, v, t: mode * q[0], to(-mode), "turn")], MP.mpf(20),
    )  # fmt: skip
    assert len(found.events) == 7
    for k, (_, t, _, _) in enumerate(found.events):
        assert abs(t - (2 * k + 1) * MP.sqrt(2)) < MP.mpf(10) ** -30


def test_the_time_of_an_oscillation_is_its_integral():
    turn = root_of(lambda x: x**2 - 4, MP.mpf(0), MP.mpf(5))
    course = Course(lambda x: x**2 / 2, MP.mpf(0), MP.mpf(2), turn=turn)
    assert abs(course.time_to_turn() - MP.pi / 2) < MP.mpf(10) ** -32
    for t in (MP.mpf(1), MP.mpf(3)):
        x, v = course.at(t)
        assert abs(x - 2 * MP.sin(t)) + abs(v - 2 * MP.cos(t)) < MP.mpf(10) ** -31


@pytest.mark.exhaustive(keep=0.2)
def test_there_are_enough_cases_and_their_names_differ():
    names = [case.name for case in cases(1)]
    assert len({*names}) == len(names) >= 200
    assert len(FAMILIES) >= 10


def test_a_seed_repeats_its_cases():
    first, again, other = ([case.text for case in cases(seed, 1, ["walls"])] for seed in (1, 1, 2))
    assert first == again != other
