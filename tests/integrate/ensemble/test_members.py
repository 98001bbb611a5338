"""What becomes of the members of an ensemble, whatever the order in which an engine lets them end.

The engine here is a stand-in whose motions are known: q = q0 + t v0, v = v0, and it may fail or be stopped.
"""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble import datasets, follow
from lagrange_cli.integrate.ensemble.follow import follow_ensemble
from lagrange_cli.integrate.ensemble.method import EndedMembers
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass
from lagrange_cli.spec.ensemble import resolve_ensemble
from lagrange_cli.spec.spec import grouped
from tests.support.motion import prepared, spec_of

FREE = """
parameters: {m: 2.0}
coordinates: {u[i in range(2)]: {initial: i}}
masses: {p[i in range(2)]: m}
embedding: {p[i in range(2)]: u[i]}
potential: 0
"""
MEMBERS = 40
TIMES = Times(0.0, 3.0, 4, 1.0)


@dataclass(frozen=True)
class StandIn:
    """Ends the members in batches, in an order of its own; ``failing`` ones half way."""

    order: tuple[int, ...] = ()
    batch: int = 7
    failing: frozenset[int] = frozenset()

    def follow(self, starts, accept, watch, threads):
        states, times = starts.states, starts.times
        order = [i for i in self.order if i < len(states)] or range(len(states))
        when = times.chunk(0, times.count)
        for start in range(0, len(states), self.batch):
            if watch(start):
                return False
            index = np.array(order[start : start + self.batch])
            failed = np.array([i in self.failing for i in index])
            t = np.where(failed, times.stop / 2, times.stop)
            q, v = states[index, :2], states[index, 2:4]
            samples = None
            if starts.sampled:
                samples = np.stack([*(q[:, i, None] + v[:, i, None] * when for i in (0, 1)),
                                    *(v[:, i, None] + 0 * when for i in (0, 1))], axis=1)  # fmt: skip
                samples[(when > t[:, None])[:, None].repeat(4, axis=1)] = np.nan
            accept(
                EndedMembers(
                    index=index,
                    ending=[Ending.NOT_A_NUMBER if x else Ending.COMPLETE for x in failed],
                    t=t,
                    state=np.concatenate([q + v * t[:, None], v], axis=1),
                    steps=index + 1,
                    samples=samples,
                    reached=(when <= t[:, None]).sum(axis=1),
                )
            )
        return True


OUTPUTS = ("q", "v", "p", "h", "energy", "positions")


def run(method, *, sampled=False, watch=lambda done: False, count=MEMBERS):
    """What was emitted by path, all members together; how often; and the outcome."""
    spec = spec_of(FREE)
    speeds = np.linspace(-1, 1, count)
    values = resolve_ensemble(spec, {}, {"u_dot[1]": speeds, "m": speeds + 2})
    families = grouped([one.name for one in spec.coordinates], spec.families["coordinates"])
    found, pieces = {}, []

    def emit(index, values):
        pieces.append(len(index))
        for path, rows in values.items():
            whole = found.setdefault(path, np.zeros((count, *rows.shape[1:]), dtype=rows.dtype))
            assert not whole[index].any(), "a member is written once"
            whole[index] = rows

    outcome = follow_ensemble(
        prepared(FREE, outputs=OUTPUTS),
        method,
        values,
        families,
        TIMES,
        emit,
        watch,
        sampled=sampled,
        threads=1,
    )
    return found, pieces, outcome


def test_every_member_gets_its_own_values():
    found, _, outcome = run(StandIn())
    v, m = np.linspace(-1, 1, MEMBERS), np.linspace(1, 3, MEMBERS)
    np.testing.assert_array_equal(found["parameters/m"], v + 2)
    np.testing.assert_array_equal(found["initial/q/u"], [[0, 1]] * MEMBERS)
    np.testing.assert_array_equal(found["initial/v/u"], np.stack([0 * v, v], axis=1))
    np.testing.assert_array_equal(found["q/u"], np.stack([0 * v, 1 + 3 * v], axis=1))
    np.testing.assert_allclose(found["diagnostics/p/u"][:, 1], m * v, rtol=1e-15)
    np.testing.assert_allclose(found["diagnostics/h"], m * v**2 / 2, rtol=1e-15)
    np.testing.assert_array_equal(found["positions/p"][:, :, 0], found["q/u"])
    assert (found["t_end"] == 3).all() and set(found["status"]) == {b"complete"}
    assert outcome.steps == MEMBERS * (MEMBERS + 1) // 2
    assert (outcome.status, outcome.h_drift, outcome.failed) == ("complete", 0.0, None)
    assert outcome.p_drift == {"u[0]": 0.0, "u[1]": 0.0}


