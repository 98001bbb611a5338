"""The power series of every operation, against series from elsewhere."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.native.recurrences import jet, layout
from lagrange_cli.series.lowering import lower
from tests.support.draws import examples
from tests.support.motion import follow, prepared, residual_of

FUNCTIONS = {
    "sin(u)": mpmath.sin,
    "cos(u)": mpmath.cos,
    "tan(u)": mpmath.tan,
    "asin(u/3)": lambda u: mpmath.asin(u / 3),
    "acos(u/3)": lambda u: mpmath.acos(u / 3),
    "atan(u)": mpmath.atan,
    "atan2(u, 2 + u**2)": lambda u: mpmath.atan2(u, 2 + u**2),
    "sinh(u)": mpmath.sinh,
    "cosh(u)": mpmath.cosh,
    "tanh(u)": mpmath.tanh,
    "exp(-u)": lambda u: mpmath.exp(-u),
    "log(3 + u)": lambda u: mpmath.log(3 + u),
    "sqrt(3 + u)": lambda u: mpmath.sqrt(3 + u),
    "1/(3 + u)": lambda u: 1 / (3 + u),
    "u**2": lambda u: u**2,
    "u**7": lambda u: u**7,
    "(3 + u)**-2": lambda u: (3 + u) ** -2,
    "(3 + u)**-1.5": lambda u: (3 + u) ** mpmath.mpf(-1.5),
    "(3 + u)**0.7": lambda u: (3 + u) ** mpmath.mpf(0.7),
    "(3 + u)**c": lambda u: (3 + u) ** mpmath.mpf(1.3),
    "2**u": lambda u: mpmath.mpf(2) ** u,
    "(3 + u)**u": lambda u: (3 + u) ** u,
    "sin(u)*exp(-u**2)/(2 + cos(u))": lambda u: mpmath.sin(u) * mpmath.exp(-(u**2)) / (2 + mpmath.cos(u)),
    "norm((u, 1, 2))": lambda u: mpmath.sqrt(u**2 + 5),
}

FORCED = """
parameters: {{c: 1.3}}
coordinates:
  x: {{initial: 0}}
  y: {{initial: 0.1, velocity: 0.5}}
masses: {{p: 1}}
embedding: {{p: [x, y]}}
definitions: {{u: {u}}}
generalized_forces: {{x: "{force}"}}
"""


BRANCHES = (
    ("sin(x*y)*y_dot - x", "x_dot**2"),
    ("x", "-x**3"),
    ("t*x", "7"),
    ("where(a < 0, x*y, y)", "where(a < 2, cos(x), exp(y))"),
    ("sqrt(-5 + a)", "y_dot"),
)
CHOICE = """
parameters: {{a: 1.3}}
coordinates: {{x: {{initial: 0.7, velocity: 0.2}}, y: {{initial: 0.1, velocity: 0.5}}}}
lagrangian: (x_dot**2 + y_dot**2 + x_dot*y_dot/2)/2
generalized_forces: {{x: "{x}", y: "{y}"}}
"""


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("one", "other"), BRANCHES)
def test_a_constant_chooses_each_coefficient(one, other):
    """What is not chosen may have no value."""
    chosen = CHOICE.format(
        x=f"sin(where(a < 1, {one}, {other}))", y=f"where(a > 1, {other}, {one})*x**2 + 2*x"
    )
    plain = CHOICE.format(x=f"sin({other})", y=f"({other})*x**2 + 2*x")
    found, known = (follow(system, 0.5, 3)["q/x"] for system in (chosen, plain))
    assert np.max(np.abs(found - known)) < 1e-15


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("u", ["0.1 + 0.5*t", "y", "y_dot*t + 0.1", "asin(sin(0.1 + 0.5*t))"])
@pytest.mark.parametrize("force", FUNCTIONS)
def test_a_force_that_is_a_known_function_of_time(force, u):
    """x'' = f(u) with u = 0.1 + t/2, however u is written: x' is an integral."""
    motion = follow(FORCED.format(u=u, force=force), 2.0, 3)
    function = FUNCTIONS[force]
    for t, rate in zip(motion["t"][1:], motion["v/x"][1:]):
        expected = mpmath.quad(lambda s: function(mpmath.mpf("0.1") + s / 2), [0, float(t)])
        assert abs(rate - float(expected)) <= 2e-13 * max(1.0, abs(float(expected)))


ELLIPSOID = """
parameters: {a: 1.5, b: 0.7, m: 2, k: 3}
coordinates:
  u: {initial: 0.4, velocity: 0.3}
  w: {initial: 0.9, velocity: -0.2}
masses: {p: m, q: 1}
embedding:
  p: [a*cos(u)*cosh(w)/2, b*sin(u)*sin(w + t), exp(-w)/(2 + u**2)]
  q: [tanh(u*w), sqrt(1 + w**2), atan2(u, 2 + w)]
potential: k*(p.x**2 + p.y**2)/2 + log(2 + sin(u)) - 1/norm(p - q + (0, 0, 3)) + 0.1*u_dot*w
dissipation: 0.01*(u_dot**2 + w_dot**2)
"""


