"""What is shipped: the wheel's content, and README's two lines against what CI runs."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import lagrange_cli
from lagrange_cli.cli import shipped

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        yield archive


def test_every_system_is_in_the_wheel_as_it_is_in_the_checkout(wheel):
    systems = sorted(ROOT.glob("systems/*.yaml"))
    assert len(systems) >= 20
    for path in systems:
        assert wheel.read(f"lagrange_cli/systems_data/{path.name}") == path.read_bytes()


def test_the_wheel_holds_every_module_and_no_test(wheel):
    modules = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("lagrange_cli/**/*.py")}
    names = set(wheel.namelist())
    assert modules <= names
    assert not [name for name in names if name.startswith(("tests", "systems/", "docs"))]


def test_the_command_and_the_version_are_declared(wheel):
    info = f"lagrange_cli-{lagrange_cli.__version__}.dist-info"
    assert "lagrange = lagrange_cli.__main__:run" in wheel.read(f"{info}/entry_points.txt").decode()
    metadata = wheel.read(f"{info}/METADATA").decode()
    assert "Requires-Python: >=3.10" in metadata
    assert "License-Expression: MIT" in metadata


def test_an_unpacked_wheel_finds_its_systems_without_a_checkout(wheel, tmp_path):
    wheel.extractall(tmp_path)
    run = subprocess.run(
        [sys.executable, "-c", "import lagrange_cli.cli.shipped as s; print(s.folder()); print(s.names())"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    folder, names = run.stdout.splitlines()
    assert Path(folder) == (tmp_path / "lagrange_cli" / "systems_data").resolve()
    assert names == str(shipped.names())


def test_everything_the_package_offers_is_there():
    assert sorted(lagrange_cli.__all__) == lagrange_cli.__all__
    for name in lagrange_cli.__all__:
        assert getattr(lagrange_cli, name).__name__ == name
    with pytest.raises(AttributeError):
        lagrange_cli.nosuch  # noqa: B018


def test_readme_has_the_two_lines_that_ci_runs():
    lines = re.findall(
        r"^python3 -m venv .*$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    run, test = lines
    assert run.endswith("lagrange solve systems/pendulum.yaml")
    assert test.endswith("-m pytest -q -n auto")
    assert "grep '^python3 -m venv ' README.md" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_readme_speaks_of_no_file_that_does_not_exist():
    for page in [ROOT / "README.md", *ROOT.glob("docs/*.md")]:
        for link in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"
