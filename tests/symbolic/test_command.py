"""``lagrange equations`` as a user runs it."""

import json

import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.decimals import scientific
from lagrange_cli.run import verification
from lagrange_cli.symbolic.verify import Verification
from tests.support.command import SYSTEMS, lagrange, lagrange_process
from tests.support.systems import NAMES, SIZES

PENDULUM = SYSTEMS / "pendulum.yaml"


def test_json_goes_by_the_contract_and_takes_overrides(tmp_path):
    run = lagrange("equations", PENDULUM, "--json", "--set", "l=2", cwd=tmp_path)
    assert run.returncode == 0 and not run.stderr
    data = json.loads(run.stdout)
    assert data["parameters"] == {"m": 1.0, "g": 9.81, "l": 2.0}
    assert data["accelerations"] == {"theta": "-g*sin(theta)/l"}
    assert (
        lagrange("equations", PENDULUM, "--format", "json", "--set", "l=2", cwd=tmp_path).stdout == run.stdout
    )


def test_python_is_a_module(tmp_path):
    run = lagrange("equations", PENDULUM, "--format", "python", cwd=tmp_path)
    module: dict = {}
    exec(run.stdout, module)
    assert module["accelerations"](0.0, [0.5], [0.0]) == pytest.approx([-9.81 * 0.479425538604203])


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--format", "braille"], 2, "braille"),
        (["--form", "newton"], 2, "newton"),
        (["--json", "--format", "latex"], 2, "contradict"),
        (["--set", "nosuch=1"], 2, "nosuch"),
    ],
)
def test_wrong_usage(arguments, status, message, tmp_path):
    run = lagrange("equations", PENDULUM, *arguments, cwd=tmp_path)
    assert run.returncode == status and message in run.stderr and not run.stdout


def test_several_systems(tmp_path):
    run = lagrange("equations", PENDULUM, "missing.yaml", SYSTEMS / "atwood.yaml", cwd=tmp_path)
    assert run.returncode == 5
    assert "pendulum: 1 degree" in run.stdout and "Atwood machine: 1 degree" in run.stdout
    assert "missing.yaml" in run.stderr


@pytest.mark.exhaustive(keep=0.35)
def test_an_explicit_form_that_cannot_be_read_names_the_matrix(tmp_path):
    names = "abcd"
    chain = [" + ".join(f"sin({n})" for n in names[: k + 1]) for k in range(4)]
    heights = [" + ".join(f"cos({n})" for n in names[: k + 1]) for k in range(4)]
    (tmp_path / "chain.yaml").write_text(
        "coordinates: {" + ", ".join(f"{n}: {{initial: 1}}" for n in names) + "}\n"
        "masses: {"
        + ", ".join(f"b{k}: 1" for k in range(4))
        + "}\nembedding:\n"
        + "".join(
            f"  b{k}:\n    - {x}\n    - {y}\n" for k, (x, y) in enumerate(zip(chain, heights, strict=True))
        )
    )
    run = lagrange("equations", "chain.yaml", "--form", "explicit", cwd=tmp_path)
    assert run.returncode == 2 and "--form matrix" in run.stderr
    run = lagrange("equations", "chain.yaml", "--form", "hamilton", cwd=tmp_path)
    assert run.returncode == 0 and "Momenta, which determine the velocities" in run.stdout
    assert lagrange("equations", "chain.yaml", "--form", "matrix", cwd=tmp_path).returncode == 0


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_printed_is_what_is_integrated(name, capsys):
    sizes = [f"--size={size}={number}" for size, number in SIZES.get(name, {}).items()]
    status = main(["equations", str(SYSTEMS / f"{name}.yaml"), "--verify", "--json", *sizes])
    verdict = json.loads(capsys.readouterr().out)["verify"]
    assert status == 0 and verdict["agrees"]
    assert 0 < verdict["difference"] <= 1e-12
    assert verdict["states"] >= 10


@pytest.mark.parametrize("difference", [1e-16, 1e-3])
@pytest.mark.parametrize("arguments", [[], ["--json"], ["--format", "python"]])
def test_verify_decides_the_status(difference, arguments, monkeypatch, capsys):
    monkeypatch.setattr(verification, "verify_system", lambda *_: Verification(difference, "h", 20))
    status = main(["equations", str(PENDULUM), "--verify", *arguments])
    output = capsys.readouterr().out
    assert status == (0 if difference < 1e-12 else 4)
    if "--json" in arguments:
        assert json.loads(output)["verify"]["difference"] == difference
    else:
        assert scientific(difference) in output.splitlines()[-1]
        assert output.splitlines()[-1].startswith("#") == bool(arguments)


@pytest.mark.exhaustive(keep=0.2)
def test_the_text_is_the_same_whatever_order_sets_have(tmp_path, monkeypatch):
    outputs = set()
    for seed in "12":
        monkeypatch.setenv("PYTHONHASHSEED", seed)
        system = SYSTEMS / "double_pendulum.yaml"
        outputs.add(lagrange_process("equations", system, "--form", "hamilton", cwd=tmp_path).stdout)
    assert len(outputs) == 1
