"""What is said of events at the end of a run."""

from __future__ import annotations

from lagrange_cli.cli.main import main
from lagrange_cli.integrate.events import Happened
from lagrange_cli.run.events import notes
from lagrange_cli.spec.read import read_spec
from tests.motions.test_shaking_floor import BALLS


def test_members_that_rest_take_one_line() -> None:
    spec = read_spec(BALLS.format(count=1000, e=0.5, g=9.81, start=1), "balls.yaml")
    rested = {
        f"floor[{i}]": Happened(count=9, accumulations=1 + i % 2, accumulates=2.0 - i / 1024)
        for i in range(999)
    }
    (said,) = notes(spec, rested | {"floor[999]": Happened(count=9)})
    assert said == (
        "event 'floor[i]': infinitely many accumulate at t = 1.02539062 to 2, for the first time "
        "(999 of 1000 members); from then on each rests there"
    )
    alone = {name: Happened(count=9) for name in spec.events} | {"floor[7]": rested["floor[7]"]}
    (said,) = notes(spec, alone)
    assert said == (
        "event 'floor[7]': infinitely many accumulate at t = 1.99316406, the first of 2 such times; "
        "from then on the motion rests there"
    )


def test_doubts_about_members_take_one_line_of_each_kind() -> None:
    spec = read_spec(BALLS.format(count=9, e=0.5, g=9.81, start=1), "balls.yaml")
    said = notes(spec, {name: Happened(1, blurred=1.5, error=1e-6, grazes=1.0) for name in spec.events})
    assert len(said) == 2
    assert all(one.startswith("event 'floor[0]': ") and "(also 8 more of its family)" in one for one in said)


def test_a_time_that_rounding_leaves_open_is_no_number() -> None:
    spec = read_spec(BALLS.format(count=1, e=0.5, g=9.81, start=1), "balls.yaml")
    for error, said in (
        (4e-5, "the time may be off by 4.0e-5"),
        (float("inf"), "the time is not determined"),
    ):
        (note,) = notes(spec, {name: Happened(1, blurred=1.5, error=error) for name in spec.events})
        assert note.endswith(said)


SLIDE = """
parameters: {g: 9.81, R: 1, start: 1}
coordinates: {r: {initial: start*R}, theta: {initial: 0.1}}
masses: {bead: 1}
positions: {bead: [r*sin(theta), r*cos(theta)]}
potential: g*bead.y
events:
  sphere: {when: norm(bead) - R, direction: falling, action: {set: {r_dot: 0}}}
  never: {when: theta - 0.1, direction: falling}
  ground: {when: bead.y + R, action: stop}
"""


def test_what_rests_from_the_start_is_said_to_touch_there(tmp_path, capsys):
    (tmp_path / "slide.yaml").write_text(SLIDE)
    solve = ["solve", str(tmp_path / "slide.yaml"), "-o", str(tmp_path / "a.h5"), "--stop", "5", "--force"]
    assert main(solve) == 0
    said = capsys.readouterr().err
    assert "event 'sphere' did not occur after the start, where its expression is 0\n" in said
    assert "event 'never' did not occur\n" in said
    assert main([*solve, "--set", "start=2", "--stop", "0.1"]) == 0
    assert "event 'sphere' did not occur\n" in capsys.readouterr().err
