"""What asks for too much ends soon, in a message that names the limit; what was computed is kept."""

import json
import os
import resource

import h5py
import pytest

import lagrange_cli
from lagrange_cli.errors import UsageError
from tests.support.command import SYSTEMS, lagrange, lagrange_process, lagrange_processes

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


def small() -> None:
    """Let this process have 1 GB."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def limited(*arguments, cwd):
    """The command as a process that may use 1 GB."""
    return lagrange_process(*arguments, cwd=cwd, preexec_fn=small)


def limited_each(root, files, *commands):
    """What each command says of each file, by its name, all in one process of 1 GB; and the folder."""
    names, given = [], []
    for i, (name, (path, text)) in enumerate(files.items()):
        (root / str(i)).mkdir()
        (root / str(i) / path).write_text(text)
        names += [name] * len(commands)
        given += [(root / str(i), command) for command in commands]
    found: dict[str, list] = {}
    for name, (folder, _), run in zip(names, given, lagrange_processes(given, preexec_fn=small), strict=True):
        found.setdefault(name, []).append((run, folder))
    return found


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
    "a large family": ("sizes: {N: 1000000}\nobservables:\n  w[i in range(N)]: i*x\n", "=members=..."),
    "many definitions": ("sizes: {N: 3000000}\ndefinitions:\n  w[i in range(N)]: i\n", "=pairs=..."),
    "a long sum": ("potential: sum(x*i for i in range(1000000000))\n", "=pairs=..."),
    "many values": ("observables:\n" + "".join(f"  o{i}: x\n" for i in range(50_000)), "=values=..."),
    "a large file": ("# " + "x" * 1_000_000 + "\n", "=bytes=..."),
    "many samples": ("solve: {stop: 1, samples: 1000000000000}\n", "=samples=..."),
    "a small step": ("solve: {stop: 1, step: 1e-300}\n", "=samples=..."),
    "a far end": ("solve: {stop: 1e300, step: 0.01}\n", "=samples=..."),
}


@pytest.fixture(scope="module")
def hostile_runs(tmp_path_factory):
    files = {name: ("bad.yaml", SYSTEM + text) for name, (text, _) in HOSTILE.items()}
    return limited_each(
        tmp_path_factory.mktemp("hostile"), files, ("check", "bad.yaml"), ("solve", "bad.yaml")
    )


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("name", HOSTILE)
def test_the_limit_is_named(hostile_runs, name):
    for run, folder in hostile_runs[name]:
        assert (run.returncode, run.stdout) == (3, ""), run.stderr
        assert HOSTILE[name][1] in run.stderr and "Traceback" not in run.stderr and len(run.stderr) < 2000
        assert os.listdir(folder) == ["bad.yaml"]


def test_a_million_coordinates(tmp_path):
    run = lagrange("check", CHAIN, "--size", "N=1000000", cwd=tmp_path)
    assert run.returncode == 3 and "LAGRANGE_LIMITS=members=..." in run.stderr


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("case", [("fpu_chain", "N=100000"), ("lattice", "N=300", "M=300")])
def test_families_that_stay_families_may_be_large(tmp_path, case):
    name, *sizes = case
    options = [word for size in sizes for word in ("--size", size)]
    run = lagrange("check", SYSTEMS / f"{name}.yaml", *options, "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert [one["quantity"] for one in json.loads(run.stdout)["conserved"]] == ["h"]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("option", [("--over", "theta=0:1:1000000000000"), ("--random", "theta=normal(0,1)")])
def test_too_many_runs(tmp_path, option):
    drawn = ("--members", "1000000000000") if option[0] == "--random" else ()
    run = lagrange_process("sweep", PENDULUM, *option, *drawn, cwd=tmp_path)
    assert run.returncode == 2 and "LAGRANGE_LIMITS=runs=..." in run.stderr
    assert os.listdir(tmp_path) == []


def with_limits(monkeypatch, limits):
    monkeypatch.setenv("LAGRANGE_LIMITS", limits)


@pytest.mark.exhaustive(keep=0.55)
def test_limits_move(tmp_path, monkeypatch):
    (tmp_path / "family.yaml").write_text(SYSTEM + "sizes: {N: 20}\nobservables:\n  w[i in range(N)]: i*x\n")
    with_limits(monkeypatch, "members=19")
    assert "more than 19 members" in lagrange_process("check", "family.yaml", cwd=tmp_path).stderr
    with_limits(monkeypatch, "members=21, terms=1")
    assert lagrange_process("check", "family.yaml", cwd=tmp_path).returncode == 0


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize(
    "limits", ["members", "members=x", "member=1", "seconds=-1", "bytes=nan", "memory=1"]
)
def test_limits_that_make_no_sense(tmp_path, monkeypatch, limits):
    with_limits(monkeypatch, limits)
    run = lagrange_process("check", PENDULUM, cwd=tmp_path)
    assert run.returncode == 2 and run.stderr.startswith("Error: LAGRANGE_LIMITS: ")


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("gravity", ["9.81", "1e20"], ids=["far", "tiny steps"])
def test_a_motion_ends_when_its_time_is_over(tmp_path, monkeypatch, gravity):
    settings = ("--set", f"g={gravity}", "--stop", "1e9", "--samples", "3", "-o", "out.h5")
    lagrange_process("solve", PENDULUM, *settings, "--stop", "1e-8", cwd=tmp_path)  # compiles the program
    os.remove(tmp_path / "out.h5")
    with_limits(monkeypatch, "seconds=2")
    run = lagrange_process("solve", PENDULUM, *settings, cwd=tmp_path)
    assert run.returncode == 130 and run.stderr.endswith(
        "The time limit is reached: LAGRANGE_LIMITS=seconds=2\n"
    )
    with h5py.File(tmp_path / "out.h5") as file:
        assert file.attrs["status"] == "interrupted"


@pytest.mark.exhaustive(keep=0.2)
def test_a_derivation_ends_when_its_time_is_over(tmp_path, monkeypatch):
    with_limits(monkeypatch, "seconds=1")
    run = lagrange_process("equations", SYSTEMS / "bicycle.yaml", cwd=tmp_path)
    assert run.returncode == 130 and run.stderr.endswith(
        "The time limit is reached: LAGRANGE_LIMITS=seconds=1\n"
    )


def test_a_command_that_may_not_use_the_memory_it_needs(tmp_path, monkeypatch):
    with_limits(monkeypatch, "memory=750")
    run = lagrange_process("sweep", PENDULUM, "--over", "theta=0:1:100000000", cwd=tmp_path)
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


@pytest.fixture(scope="module")
def table_runs(tmp_path_factory):
    files = {name: ("table.csv", text) for name, (text, _) in TABLES.items()}
    with pytest.MonkeyPatch.context() as patch:
        with_limits(patch, "runs=100")
        sweep = ("sweep", PENDULUM, "--table", "table.csv")
        return limited_each(tmp_path_factory.mktemp("tables"), files, sweep)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", TABLES)
def test_a_table_from_elsewhere(table_runs, name):
    ((run, folder),) = table_runs[name]
    assert run.returncode == 2 and TABLES[name][1] in run.stderr, run.stderr
    assert len(run.stderr) < 2000 and os.listdir(folder) == ["table.csv"]


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


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("command", ["check", "solve"])
def test_equations_that_grow_beyond_bounds_are_refused_with_the_way_out(tmp_path, command, monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "nodes=700")
    chain = str(SYSTEMS / "n_pendulum.yaml")
    run = lagrange_process(command, chain, "--size", "N=11", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert run.stderr.startswith(chain) and "the equations have more than 700 terms" in run.stderr
    assert "LAGRANGE_LIMITS=nodes=" in run.stderr and not os.listdir(tmp_path)
    run = lagrange_process(command, chain, "--size", "N=4", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    if command == "check":  # the search for conserved quantities ends at the limit, and that is said
        assert "looking for all of them takes too much work" in run.stdout


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


@pytest.mark.exhaustive(keep=0.2)
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


@pytest.mark.exhaustive(keep=0.15)
def test_very_many_coordinates_are_refused_before_their_matrix_is_built(tmp_path, monkeypatch):
    """Here with a fraction of the work that is usually allowed. All of them are coupled."""
    with_limits(monkeypatch, "work=500000")
    text = "sizes: {N: 225}\ncoordinates:\n  x[i in range(N)]: {initial: 1}\n"
    energy = "sum(x_dot[i] for i in range(N))**2 + x[0]*x_dot[0]**2 - sum(x[i]**2 for i in range(N))"
    (tmp_path / "bad.yaml").write_text(f"{text}lagrangian: {energy}\n")
    run = limited("check", "bad.yaml", cwd=tmp_path)
    assert run.returncode == 3 and "a mass matrix of 225 coordinates takes more than" in run.stderr
    assert "LAGRANGE_LIMITS=work=" in run.stderr


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("command", ["check", "solve", "equations"])
def test_the_work_of_deriving_is_bounded(tmp_path, command, monkeypatch):
    with_limits(monkeypatch, "work=2000")
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")  # what has been derived before is not derived
    pendulum = str(SYSTEMS / "double_pendulum.yaml")
    run = lagrange_process(command, pendulum, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert f"{pendulum}: deriving the equations takes more than 2000 steps of work" in run.stderr
    assert "LAGRANGE_LIMITS=work=" in run.stderr and not os.listdir(tmp_path)


SAMPLED = "name: s\ncoordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - x**2/2\nsolve: {stop: 1}\n"


@pytest.mark.parametrize(
    ("command", "size"),
    [
        (("solve", "--samples", "30001"), "30001 samples, 40 bytes each, would take 0.0012 GB"),
        (
            ("sweep", "--over", "x=0:1:101", "--outputs", "q", "--samples", "1001"),
            "1001 samples of 101 members",
        ),
    ],
)
def test_an_output_that_would_be_large_is_refused_with_its_size(tmp_path, monkeypatch, command, size):
    (tmp_path / "s.yaml").write_text(SAMPLED)
    monkeypatch.setenv("LAGRANGE_LIMITS", "output=1")
    name, *options = command
    run = lagrange(name, "s.yaml", *options, cwd=tmp_path)
    assert run.returncode == 2 and size in run.stderr and "LAGRANGE_LIMITS=output=..." in run.stderr
    assert os.listdir(tmp_path) == ["s.yaml"]
    monkeypatch.setenv("LAGRANGE_LIMITS", "output=6")
    assert lagrange(name, "s.yaml", *options, cwd=tmp_path).returncode == 0


def test_samples_in_memory_are_as_many_as_those_of_a_file(tmp_path, monkeypatch):
    (tmp_path / "s.yaml").write_text(SAMPLED)
    monkeypatch.setenv("LAGRANGE_LIMITS", "output=1")
    with pytest.raises(UsageError, match="30001 samples, 40 bytes each"):
        lagrange_cli.solve(tmp_path / "s.yaml", samples=30001)
