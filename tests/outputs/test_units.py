"""Units by dimension: of shipped systems, of what little a file gives, and against numbers in other units."""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.syntax import Tree
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.model.build import build_model
from lagrange_cli.model.dimensions import Walk
from lagrange_cli.model.unit import WHOLE
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.model.units import meaning
from lagrange_cli.outputs.units import Units, find_units
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import resolve_values
from tests.fuzzing.grammar import system
from tests.support.motion import CONSTRAINED, NAMES, SYSTEMS, spec_of

ENERGY = "kg*m^2/s^2"
ANGULAR, LINEAR = "kg*m^2/s", "kg*m/s"


def units(text: str) -> Mapping[str, str]:
    """The units by path; the file must not contradict itself."""
    found = find_units(read_spec(text, "a.yaml"))
    assert found.conflicts == ()
    return found.texts


def conflicts(text: str) -> list[str]:
    return [one.message for one in find_units(read_spec(text, "a.yaml")).conflicts]


def test_times_of_solve_agree_with_t():
    text = "parameters: {k: {value: 1, unit: 1/s}, l: {value: 2, unit: m}}\ncoordinates: {x: {initial: 0}}\n"
    text += "lagrangian: x_dot**2/2 - k**2*x**2/2\nsolve: {start: 1, stop: %s, step: 0.1/k}\n"
    assert conflicts(text % "10*pi/k") == []
    assert conflicts(text % "l/2") == ["the stop of solve is in m, and t is in s"]
    assert conflicts(text % "1/k + l") == ["s and m are added in stop of solve"]


# Shipped systems


@pytest.mark.parametrize(
    ("system", "expected"),
    [
        ("pendulum", {"t": "s", "q/theta": "rad", "v/theta": "rad/s", "diagnostics/p/theta": ANGULAR}),
        ("harmonic_oscillator", {"v/x": "m/s", "diagnostics/p/x": LINEAR, "diagnostics/action": ANGULAR}),
        ("charged_particle", {"diagnostics/p/y": LINEAR, "diagnostics/U": ENERGY, "positions/ion": "m"}),
        ("driven_damped_pendulum", {"diagnostics/ledger/p/theta": ANGULAR, "diagnostics/ledger/h": ENERGY}),
        ("gauge_oscillator", {"diagnostics/h": ENERGY, "diagnostics/p/x": LINEAR}),
        ("rotating_hoop", {"diagnostics/h": ENERGY, "diagnostics/energy": ENERGY}),
        (
            "solar_system",
            {
                "t": "d",
                "v/x": "AU/d",
                "diagnostics/p/z": "Msun*AU/d",
                "diagnostics/h": "Msun*AU^2/d^2",
                "positions/body": "AU",
            },
        ),
    ],
)
def test_units_of_shipped_systems(system, expected):
    found = find_units(spec_of(system)).texts
    assert {path: found.get(path) for path in expected} == expected


@pytest.mark.parametrize("system", [*NAMES, *CONSTRAINED])
def test_no_shipped_system_contradicts_itself(system):
    found = find_units(spec_of(system))
    assert found.conflicts == ()
    coordinates = {family_name(one.name): one.unit for one in spec_of(system).coordinates}
    known = ("diagnostics/h" in found.texts, "t" in found.texts)
    assert known == (True, True) or not all(coordinates.values()) or system == "lattice"


def test_conserved_quantities_have_units():
    text = "parameters: {m: {value: 1, unit: kg}, k: {value: 2, unit: N*m^2}}\nmasses: {p: m}\n"
    text += "coordinates: {x: {initial: 1, unit: m}, y: {initial: 0, unit: m}}\npositions: {p: [x, y]}\n"
    found = units(text + "potential: -k/norm(p)\n")
    assert found["diagnostics/conserved/A_x"] == "kg*m^3/s^2"
    assert found["diagnostics/conserved/h_x"] == found["diagnostics/conserved/F_xy"] == ENERGY


