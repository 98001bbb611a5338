"""Units by dimension against numbers in other units."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.model.build import build_model
from lagrange_cli.model.unit import WHOLE
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.model.units import meaning
from lagrange_cli.outputs.units import Units, find_units
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import CONSTRAINED, NAMES, spec_of


def scaled_values(spec: Spec, texts: Mapping[str, str], bases: Mapping[str, float], source: random.Random):
    """Random values of all symbols, and the same in units that are smaller by factors ``bases``."""
    symbols = {"t": (source.uniform(0.1, 2), "t")}
    for name, value in resolve_values(spec).parameters.items():
        symbols[name] = value * source.uniform(0.8, 1.2), f"parameters/{name}"
    for one in spec.coordinates:
        symbols[one.name] = source.uniform(0.2, 1.5), f"q/{family_name(one.name)}"
        symbols[velocity_name(one.name)] = source.uniform(-1, 1), f"v/{family_name(one.name)}"
    plain = {name: value for name, (value, _) in symbols.items()}
    other = {name: value * factor(texts.get(path, ""), bases) for name, (value, path) in symbols.items()}
    return plain, other


def factor(text: str, bases: Mapping[str, float]) -> float:
    """How much a number in a unit grows where the base units become smaller."""
    if not text:
        return 1.0
    unit = read_unit(text)
    assert unit is not None
    return math.prod(bases[name] ** (power / WHOLE) for name, power in meaning(unit)[1].items())


def check_numbers(spec: Spec, seed: int) -> int:
    """Compare what the graph has in two systems of units; says how many quantities had a unit."""
    source, texts = random.Random(seed), find_units(spec).texts
    names = ("kg", "m", "s", "A", "K", "Msun", "EUR")
    bases = {name: source.choice((0.5, 3.0, 1.7, 0.2)) * source.uniform(0.9, 1.1) for name in names}
    plain, other = scaled_values(spec, texts, bases, source)
    model = build_model(spec, GraphAlgebra())
    energetics = Energetics(model)
    nodes = {"h": energetics.energy_function, "L": energetics.lagrangian}
    paths = {"h": "diagnostics/h", "L": "diagnostics/h"}
    if energetics.kinetic is not None and energetics.potential is not None:
        nodes |= {"T": energetics.kinetic, "U": energetics.potential}
        paths |= {"T": "diagnostics/T", "U": "diagnostics/U"}
    for name, node in zip(model.coordinates, energetics.momenta):
        nodes[f"p_{name}"], paths[f"p_{name}"] = node, f"diagnostics/p/{family_name(name)}"
    for particle in model.particles:
        for number, node in enumerate(particle.position):
            key = f"{particle.name}.{number}"
            nodes[key], paths[key] = node, f"positions/{family_name(particle.name)}"
    for name, node in model.observables.items():
        nodes[f"o {name}"], paths[f"o {name}"] = node, f"observables/{family_name(name)}"
    told = {key: node for key, node in nodes.items() if texts.get(paths[key])}
    try:
        before, sizes = evaluate([*told.values()], plain)
        after, _ = evaluate([*told.values()], other)
    except (ArithmeticError, ValueError):
        return 0
    for key, node in told.items():
        if math.isfinite(before[node]) and math.isfinite(sizes[node]) and math.isfinite(after[node]):
            ratio = factor(texts[paths[key]], bases)
            assert after[node] == pytest.approx(before[node] * ratio, abs=1e-9 * sizes[node] * ratio), key
    return len(told)


CONTRIVED = {
    "tonnes and millimetres": """\
        parameters: {m: {value: 2, unit: t}, k: {value: 3, unit: N/mm}, c: {value: 0.1, unit: N*s/mm}}
        coordinates: {x: {initial: 1, unit: mm}, y: {initial: 1, unit: mm}}
        masses: {bead: m}
        embedding: {bead: [x, y]}
        potential: {spring: k*norm(bead)**2/2, cross: 0.5*k*x*y}
        dissipation: c*(x_dot**2 + y_dot**2)/2
        observables: {power: -c*dot((bead.vx, bead.vy), (bead.vx, bead.vy)), angle: "atan2(y, x)"}
    """,
    "a circuit": """\
        parameters: {L: {value: 2, unit: H}, C: {value: 3, unit: F}, R: {value: 1, unit: ohm}}
        coordinates: {q: {initial: 1, unit: C}}
        lagrangian: L*q_dot**2/2 - q**2/(2*C)
        dissipation: R*q_dot**2/2
        observables: {voltage: q/C, current: q_dot, rate: 1/sqrt(L*C), loss: R*q_dot**2}
    """,
    "a chain": """\
        sizes: {N: 4}
        parameters: {m: {value: [1, 2, 3, 4], unit: kg}, k: {value: 2, unit: J/m^2},
          b: {value: 1, unit: N/m^3}}
        coordinates: {"u[i in range(N)]": {initial: 0.1*i, unit: m}}
        definitions:
          stretch[0]: u[0]
          stretch[i in range(1, N)]: u[i] - u[i - 1]
          mode[j in range(2)]: sqrt(2/(N + 1))*sum(u[i]*sin(pi*(i + 1)*(j + 1)/(N + 1)) for i in range(N))
        masses: {"bead[i in range(N)]": "m[i]"}
        embedding: {"bead[i in range(N)]": "u[i]"}
        potential: sum(k*stretch[i]**2/2 + b*stretch[i]**4/4 for i in range(N))
        observables: {"energy[j in range(2)]": "k*mode[j]**2", longest: norm((u[0], u[1], u[2]))}
    """,
    "degrees": """\
        parameters: {m: {value: 2, unit: kg}, g: {value: 9.8, unit: m/s^2}, l: {value: 1, unit: m}}
        coordinates: {theta: {initial: 20, unit: rad}, s: {initial: 1, unit: m}}
        masses: {bob: m}
        embedding: {bob: [s + l*sin(theta), -l*cos(theta)]}
        potential: m*g*bob.y
        observables: {turn: theta - 2*theta, arc: l*theta, spin: theta_dot, mixed: s_dot + l*theta_dot}
    """,
}


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize("system", [*NAMES, *CONSTRAINED, *CONTRIVED])
def test_numbers_in_other_units_are_other_by_what_the_units_say(system):
    spec = spec_of(system) if system not in CONTRIVED else read_spec(CONTRIVED[system], "a.yaml")
    assert find_units(spec).conflicts == ()
    counts = [check_numbers(spec, seed) for seed in range(3)]
    if system in CONTRIVED:
        assert min(counts) >= 4 + len(spec.observables) - (system == "a circuit")


NAMED = ["m", "l", "g", "k", "w", "x", "theta", "x_dot", "theta_dot", "t", "x_dot", "bob.x", "bob.vy", "rest"]
QUANTITIES = """\
parameters: {m: {value: 1.5, unit: kg}, l: {value: 2, unit: m}, g: {value: 3, unit: m/s^2},
  k: {value: 2, unit: N/m}, w: {value: 0.7, unit: rad/s}, rest: l/2}
