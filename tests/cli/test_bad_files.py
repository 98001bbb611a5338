"""Files that no person wrote by mistake alone: each is refused with one clear message, in little memory."""

import os
import resource

import pytest

from tests.support.command import SYSTEMS, lagrange, lagrange_processes

GOOD = (SYSTEMS / "pendulum.yaml").read_text(encoding="utf-8")
MEMORY = 500_000_000
"""Bytes of address space; what may be imported before a file is found wrong fits well into it."""
COMMANDS = ("solve", "check", "equations")


def with_potential(expression: str) -> bytes:
    """The pendulum with another potential."""
    before, _, after = GOOD.partition("potential:")
    return f"{before}potential: {expression}\n{after.partition(chr(10))[2]}".encode()


def aliases(levels: int) -> bytes:
    """A YAML bomb: each line holds nine times the one before."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, levels)]
    return "\n".join(lines).encode()


BAD = {
    "empty": (b"", "empty"),
    "blank": (b"\n\n   \n", "bad.yaml"),
    "binary": (bytes(range(256)) * 100, "bad.yaml"),
    "a tab": (GOOD.replace("  m:", "\tm:").encode(), "tab"),
    "aliases that multiply": (aliases(12), "alias"),
    "an alias of itself": (b"parameters: &a {x: *a}", "bad.yaml"),
    "brackets": (b"[" * 100_000, "bad.yaml"),
    "five megabytes": (b"# " + b"x" * 5_000_000, "bad.yaml"),
    "a tower of powers": (with_potential("9**9**9**9"), "exponent"),
    "a call of Python": (with_potential("__import__('os').system('touch hacked')"), "bad.yaml:"),
    "parentheses": (with_potential("(" * 10_000 + "theta" + ")" * 10_000), "too long"),
    "deep parentheses": (with_potential("(" * 400 + "theta" + ")" * 400), "nest"),
    "a long sum": (with_potential("+".join(["theta"] * 5000)), "too long"),
    "a caret": (with_potential("m^2"), "write ** for powers"),
    "a sum without end": (with_potential("sum(theta for i in range(10000000000))"), "terms in all"),
    "sums in sums": (
        with_potential("sum(theta*i*j*k for i in range(999) for j in range(999) for k in range(999))"),
        "terms",
    ),
    "a crowd": (
        GOOD.replace("theta:", "'x[i in range(10000000000)]': {initial: 0}\n  theta:").encode(),
        "members",
    ),
    "a misspelt name": (with_potential("m*g*l*cos(thta)"), "did you mean 'theta'?"),
    "numbers beyond doubles": (with_potential("m*g*theta*1e300*1e10"), "choose units"),
    "coefficients beyond doubles": (
        b"coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2*1e300*1e10\nsolve: {stop: 1}",
        "choose units",
    ),
    "no number": (GOOD.replace("m: {value: 1.0", "m: {value: .nan").encode(), "m"),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """What each command says of each file, in one process with little memory; and the folder it worked in."""
    root = tmp_path_factory.mktemp("bad")
    commands = []
    for i, (content, _) in enumerate(BAD.values()):
        (root / str(i)).mkdir()
        (root / str(i) / "bad.yaml").write_bytes(content)
        commands += [(root / str(i), (command, "bad.yaml")) for command in COMMANDS]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAGRANGE_LIMITS", "terms=20000")  # a tenth of the default, reached ten times as soon
        found = lagrange_processes(
            commands, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        )
    names = [(name, command) for name in BAD for command in COMMANDS]
    return {name: (run, folder) for name, run, (folder, _) in zip(names, found, commands, strict=True)}


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", BAD)
def test_one_clear_message(runs, name, command):
    run, folder = runs[name, command]
    assert (run.returncode, run.stdout) == (3, ""), run.stderr
    assert BAD[name][1] in run.stderr and run.stderr.startswith("bad.yaml:")
    assert len(run.stderr) < 2_000 and "Traceback" not in run.stderr
    assert os.listdir(folder) == ["bad.yaml"]


@pytest.mark.parametrize("command", ["solve", "check"])
def test_a_coordinate_that_no_kinetic_energy_depends_on(tmp_path, command):
    content = GOOD.replace("coordinates:\n", "coordinates:\n  idle: {initial: 1}\n  other: {initial: 2}\n")
    (tmp_path / "bad.yaml").write_text(content)
    line = content.splitlines().index("  idle: {initial: 1}") + 1
    run = lagrange(command, "bad.yaml", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert run.stderr.startswith(f"bad.yaml:{line}:3: no kinetic energy depends on the velocity of 'idle'\n")
    assert f"\nbad.yaml:{line + 1}:3: no kinetic energy depends on the velocity of 'other'\n" in run.stderr


@pytest.mark.parametrize(
    "text",
    ["lagrangian: (a_dot + b_dot)**2/2 - a*b", "masses: {p: 1}\npositions: {p: [cos(a + b), sin(a + b)]}"],
)
def test_more_coordinates_than_the_kinetic_energy_has_velocities(tmp_path, text):
    (tmp_path / "bad.yaml").write_text(f"coordinates: {{a: {{initial: 1}}, b: {{initial: 2}}}}\n{text}\n")
    run = lagrange("check", "bad.yaml", cwd=tmp_path)
    assert run.returncode == 3
    assert "the kinetic energy does not depend on the velocities of a and b separately" in run.stderr
