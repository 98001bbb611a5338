"""What the shell offers at Tab, asked as the shell asks, and in a real bash."""

import os
import shutil
import subprocess
import sys
import threading
from contextlib import suppress

import click
import pytest
from click.shell_completion import ShellComplete

from lagrange_cli.cli.main import COMMANDS, lagrange, main
from lagrange_cli.cli.options.completion import names_in
from lagrange_cli.cli.shells import Bash, Fish, Zsh, register
from lagrange_cli.integrate.methods.table import AUTO, METHODS
from lagrange_cli.outputs.catalog import OUTPUTS
from tests.support.command import PATIENCE, SYSTEMS, environment

HOOP = str(SYSTEMS / "rotating_hoop.yaml")
CHAIN = str(SYSTEMS / "n_pendulum.yaml")


def asked(monkeypatch, *words: str, kind: type[ShellComplete] = Bash) -> list[str]:
    """The lines that the shell is given for the last of the words."""
    monkeypatch.setenv("COMP_WORDS", "\n".join(("lagrange", *words)))
    monkeypatch.setenv("COMP_CWORD", str(len(words)))
    return kind(lagrange, {}, "lagrange", "_LAGRANGE_COMPLETE").complete().split("\n")


@pytest.mark.parametrize(
    ("words", "values"),
    [
        ([""], list(COMMANDS)),
        (["so"], ["solve"]),
        (["solve", "--prec"], ["--precision"]),
        (["solve", "--precision", ""], ["double", "double-double"]),
        (["solve", HOOP, "--method", ""], [AUTO, *METHODS]),
        (["solve", HOOP, "--method", "="], [AUTO, *METHODS]),
        (["solve", HOOP, "--method", "=", "t"], ["taylor"]),
        (["solve", HOOP, "--method", "r"], ["Radau"]),
        (["solve", HOOP, "--outputs", ""], [*OUTPUTS, "all"]),
        (["sweep", HOOP, "--outputs", "q,e"], ["q,energy"]),
        (["sweep", HOOP, "--outputs", "q,energy,e"], [""]),
        (["bench", HOOP, "--methods", "taylor,"], [f"taylor,{name}" for name in list(METHODS)[1:]]),
        (["equations", HOOP, "--form", "h"], ["hamilton"]),
        (["systems", "pe"], ["pendulum"]),
        (["cache", "i"], ["info"]),
        (["completion", ""], ["bash", "zsh", "fish"]),
        (["solve", HOOP, "--set", ""], ["m=", "g=", "a=", "omega=", "theta=", "theta_dot="]),
        (["check", HOOP, "--set", "th"], ["theta=", "theta_dot="]),
        (["sweep", HOOP, "--over", "om"], ["omega="]),
        (["sweep", HOOP, "--random", "om"], ["omega="]),
        (["section", HOOP, "--set", "th"], ["theta=", "theta_dot="]),
        (["section", HOOP, "--over", "om"], ["omega="]),
        (["section", HOOP, "--direction", "f"], ["falling"]),
        (["section", HOOP, "--where", "th"], ["theta", "theta_dot"]),
        (["section", HOOP, "--where", "sin(theta)-om"], ["sin(theta)-omega"]),
        (["section", CHAIN, "--where", "the"], ["theta[", "theta_dot["]),
        (["section", HOOP, "--where", "theta>2"], [""]),
        (["section", HOOP, "--every", "2*pi/o"], ["2*pi/omega"]),
        (["solve", HOOP, "--stop", "20*pi/o"], ["20*pi/omega"]),
        (["solve", CHAIN, "--size", ""], ["N="]),
        (["solve", CHAIN, "--set", "the"], ["theta[", "theta_dot["]),
        (["solve", HOOP, "--set", "m", "="], [""]),
        (["solve", HOOP, "--set", "m", "=", "1"], [""]),
        (["solve", "nosuch.yaml", "--set", ""], [""]),
    ],
)
def test_words(monkeypatch, words, values):
    assert asked(monkeypatch, *words) == [f"plain,{value}" if value else "" for value in values]