# Against numbers


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


@settings(max_examples=60, deadline=None)
@given(st.lists(formulas(), min_size=1, max_size=5), st.integers(0, 99))
def test_no_formula_has_a_unit_that_is_false(texts, seed):
    observables = "".join(f'  o{i}: "{text}"\n' for i, text in enumerate(texts))
    check_numbers(read_spec(f"{QUANTITIES}observables:\n{observables}", "a.yaml"), seed)


def test_a_false_unit_would_be_found(monkeypatch):
    spec = read_spec(QUANTITIES, "a.yaml")
    assert check_numbers(spec, 0) > 5
    texts = {**find_units(spec).texts, "diagnostics/p/x": "kg*m"}
    monkeypatch.setattr("tests.outputs.test_units.find_units", lambda spec: Units(texts))
    with pytest.raises(AssertionError, match="p_x"):
        check_numbers(spec, 0)


# What little a file gives


def one(potential: str = "k*x**2/2", **changes: str) -> str:
    """A particle on a line, in kg, m and s but for ``changes``."""
    parts = {
        "m": "{value: 1, unit: kg}",
        "k": "{value: 4, unit: N/m}",
        "x": "{initial: 1, unit: m}",
        "mass": "m",
        "position": "[x]",
        "more": "",
        **changes,
    }
    return (
        f"parameters: {{m: {parts['m']}, k: {parts['k']}}}\ncoordinates: {{x: {parts['x']}}}\n"
        f"masses: {{bead: {parts['mass']}}}\nembedding: {{bead: {parts['position']}}}\n"
        f"potential: {potential}\n{parts['more']}"
    )


def test_a_file_without_units_has_none():
    assert units(one(m="1", k="4", x="{initial: 1}")) == {}


@pytest.mark.parametrize(
    "time", ["time: {unit: d}", "time: d", "solve: {unit: d}", "time: d\nsolve: {unit: d}"]
)
def test_the_file_says_the_unit_of_t(time):
    found = units(one(m="1", k="4", more=time))
    assert (found["t"], found["v/x"]) == ("d", "m/d")


@pytest.mark.parametrize(
    ("k", "unit"),
    [
        ("N/m", "s"),
        ("kg/d^2", "d"),
        ("kg/ms^2", "ms"),
        ("1/yr", "yr"),
        ("V", "s"),
        ("kN/m", None),  # kN, mm, ms and kg go together as well as kN, m, s and t
        ("kHz", None),
        ("m", None),
        ("rpm", None),
    ],
)
def test_the_unit_of_t_is_that_of_the_others(k, unit):
    found = units(one(m="1", k=f"{{value: 4, unit: {k}}}", potential="0*x"))
    assert found.get("t") == unit
    assert found.get("v/x") == (unit and f"m/{unit}")


def test_several_units_of_time_say_nothing_of_t():
    text = one(m="{value: 1, unit: kg}, w: {value: 1, unit: km/h}")
    found = find_units(read_spec(text, "a.yaml"))
    assert "t" not in found.texts and "v/x" not in found.texts
    (conflict,) = found.conflicts
    assert "h and s" in conflict.message and "time: {unit: h}" in conflict.hint
    assert units(text + "time: s")["v/x"] == "m/s"


def test_a_unit_of_t_that_only_seems_so_is_given_up():
    """g, mm, ms and N are one system of units; N alone would say s."""
    text = one(m="{value: 1, unit: g}", k="{value: 1, unit: N/mm}", x="{initial: 1, unit: mm}")
    found = find_units(read_spec(text, "a.yaml"))
    assert not found.texts.keys() & {"t", "v/x", "diagnostics/h"} and found.texts["q/x"] == "mm"
    (conflict,) = found.conflicts
    assert conflict.message == "the potential is in N*mm, other energies in g*mm^2/s^2"
    assert "time: {unit: ...}" in conflict.hint
    assert units(text + "time: ms")["diagnostics/h"] == "g*mm^2/ms^2"


