"""Large systems that are refused before they are derived: what is foreseen is always done."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from lagrange_cli.errors import SpecError, TooLargeSystem, TooManyNumbers
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.limits import Work
from lagrange_cli.model.start.shortest import Blocks
from lagrange_cli.run import derive
from lagrange_cli.run.check import classify
from lagrange_cli.run.foresight import MARGIN, STEP, alike, foresee_sizes, least, smaller_sizes, step_of
from lagrange_cli.run.prepare import foresee_matrices, measures_of, named
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from tests.support.motion import SYSTEMS

BEADS = """
sizes: {N: 60}
parameters: {mu: 0.3}
coordinates: {"x[i in range(N)]": {initial: 0.1*i}}
masses: {"b[i in range(N)]": 1}
embedding: {"b[i in range(N)]": "x[i]"}
potential: "sum((x[i] - x[i - 1])**2/2 for i in range(1, N))"
"""
FRICTION = BEADS + "generalized_forces:\n  x[i in range(N - 1)]: -mu*sign(x_dot[i] - x_dot[i + 1])\n"
IMPACTS = BEADS + (
    'events:\n  blow[i in range(N - 1)]: {when: "x[i] - x[i + 1] + 9", direction: falling, '
    'action: {set: {"x_dot[i]": "(x_dot[i] + 3*x_dot[i + 1])/4", '
    '"x_dot[i + 1]": "(3*x_dot[i] + x_dot[i + 1])/4"}}}\n'
)
SOME = BEADS + "  + sum(sin(x[i])**3 for i in range(N) if i % 5 == 0 or i % 7 == 1)\n"
SOME = SOME.replace('N))"\n  + ', "N)) + ").replace("== 1)\n", '== 1)"\n')
SLEDGES = """
sizes: {N: 60}
coordinates:
  {"x[i in range(N)]": {initial: i}, "y[i in range(N)]": {initial: 0}, "a[i in range(N)]": {initial: 0.1}}
masses: {"s[i in range(N)]": 1, "r[i in range(N)]": 1}
embedding:
  s[i in range(N)]: ["x[i]", "y[i]"]
  r[i in range(N)]: ["x[i] + cos(a[i])", "y[i] + sin(a[i])"]
