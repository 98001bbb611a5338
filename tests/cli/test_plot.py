"""``lagrange plot``: pictures of outputs and of systems."""

import json

import numpy as np
import pytest

from lagrange_cli.cli.commands import plot
from lagrange_cli.cli.main import main
from lagrange_cli.run.monitor import Silence
from tests.cli.test_endings import Impatient
from tests.support.command import SYSTEMS, working_in


@pytest.mark.exhaustive(keep=0.15)
def test_a_system_is_solved_and_drawn(tmp_path, capsys):
    system = str(SYSTEMS / "pendulum.yaml")
    with working_in(tmp_path):
        assert main(["plot", system, "--stop", "2", "--json"]) == 0
        report = json.loads(capsys.readouterr().out)
        assert report["output"] == "pendulum.png" and len(report["panels"]) == 4
        assert (tmp_path / "pendulum.png").read_bytes().startswith(b"\x89PNG")
        assert main(["plot", system, "--stop", "2", "--terminal", "--what", "q"]) == 0
        assert "theta" in capsys.readouterr().out
        assert [path.name for path in tmp_path.iterdir()] == ["pendulum.png"]


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    ("sampling", "options", "count"),
    [
        ("samples: 7", (), 6 * 667 + 1),
        ("step: 0.3", (), 3813 + 2),
        ("samples: 7", ("--samples", "9"), 9),
        ("samples: 7", ("--step", "0.5"), 5),
        ("samples: 1501", (), 1500 * 3 + 1),
        ("samples: 4501", (), 4501),
    ],
)
def test_few_samples_of_a_file_make_no_polygon(tmp_path, monkeypatch, sampling, options, count):
    """Unless they are asked for with an option. The samples of the file are among the others."""
    (tmp_path / "swing.yaml").write_text(
        "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - x**2/2\n"
        f"solve: {{stop: 2, {sampling}}}\n"
    )
    pages = []
    monkeypatch.setattr("lagrange_cli.figures.draw.draw", lambda page, *_: pages.append(page) or b"")
    with working_in(tmp_path):
        assert main(["plot", "swing.yaml", "--what", "q", "--quiet", *options]) == 0
    curve = pages[0].panels[0].items[0]
    assert len(curve.x) == count
    np.testing.assert_allclose(curve.y, np.cos(curve.x), atol=1e-14)
    if not options and "step" in sampling:
        assert min(abs(curve.x - 1.8)) < 1e-12


def test_outputs_of_different_systems_share_what_both_have(tmp_path, monkeypatch):
    """Each phase portrait has the curves of those that have its coordinate."""
    for name, other in (("a", "z"), ("b", "y")):
        (tmp_path / f"{name}.yaml").write_text(
            f"coordinates: {{x: {{initial: 1}}, {other}: {{initial: 2}}}}\n"
            f"lagrangian: (x_dot**2 + {other}_dot**2 - x**2 - {other}**2)/2\nsolve: {{stop: 1}}\n"
        )
    pages = []
    monkeypatch.setattr("lagrange_cli.figures.draw.draw", lambda page, *_: pages.append(page) or b"")
    with working_in(tmp_path):
        assert main(["solve", "a.yaml", "b.yaml", "--quiet"]) == 0
        assert main(["plot", "a.h5", "b.h5", "--what", "phase", "--quiet"]) == 0
    curves = {panel.x: [curve.label for curve in panel.items] for panel in pages[0].panels}
    assert curves == {"$x$": ["a", "b"], "$z$": ["a"], "$y$": ["b"]}