@pytest.mark.parametrize(
    ("text", "energy"),
    [
        (one(), ENERGY),
        (one("9.81*x"), ENERGY),  # T tells
        (one("0"), ENERGY),
        (one(m="1"), ENERGY),  # U tells
        (one(mass="2"), ENERGY),
        (one("x**2/2", mass="2"), None),  # m^2 is no energy: the number is a stiffness
        (one("m*x", mass="2"), None),
        (one(m="1", k="4"), None),
        (one(x="{initial: 1}"), None),
        (one(x="{initial: 1}", more="time: s"), None),
        (one("k*x**2/2*m", m="1"), None),
        (one("k*(x - 1.25)**2/2", mass="2"), None),
        (one("k*(x - 1.25)**2/2"), ENERGY),
        (one(position="[cos(x/l)]", k="{value: 1, unit: N}", more="definitions: {l: 2}"), None),
    ],
)
def test_the_unit_of_energy(text, energy):
    found = units(text)
    assert {found.get(f"diagnostics/{name}") for name in ("h", "T", "U", "energy", "ledger/h")} == {energy}
    assert ("diagnostics/p/x" in found) == (energy is not None)


@pytest.mark.parametrize(
    ("formula", "unit"),
    [
        ("x", "m"),
        ("2*x", "m"),
        ("x/2 + 0.25*x", "m"),
        ("x + 1.5", "m"),
        ("x - 57.3", "m"),
        ("57.3*x", None),
        ("x*180/pi", None),
        ("100*x", None),
        ("3/(1 + x**2)", None),
        ("exp(-(x - 0.3)/(2*x))", None),
        ("x_dot", "m/s"),
        ("x_dot/x", "1/s"),
        ("bead.x*bead.vx", "m^2/s"),
        ("sqrt(k/m)", "1/s"),
        ("k*x", "N"),
        ("k*x**2/2", ENERGY),
        ("x**(1/3)", "m^(1/3)"),
        ("x**c", None),
        ("(x/bead.x)**(m/m)", None),
        ("x/bead.x", None),
        ("cos(t*sqrt(k/m))", None),
        ("atan2(x, bead.x)", "rad"),
        ("asin(x/bead.x) - 1.0", "rad"),
        ("norm((x, 2*x, 0))", "m"),
        ("dot((x, x), (x_dot, x_dot))", "m^2/s"),
        ("dot(cross((x, x, x), (x_dot, x_dot, x_dot)), (2, 2, 2))", "m^2/s"),
        ("sum(x for i in range(3))", "m"),
        ("sum(i*x for i in range(3))", "m"),
        ("log(x)", None),
        ("m*log(x)", "kg"),
        ("1", None),
        ("0*x + x_dot", "m/s"),
    ],
)
def test_the_unit_of_an_observable(formula, unit):
    text = one(m="{value: 1, unit: kg}, c: 2", more=f'observables: {{o: "{formula}"}}')
    assert units(text).get("observables/o") == unit


def test_coordinates_without_a_unit_have_that_of_their_initial_values():
    found = units(one(x="{initial: 2*l}", more="", k="{value: 1, unit: N/m}, l: {value: 1, unit: m}"))
    assert (found["q/x"], found["v/x"], found["diagnostics/p/x"]) == ("m", "m/s", LINEAR)
    found = units(one("0", x="{initial: 0, velocity: w}", k="1, w: {value: 1, unit: km/h}"))
    assert (found["q/x"], found["v/x"]) == ("km", "km/h")


def test_a_parameter_without_a_unit_has_that_of_its_expression():
    found = units(one(k="{value: 1, unit: N/m}, w: sqrt(k/m), n: 2*3, e: k*1.234"))
    assert found["parameters/w"] == "1/s"
    assert not found.keys() & {"parameters/n", "parameters/e"}