nonholonomic: {"blade[i in range(N)]": "x_dot[i]*sin(a[i]) - y_dot[i]*cos(a[i])"}
"""
TIED = SLEDGES.replace("x_dot[i]*sin(a[i])", "x_dot[i]*sin(sum(a[j] for j in range(N)))")
TEXTS = {
    "friction": FRICTION, "impacts": IMPACTS, "some": SOME, "sledges": SLEDGES,
    "pendulums": (SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8"),
}  # fmt: skip

EQUATIONS = derive.derive_system(read_spec(BEADS, "beads.yaml", {"N": "3"}))


def taken(spec: Spec) -> Work:
    """The work of a derivation."""
    numbers = derive.algebra_of(spec, exact=False, portable=False)()
    derive._derived(spec, numbers, resting=True)
    return numbers.graph.work


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", sorted(TEXTS))
def test_what_is_foreseen_is_done(name: str) -> None:
    """For twice the largest of the smaller sizes."""
    text, size = TEXTS[name], 2 * smaller_sizes(STEP)[-1]
    assert alike(text)
    found = [taken(read_spec(text, "system.yaml", {"N": f"{n}"})) for n in (*smaller_sizes(STEP), size)]
    for values in ([one.spent - one.tried for one in found], [one.nodes - one.tried_nodes for one in found]):
        *few, last = values
        foreseen = least(few, size, even="%" not in text) / MARGIN
        assert 0.2 * last < foreseen < last


@pytest.mark.parametrize("power", [1, 2, 3])
def test_growth_is_foreseen_from_below(power: int) -> None:
    found = least([n**power for n in smaller_sizes(STEP)], 5000, even=True)
    assert 0.01 * 5000**power < found < 5000**power * (1 + 1e-12)
    assert least([int(n**0.5 * 100) for n in smaller_sizes(STEP)], 5000, even=True) == 0.0


@pytest.mark.parametrize("period", range(2, STEP))
@pytest.mark.parametrize("first", range(3))
def test_members_here_and_there_are_not_overestimated(period: int, first: int) -> None:
    counts = [len(range(first, n, period)) for n in smaller_sizes(STEP)]
    assert least(counts, 5000, even=False) / MARGIN <= len(range(first, 5000, period))


def test_files_with_large_numbers_beside_indices_are_derived() -> None:
    for text in (
        "sum(x[i] for i in range(100))",
        "where(i < 40, 1, 0)",
        "x[17]",
        "sum(i for i in a if i > 30)",
    ):
        assert not alike(text)
    assert not alike("where(i < 5, 1, 0)", step=4)
    assert alike("[1.0e-4, 2e17, x[i - 1]]", step=4)
    assert alike("sum(9810*x[i - 1] for i in range(1, N) if i % 2 == 0)  # [100]")


def test_a_large_system_is_refused_from_small_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGE_LIMITS", "work=50000")
    derived: list[int] = []
    plain = derive._derived

    def seen(spec: Spec, *given: object) -> object:
        derived.append(len(spec.coordinates))
        return plain(spec, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(derive, "_derived", seen)
    spec = read_spec(BEADS, "beads.yaml", {"N": "5000"})
    with pytest.raises(TooLargeSystem, match="takes more than 50000 steps of work"):
        derive.derive_system(spec)
    assert derived == [*smaller_sizes(STEP)]


def test_smaller_systems_have_few_members_with_many_coordinates() -> None:
    assert [step_of("x[i - 1]", each) for each in (1, 2, 3, 6)] == [12, 6, 4, 4]
    assert step_of("x[i - 6]", 3) == 7
    assert step_of("x[i - 60]", 3) == STEP
    assert not alike("x[i - 60]", STEP)


@pytest.mark.exhaustive(keep=0.5)
def test_series_are_foreseen_from_small_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would be found after 1000 bodies have been derived."""
    spec = read_spec(SLEDGES, "sledges.yaml", {"N": "1000"})
    few = derive.derive_system(read_spec(SLEDGES, "sledges.yaml", {"N": "40"}))
    each = few.costs[few.formulation] // 40
    derived: list[int] = []
    plain = derive._derived

    def seen(spec: Spec, *given: object) -> object:
        derived.append(len(spec.coordinates))
        return plain(spec, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(derive, "_derived", seen)
    monkeypatch.setenv("LAGRANGE_LIMITS", f"convolutions={700 * each}")
    with pytest.raises(TooLargeSystem, match=f"take at least {800 * each} convolutions"):
        derive.derive_system(spec, measures=partial(measures_of, "taylor", "double"))
    assert derived == [12, 24, 36, 48]
    assert not measures_of("ias15", "double")


def test_other_sizes_are_kept_and_what_is_wrong_with_small_ones_is_not_told() -> None:
    spec = read_spec(BEADS.replace("mu: 0.3", f"k: {[1] * 300}"), "beads.yaml", {"N": "300"})
    foresee_sizes(spec, lambda smaller, most: (Work(), EQUATIONS))
    fixed = read_spec(BEADS.replace("N: 60", "N: 300, M: 400"), "beads.yaml")
    foresee_sizes(fixed, lambda smaller, most: pytest.fail("two sizes are large"))


@pytest.mark.parametrize(("text", "line"), [(FRICTION, 9), (TIED, 9)])
def test_the_message_points_at_what_members_are_written_out_for(
    text: str, line: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAGRANGE_LIMITS", "work=2000")
    spec = read_spec(text, "system.yaml")
    compilation = Compilation("taylor", FULL_PRECISION, frozenset({"q"}))
    with pytest.raises(SpecError, match="members are written out for") as caught, named(spec, compilation):
        derive.derive_system(spec)
    assert [one.line for one in caught.value.problems] == [line]


@pytest.mark.exhaustive(keep=0.5)
def test_check_accepts_what_can_be_derived(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search for conserved quantities does not count to the limit, and says where it is given up."""
    spec = read_spec(SLEDGES, "sledges.yaml", {"N": "8"})
    most = derive.derive_system(spec).graph.work.spent + 1
    monkeypatch.setenv("LAGRANGE_LIMITS", f"work={most}")
    given_up = "further conserved quantities: looking for all of them takes too much work"
    assert given_up in classify(spec).skipped
    monkeypatch.delenv("LAGRANGE_LIMITS")
    found = classify(spec)
    assert given_up not in found.skipped
    assert {"h", "h_x[7]"} <= {one.quantity for one in found.mechanics.conserved}


def test_masses_in_blocks_are_divided_by_as_a_whole() -> None:
    rng = np.random.default_rng(1)
    matter: dict[int, dict[int, float]] = {99: {99: 2.0}}
    for first in range(0, 90, 3):
        part = rng.standard_normal((3, 3))
        part = part @ part.T + np.eye(3)
        matter |= {first + j: {first + k: part[j, k] for k in range(3)} for j in range(3)}
    blocks = Blocks.of(matter)
    assert blocks is not None
    row = {1: 1.0, 40: -2.0, 41: 0.5, 99: 3.0}
    found = blocks.divided(row)
    back = {j: sum(m * found.get(k, 0.0) for k, m in matter[j].items()) for j in matter}
    assert [back[j] for j in matter] == pytest.approx([row.get(j, 0.0) for j in matter], abs=1e-12)
    assert Blocks.of({j: dict.fromkeys(range(100), 1.0) for j in range(100)}) is None


@pytest.mark.exhaustive(keep=0.45)
def test_code_is_the_same_when_it_is_compiled_apart() -> None:
    from lagrange_cli.native.compilation.apart import compile_apart
    from lagrange_cli.native.compilation.llvm import compile_text

    text = "define i64 @f(i64 %x) {\n  %y = add i64 %x, 1\n  ret i64 %y\n}\n"
    for loops in (False, True):
        assert compile_apart(text, 0, 2**20, loops) == compile_text(text, 0, loops)
    with pytest.raises(MemoryError):
        compile_apart("no code", 0, 2**20, loops=False)


def test_matrices_of_implicit_steps_take_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seven numbers for each two coordinates."""
    foresee_matrices(3779)
    with pytest.raises(TooManyNumbers, match="choose --method DOP853"):
        foresee_matrices(3780)
    monkeypatch.setenv("LAGRANGE_LIMITS", "numbers=1e9")
    foresee_matrices(3780)