@pytest.mark.parametrize(
    ("words", "lines"),
    [
        (["solve", ""], ["ending,yaml", "ending,yml", "dir,"]),
        (["solve", HOOP, "x"], ["ending,yaml", "ending,yml", "dir,"]),
        (["check", "x"], ["ending,yaml", "ending,yml", "dir,"]),
        (["sweep", HOOP, "--table", ""], ["ending,csv", "dir,"]),
        (["solve", HOOP, "-o", "out"], ["file,out"]),
        (["bench", HOOP, "--plot", ""], ["ending,svg", "ending,pdf", "ending,png", "dir,"]),
    ],
)
def test_files(monkeypatch, words, lines):
    assert asked(monkeypatch, *words) == lines
    endings = [line.removeprefix("ending,") for line in lines if "ending" in line]
    pattern = f"*.({'|'.join(endings)})" if endings else "*"
    assert asked(monkeypatch, *words, kind=Zsh) == ["file", pattern, "_"]


def test_every_option_with_a_file_name_completes_files(monkeypatch):
    context = click.Context(lagrange)
    found = 0
    for name in COMMANDS:
        command = lagrange.get_command(context, name)
        for parameter in command.params:
            if ".yaml" in (parameter.metavar or "") or "FILE" in (parameter.metavar or ""):
                (item,) = parameter.shell_complete(context, "")
                assert item.type == "file"
                found += 1
    assert found >= 9


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\xfe", b"parameters: [", b"- 1", b"parameters: {m: 1}\n" * 20000, b"coordinates: x"],
)
def test_a_file_that_is_wrong_offers_nothing_and_says_nothing(tmp_path, monkeypatch, capfd, content):
    (tmp_path / "x.yaml").write_bytes(content)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COMP_WORDS", "lagrange solve x.yaml --set ")
    monkeypatch.setenv("COMP_CWORD", "4")
    for instruction in ("bash_complete", "zsh_complete", "nonsense", ""):
        monkeypatch.setenv("_LAGRANGE_COMPLETE", instruction)
        assert main([]) == 0
    out, err = capfd.readouterr()
    assert (out.strip(), err) == ("", "")