def test_members_of_a_family_have_one_unit_or_none():
    text = "coordinates:\n  u[0]: {{initial: 1, unit: m}}\n  u[1]: {{initial: 1, unit: {}}}\n"
    text += "time: s\nlagrangian: u_dot[0]**2 + u_dot[1]**2\n"
    assert units(text.format("m"))["v/u"] == "m/s"
    assert not units(text.format("cm")).keys() & {"q/u", "v/u", "diagnostics/p/u"}


def test_a_text_that_is_no_unit_stays_as_it_is():
    found = units(one(x="{initial: 1, unit: widths of the gap}", m="{value: 1, unit: solar masses}"))
    assert (found["q/x"], found["parameters/m"], found["t"]) == ("widths of the gap", "solar masses", "s")
    assert not found.keys() & {"v/x", "diagnostics/p/x", "diagnostics/T", "positions/bead"}


def test_angles_are_in_radians_and_only_they():
    found = units(
        one(
            x="{initial: 1, unit: rad}",
            k="{value: 1, unit: N*m}",
            position="[x]",
            m="{value: 1, unit: kg*m^2}",
        )
    )
    assert (found["v/x"], found["diagnostics/p/x"], found["positions/bead"]) == ("rad/s", ANGULAR, "rad")
    degrees = one("0", x="{initial: 1, unit: deg}", position='["k*sin(x*pi/180)"]', k="{value: 1, unit: m}")
    found = units(degrees + "time: s")
    assert (found["v/x"], found["diagnostics/p/x"]) == ("deg/s", "kg*m^2/(s*deg)")


# Contradictions


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (one("k*x**2/2 + k*x"), "N*m and N are added in potential"),
        (one("k*x", k="{value: 1, unit: N/m}"), f"the potential is in N, other energies in {ENERGY}"),
        (one("{a: k*x**2, b: k*x}"), f"the potential 'b' is in N, other energies in {ENERGY}"),
        (one(position="[x, x**2]"), "the position of 'bead' has components in m and m^2"),
        (one(position="[sin(x)]"), "sin is taken of a quantity in m in the position of 'bead'"),
        (one("k*x**(x)"), "an exponent is in m in potential"),
        (one(more="definitions: {d: x + x_dot}"), "m and m/s are added in definition 'd'"),
        (one(more="observables: {o: 'where(x > x_dot, 1, 2)'}"), "m and m/s are compared in observable 'o'"),
        (one(more="observables: {o: 'max(0, x, k)'}"), "m and N/m are compared in observable 'o'"),
        (
            one(more="observables: {o: 'where(0 < x and x > 5, x, x_dot)'}"),
            "m and m/s are branches of one 'where' in observable 'o'",
        ),
        (
            one(more="observables: {o: 'sign(x) + abs(x)'}"),
            "a plain number and m are added in observable 'o'",
        ),
        (one(more="observables: {o: x + cos(x/x)}"), "m and a plain number are added in observable 'o'"),
        (one(more="forces: {bead: [-k*x_dot]}"), "the force on 'bead' is in N/s, and should be in"),
        (one(more="generalized_forces: {x: -m}"), "the generalized force 'x' is in kg, and should be in"),
        (one(more="dissipation: k*x_dot**2"), "the dissipation is in"),
        (one(k="{value: m*2, unit: N/m}"), "the value of parameter 'k' is in kg, and its unit is N/m"),
        (one(x="{initial: m, unit: m}"), "the initial value of coordinate 'x' is in kg, and its unit is m"),
        (one(x="{initial: 1, velocity: m, unit: m}"), "the initial velocity of coordinate 'x' is in kg"),
        (one(more="events: {e: x + x_dot}"), "m and m/s are added in event 'e'"),
        (
            one(more="events: {e: {when: x_dot, action: {set: {x: -x, x_dot: x}}}}"),
            "the new x_dot of event 'e' is in m, and should be in m/s",
        ),
        (
            one(more="events: {e: {when: x_dot, action: {set: {k: m, m: 2*m}}}}"),
            "the new k of event 'e' is in kg, and should be in N/m",
        ),
        (one("m*k", k="{value: 1, unit: m*cm/s^2}"), "the potential is in kg*m*cm/s^2, other energies in"),
        (one(more="time: d"), "the potential is in N*m, other energies in kg*m^2/d^2"),
    ],
)
def test_contradictions_are_told(text, message):
    (found,) = conflicts(text)
    assert message in found
    texts = find_units(read_spec(text, "a.yaml")).texts
    if "potential" in message or "position" in message:
        assert not texts.keys() & {"diagnostics/h", "diagnostics/p/x", "diagnostics/U"}


