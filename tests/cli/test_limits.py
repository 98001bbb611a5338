"""What asks for too much ends soon, in a message that names the limit; what was computed is kept."""

import os
import resource

import h5py
import pytest

from tests.support.command import ENVIRONMENT, SYSTEMS, lagrange

PENDULUM, CHAIN = SYSTEMS / "pendulum.yaml", SYSTEMS / "fpu_chain.yaml"
MEMORY = 1_000_000_000
SYSTEM = """
parameters: {m: 1}
coordinates:
  x: {initial: 1}
masses: {bead: m}
embedding:
  bead: [x]
"""


def limited(*arguments, cwd):
    """The command as a process that may use 1 GB."""
    return lagrange(
        *arguments,
        cwd=cwd,
        timeout=60,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
    )


HOSTILE = {
    "a huge product": ("potential: (((x + 1)**64 + x)**64 + x)**64*(x + 2)**64\n", "limit 'size'"),
    "definitions that double": (
        "definitions:\n"
        + "".join(f"  a{i + 1}: a{i}*a{i}\n" for i in range(40))
        + "  a0: x\npotential: a40\n",
        "limit 'size'",
    ),
    "a deep nest": ("potential: " + "sin(" * 200 + "x" + ")" * 200 + "\n", "nested more than 100 deep"),
    "a large exponent": ("potential: x**1e9\n", "limit 'exponent'"),
    "a large family": ("sizes: {N: 1000000}\ndefinitions:\n  w[i in range(N)]: i\n", "=members=..."),
    "a long sum": ("potential: sum(x*i for i in range(1000000000))\n", "=terms=..."),
    "many values": ("observables:\n" + "".join(f"  o{i}: x\n" for i in range(50_000)), "=values=..."),
    "a large file": ("# " + "x" * 1_000_000 + "\n", "=bytes=..."),
    "many samples": ("solve: {stop: 1, samples: 1000000000000}\n", "=samples=..."),
    "a small step": ("solve: {stop: 1, step: 1e-300}\n", "=samples=..."),
    "a far end": ("solve: {stop: 1e300, step: 0.01}\n", "=samples=..."),
}


@pytest.mark.parametrize(("text", "message"), HOSTILE.values(), ids=HOSTILE)
def test_the_limit_is_named(tmp_path, text, message):
    (tmp_path / "bad.yaml").write_text(SYSTEM + text)
    for command in ("check", "solve"):
        run = limited(command, "bad.yaml", cwd=tmp_path)
        assert (run.returncode, run.stdout) == (3, ""), run.stderr
        assert message in run.stderr and "Traceback" not in run.stderr and len(run.stderr) < 2000
    assert os.listdir(tmp_path) == ["bad.yaml"]


def test_a_hundred_thousand_coordinates(tmp_path):
    run = limited("check", CHAIN, "--size", "N=100000", cwd=tmp_path)
    assert run.returncode == 3 and "LAGRANGE_LIMITS=members=..." in run.stderr


@pytest.mark.parametrize("option", [("--over", "theta=0:1:1000000000000"), ("--random", "theta=normal(0,1)")])
def test_too_many_runs(tmp_path, option):
    drawn = ("--members", "1000000000000") if option[0] == "--random" else ()
    run = limited("sweep", PENDULUM, *option, *drawn, cwd=tmp_path)
    assert run.returncode == 2 and "LAGRANGE_LIMITS=runs=..." in run.stderr
    assert os.listdir(tmp_path) == []


def with_limits(monkeypatch, limits):
    monkeypatch.setitem(ENVIRONMENT, "LAGRANGE_LIMITS", limits)