def test_names_are_those_of_the_file(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text("parameters: {m: [1, 2], k: 3}\ncoordinates: [x, y]\nsizes: {N: 3}\n")
    sections = ("parameters", "coordinates")
    assert list(names_in(str(path), sections)) == ["m[", "k=", "x=", "x_dot=", "y=", "y_dot="]


COMPLETING = """
import os, sys
os.environ |= {"_LAGRANGE_COMPLETE": "bash_complete", "COMP_CWORD": "4", "COMP_WORDS": sys.argv[1]}
from lagrange_cli.cli.main import main
main([])
heavy = {"numpy", "h5py", "sympy", "scipy", "llvmlite"} & {*sys.modules}
assert not heavy, heavy
"""


@pytest.mark.parametrize("words", ["lagrange solve {} --set ", "lagrange bench x --methods "])
def test_little_is_imported(tmp_path, words):
    arguments = [sys.executable, "-c", COMPLETING, words.format(HOOP)]
    run = subprocess.run(arguments, env=environment(), capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "") and "plain," in run.stdout


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_command_prints_the_script(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "_LAGRANGE_COMPLETE" in script and "%(" not in script
    if shutil.which(shell):
        checked = subprocess.run([shell, "-n"], input=script, capture_output=True, text=True)
        assert (checked.returncode, checked.stderr) == (0, "")
    assert main(["completion", "tcsh"]) == 2


def installed(folder):
    """The command ``lagrange`` in a new folder."""
    folder.mkdir()
    command = folder / "lagrange"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m lagrange_cli "$@"\n')
    command.chmod(0o755)
    return command


def complete_in_bash(tmp_path):
    """Tab in an interactive bash in a pseudo-terminal: the words that it makes of what is typed."""
    command = installed(tmp_path / "bin")
    (tmp_path / "my hoop.yaml").write_text((SYSTEMS / "rotating_hoop.yaml").read_text(encoding="utf-8"))
    (tmp_path / "my notes.txt").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "lagrange.sh").write_text(
        f'PATH="{command.parent}:$PATH"\nargs() {{ printf "<%s>" "$@" >> typed; echo >> typed; }}\n'
        'eval "$(lagrange completion bash)"\nasked() { _lagrange_completion lagrange; }\n'
        'complete -o nosort -F asked args\nPS1="ready "\nbind "set bell-style none"\n'
    )
    typed = ["args so\t", "args solve m\t", "args solve f\t", "args solve my\\ hoop.yaml --set om\t4",
             "args solve my\\ hoop.yaml --method=t\t", "args solve -o my\\ n\t"]  # fmt: skip
    master, slave = os.openpty()
    process = subprocess.Popen(
        ["bash", "--norc", "--noprofile", "-i"], cwd=tmp_path,
        env={**environment(), "TERM": "dumb", "INPUTRC": os.devnull, "HISTFILE": os.devnull},
        stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
    )  # fmt: skip
    os.close(slave)
    shown = bytearray()

    def read() -> None:
        with suppress(OSError):
            while piece := os.read(master, 4096):
                shown.extend(piece)

    reading = threading.Thread(target=read)
    reading.start()
    os.write(master, b". ./lagrange.sh\n" + "".join(f"{line}\n" for line in typed).encode() + b"exit\n")
    process.wait(PATIENCE)
    reading.join(PATIENCE)
    os.close(master)
    assert (tmp_path / "typed").read_text().splitlines() == [
        "<solve>",
        "<solve><my hoop.yaml>",
        "<solve><folder/>",
        "<solve><my hoop.yaml><--set><omega=4>",
        "<solve><my hoop.yaml><--method=taylor>",
        "<solve><-o><my notes.txt>",
    ], shown.decode()


def complete_in_fish(tmp_path):
    """As at the Tab key: fish is asked what it would offer."""
    command = installed(tmp_path / "folder")
    (tmp_path / "my hoop.yaml").write_text((SYSTEMS / "rotating_hoop.yaml").read_text(encoding="utf-8"))
    for name in ("my notes.txt", "other.yml", "my.csv"):
        (tmp_path / name).touch()
    typed = {
        "so": ["solve"],
        "solve ": ["folder/", "my hoop.yaml", "other.yml"],
        "solve my": ["my hoop.yaml"],
        "solve my\\ n": ["my notes.txt"],
        "solve my\\ hoop.yaml --set om": ["omega="],
        "solve my\\ hoop.yaml --method=t": ["--method=taylor"],
        "solve --output=my": ["--output=my hoop.yaml", "--output=my notes.txt", "--output=my.csv"],
        "sweep other.yml --table ": ["folder/", "my.csv"],
    }
    lines = (line.replace("\\", "\\\\") for line in typed)
    script = "lagrange completion fish | source\n"
    script += "".join(f"echo '>'\ncomplete -C 'lagrange {line}'\n" for line in lines)
    home = {"HOME": str(tmp_path / "folder"), "PATH": f"{command.parent}:{os.environ['PATH']}"}
    run = subprocess.run(
        ["fish", "--no-config", "-c", script], cwd=tmp_path, env={**environment(), **home},
        capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    offered = [
        [line.partition("\t")[0].replace("\\", "") for line in one.splitlines() if line]
        for one in run.stdout.split(">\n")[1:]
    ]
    found = dict(zip(typed, offered, strict=True))
    assert found == typed, run.stderr


IN_SHELLS = {"bash": complete_in_bash, "fish": complete_in_fish}
TRIED = ["bash", *(shell for shell in ("fish",) if shutil.which(shell))]
"""bash is required; other shells are tried where they are installed."""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("shell", TRIED)
def test_a_shell_completes_what_is_typed(tmp_path, shell):
    IN_SHELLS[shell](tmp_path)


def test_the_shells_are_registered():
    register()
    from click.shell_completion import get_completion_class

    assert get_completion_class("bash") is Bash and get_completion_class("zsh") is Zsh
    assert get_completion_class("fish") is Fish
