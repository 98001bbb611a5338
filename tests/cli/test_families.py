"""Systems of families from the command line: their output, their printed equations, their motion."""

import json

import h5py
import numpy as np
import pytest
import sympy
import xarray

from tests.support.command import SYSTEMS, lagrange

N_PENDULUM, CHAIN, LATTICE = (SYSTEMS / f"{name}.yaml" for name in ("n_pendulum", "fpu_chain", "lattice"))


def solve(*arguments, cwd) -> dict:
    run = lagrange("solve", "--json", *arguments, cwd=cwd)
    assert (run.returncode, run.stderr) == (0, ""), run.stderr
    return json.loads(run.stdout)


@pytest.mark.exhaustive(keep=0.2)
def test_two_bobs_are_the_double_pendulum_to_the_last_bit(tmp_path):
    options = ["--stop", "5", "--outputs", "all"]
    start = ["--size", "N=2", "--set", "theta[1]=2.5"]
    chain = solve(N_PENDULUM, *start, *options, cwd=tmp_path)
    double = solve(SYSTEMS / "double_pendulum.yaml", *options, cwd=tmp_path)
    assert chain["steps"] == double["steps"]
    with h5py.File(tmp_path / "n_pendulum.h5") as short, h5py.File(tmp_path / "double_pendulum.h5") as long:
        for path in ("q/theta", "v/theta", "diagnostics/p/theta", "diagnostics/ledger/p/theta"):
            assert short[path].shape == (501, 2)
            for i in (0, 1):
                np.testing.assert_array_equal(short[path][:, i], long[f"{path}{i + 1}"])
        assert short["positions/bob"].shape == (501, 2, 2)
        for i, name in enumerate(("upper", "lower")):
            found, known = short["positions/bob"][:, i], long[f"positions/{name}"][()]
            np.testing.assert_array_equal(found, known)
        np.testing.assert_array_equal(short["diagnostics/h"], long["diagnostics/h"])
        assert json.loads(short.attrs["sizes"]) == {"N": 2}
        assert "sizes" not in long.attrs


@pytest.mark.exhaustive(keep=0.75)
def test_a_family_is_one_dataset_with_axes_that_xarray_knows(tmp_path):
    solve(LATTICE, "--size", "N=3", "--set", "u[N-1,1]=0.25", "--stop", "1", "--step", "0.5", cwd=tmp_path)
    with xarray.open_dataset(tmp_path / "lattice.h5", group="q", engine="h5netcdf") as data:
        assert data["u"].dims == ("t", "N", "M")
        assert data["u"].shape == (3, 3, 4)
        assert data["u"].attrs["unit"] == "rad"
        assert float(data["u"].sel(t=0, N=2, M=1)) == 0.25
        assert data["u"].sel(t=0, N=1).values == pytest.approx(
            2 * np.exp(-((np.arange(4) - 2) ** 2) / 1.5**2)
        )


@pytest.mark.exhaustive(keep=0.45)
def test_modes_of_the_harmonic_chain_keep_their_energies(tmp_path):
    options = ["--set", "alpha=0", "--size", "N=6", "--size", "modes=6", "--stop", "100", "--samples", "50"]
    summary = solve(CHAIN, *options, "--set", "u[2]=1.5", "--outputs", "h,observables", cwd=tmp_path)
    with h5py.File(tmp_path / "fpu_chain.h5") as file:
        energies = file["observables/mode_energy"][()]
        assert energies.shape == (50, 6)
        np.testing.assert_allclose(energies, np.broadcast_to(energies[0], energies.shape), atol=1e-14)
        np.testing.assert_allclose(energies.sum(axis=1), file["diagnostics/h"], rtol=1e-14)
    assert summary["h_drift"] < 1e-14


@pytest.mark.exhaustive(keep=0.55)
def test_the_nonlinear_chain_keeps_its_energy_and_hands_it_on(tmp_path):
    summary = solve(CHAIN, "--stop", "2000", "--samples", "201", cwd=tmp_path)
    assert summary["h_drift"] < 1e-13
    with h5py.File(tmp_path / "fpu_chain.h5") as file:
        lowest = file["observables/mode_energy"][:, 0]
        assert lowest.min() < 0.9 * lowest[0]


@pytest.mark.exhaustive(keep=0.65)
def test_three_bodies_come_back_along_the_eight(tmp_path):
    solve(SYSTEMS / "figure_eight.yaml", "--stop", "6.32591398", "--samples", "4", "--force", cwd=tmp_path)
    with h5py.File(tmp_path / "figure_eight.h5") as file:
        start, third, _, end = np.stack([file["q/x"], file["q/y"]], axis=-1)
        np.testing.assert_allclose(end, start, atol=1e-7)
        np.testing.assert_allclose(third, np.roll(start, 1, axis=0), atol=1e-6)