def test_what_contradicts_has_no_unit_and_all_else_has():
    found = find_units(read_spec(one(more="observables: {o: x + x_dot, p: m*(x + x_dot), r: x}"), "a.yaml"))
    assert len(found.conflicts) == 2
    assert found.texts["observables/r"] == "m" and found.texts["diagnostics/h"] == ENERGY
    assert not found.texts.keys() & {"observables/o", "observables/p"}


@pytest.mark.parametrize(
    "force",
    [
        "forces: {bead: [-k*x_dot]}",
        "generalized_forces: {x: -m}",
        "dissipation: k*x_dot**2",
        "forces: {bead: [x + m]}",
    ],
)
def test_forces_that_contradict_leave_the_ledgers_without_units(force):
    found = find_units(read_spec(one(more=force), "a.yaml")).texts
    assert found["diagnostics/h"] == ENERGY and found["diagnostics/p/x"] == LINEAR
    assert not found.keys() & {"diagnostics/ledger/h", "diagnostics/ledger/p/x"}


def test_a_unit_that_is_not_known_may_be_another_name():
    found = find_units(read_spec(one(k="{value: 1, unit: Foo/m^2}", more="time: s"), "a.yaml"))
    (conflict,) = found.conflicts
    assert conflict.message == f"the potential is in Foo, other energies in {ENERGY}"
    assert conflict.hint == "unknown unit 'Foo': write it in terms of others"


@settings(max_examples=60, deadline=None)
@given(
    st.randoms(use_true_random=False), st.lists(st.sampled_from(["m", "s", "N/mm", "deg", "?", "rad", "1"]))
)
def test_any_file_has_units_or_none(source, some):
    text = system(source)
    for unit in some:
        text = text.replace("{initial:", f"{{unit: '{unit}', initial :", 1)
    try:
        spec = read_spec(f"{text}\ntime: s\n", "a.yaml")
    except SpecError:
        return
    find_units(spec)


def test_a_contradiction_of_a_family_is_told_once():
    text = "sizes: {N: 30}\nparameters: {m: {value: 1, unit: kg}}\ntime: s\n"
    text += "coordinates: {'u[i in range(N)]': {initial: 1, unit: m}}\nmasses: {'b[i in range(N)]': m}\n"
    text += "embedding: {'b[i in range(N)]': 'u[i] + u_dot[i]*t'}\n"
    text += "observables: {'o[i in range(N)]': 'u[i] + u_dot[i]'}\n"
    text = text.replace(" + u_dot[i]*t", "")
    assert conflicts(text) == ["m and m/s are added in observable 'o'"]


def test_families_are_gone_through_once(monkeypatch):
    """However many members: the work is counted in trees."""
    plain, counts = Walk.value, Counter[int]()

    def counted(self: Walk, tree: Tree) -> Value:
        counts[size] += 1
        return plain(self, tree)

    monkeypatch.setattr(Walk, "value", counted)
    for size in (5, 300):
        find_units(read_spec((SYSTEMS / "n_pendulum.yaml").read_bytes(), "a.yaml", {"N": str(size)}))
    assert counts[5] == counts[300] < 100