coordinates: {x: {initial: 1, unit: m}, theta: {initial: 1, unit: rad}}
definitions: {phi: "sqrt(g/l)*t"}
masses: {bob: m}
embedding: {bob: [x + l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y + k*x**2/2
"""


def formulas() -> st.SearchStrategy[str]:
    """Formulas of quantities whose units are known, some of them nonsense."""
    number = st.sampled_from(["2", "0.5", "3", "1/2", "pi"])
    atom = st.sampled_from([*NAMED, "phi", "cos(theta)", "k*x**2", "m*g*l", "m*x_dot**2"])

    def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        def alike(one: str, other: str, sign: str) -> str:
            return f"({one} {sign} {one}*cos({other}/({other} + {other})))"

        return st.one_of(
            st.builds("{}*({})".format, inner, inner),
            st.builds("({})/({})".format, inner, inner),
            st.builds("({} {} {})".format, inner, st.sampled_from("+-"), inner),
            st.builds(alike, inner, inner, st.sampled_from("+-")),
            st.builds("{}*({})".format, number, inner),
            st.builds("({})**{}".format, inner, st.sampled_from(["2", "3", "(-1)", "0.5", "(1/3)"])),
            st.builds("{}({})".format, st.sampled_from(["sin", "exp", "sqrt", "atan"]), inner),
            st.builds("-({})".format, inner),
            st.builds("atan2({}, {})".format, inner, inner),
            st.builds("norm(({}, {}))".format, inner, inner),
            st.builds("dot(({0}, {1}), ({1}, {0}))".format, inner, inner),
        )

    return st.recursive(atom, grown, max_leaves=6)


@pytest.mark.exhaustive(keep=0.35)
@settings(max_examples=30, deadline=None)
@given(st.lists(formulas(), min_size=1, max_size=5), st.integers(0, 99))
def test_no_formula_has_a_unit_that_is_false(texts, seed):
    observables = "".join(f'  o{i}: "{text}"\n' for i, text in enumerate(texts))
    check_numbers(read_spec(f"{QUANTITIES}observables:\n{observables}", "a.yaml"), seed)


def test_a_false_unit_would_be_found(monkeypatch):
    spec = read_spec(QUANTITIES, "a.yaml")
    assert check_numbers(spec, 0) > 5
    texts = {**find_units(spec).texts, "diagnostics/p/x": "kg*m"}
    monkeypatch.setattr("tests.outputs.units.test_numbers.find_units", lambda spec: Units(texts))
    with pytest.raises(AssertionError, match="p_x"):
        check_numbers(spec, 0)