def shape_code(monkeypatch, stages, few):
    """So many stages unrolled; dot products in loops where there are more than ``few`` groups."""
    monkeypatch.setattr(jet, "ALONE", 0)
    monkeypatch.setattr(jet, "UNROLLED", stages)
    monkeypatch.setattr(jet, "FEW_GROUPS", few)


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(("stages", "few"), [(3, 0), (3, 99), (7, 0), (10, 99), (60, 0)])
def test_loops_and_unrolled_stages_agree(stages, few, monkeypatch):
    """Everything at once: each way to write the stages gives the same motion, and the ledgers close."""
    reference = follow(ELLIPSOID, 3.0, outputs=("q", "v", "p", "h", "ledger"))
    shape_code(monkeypatch, stages, few)
    prepared.cache_clear()
    motion = follow(ELLIPSOID, 3.0, outputs=("q", "v", "p", "h", "ledger"))
    prepared.cache_clear()
    for path, series in motion.data.items():
        assert np.max(np.abs(series - reference[path])) <= 1e-12, path
        if "ledger" in path:
            assert np.max(np.abs(series)) <= 1e-12, path


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "system",
    ["double_pendulum", "spherical_pendulum", "free_particles", "rotating_hoop", "parabola_bead", "pendulum"],
)
@pytest.mark.parametrize(("stages", "few"), [(3, 0), (3, 99), (60, 0)])
def test_every_shape_of_code_closes_the_ledgers(system, stages, few, monkeypatch):
    shape_code(monkeypatch, stages, few)
    prepared.cache_clear()
    motion = follow(system, 10.0, outputs=("q", "v", "p", "h", "ledger", "action"))
    prepared.cache_clear()
    for path, series in motion.data.items():
        if "ledger" in path:
            assert np.max(np.abs(series)) <= 1e-12 * max(1.0, np.max(np.abs(motion["diagnostics/h"]))), path


ARRANGED = [("MIXED", 0), ("MIXED", 8), ("FEW", 0), ("FEW", 8), ("NEAR", 0)]


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize(
    "system", [ELLIPSOID, "spherical_pendulum", "rotating_hoop", "parabola_bead", "central_force_cartesian"]
)
@pytest.mark.parametrize(("stages", "few"), [(3, 0), (3, 99), (60, 0)])
def test_dot_products_give_the_same_however_they_are_arranged(system, stages, few, monkeypatch):
    """Alone or beside those of other levels, their newest terms in vectors or not: but for the last bits."""
    shape_code(monkeypatch, stages, few)

    def arranged():
        prepared.cache_clear()
        program = lower_system(residual_of(system))
        return follow(system, 3.0, outputs=("q", "v")), layout.arrange(program, 20).groups

    usual, groups = arranged()
    different = 0
    for name, value in ARRANGED:
        with monkeypatch.context() as patch:
            patch.setattr(layout, name, value)
            other, others = arranged()
        different += others != groups
        for path, series in usual.data.items():
            assert np.max(np.abs(series - other[path])) <= 1e-13 * max(1.0, np.max(np.abs(series))), path
    prepared.cache_clear()
    assert different >= 2


def lower_system(residual):
    """The series of a system's equations."""
    model = residual.model
    return lower(residual.graph, residual.variables, model.q, model.v, model.time, residual.residual, [])


def lagrangian_of(matrix):
    """L = v.M.v/2 - sum_k (k+1) sin(x_k) as a system."""
    size = len(matrix)
    terms = [f"({matrix[i][j] / 2!r})*x{i}_dot*x{j}_dot" for i in range(size) for j in range(size)]
    slopes = [f"- {k + 1}*sin(x{k})" for k in range(size)]
    names = ", ".join(f"x{k}" for k in range(size))
    return f"coordinates: [{names}]\nlagrangian: {' + '.join(terms)} {' '.join(slopes)}\n"


@pytest.mark.exhaustive(keep=0.2)
@examples(4)
@given(st.integers(2, 8), st.integers(0, 10**6), st.booleans())
def test_coupled_mass_matrices_of_any_sign_are_solved(size, seed, hollow):
    """Indefinite M, also with zeros on its diagonal, in small blocks and in the large ones' loops."""
    source = np.random.default_rng(seed)
    matrix = source.normal(size=(size, size))
    matrix = matrix + matrix.T
    if hollow:
        np.fill_diagonal(matrix, 0.0)
    if np.linalg.cond(matrix) > 1e4:
        return
    q = source.normal(size=size)
    values = compiled_values(residual_of(lagrangian_of([[float(x) for x in row] for row in matrix])))
    accelerations, momenta, *_ = values([], 0.0, list(q), [1.0] * size)
    expected = np.linalg.solve(matrix, -np.cos(q) * np.arange(1, size + 1))
    assert np.max(np.abs(accelerations - expected)) <= 1e-11 * np.linalg.cond(matrix) * np.max(
        np.abs(expected)
    )
    assert np.max(np.abs(momenta - matrix.sum(axis=1))) <= 1e-13 * size * np.max(np.abs(matrix))


