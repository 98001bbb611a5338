"""``lagrange solve --portable``: the same bits whatever the processor and the C library; what is refused."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import h5py
import llvmlite.binding as llvm
import mpmath
import numpy as np
import pytest

from lagrange_cli.cli.commands import solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.native.compilation import fingerprint
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_portable_values, resolve_values
from tests.support.command import PATIENCE, ROOT, SYSTEMS
from tests.support.motion import NAMES
from tests.support.portable_digests import all_digests, functions, shipped

OTHER_LIBRARY = "glibc.cpu.hwcaps=" + ",".join(
    f"-{ability}" for ability in ("FMA", "FMA_Usable", "FMA4", "FMA4_Usable", "AVX2", "AVX2_Usable")
)
"""What has glibc take its functions for older processors; elsewhere it means nothing."""
COORDINATE = b"coordinates: {x: {initial: 1}}\n"
SIMPLEST = ("", "")
ABLE = all(llvm.get_host_cpu_features().get(one) for one in ("fma", "avx2", "avx"))
KINDS = [SIMPLEST, ("haswell", "+fma,+avx2,+avx,")] if ABLE else [SIMPLEST]
"""Kinds of processor whose code this one can run."""


class AtOnce(Interrupts):
    """Ctrl-C before the first step."""

    def __call__(self) -> bool:
        return True


def check_digests(cpu: str, features: str, systems: list[str], folder: Path) -> None:
    """Hold what a process elsewhere computes against what this one does."""
    made = subprocess.run(
        [sys.executable, "-m", "tests.support.portable_digests", str(folder), cpu, features, *systems],
        env={**os.environ, "GLIBC_TUNABLES": OTHER_LIBRARY},
        cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    found = json.loads(made.stdout.splitlines()[-1])
    assert found == all_digests(folder, "here", "", systems) and set(found) == set(systems)


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(("cpu", "features"), KINDS)
def test_another_processor_and_library_give_the_same_bits_of_every_function(cpu, features, tmp_path):
    check_digests(cpu, features, functions(tmp_path), tmp_path)


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(("cpu", "features"), KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_another_processor_and_library_give_the_same_bits_of_shipped_systems(name, cpu, features, tmp_path):
    check_digests(cpu, features, [shipped(name)], tmp_path)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("cpu", "features"), KINDS)
@pytest.mark.parametrize("name", ["fpu_chain --size N=1000 --stop 2", "n_pendulum --size N=20 --stop 0.1"])
def test_another_processor_and_library_give_the_same_bits_of_families(name, cpu, features, tmp_path):
    system, *options = name.split()
    given = " ".join([shipped(system).split()[0], *options, "--outputs q,v,p,h"])
    check_digests(cpu, features, [given], tmp_path)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", ["double_pendulum", "spherical_pendulum", "driven_damped_pendulum"])
def test_it_is_the_same_motion(name, tmp_path):
    """Up to rounding: before chaos can show."""
    run = ["solve", str(SYSTEMS / f"{name}.yaml"), "--stop", "2", "--outputs", "all"]
    assert (
        main([*run, "-o", str(tmp_path / "a.h5")])
        == main([*run, "--portable", "-o", str(tmp_path / "b.h5")])
        == 0
    )
    with h5py.File(tmp_path / "a.h5") as plain, h5py.File(tmp_path / "b.h5") as portable:
        assert "portable" not in plain.attrs and portable.attrs["portable"] == 1
        for kind in ("q", "v"):
            for coordinate in set(plain[kind]) - {"t"}:
                np.testing.assert_allclose(
                    portable[kind][coordinate], plain[kind][coordinate], rtol=0, atol=1e-11
                )


def test_numbers_of_the_file_are_rounded_once():
    """Decimals, functions and powers: to the double nearest to what is written, here and everywhere."""
    text = (
        b"parameters: {a: 0.1*3, b: 10**0.5, c: sin(pi)}\n" + COORDINATE + b"lagrangian: x_dot**2/2 - a*x\n"
    )
    spec = read_spec(text, "a.yaml")
    values = resolve_portable_values(spec)
    assert values.parameters["a"] == 0.3 and resolve_values(spec).parameters["a"] != 0.3
    assert values.parameters["b"] == math.sqrt(10) and abs(values.parameters["c"]) < 1e-60
    assert values.remainder is None


def test_numbers_of_expressions_are_rounded_once():
    spec = read_spec(COORDINATE + b"lagrangian: x_dot**2/2 - sin(0.7)**0.3*x\n", "a.yaml")
    residual = derive_system(spec, portable=True)
    with mpmath.workdps(50):
        sine = float(mpmath.sin(0.7))
        power = float(mpmath.mpf(sine) ** mpmath.mpf(0.3))
    assert residual.residual[0].data[0] == power


@pytest.mark.exhaustive(keep=0.6)
def test_a_run_that_is_kept_compiled_is_that_of_its_kind(tmp_path):
    """A portable program is not taken for a plain one, nor the other way."""
    run = ["solve", str(SYSTEMS / "double_pendulum.yaml"), "--stop", "3"]
    made = {}
    for i, options in enumerate([[], ["--portable"], [], ["--portable"]]):
        assert main([*run, *options, "-o", str(tmp_path / f"{i}.h5")]) == 0
        made[i] = (tmp_path / f"{i}.h5").read_bytes()
    assert made[0] == made[2] != made[1] == made[3]


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize(("options", "code"), [(["--portable"], 0), ([], 5)])
def test_it_goes_on_on_another_machine(options, code, tmp_path, monkeypatch):
    """To the same bytes; a plain run does not."""
    run = ["solve", str(SYSTEMS / "double_pendulum.yaml"), "--stop", "60", *options]
    run += ["-o", str(tmp_path / "out.h5")]
    assert main(run) == 0
    expected = (tmp_path / "out.h5").read_bytes()
    monkeypatch.setattr(solving, "Interrupts", AtOnce)
    assert main([*run, "--force"]) == 130
    assert (tmp_path / "out.h5").read_bytes() != expected
    monkeypatch.setattr(solving, "Interrupts", Interrupts)
    monkeypatch.setattr(fingerprint, "processor", lambda: ["another one"])
    assert main([*run, "--resume"]) == code
    assert ((tmp_path / "out.h5").read_bytes() == expected) == (code == 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--method", "LSODA"), "--portable needs method taylor, ias15, DOP853 or Radau, not LSODA"),
        (("--certify",), "--certify and --portable cannot be combined"),
    ],
)
def test_what_is_not_portable_is_refused(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["solve", str(SYSTEMS / "pendulum.yaml"), "--portable", *options]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