@pytest.mark.parametrize("sampled", [False, True])
def test_neither_the_order_nor_the_batches_change_anything(sampled):
    failing = frozenset({3, 4, 31})
    expected, _, first = run(StandIn(failing=failing), sampled=sampled)
    order = tuple(np.random.default_rng(2).permutation(MEMBERS).tolist())
    for batch in (1, 3, 40):
        found, _, outcome = run(StandIn(order, batch, failing), sampled=sampled)
        assert {path: rows.tobytes() for path, rows in found.items()} == {
            path: rows.tobytes() for path, rows in expected.items()
        }
        assert (outcome.failed, outcome.steps) == (first.failed, first.steps)


def test_members_that_fail_are_kept_up_to_there_and_the_first_is_told():
    found, _, outcome = run(StandIn(batch=3, failing=frozenset({31, 5})), sampled=True)
    assert outcome.status == "failed" and outcome.count("failed") == 2
    member, message = outcome.failed
    assert member == 5
    assert message.startswith(f"{Ending.NOT_A_NUMBER.value} at t = 1.5, where u[0] = 0, u[1] = ")
    assert found["status"][5] == b"failed" and found["t_end"][5] == 1.5
    assert np.isfinite(found["q/u"][5, :2]).all() and np.isnan(found["q/u"][5, 2:]).all()
    assert np.isfinite(found["q/u"][6]).all()


@pytest.mark.parametrize("sampled", [False, True])
def test_members_that_were_not_followed_are_nan(sampled):
    found, _, outcome = run(StandIn(batch=7), sampled=sampled, watch=lambda done: done >= 14)
    assert outcome.status == "interrupted"
    assert (outcome.count("complete"), outcome.count("interrupted")) == (14, MEMBERS - 14)
    assert found["status"].tolist() == [b"complete"] * 14 + [b"interrupted"] * (MEMBERS - 14)
    assert np.isfinite(found["q/u"][:14]).all() and np.isnan(found["q/u"][14:]).all()
    assert np.isnan(found["t_end"][14:]).all() and np.isnan(found["diagnostics/h"][14:]).all()
    assert np.isfinite(found["initial/q/u"]).all() and outcome.h_drift == 0.0


def test_a_member_that_its_engine_calls_interrupted_counts_as_not_followed():
    class Hasty:
        def follow(self, starts, accept, watch, threads):
            ones = np.ones(2)
            ends = [Ending.COMPLETE, Ending.INTERRUPTED]
            accept(
                EndedMembers(np.array([0, 1]), ends, ones, starts.states[:2], np.array([1, 1]), None, ones)
            )
            return False

    found, _, outcome = run(Hasty(), count=3)
    assert found["status"].tolist() == [b"complete", b"interrupted", b"interrupted"]
    assert np.isnan(found["q/u"][1]).all() and outcome.steps == 1


def test_an_ensemble_is_laid_out_and_written_in_parts(monkeypatch):
    whole, _, _ = run(StandIn(batch=4), sampled=True)
    monkeypatch.setattr(datasets, "MEMORY", 10_000)
    monkeypatch.setattr(follow, "MEMORY", 10_000)
    monkeypatch.setattr(follow, "FEWEST", 16)
    heard = []
    found, pieces, outcome = run(
        StandIn(batch=4), sampled=True, watch=lambda done: heard.append(done) or False
    )
    assert {path: rows.tobytes() for path, rows in found.items()} == {
        path: rows.tobytes() for path, rows in whole.items()
    }
    rows = 8 * TIMES.count * (4 + 2 * len(prepared(FREE, outputs=OUTPUTS).machine.program.observed))
    assert max(pieces) <= max(10_000 / rows + 4, 10_000 / 8 / 5) and len(pieces) > MEMBERS / 16
    assert heard == sorted(heard) and outcome.status == "complete"