@pytest.mark.exhaustive(keep=0.25)
def test_the_progress_of_the_motion_is_shown(tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr(plot, "Progress", lambda *given, quiet: shown.append((*given, quiet)) or Silence())
    with working_in(tmp_path):
        assert main(["plot", str(SYSTEMS / "pendulum.yaml"), "--start", "1", "--stop", "2"]) == 0
    assert shown == [("pendulum", 1.0, 2.0, False)]


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["none.h5"], 5, "no such file"),
        (["other.h5"], 5, "not an output of lagrange"),
        (["other.h5", "--stop", "3"], 2, "--stop is for the motion of a system file"),
        (["other.h5", "-o", "a.jpg"], 2, "must end in"),
        (["other.h5", "-o", "none/a.png"], 5, "there is no directory"),
        (["other.h5", "-o", "kept.png"], 5, "already exists"),
        (["kept.png", "--force"], 2, "kept.png is a picture"),
        (["other.h5", "-o", "linked.png", "--force"], 2, "linked.png is read by this command"),
        ([""], 2, "the name of the file is empty"),
        (["other.h5", "--what", "q", "--y", "h"], 2, "give one of them"),
        (["other.h5", "--terminal", "-o", "a.png"], 2, "writes no file"),
        (["other.h5", "--inches", "big"], 2, "not a size in inches"),
    ],
)
def test_mistakes(tmp_path, capsys, arguments, status, message):
    (tmp_path / "other.h5").write_text("something else")
    (tmp_path / "kept.png").write_text("mine")
    (tmp_path / "linked.png").symlink_to("other.h5")
    with working_in(tmp_path):
        assert main(["plot", *arguments]) == status
    assert message in capsys.readouterr().err
    assert (tmp_path / "kept.png").read_text() == "mine"


SLIDER = """coordinates: {x: {initial: 1}, y: {}}
masses: {bead: 1, load: 1}
embedding: {bead: [x, 0], load: [0, y]}
constraints: {one: x - y, two: 2*x - 2*y}
observables: {w: 1/(t - 1)}
solve: {stop: 2, samples: 3}
"""


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("command", [("plot", "-o", "a.png"), ("animate", "-o", "a.gif", "--speed", "10")])
def test_what_solve_says_of_a_motion_is_said_beside_its_picture(tmp_path, capsys, command):
    """What was found and left out at the start, and values that are not finite."""
    (tmp_path / "s.yaml").write_text(SLIDER)
    name, *options = command
    with working_in(tmp_path):
        assert main(["solve", "s.yaml"]) == 0
        told = capsys.readouterr().err.splitlines()
        assert main([name, "s.yaml", *options]) == 0
        assert capsys.readouterr().err.splitlines() == told and len(told) == 3
        assert main([name, "s.yaml", "--force", "--quiet", *options]) == 0
        assert capsys.readouterr().err == ""


@pytest.mark.exhaustive(keep=0.95)
@pytest.mark.parametrize(
    ("system", "options", "message"),
    [
        ("pendulum", ("--what", "constraints"), "pendulum has no constraints"),
        ("chaplygin_sleigh", ("--what", "path"), "Chaplygin's sleigh has no particles"),
        ("henon_heiles", ("--y", "bob.x"), "has no such quantity; known: t, x,"),
        ("henon_heiles", ("--y", "x*y"), "write an expression under 'observables'"),
        ("henon_heiles", ("--what", "p_x"), "there is no such plot; --y p_x draws this quantity"),
    ],
)
def test_what_a_system_lacks_cannot_be_asked_for(tmp_path, capsys, system, options, message):
    """To solve it again would not help."""
    with working_in(tmp_path):
        assert main(["plot", str(SYSTEMS / f"{system}.yaml"), "--stop", "0.1", *options]) == 2
    told = capsys.readouterr().err
    assert message in told and "solve again" not in told


def test_a_package_that_is_missing_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with working_in(tmp_path):
        assert main(["plot", str(SYSTEMS / "pendulum.yaml")]) == 2
    assert "pip install" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("command", ["plot", "animate"])
def test_ctrl_c_in_the_motion_ends_the_command_without_a_picture(tmp_path, monkeypatch, capsys, command):
    """It had to be pressed twice: the first one drew the motion so far, which took seconds."""
    monkeypatch.setattr("lagrange_cli.run.interrupts.Interrupts", Impatient)
    with working_in(tmp_path):
        assert main([command, str(SYSTEMS / "double_pendulum.yaml"), "--stop", "1e5", "--quiet"]) == 130
    captured = capsys.readouterr()
    assert (captured.out, captured.err.strip()) == ("", "Interrupted.")
    assert list(tmp_path.iterdir()) == []
