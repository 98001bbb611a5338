"""The recipes of the page on the architecture: done as the page says, in a copy of the package, and used."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.support.command import PATIENCE, ROOT, environment

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^### (.*?)\n(.*?)(?=^### |\Z)", PAGE, re.MULTILINE | re.DOTALL))
PENDULUM = """\
time: s
parameters: {m: {value: 1, unit: kg}, l: {value: 2, unit: m}, g: {value: 9.81, unit: m/s^2}, c: 0.3}
coordinates: {theta: {initial: 1.5, velocity: 0.4, unit: rad}}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
solve: {stop: 3, samples: 31}
"""


def new_files(recipe: str) -> dict[str, str]:
    """The files that a recipe writes, by path."""
    blocks = re.findall(r"^```python\n# (lagrange_cli/\S+)\n(.*?)^```", recipe, re.MULTILINE | re.DOTALL)
    return dict(blocks)


def changes(recipe: str) -> list[tuple[str, str, str]]:
    """The changes of existing files that a recipe makes: path, text before, text after."""
    found = []
    for path, body in re.findall(r"^```diff\n--- (\S+)\n(.*?)^```", recipe, re.MULTILINE | re.DOTALL):
        for hunk in body.split("@@\n")[1:]:
            lines = hunk.splitlines(keepends=True)
            before, after = ("".join(x[1:] for x in lines if x[0] in kept) for kept in (" -", " +"))
            found.append((path, before, after))
    return found


def touched(recipe: str) -> set[str]:
    """The files of code that a recipe touches."""
    return {*new_files(recipe), *(path for path, _, _ in changes(recipe))}


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """A folder with a copy of the package in which every recipe has been followed."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(
        ROOT / "lagrange_cli", folder / "lagrange_cli", ignore=shutil.ignore_patterns("__pycache__")
    )
    for recipe in RECIPES.values():
        for path, before, after in changes(recipe):
            file = folder / path
            text = file.read_text(encoding="utf-8")
            assert text.count(before) == 1, f"{path} has not this once:\n{before}"
            file.write_text(text.replace(before, after), encoding="utf-8")
        for path, text in new_files(recipe).items():
            assert not (folder / path).exists()
            (folder / path).write_text(text, encoding="utf-8")
    return folder


