"""The shell of the command line: help, the handler at the edge, and what becomes of standard output."""

import json
import os
import resource
import subprocess
import sys

import click
import pytest

import lagrange_cli
from lagrange_cli.cli import console as report
from lagrange_cli.cli.main import COMMANDS, LazyGroup, main
from lagrange_cli.errors import FileError, LagrangeError, MotionError, Problem, SpecError, UsageError
from lagrange_cli.run import shipped
from tests.support.command import SYSTEMS, environment, lagrange


@pytest.mark.exhaustive(keep=0.7)
def test_the_process_ends_at_once_but_not_before_what_was_asked_for_at_its_end(tmp_path):
    script = (
        "import atexit, sys; atexit.register(print, 'last words', flush=True)\n"
        "from lagrange_cli.cli.main import run\n"
        "sys.argv = ['lagrange', *{arguments}]; run()"
    )
    for arguments, status in ((["--version"], 0), (["check", "nosuch.yaml"], 5), (["--nosuch"], 2)):
        run = subprocess.run(
            [sys.executable, "-c", script.format(arguments=arguments)],
            cwd=tmp_path,
            env=environment(),
            capture_output=True,
            text=True,
        )
        assert run.returncode == status
        assert run.stdout.endswith("last words\n") and bool(run.stderr) is bool(status)


def test_help_names_every_command_with_its_purpose(capsys):
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    for name in COMMANDS:
        assert any(line.split()[:1] == [name] and len(line.split()) > 2 for line in out.splitlines())


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["solve", "--stpo", "3"], "; did you mean --stop or --step?"),
        (["solve", "--dt=0.1"], "; did you mean --step?"),
        (["sweep", "-n", "10"], "; did you mean --samples?"),
        (["solve", "--out", "x"], "; did you mean --output or --outputs?"),
        (["solve", "--csv"], "; did you mean --format csv?"),
        (["equations", "--latex"], "; did you mean --format latex?"),
        (["equations", "--hamilton"], "; did you mean --form hamilton?"),
        (["section", "--verbose"], ""),
        (["--json", "solve"], "; options follow the command"),
        (["--vesrion"], "; did you mean --version?"),
    ],
)
def test_an_option_that_was_perhaps_meant_is_named(arguments, hint, capsys):
    assert main(arguments) == 2
    option = next(one for one in arguments if one.startswith("-")).partition("=")[0]
    assert capsys.readouterr().err.endswith(f"Error: there is no option '{option}'{hint}\n")


@pytest.mark.parametrize(
    ("arguments", "hint"), [(["help"], "lagrange --help"), (["help", "solve"], "lagrange solve --help")]
)
def test_help_is_an_option(arguments, hint, capsys):
    assert main(arguments) == 2
    assert capsys.readouterr().err.endswith(f"there is no command 'help'; write {hint}\n")


def test_a_file_without_a_command(tmp_path):
    (tmp_path / "a.yaml").write_text("")
    run = lagrange("a.yaml", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert "there is no command 'a.yaml'; a file follows its command, as in lagrange solve" in run.stderr


@pytest.mark.exhaustive(keep=0.15)
def test_the_name_of_a_file_need_not_be_text(tmp_path):
    """It is written as it is; where file systems take text only, with a letter beyond ASCII."""
    text = (SYSTEMS / "pendulum.yaml").read_text().replace("name: pendulum\n", "")
    stem = os.fsdecode(b"\xff")
    try:
        (tmp_path / f"{stem}.yaml").write_text(text)
    except OSError:
        stem = "\xff"
        (tmp_path / f"{stem}.yaml").write_text(text)
    said, written = stem.encode("utf-8", "replace") + b": ", b"wrote " + os.fsencode(stem) + b"."
    for command in ("solve", "plot"):
        run = subprocess.run(
            [sys.executable, "-m", "lagrange_cli", command, f"{stem}.yaml", "--stop", "1"],
            cwd=tmp_path,
            env=environment() | {"LAGRANGE_CACHE_DIR": str(tmp_path / "cache")},
            capture_output=True,
        )
        assert (run.returncode, run.stderr) == (0, b"")
        assert run.stdout.startswith(said) and written in run.stdout


def test_whole_numbers_may_have_an_exponent(tmp_path):
    for text, status in (("1e4", 0), ("1.5e1", 0), ("1.25e1", 2), ("1e999", 2), ("1e", 2)):
        run = lagrange("systems", "pendulum", cwd=tmp_path)
        (tmp_path / "a.yaml").write_text(run.stdout)
        run = lagrange(
            "solve", "a.yaml", "--samples", text, "--stop", "1", "--quiet", "--force", cwd=tmp_path
        )
        assert run.returncode == status, run.stderr


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], *([name, "--help"] for name in COMMANDS)])
def test_help_is_help(arguments, capsys):
    assert main(arguments) == 0
    assert capsys.readouterr().out.startswith("Usage: lagrange")


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"lagrange, version {lagrange_cli.__version__}\n"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_in_the_table_exists_under_its_own_name(name):
    command = LazyGroup().get_command(click.Context(LazyGroup()), name)
    assert command is not None and command.name == name


