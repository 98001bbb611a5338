"""Random systems: the compiled equations against Euler and Lagrange's, written out by sympy in this test.

Embeddings that move with time, potentials with velocities, forces of every kind. Only the reading of the
file is shared: on one side are d'Alembert's principle, series and machine code, on the other
dp/dt = dL/dq + Q.
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from tests.support.draws import examples
from tests.support.motion import Motion, each_formulation, follow, residual_of, spec_of, values_of

ATOMS = [
    "{q}",
    "{q}",
    "sin({q})",
    "cos({q})",
    "{q}**2",
    "{r}",
    "cos({q} - {r})",
    "{q}*sin({r})",
    "exp(-{q}/2)",
    "t",
    "cos(w*t)",
    "sin({q} + w*t)",
    "a",
    "atan({q})",
    "sqrt(2 + {q}**2 + {r}**2)",
    "1/(3 + {q})",
    "log(4 + {q} + {r})",
    "tanh({q})",
]
RATES = ["{q}_dot", "{q}_dot*{r}", "{q}_dot**2/9", "{q}_dot*{r}_dot/9", "{q}_dot*cos({r})"]


@st.composite
def systems(draw: st.DrawFn) -> str:
    """One to three coordinates, a particle on each and one or two that couple them."""
    names = ["q", "u", "s"][: draw(st.integers(1, 3))]
    name = st.sampled_from(names)

    def atom(kinds: list[str]) -> str:
        return draw(st.sampled_from(kinds)).format(q=draw(name), r=draw(name))

    def term(kinds: list[str] = ATOMS) -> str:
        product = [atom(kinds), *(atom(ATOMS) for _ in range(draw(st.integers(0, 1))))]
        return f"({draw(st.integers(1, 9)) / 4}*" + "*".join(product) + ")"

    def total(kinds: list[str] = ATOMS, most: int = 2) -> str:
        return " + ".join(term(kinds) for _ in range(draw(st.integers(1, most))))

    particles = [f"p{k}" for k in range(draw(st.integers(1, 2)))]
    embedding = {p: [total() for _ in range(draw(st.integers(1, 3)))] for p in particles}
    lines = ["parameters: {a: 0.7, b: 1.3, w: 2.1}", "coordinates:"]
    lines += [
        f"  {n}: {{initial: {draw(st.integers(-9, 9)) / 10}, velocity: {draw(st.integers(-9, 9)) / 10}}}"
        for n in names
    ]
    lines += ["masses:", *(f"  on_{n}: a + b" for n in names), *(f"  {p}: b" for p in particles)]
    lines += ["embedding:", *(f"  on_{n}: 2*{n}" for n in names)]
    lines += [f'  {p}: ["' + '", "'.join(rows) + '"]' for p, rows in embedding.items()]
    lines.append(f'potential: "{total(most=3)} + {term(RATES)} + b*{particles[0]}.x"')
    lines.append(f'generalized_forces: {{{names[0]}: "{total(ATOMS + RATES)}"}}')
    pulls = ", ".join(f'"{total(ATOMS + RATES, 1)}"' for _ in embedding[particles[0]])
    lines.append(f"forces: {{{particles[0]}: [{pulls}]}}")
    lines.append(f'dissipation: "{names[-1]}_dot**2*({atom(ATOMS)})/5"')
    return "\n".join(lines) + "\n"


def euler_lagrange(model: Model[sympy.Expr]) -> tuple[list[sympy.Symbol], list[sympy.Expr]]:
    """Arguments (t, q, v, parameters), and a flat list of M, the right-hand side, p and h, from L = T - U."""
    q, v, t = model.q, model.v, model.time

    def rate(x: sympy.Expr) -> sympy.Expr:
        return sum((x.diff(a) * b for a, b in zip(q, v, strict=True)), x.diff(t))

    lagrangian = -model.potential + sum(
        p.mass * sum(rate(x) ** 2 for x in p.position) / 2 for p in model.particles
    )
    momenta = [lagrangian.diff(b) for b in v]
    matrix = [p.diff(b) for p in momenta for b in v]
    right = []
    for k, (a, b) in enumerate(zip(q, v, strict=True)):
        force = model.generalized_forces[k] - model.dissipation.diff(b)
        for particle in model.particles:
            if particle.force:
                pairs = zip(particle.force, particle.position, strict=True)
                force += sum(f * x.diff(a) for f, x in pairs)
        right.append(lagrangian.diff(a) + force - rate(momenta[k]))
    h = sum(p * b for p, b in zip(momenta, v, strict=True)) - lagrangian
    return [t, *q, *v, *model.parameters.values()], [*matrix, *right, *momenta, h]


def reference(system: str, state: list[float]) -> tuple[list[mpmath.mpf], list[mpmath.mpf], mpmath.mpf]:
    """Accelerations, momenta and h at (t, q, v), to 30 digits."""
    model = build_model(spec_of(system), SympyAlgebra())
    arguments, expressions = euler_lagrange(model)
    n = len(model.q)
    with mpmath.workdps(30):
        numbers = [mpmath.mpf(x) for x in (*state, *values_of(system).parameters.values())]
        found = sympy.lambdify(arguments, expressions, "mpmath", cse=True)(*numbers)
        matrix = mpmath.matrix(n, n)
        for i in range(n * n):
            matrix[i // n, i % n] = found[i]
        accelerations = list(mpmath.lu_solve(matrix, mpmath.matrix(found[n * n : n * n + n])))
    return accelerations, found[n * n + n : -1], found[-1]


def close(found: np.ndarray, known: list[mpmath.mpf], slack: float) -> bool:
    scale = max(1.0, *(abs(float(x)) for x in known))
    return bool(np.max(np.abs(found - np.array([float(x) for x in known]))) <= slack * scale)


@pytest.mark.exhaustive(keep=0.2)
@examples(2)
@given(systems())
def test_accelerations_momenta_and_h_are_those_of_euler_and_lagrange(system: str) -> None:
    values = values_of(system)
    state = [0.3, *values.q, *values.v]
    accelerations, momenta, h = reference(system, state)
    for name, form in each_formulation(system).items():
        found = compiled_values(form)(list(values.parameters.values()), state[0], values.q, values.v)
        assert close(found[0], accelerations, 1e-12), name
        assert close(found[1], momenta, 1e-13)
        assert close(np.array([found[2]]), [h], 1e-13)


def unaccounted(motion: Motion, names: tuple[str, ...]) -> float:
    """The largest ledger, for the size of what it accounts for."""
    sizes = [abs(motion[f"diagnostics/p/{name}"]).max() for name in names]
    flow = sum(abs(motion[f"diagnostics/p/{name}"] * motion[f"v/{name}"]).max() for name in names)
    h = max(1.0, abs(motion["diagnostics/h"]).max(), flow)
    ledgers = [abs(motion[f"diagnostics/ledger/p/{name}"]).max() / max(1.0, *sizes) for name in names]
    return float(max(*ledgers, abs(motion["diagnostics/ledger/h"]).max() / h))


@pytest.mark.exhaustive(keep=0.2)
@examples(2)
@given(systems())
def test_ledgers_of_random_systems_close(system: str) -> None:
    motion = follow(system, 0.5, 21, outputs=("q", "v", "p", "h", "ledger"))
    assert motion.t[-1] == 0.5 or motion.outcome.message
    if len(motion.t) > 1:
        assert unaccounted(motion, residual_of(system).coordinates) < 1e-12


def test_a_wrong_sign_would_be_seen() -> None:
    """The reference is not the compiled code in disguise: it disagrees with another system's."""
    right, wrong = (
        "coordinates: {q: {initial: 0.5}}\nmasses: {p: 1}\nembedding: {p: [sin(q), -cos(q)]}\n"
        f"potential: {g}*p.y\n"
        for g in (9.81, -9.81)
    )
    found = compiled_values(residual_of(right))([], 0.0, (0.5,), (0.0,))[0]
    assert close(found, reference(right, [0.0, 0.5, 0.0])[0], 1e-15)
    assert not close(found, reference(wrong, [0.0, 0.5, 0.0])[0], 1e-3)
    assert pytest.approx(-9.81 * np.sin(0.5), rel=1e-15) == found[0]