@pytest.mark.exhaustive(keep=0.4)
def test_the_planets_keep_their_distances(tmp_path):
    summary = solve(SYSTEMS / "solar_system.yaml", "--size", "N=5", "--outputs", "positions", cwd=tmp_path)
    assert summary["status"] == "complete"
    with h5py.File(tmp_path / "solar_system.h5") as file:
        positions = file["positions/body"][()]
        assert positions.shape == (3654, 5, 3)
        distances = np.linalg.norm(positions[:, 1:] - positions[:, :1], axis=-1)
    # perihelia and aphelia in astronomical units, as almanacs have them
    for k, (nearest, farthest) in enumerate([(0.307, 0.467), (0.718, 0.728), (0.983, 1.017), (1.381, 1.666)]):
        assert distances[:, k].min() == pytest.approx(nearest, abs=2e-3)
        assert distances[:, k].max() == pytest.approx(farthest, abs=2e-3)


FREE = """\
sizes: {N: 30}
coordinates:
  x[i in range(N)]: {initial: i, velocity: 1}
masses:
  p[i in range(N)]: 1 + i
embedding:
  p[i in range(N)]: x[i]
"""


@pytest.mark.exhaustive(keep=0.15)
def test_what_is_said_of_many_members_stays_short(tmp_path):
    (tmp_path / "free.yaml").write_text(FREE, encoding="utf-8")
    run = lagrange("solve", "free.yaml", "--stop", "1", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert all(len(line) < 120 for line in run.stdout.splitlines())
    assert "largest of 30 momenta, p_x[" in run.stdout
    summary = solve("free.yaml", "--stop", "1", "--force", cwd=tmp_path)
    assert list(summary["p_drift"]) == [f"x[{i}]" for i in range(30)]
    check = lagrange("check", "free.yaml", cwd=tmp_path)
    assert "  coordinates: x[0..29]\n  cyclic: x[0..29]\n" in check.stdout
    assert check.stdout.count("p_x[") == 1 and "   [for i in range(30)]\n" in check.stdout
    (tmp_path / "held.yaml").write_text(FREE + "potential: x[0]**2\n", encoding="utf-8")
    held = lagrange("check", "held.yaml", cwd=tmp_path).stdout
    assert "  cyclic: x[1..29]\n" in held and held.count("p_x[") == 1
    assert "   [for i in range(1, 30)]\n" in held
    (tmp_path / "pairs.yaml").write_text(
        FREE + "potential: sum(x[i]**2 for i in range(N) if i % 3 == 0)\n", encoding="utf-8"
    )
    pairs = lagrange("check", "pairs.yaml", "--size", "N=60", cwd=tmp_path).stdout
    assert "more, see --json" in pairs and pairs.count("p_x[") == 20
    facts = json.loads(lagrange("check", "free.yaml", "--json", "--size", "N=2", cwd=tmp_path).stdout)
    assert (facts["degrees_of_freedom"], facts["cyclic"]) == (2, ["x[0]", "x[1]"])
    assert [each["expression"] for each in facts["conserved"][:2]] == ["dL/dx_dot[0]", "dL/dx_dot[1]"]


@pytest.mark.exhaustive(keep=0.35)
def test_many_masses_that_are_not_coupled_are_listed_in_short(tmp_path):
    (tmp_path / "free.yaml").write_text(FREE.replace("x[i]\n", "x[i] + x[i - i % 2]\n"), encoding="utf-8")
    check = lagrange("check", "--verbose", "free.yaml", cwd=tmp_path)
    assert "{x[0], x[1]}, {x[2], x[3]}" in check.stdout
    assert all(len(line) < 200 for line in check.stdout.splitlines())


@pytest.mark.exhaustive(keep=0.15)
def test_text_says_members_as_the_file_does(tmp_path):
    run = lagrange("equations", N_PENDULUM, "--size", "N=2", "--verify", cwd=tmp_path)
    assert "theta_ddot[1] + g*sin(theta[0])" in run.stdout or "l*theta_ddot[1]" in run.stdout
    assert "p_theta[0] = " in run.stdout
    assert "equations agree" in run.stdout
    latex = lagrange("equations", N_PENDULUM, "--size", "N=2", "--format", "latex", cwd=tmp_path).stdout
    assert r"\ddot{\theta}_{1}" in latex and r"p_{\theta_{0}}" in latex
    unicode = lagrange(
        "equations", LATTICE, "--size", "N=2", "--size", "M=2", "--format", "unicode", cwd=tmp_path
    )
    assert "u̇₀,₁²" in unicode.stdout


@pytest.mark.exhaustive(keep=0.75)
def test_the_printed_equations_are_those_of_the_double_pendulum(tmp_path):
    start = ["--size", "N=2", "--format", "json"]
    chain = json.loads(lagrange("equations", N_PENDULUM, *start, cwd=tmp_path).stdout)
    double = json.loads(
        lagrange("equations", SYSTEMS / "double_pendulum.yaml", "--json", cwd=tmp_path).stdout
    )
    names = chain["symbols"]
    assert names["theta_ddot[1]"] == "theta_ddot_1"
    known = {f"{kind}_{i}": f"{kind}{i + 1}" for kind in ("theta",) for i in (0, 1)}
    known |= {f"theta_{dot}_{i}": f"theta{i + 1}_{dot}" for dot in ("dot", "ddot") for i in (0, 1)}
    same = {
        **{name: sympy.Symbol(other) for name, other in known.items()},
        "l": sympy.Symbol("l"),
        "m": sympy.Symbol("m"),
    }
    equal = dict.fromkeys(("l1", "l2"), same["l"]) | dict.fromkeys(("m1", "m2"), same["m"])

    def vanishes(expression: sympy.Expr) -> bool:
        symbols = sorted(expression.free_symbols, key=str)
        state = {one: sympy.Rational(2 * k + 3, 7) for k, one in enumerate(symbols)}
        return abs(expression.subs(state).evalf(40)) < 1e-35

    for key in ("T", "U", "h"):
        left = sympy.sympify(chain[key], locals=same)
        right = sympy.sympify(double[key]).subs(equal)
        assert vanishes(left - right) and not vanishes(left - 2 * right)
    for i in (0, 1):
        left = sympy.sympify(chain["accelerations"][f"theta[{i}]"], locals=same)
        right = sympy.sympify(double["accelerations"][f"theta{i + 1}"]).subs(equal)
        assert vanishes(left - right)


@pytest.mark.exhaustive(keep=0.15)
def test_every_string_of_the_json_is_read_back_by_sympy(tmp_path):
    (tmp_path / "taken.yaml").write_text(
        "parameters: {m: [2], m_0: 3}\n"
        "coordinates:\n  x[i in range(1), j in range(2)]: {}\n  x_0_1: {}\n"
        "lagrangian: sum(m[i]*x_dot[i, j]**2/2 - m_0*x[i, j]*x_0_1 "
        "for i in range(1) for j in range(2)) + x_0_1_dot**2",
        encoding="utf-8",
    )
    data = json.loads(
        lagrange("equations", "taken.yaml", "--json", "--form", "hamilton", cwd=tmp_path).stdout
    )
    assert data["symbols"]["x[0,1]"] == "x_0_1_"
    assert data["symbols"]["m[0]"] == "m_0_"
    free = sympy.sympify(data["L"]).free_symbols
    assert {str(symbol) for symbol in free} >= {"x_0_1", "x_0_1_", "m_0", "m_0_", "x_dot_0_0"}
    assert "p_x_0_0" in {str(one) for one in sympy.sympify(data["hamiltonian"]).free_symbols}
    source = lagrange("equations", "taken.yaml", "--format", "python", cwd=tmp_path).stdout
    module: dict = {}
    exec(source, module)
    known = {"m[0]": 2.0, "m_0": 3.0}
    accelerations = module["accelerations"](0, [0, 0, 1.0], [0] * 3, known)
    assert accelerations == pytest.approx((-1.5, -1.5, 0))
    assert module["COORDINATES"] == ("x[0,0]", "x[0,1]", "x_0_1")


def test_a_coordinate_without_kinetic_energy_is_shown_at_its_key(tmp_path):
    text = FREE.replace("1 + i\n", "1 + i\n").replace("x[i]\n", "x[i - i//29]\n")
    (tmp_path / "idle.yaml").write_text(text, encoding="utf-8")
    run = lagrange("check", "idle.yaml", cwd=tmp_path)
    assert run.returncode == 3
    assert run.stderr.startswith("idle.yaml:3:3: no kinetic energy depends on the velocity of 'x[29]'")
    assert run.stderr.count("idle.yaml") == 1


@pytest.mark.exhaustive(keep=0.45)
def test_chains_are_printed_with_indices_however_long_they_are(tmp_path):
    run = lagrange("equations", N_PENDULUM, "--size", "N=300", "--verify", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert "U = -m*l*g*sum((N - j)*cos(theta[j]) for j in range(N))" in run.stdout
    assert "printed and compiled equations agree" in run.stdout
    check = lagrange("check", N_PENDULUM, "--size", "N=1000", cwd=tmp_path)
    assert (check.returncode, check.stderr) == (0, "")
    assert "h = T + U: L does not depend on t explicitly" in check.stdout


@pytest.mark.parametrize(
    ("system", "options", "status", "said"),
    [
        (N_PENDULUM, ["--form", "vakonomic"], 3, "--form vakonomic writes out every member"),
        (SYSTEMS / "chain.yaml", ["--form", "vakonomic"], 3, "--form vakonomic writes out every member"),
    ],
)
def test_why_members_are_written_out_and_what_can_be_done(
    system, options, status, said, tmp_path, monkeypatch
):
    if status == 3:
        monkeypatch.setenv("LAGRANGE_LIMITS", "work=500000")
    run = lagrange("equations", system, "--size", "N=100", *options, cwd=tmp_path)
    assert run.returncode == status
    assert said in run.stderr and "such as --size N=4" in run.stderr