def chain(size):
    """A chain of pendulums, l = m = 1, written out by hand."""
    names = [f"th{k}" for k in range(size)]
    starts = "\n".join(f"  {name}: {{initial: {1 + 0.1 * k}}}" for k, name in enumerate(names))
    places = "\n".join(
        f"  b{k}: [{' + '.join(f'sin({n})' for n in names[: k + 1])},"
        f" -({' + '.join(f'cos({n})' for n in names[: k + 1])})]"
        for k in range(size)
    )
    masses = "\n".join(f"  b{k}: 1" for k in range(size))
    heights = " + ".join(f"b{k}.y" for k in range(size))
    return f"coordinates:\n{starts}\nmasses:\n{masses}\nembedding:\n{places}\npotential: 9.81*({heights})\n"


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("size", [3, 7, 22])
def test_chains_of_any_length_keep_their_energy(size):
    """22 coordinates factor their mass matrix in loops, fewer in unrolled code."""
    motion = follow(chain(size), 1.0, 11, outputs=("q", "h", "ledger"))
    assert motion.outcome.h_drift <= 1e-13 * abs(motion["diagnostics/h"][0])
    for k in range(size):
        assert np.max(np.abs(motion[f"diagnostics/ledger/p/th{k}"])) <= 1e-12 * size**2


LINE = (
    "coordinates: {{x: {{initial: {initial}, velocity: {velocity}}}}}\n"
    "masses: {{p: 1}}\nembedding: {{p: x}}\npotential: {potential}\n"
)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("power", [3, 7, 11, 21])
def test_series_of_which_many_coefficients_vanish(power):
    """x'' = -x^n from x = 0: only every (n+1)-th coefficient is there; the step must not leap over them."""
    text = LINE.format(initial=0, velocity=1, potential=f"x**{power + 1}/{power + 1}")
    motion = follow(text, 20.0, 201)
    assert motion.outcome.h_drift <= 1e-12
    turning = ((power + 1) / 2) ** (1 / (power + 1))
    assert np.max(motion["q/x"]) <= turning * (1 + 1e-12)
    assert np.max(motion["q/x"]) >= 0.97 * turning


def test_rest_and_free_motion_take_one_step():
    text = (
        "coordinates: {x: {initial: 1}, y: {initial: 2, velocity: 3}}\n"
        "masses: {p: 1}\nembedding: {p: [x, y]}\npotential: (x - 1)**4\n"
    )
    motion = follow(text, 1e6, 3)
    assert motion.outcome.steps == 1
    assert motion["q/x"].tolist() == [1.0, 1.0, 1.0]
    assert motion["q/y"].tolist() == [2.0, 1500002.0, 3000002.0]


@pytest.mark.exhaustive(keep=0.4)
def test_the_unit_of_time_does_not_matter():
    """As many steps, the same error; more where many coefficients are below what doubles hold."""
    steps = []
    for frequency in (1e-12, 1.0, 1e9, 1e-15, 1e-18, 1e-22, 1e-30):
        text = LINE.format(initial=1, velocity=0, potential=f"{frequency**2!r}*x**2/2")
        motion = follow(text, 20 * math.pi / frequency, 3)
        steps.append(motion.outcome.steps)
        assert abs(motion["q/x"][-1] - 1) <= 1e-14
    assert max(steps[:3]) <= 1.1 * min(steps[:3])
    assert steps[-1] <= 2000


def test_scale_does_not_matter():
    """Micrometres and light years: the same steps, the same relative error."""
    steps = set()
    for size in (1e-12, 1.0, 1e15):
        text = LINE.format(initial=size, velocity=0, potential="x**2/2")
        motion = follow(text, 20 * math.pi, 3)
        steps.add(motion.outcome.steps)
        assert abs(motion["q/x"][-1] / size - 1) <= 1e-13
    assert len(steps) == 1


@pytest.mark.parametrize("name", ["double_pendulum", "spherical_pendulum", "figure_eight"])
def test_every_term_of_a_convolution_is_summed_once_wherever_its_group_begins(name):
    program = lower_system(residual_of(name))
    dots = list(layout.dot_products(program))
    lowest = min(dot.level for dot in dots)
    for least in (None, lowest, lowest - 1, lowest - 2):
        for group in layout.side_by_side(program, dots, least):
            assert least is None or group.level >= least
            for dot, shifts in zip(group.dots, group.shifts):
                assert min(shifts) >= 0 and sum(shifts) == dot.level - group.level