def test_limits_move(tmp_path, monkeypatch):
    (tmp_path / "family.yaml").write_text(SYSTEM + "sizes: {N: 20}\ndefinitions:\n  w[i in range(N)]: i\n")
    with_limits(monkeypatch, "members=19")
    assert "more than 19 members" in lagrange("check", "family.yaml", cwd=tmp_path).stderr
    with_limits(monkeypatch, "members=21, terms=1")
    assert lagrange("check", "family.yaml", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize(
    "limits", ["members", "members=x", "member=1", "seconds=-1", "bytes=nan", "memory=1"]
)
def test_limits_that_make_no_sense(tmp_path, monkeypatch, limits):
    with_limits(monkeypatch, limits)
    run = lagrange("check", PENDULUM, cwd=tmp_path)
    assert run.returncode == 2 and run.stderr.startswith("Error: LAGRANGE_LIMITS: ")


@pytest.mark.parametrize("gravity", ["9.81", "1e20"], ids=["far", "tiny steps"])
def test_a_motion_ends_when_its_time_is_over(tmp_path, monkeypatch, gravity):
    with_limits(monkeypatch, "seconds=2")
    settings = ("--set", f"g={gravity}", "--stop", "1e9", "--samples", "3", "-o", "out.h5")
    run = lagrange("solve", PENDULUM, *settings, cwd=tmp_path, timeout=60)
    assert run.returncode == 130 and run.stderr.endswith(
        "The time limit is reached: LAGRANGE_LIMITS=seconds=2\n"
    )
    with h5py.File(tmp_path / "out.h5") as file:
        assert file.attrs["status"] == "interrupted"


def test_a_derivation_ends_when_its_time_is_over(tmp_path, monkeypatch):
    with_limits(monkeypatch, "seconds=2")
    run = lagrange("check", SYSTEMS / "n_pendulum.yaml", "--size", "N=600", cwd=tmp_path, timeout=60)
    assert run.returncode == 130 and run.stderr.endswith(
        "The time limit is reached: LAGRANGE_LIMITS=seconds=2\n"
    )


def test_a_command_that_may_not_use_the_memory_it_needs(tmp_path, monkeypatch):
    with_limits(monkeypatch, "memory=1000")
    run = lagrange("sweep", PENDULUM, "--over", "theta=0:1:100000000", cwd=tmp_path, timeout=60)
    assert run.returncode == 4 and "not enough memory" in run.stderr and "Traceback" not in run.stderr
    assert os.listdir(tmp_path) == []


TABLES = {
    "one endless line": ("x" * 3_000_000, "a line has more than 1000000 characters"),
    "columns without end": (",".join(f"c{i}" for i in range(60_000)) + "\n", "table.csv has no rows"),
    "many times one name": (",".join(["theta"] * 150_000), "two columns are called 'theta'"),
    "another quote": ('theta\n"1', "table.csv:2: "),
    "a formula": ("theta\n=cmd|' /C calc'!A0\n", "expected a number"),
    "Python": ("theta\n__import__('os').getcwd()\n", "expected a number"),
    "no number": ("theta\nnan\n", "not a finite number"),
    "too many rows": ("theta\n" + "1\n" * 101, "LAGRANGE_LIMITS=runs=..."),
}


@pytest.mark.parametrize(("text", "message"), TABLES.values(), ids=TABLES)
def test_a_table_from_elsewhere(tmp_path, monkeypatch, text, message):
    with_limits(monkeypatch, "runs=100")
    (tmp_path / "table.csv").write_text(text)
    run = limited("sweep", PENDULUM, "--table", "table.csv", cwd=tmp_path)
    assert run.returncode == 2 and message in run.stderr, run.stderr
    assert len(run.stderr) < 2000 and os.listdir(tmp_path) == ["table.csv"]


def test_an_output_that_leads_elsewhere_is_not_gone_on_with(tmp_path):
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["t"] = [1.0, 2.0]
    before = (tmp_path / "secret.h5").read_bytes()
    for path in ("t", "checkpoint"):
        with h5py.File(tmp_path / "out.h5", "w") as file:
            file[path] = h5py.ExternalLink("secret.h5", "t")
        run = lagrange("solve", PENDULUM, "-o", "out.h5", "--resume", cwd=tmp_path)
        assert run.returncode == 5 and "out.h5" in run.stderr
        assert (tmp_path / "secret.h5").read_bytes() == before


@pytest.mark.parametrize("command", ["check", "solve"])
def test_equations_that_grow_beyond_bounds_are_refused_with_the_way_out(tmp_path, command, monkeypatch):
    monkeypatch.setitem(ENVIRONMENT, "LAGRANGE_LIMITS", "nodes=2000")
    chain = str(SYSTEMS / "n_pendulum.yaml")
    run = lagrange(command, chain, "--size", "N=40", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert run.stderr.startswith(chain) and "the equations have more than 2000 terms" in run.stderr
    assert "LAGRANGE_LIMITS=nodes=" in run.stderr and not os.listdir(tmp_path)
    assert lagrange(command, chain, "--size", "N=4", cwd=tmp_path).returncode == 0


BOTH = ("check", "equations")
LARGE = {
    "definitions that double": (
        "definitions:\n  a0: x\n"
        + "".join(f"  a{i + 1}: (1 + a{i})*(2 + a{i})\n" for i in range(16))
        + "potential: a16\n",
        ("check",),
        "bad.yaml:26:12: this expression has 393211 terms and factors",
    ),
    "functions of functions": (
        "definitions:\n  a0: x\n"
        + "".join(f"  a{i + 1}: a{i} + a{i}*sin(a{i})\n" for i in range(11))
        + "potential: a11\n",
        ("check",),
        "=printed=...",
    ),
    "many factors": (f"potential: {'*'.join(f'(x + {i})' for i in range(200))}\n", BOTH, ""),
    "a deep nest": (f"potential: {'sin(x + ' * 30}x{')' * 30}\n", BOTH, ""),
}


@pytest.mark.parametrize(("text", "commands", "message"), LARGE.values(), ids=LARGE)
def test_what_is_short_and_grows_is_derived_or_refused(tmp_path, text, commands, message):
    """What is derived is derived by both; ``message`` is that of ``equations`` where it refuses."""
    (tmp_path / "bad.yaml").write_text(SYSTEM + text)
    for command in commands:
        run = limited(command, "bad.yaml", cwd=tmp_path)
        assert run.returncode == 0, run.stderr
    if message:
        run = limited("equations", "bad.yaml", cwd=tmp_path)
        assert (run.returncode, run.stdout) == (3, "") and message in run.stderr, run.stderr
        assert "'check' and 'solve' may work nevertheless" in run.stderr


def test_very_many_coordinates_are_refused_before_their_matrix_is_built(tmp_path):
    text = "sizes: {N: 45000}\ncoordinates:\n  x[i in range(N)]: {initial: 1}\n"
    (tmp_path / "bad.yaml").write_text(text + "lagrangian: sum(x_dot[i]**2 - x[i]**2 for i in range(N))\n")
    run = limited("check", "bad.yaml", cwd=tmp_path)
    assert run.returncode == 3 and "a mass matrix of 45000 coordinates takes more than" in run.stderr
    assert "LAGRANGE_LIMITS=work=" in run.stderr


@pytest.mark.parametrize("command", ["check", "solve", "equations"])
def test_the_work_of_deriving_is_bounded(tmp_path, command, monkeypatch):
    with_limits(monkeypatch, "work=2000")
    monkeypatch.setitem(ENVIRONMENT, "LAGRANGE_NO_CACHE", "1")  # what has been derived before is not derived
    pendulum = str(SYSTEMS / "double_pendulum.yaml")
    run = lagrange(command, pendulum, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert f"{pendulum}: deriving the equations takes more than 2000 steps of work" in run.stderr
    assert "LAGRANGE_LIMITS=work=" in run.stderr and not os.listdir(tmp_path)