@pytest.mark.parametrize(
    "arguments", [["slove"], ["solve"], ["systems", "a", "b"], ["check", "--nosuch", "x"]]
)
def test_wrong_usage_ends_with_status_2_and_a_hint(arguments, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and "--help" in captured.err


def test_a_command_that_was_perhaps_meant_is_named(capsys):
    assert main(["slove", "x.yaml"]) == 2
    assert "there is no command 'slove'; did you mean 'solve'?" in capsys.readouterr().err


RAISED = {
    "usage": (UsageError("wrong option"), 2, "Error: wrong option\n"),
    "spec": (SpecError("a.yaml", [Problem(0, 0, "it is empty")]), 3, "a.yaml: it is empty\n"),
    "motion": (MotionError("stuck"), 4, "Error: stuck\n"),
    "file": (FileError("no such file"), 5, "Error: no such file\n"),
    "interrupt": (KeyboardInterrupt(), 130, "\nInterrupted.\n"),
}


@pytest.mark.parametrize(("error", "status", "message"), RAISED.values(), ids=RAISED)
def test_every_error_ends_as_a_message_and_its_status(error, status, message, monkeypatch, capsys):
    def names():
        raise error

    monkeypatch.setattr(shipped, "names", names)
    assert main(["systems"]) == status
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", message)


def test_every_kind_of_error_has_a_status_of_its_own():
    kinds = LagrangeError.__subclasses__()
    assert {kind.exit_code for kind in kinds} == {2, 3, 4, 5}
    assert len(kinds) == 10


@pytest.mark.parametrize("error", [ZeroDivisionError("by zero"), RecursionError("deep"), LookupError("none")])
def test_what_nobody_expected_is_one_line_that_asks_for_a_report(error, monkeypatch, capsys):
    def names():
        raise error

    monkeypatch.setattr(shipped, "names", names)
    monkeypatch.delenv("LAGRANGE_DEBUG", raising=False)
    assert main(["systems"]) == 1
    err = capsys.readouterr().err
    assert "please report it" in err and type(error).__name__ in err
    assert err.count("\n") == 1 and "Traceback" not in err
    monkeypatch.setenv("LAGRANGE_DEBUG", "1")
    assert main(["systems"]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_the_others_still_run_and_the_highest_status_counts(capsys):
    outcomes = {"a": 0, "b": SpecError("b", [Problem(0, 0, "wrong")]), "c": FileError("gone"), "d": 4, "e": 0}
    ran = []

    def action(system):
        ran.append(system)
        if isinstance(outcomes[system], Exception):
            raise outcomes[system]
        return outcomes[system]

    assert report.run_each(outcomes, action, as_json=False) == 5
    assert ran == list(outcomes)
    assert capsys.readouterr().err == "b: wrong\nError: c: gone\n"


def test_with_json_a_failure_has_an_object_too(capsys):
    def action(system):
        raise MotionError("stuck")

    assert report.run_each(["dir/a.yaml"], action, as_json=True) == 4
    captured = capsys.readouterr()
    assert json.loads(captured.out) == {"name": "a", "status": "failed", "message": "stuck", "exit_code": 4}
    assert captured.err == "Error: stuck\n"


def test_an_interrupt_ends_the_whole_run():
    ran = []

    def action(system):
        ran.append(system)
        return 130

    assert report.run_each(["a", "b"], action, as_json=False) == 130
    assert ran == ["a"]


def test_json_knows_no_infinities(capsys):
    report.emit_json({"a": float("nan"), "b": [float("inf"), 1.5], "c": {"d": -float("inf")}, "é": "θ"})
    out = capsys.readouterr().out
    assert json.loads(out) == {"a": None, "b": [None, 1.5], "c": {"d": None}, "é": "θ"}
    assert out.count("\n") == 1


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("arguments", [["systems"], ["--help"], ["check", str(SYSTEMS / "pendulum.yaml")]])
def test_a_reader_that_hangs_up_is_no_error(arguments, tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    run = subprocess.run(
        [sys.executable, "-m", "lagrange_cli", *arguments],
        cwd=tmp_path,
        env=environment(),
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(writer)
    assert (run.returncode, run.stderr) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "what"), [(["systems"], "standard output"), (["--help"], "the output")]
)
def test_standard_output_on_a_full_disk(arguments, what):
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [sys.executable, "-m", "lagrange_cli", *arguments],
            env=environment(),
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert run.returncode == 5
    assert run.stderr == f"Error: {what} could not be written: No space left on device\n"


@pytest.mark.exhaustive(keep=0.35)
def test_standard_output_in_an_encoding_that_lacks_a_letter(tmp_path):
    run = subprocess.run(
        [
            sys.executable,
            "-m",
            "lagrange_cli",
            "equations",
            "--format",
            "unicode",
            str(SYSTEMS / "pendulum.yaml"),
        ],
        env={**environment(), "PYTHONUTF8": "0", "PYTHONIOENCODING": "latin-1"},
        capture_output=True,
        text=True,
    )
    assert (run.returncode, run.stdout) == (5, "")
    assert "encoding latin-1" in run.stderr and "PYTHONUTF8=1" in run.stderr


def test_systems_lists_each_with_one_line(tmp_path):
    run = lagrange("systems", cwd=tmp_path)
    assert run.returncode == 0
    lines = run.stdout.splitlines()
    assert [line.split()[0] for line in lines] == sorted(path.stem for path in SYSTEMS.glob("*.yaml"))
    assert all(len(line.split(maxsplit=1)[1]) > 20 and len(line) <= 120 for line in lines)


@pytest.mark.parametrize("name", ["pendulum", "pendulum.yaml"])
def test_systems_writes_one_out_as_it_is(tmp_path, name):
    run = lagrange("systems", name, cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == (SYSTEMS / "pendulum.yaml").read_text(encoding="utf-8")


def test_systems_suggests_what_was_meant(tmp_path):
    run = lagrange("systems", "pendlum", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert "did you mean 'pendulum'" in run.stderr


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(
    "arguments",
    [["schema"], ["solve", SYSTEMS / "pendulum.yaml", "-o", "-", "--format", "csv", "--quiet"]],
    ids=lambda listed: listed[0],
)
def test_a_disk_that_fills_in_the_middle_of_the_output_is_an_error(tmp_path, arguments, unbuffered):
    limit = 20480
    with open(tmp_path / "out", "wb") as out:
        run = subprocess.run(
            [sys.executable, "-m", "lagrange_cli", *map(str, arguments)],
            cwd=tmp_path,
            env=environment() | {"PYTHONUNBUFFERED": unbuffered},
            stdout=out,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        )
    assert (tmp_path / "out").stat().st_size == limit
    assert run.returncode == 5
    assert "standard output could not be written" in run.stderr