def run(folder: Path, *arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
    """The command of the copy."""
    done = subprocess.run(
        [sys.executable, "-m", "lagrange_cli", *arguments],
        cwd=folder,
        env=environment() | {"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == status, done.stderr
    return done


def solved(folder: Path, text: str, *options: str) -> dict[str, np.ndarray]:
    """The datasets of a system's output, and their units under "units"."""
    (folder / "a.yaml").write_text(text)
    run(folder, "solve", "a.yaml", "--force", "--quiet", "--no-cache", *options)
    found: dict[str, np.ndarray] = {"units": {}}

    def add(name: str, one: h5py.Dataset | h5py.Group) -> None:
        if isinstance(one, h5py.Dataset):
            found[name], found["units"][name] = one[()], one.attrs.get("unit", "")

    with h5py.File(folder / "a.h5") as file:
        file.visititems(add)
    return found


@pytest.mark.parametrize(
    ("recipe", "most"),
    [("A force key", 4), ("An integration method", 2), ("An output dataset", 2), ("A command", 2)],
)
def test_a_recipe_touches_few_files(recipe, most):
    assert new_files(RECIPES[recipe]) and changes(RECIPES[recipe])
    assert len(touched(RECIPES[recipe])) <= most


@pytest.mark.exhaustive(keep=0.15)
def test_a_force_key_acts_as_the_force_that_it_stands_for(package):
    outputs = ("--outputs", "q,v,h,ledger")
    drag = solved(package, PENDULUM + "drag: {bob: c}\n", *outputs)
    force = solved(package, PENDULUM + "forces: {bob: [-c*bob.vx, -c*bob.vy]}\n", *outputs)
    for name in ("q/theta", "v/theta", "diagnostics/h", "diagnostics/ledger/h"):
        np.testing.assert_allclose(drag[name], force[name], rtol=0, atol=1e-12)
    assert drag["diagnostics/h"][-1] < drag["diagnostics/h"][0] - 1
    text = PENDULUM.replace("c: 0.3", "c: {value: 1, unit: kg}")
    (package / "a.yaml").write_text(f"{text}drag: {{bbo: c, bob: c}}\n")
    assert "unknown particle 'bbo' in drag" in run(package, "check", "a.yaml", status=3).stderr
    (package / "a.yaml").write_text(f"{text}drag: {{bob: c}}\n")
    assert "the drag on 'bob' is in kg, and should be in kg/s" in run(package, "check", "a.yaml").stderr


@pytest.mark.exhaustive(keep=0.2)
def test_a_method_follows_the_motion_and_what_it_cannot_do_is_refused(package):
    taylor = solved(package, PENDULUM)
    found = solved(package, PENDULUM, "--method", "GBS", "--tolerance", "1e-12")
    np.testing.assert_allclose(found["q/theta"], taylor["q/theta"], rtol=0, atol=1e-9)
    assert np.any(found["q/theta"] != taylor["q/theta"])
    wrong = run(package, "solve", "a.yaml", "--method", "gbs", "--precision", "double-double", status=2)
    assert "needs method taylor, not GBS" in wrong.stderr


@pytest.mark.exhaustive(keep=0.3)
def test_an_output_is_written_with_its_unit(package):
    found = solved(package, PENDULUM, "--outputs", "q,v,velocities")
    theta, omega = found["q/theta"], found["v/theta"]
    expected = 2 * omega[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=1)
    np.testing.assert_allclose(found["velocities/bob"], expected, rtol=0, atol=1e-12)
    assert found["units"]["velocities/bob"] == "m/s"
    assert "velocities" in run(package, "check", "a.yaml").stdout


def test_a_command_is_listed_and_runs(package):
    (package / "a.yaml").write_text(PENDULUM)
    assert "parameters" in run(package, "--help").stdout
    done = run(package, "parameters", "a.yaml", "--set", "l=2*m", "--json")
    assert json.loads(done.stdout)["parameters"] == {"m": 1.0, "l": 2.0, "g": 9.81, "c": 0.3}


def test_a_constraint_would_touch_about_twenty_files():
    rows = re.findall(r"^\| (`.*?) \|", RECIPES["A holonomic constraint"], re.MULTILINE)
    files = re.findall(r"`(\S+\.py)`( \(new\))?", " ".join(rows))
    assert 15 <= len(files) <= 22
    for path, new in files:
        assert (ROOT / "lagrange_cli" / path).exists() != bool(new), path


def test_the_page_names_every_package():
    packages = {path.parent.name for path in (ROOT / "lagrange_cli").glob("*/__init__.py")}
    described = set(re.findall(r"^\*\*`(\w+)`\*\* ", PAGE, re.MULTILINE))
    assert described == packages
    parts = re.split(r"^\*\*`(\w+)`\*\* ", PAGE, flags=re.MULTILINE)
    for package, paragraph in zip(parts[1::2], parts[2::2]):
        inner = {path.parent.name for path in (ROOT / "lagrange_cli" / package).glob("*/__init__.py")}
        assert set(re.findall(r"^- `(\w+)`: ", paragraph, re.MULTILINE)) == inner, package
        named = {*re.findall(r"`([a-z_]+/[a-z_/]+)`", paragraph)}
        for path in (ROOT / "lagrange_cli" / one for one in named if one.split("/")[0] in packages):
            assert path.is_dir() or path.with_suffix(".py").exists(), path


def test_the_page_shows_the_layers_of_the_import_contract():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    layers = re.search(r'containers = \["lagrange_cli"\]\nlayers = \[\n(.*?)\]', text, re.DOTALL)
    contract = [line.split(" | ") for line in re.findall(r'"(.*?)"', layers[1])]
    shown = re.search(r"^```text\n(  cli .*?)^  decimals", PAGE, re.MULTILINE | re.DOTALL)
    assert [*map(str.split, shown[1].splitlines())] == contract
