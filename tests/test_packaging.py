"""What is shipped: the wheel's content, and README's two lines against what CI runs."""

import json
import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import click
import pytest
import yaml

import lagrange_cli
from lagrange_cli.cli.main import COMMANDS
from lagrange_cli.run import shipped

ROOT = Path(__file__).resolve().parent.parent
INFO = f"lagrange_cli-{lagrange_cli.__version__}.dist-info"
LARGEST = 4_000_000
"""Bytes of a wheel, or of a source distribution."""


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


def metadata_of(wheel):
    return wheel.read(f"{INFO}/METADATA").decode()


@pytest.mark.exhaustive(keep=0.45)
def test_every_system_is_in_the_wheel_as_it_is_in_the_checkout(wheel):
    systems = sorted(ROOT.glob("systems/*.yaml"))
    assert len(systems) >= 20
    for path in systems:
        assert wheel.read(f"lagrange_cli/systems_data/{path.name}") == path.read_bytes()


@pytest.mark.exhaustive(keep=0.35)
def test_the_wheel_holds_every_module_and_no_test(wheel):
    modules = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("lagrange_cli/**/*.py")}
    assets = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("lagrange_cli/page/assets/*")}
    names = set(wheel.namelist())
    assert modules <= names
    assert assets <= names
    assert len(assets) > 10
    assert not [name for name in names if name.startswith(("tests", "systems/", "docs"))]


def test_three_js_is_there_with_its_license_in_the_version_that_its_tools_name(wheel):
    asked = json.loads((ROOT / "tools" / "three" / "package.json").read_text(encoding="utf-8"))
    text = wheel.read("lagrange_cli/page/assets/three.js").decode()
    assert text.startswith(f"/* three.js {asked['dependencies']['three']}, ")
    license = wheel.read("lagrange_cli/page/assets/three.LICENSE").decode().strip()
    assert "Permission is hereby granted" in license and license in text
    assert "License-File: lagrange_cli/page/assets/three.LICENSE" in metadata_of(wheel)


def test_types_and_manual_pages_are_in_the_wheel(wheel):
    names = wheel.namelist()
    assert "lagrange_cli/py.typed" in names
    data = f"lagrange_cli-{lagrange_cli.__version__}.data/data/share/man/man1"
    for command in ("", *(f"-{name}" for name in COMMANDS)):
        page = wheel.read(f"{data}/lagrange{command}.1").decode()
        assert page.startswith(".TH") and "EXIT STATUS" in page


@pytest.mark.skipif(shutil.which("groff") is None, reason="this checks the form of the manual pages")
def test_manual_pages_are_in_good_form():
    for path in sorted(ROOT.glob("docs/man/*.1")):
        run = subprocess.run(
            ["groff", "-man", "-Tutf8", "-ww", "-z", str(path)], capture_output=True, text=True, check=True
        )
        assert run.stderr == "", run.stderr


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("form", ["wheel", "sdist"])
def test_it_installs_in_an_environment_without_it(form, tmp_path):
    """Its dependencies are those of this environment: README's first line, which CI runs, installs them."""
    built = tmp_path / "dist"
    build = [sys.executable, "-m", "hatchling", "build", "-t", form, "-d", str(built)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (package,) = built.iterdir()
    assert package.stat().st_size < LARGEST
    venv.create(tmp_path / "bare")
    python = next((tmp_path / "bare").glob("[bS]*/python*"))
    (site,) = (tmp_path / "bare").glob("lib/python*/site-packages")
    others = str(Path(click.__file__).parents[1])
    (site / "others.pth").write_text(f"{others}\n")
    install = [sys.executable, "-m", "pip", "--python", str(python), "install", "-q", "--no-index", "-I"]
    subprocess.run(
        [*install, "--no-deps", "--no-build-isolation", str(package)],
        env={**os.environ, "PYTHONPATH": others},
        check=True,
    )
    manual = tmp_path / "bare" / "share" / "man" / "man1" / "lagrange-solve.1"
    assert manual.read_bytes() == (ROOT / "docs" / "man" / "lagrange-solve.1").read_bytes()
    command, folder = python.parent / "lagrange", tmp_path / "empty"
    folder.mkdir()
    text = subprocess.run(
        [command, "systems", "pendulum"], cwd=folder, check=True, capture_output=True
    ).stdout
    (folder / "pendulum.yaml").write_bytes(text)
    subprocess.run([command, "solve", "pendulum.yaml", "--quiet"], cwd=folder, check=True)
    where = subprocess.run(
        [python, "-c", "import lagrange_cli; print(lagrange_cli.__file__, lagrange_cli.__version__)"],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert where.startswith(str(site)) and where.split()[1] == lagrange_cli.__version__
    assert (folder / "pendulum.h5").stat().st_size > 10_000


def test_what_an_extra_installs_is_what_a_message_says():
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    extras = set(
        re.findall(r"^(\w+) = \[$", project.partition("[project.optional-dependencies]")[2], re.MULTILINE)
    )
    named = {
        extra
        for path in ROOT.glob("lagrange_cli/**/*.py")
        for extra in re.findall(r'MissingPackage\([^)]*"(\w+)"\)', path.read_text(encoding="utf-8"))
    }
    assert {"animate", "plot", "xarray"} <= named <= extras and {"notebook", "all"} <= extras
    (every,) = re.findall(r'^all = \[\n *"lagrange-cli\[(.*?)\]"', project, re.MULTILINE)
    assert {*every.split(",")} >= named


def test_the_citation_has_the_version():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == lagrange_cli.__version__ and cited["license"] == "MIT"


def test_the_command_and_the_version_are_declared(wheel):
    assert "lagrange = lagrange_cli.__main__:run" in wheel.read(f"{INFO}/entry_points.txt").decode()
    metadata = metadata_of(wheel)
    assert "Requires-Python: >=3.10" in metadata
    assert "License-Expression: MIT" in metadata


def test_an_unpacked_wheel_finds_its_systems_without_a_checkout(wheel, tmp_path):
    wheel.extractall(tmp_path)
    run = subprocess.run(
        [sys.executable, "-c", "import lagrange_cli.run.shipped as s; print(s.folder()); print(s.names())"],
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
