"""``lagrange check``: what it says of each kind of system."""

import json
import re

import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.run.check import classify
from lagrange_cli.run.classification import as_object, as_text
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.command import SYSTEMS, lagrange

KEYS = [
    "name",
    "degrees_of_freedom",
    "scleronomic",
    "cyclic",
    "conserved",
    "events",
    "skipped",
    "structure",
    "engine",
    "formulation",
    "convolutions",
    "warnings",
]

FACTS = {
    # system: degrees of freedom, scleronomic, cyclic coordinates, what is conserved
    "pendulum": (1, True, [], {"h"}),
    "double_pendulum": (2, True, [], {"h"}),
    "atwood": (1, True, [], {"h", "C_1", "C_2"}),
    "incline": (1, True, [], {"h", "C_1", "C_2"}),
    "henon_heiles": (2, True, [], {"h"}),
    "parabola_bead": (1, True, [], {"h"}),
    "rotating_hoop": (1, False, [], {"h"}),
    "rotating_rod": (1, False, [], {"h"}),
    "harmonic_oscillator": (1, True, [], {"h"}),
    "central_force": (2, True, ["theta"], {"h", "p_theta", "A_x", "A_y"}),
    "spherical_pendulum": (2, True, ["phi"], {"h", "p_phi"}),
    "driven_damped_pendulum": (1, True, [], set()),
}


def check(*names: str, cwd) -> list[dict]:
    run = lagrange("check", "--json", *(SYSTEMS / f"{name}.yaml" for name in names), cwd=cwd)
    assert (run.returncode, run.stderr) == (0, "")
    return [json.loads(line) for line in run.stdout.splitlines()]


@pytest.mark.exhaustive(keep=0.35)
def test_what_kind_of_system_each_is(tmp_path):
    for name, answer in zip(FACTS, check(*FACTS, cwd=tmp_path), strict=True):
        degrees, scleronomic, cyclic, conserved = FACTS[name]
        assert list(answer) == KEYS
        assert answer["degrees_of_freedom"] == degrees, name
        assert answer["scleronomic"] is scleronomic, name
        assert answer["cyclic"] == cyclic, name
        assert {each["quantity"] for each in answer["conserved"]} == conserved, name
        assert all(each["expression"] and each["because"] for each in answer["conserved"])
        assert all(isinstance(sentence, str) for sentence in answer["skipped"])


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("name", [path.stem for path in sorted(SYSTEMS.glob("*.yaml"))])
def test_every_shipped_system_is_right(name, capsys):
    assert main(["check", "--json", str(SYSTEMS / f"{name}.yaml")]) == 0
    assert json.loads(capsys.readouterr().out)["degrees_of_freedom"] > 0


def test_the_text_says_the_same(tmp_path):
    run = lagrange("check", SYSTEMS / "central_force.yaml", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert "2 degrees of freedom, scleronomic: positions do not depend on t" in run.stdout
    assert "mass matrix" not in run.stdout and "convolution" not in run.stdout
    assert "cyclic: theta" in run.stdout
    assert "p_theta = " in run.stdout


def test_how_it_is_integrated_is_said_on_request(tmp_path):
    run = lagrange("check", "--verbose", SYSTEMS / "central_force.yaml", cwd=tmp_path)
    assert "the mass matrix after Routh's reduction contains parameters only" in run.stdout
    assert "convolutions per order" in run.stdout


def test_nothing_is_written(tmp_path):
    check("pendulum", cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_quiet_checks_without_a_word(tmp_path):
    assert lagrange("check", "--quiet", SYSTEMS / "pendulum.yaml", cwd=tmp_path).stdout == ""


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["missing.yaml"], 5, "no such file"),
        (["wrong.yaml"], 3, "wrong.yaml:"),
        (["solve.yaml"], 3, "unknown method 'rk4'"),
        (["good.yaml", "--set", "nosuch=1"], 2, "nosuch"),
    ],
)
def test_what_is_wrong_is_said_with_the_status_of_solve(tmp_path, arguments, status, message):
    good = (SYSTEMS / "pendulum.yaml").read_text(encoding="utf-8").partition("solve:")[0]
    (tmp_path / "good.yaml").write_text(good)
    (tmp_path / "solve.yaml").write_text(good + "solve: {stop: 1, method: rk4}\n")
    (tmp_path / "wrong.yaml").write_text(good + "frobnicate: 1\n")
    run = lagrange("check", *arguments, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (status, "")
    assert message in run.stderr


def test_a_system_is_read_from_standard_input(tmp_path):
    text = (SYSTEMS / "atwood.yaml").read_text(encoding="utf-8")
    run = lagrange("check", "--json", "-", cwd=tmp_path, input=text)
    assert json.loads(run.stdout)["degrees_of_freedom"] == 1


CONTRADICTION = """\
parameters: {m: {value: 1, unit: kg}, g: {value: 9.81, unit: m/s^2}, l: {value: 100, unit: cm}}
coordinates: {theta: {initial: 1, unit: rad}}
masses: {bob: m}
embedding: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
"""


def test_units_that_contradict_are_a_warning(tmp_path):
    (tmp_path / "a.yaml").write_text(CONTRADICTION)
    run = lagrange("check", "a.yaml", cwd=tmp_path)
    assert run.returncode == 0 and run.stdout.startswith("a: 1 degree of freedom")
    message = "the potential is in kg*m*cm/s^2, other energies in kg*cm^2/s^2"
    first, excerpt, _ = run.stderr.splitlines()
    assert first == f"a.yaml:5:12: warning: {message}"
    assert excerpt.endswith("potential: m*g*bob.y")
    run = lagrange("check", "a.yaml", "--json", cwd=tmp_path)
    (warning,) = json.loads(run.stdout)["warnings"]
    assert (warning["line"], warning["column"], warning["message"]) == (5, 12, message)
    assert run.stderr == ""


@pytest.mark.parametrize("command", [["solve"], ["sweep", "--over", "m=1,2"]], ids=lambda words: words[0])
def test_units_that_contradict_are_told_where_numbers_are_computed(tmp_path, command):
    """``unit: deg`` does not convert what sin takes."""
    text = CONTRADICTION.replace("unit: cm", "unit: m").replace("1, unit: rad", "30, unit: deg")
    (tmp_path / "a.yaml").write_text(text)
    run = lagrange(command[0], "a.yaml", *command[1:], "--stop", "0.1", cwd=tmp_path)
    assert run.returncode == 0
    (line,) = run.stderr.splitlines()
    assert line.startswith("a.yaml: warning: sin is taken of a quantity in deg in the position of 'bob'; ")
    run = lagrange(command[0], "a.yaml", *command[1:], "--stop", "0.1", "--force", "--quiet", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("sequence", "middle", "angle"), [("zxz", "b", 0), ("xyz", "b", "pi/2"), ("zxz", "b", 0.1)]
)
def test_angles_that_are_singular_at_the_start_are_a_warning(sequence, middle, angle, tmp_path):
    (tmp_path / "a.yaml").write_text(
        f"coordinates: {{a: {{initial: 0.1}}, b: {{initial: {angle}}}, c: {{initial: 0}}}}\n"
        "bodies:\n  top: {mass: 1, position: [b, 0, 0], inertia: [1, 1, 1],\n"
        f"    orientation: {{euler: [a, {middle}, c], sequence: {sequence}}}}}\n"
    )
    run = lagrange("check", "a.yaml", cwd=tmp_path)
    assert run.returncode == 0
    warned = "the angles of body 'top' are singular at the start: the"
    assert (warned in run.stderr) == (middle == "b" and angle != 0.1)


def test_many_warnings_are_counted(tmp_path):
    wrong = "".join(f"  o{i}: l + m\n" for i in range(25))
    (tmp_path / "a.yaml").write_text(f"{CONTRADICTION.replace('unit: cm', 'unit: m')}observables:\n{wrong}")
    run = lagrange("check", "a.yaml", cwd=tmp_path)
    assert run.stderr.count("warning: m and kg are added in observable") == 20
    assert run.stderr.splitlines()[-1] == "a.yaml: 5 more warnings, see --json"


def test_events_are_listed_and_what_they_may_change(tmp_path):
    run = lagrange("check", SYSTEMS / "bouncing_ball.yaml", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert (
        "    floor: y = 0, falling: y_dot -> -e*y_dot\n    top: y_dot = 0, falling: recorded\n" in run.stdout
    )
    assert "only between events, as 'floor' may change it\n" in run.stdout
    (answer,) = check("bouncing_ball", cwd=tmp_path)
    assert answer["events"] == [
        {"name": "floor", "when": "y", "direction": "falling", "action": "set", "set": {"y_dot": "-e*y_dot"}},
        {"name": "top", "when": "y_dot", "direction": "falling", "action": "record", "set": {}},
    ]
    assert [each.get("broken_by") for each in answer["conserved"]] == [["floor"]] * 3


ROLLING_BALL = """
coordinates:
  x: {initial: 0, velocity: 1}
  y: {initial: 0}
  a: {initial: 0}
  b: {initial: 0, velocity: 1}
  c: {initial: 0}
lagrangian: (x_dot**2 + y_dot**2)/2 + (a_dot**2 + b_dot**2 + c_dot**2)/5
nonholonomic: {along: (x_dot - b_dot)*(2 + cos(c)), across: (y_dot + a_dot)*(2 + cos(c))}
"""
RISING_RAMP = """
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {m: 1}
positions: {m: [x, y]}
potential: y
constraints: {ramp: y - t**2*x}
"""


def test_the_matrix_with_constraints_is_described(tmp_path):
    run = lagrange("check", "--verbose", "-", cwd=tmp_path, input=ROLLING_BALL)
    assert (run.returncode, run.stderr) == (0, "")
    assert "L and constraints do not depend on t" in run.stdout
    assert "block-diagonal, {x, b, along}, {y, a, across}, {c}:" in run.stdout


def test_constraints_that_depend_on_t_are_rheonomic(tmp_path):
    run = lagrange("check", "-", cwd=tmp_path, input=RISING_RAMP)
    assert (run.returncode, run.stderr) == (0, "")
    assert "rheonomic: constraints depend on t" in run.stdout


FROBENIUS = """
parameters: {R: 0.5}
coordinates: {x: {initial: 0}, y: {initial: 0}, phi: {initial: 0}, a: {initial: 0.5, velocity: 1}}
lagrangian: (x_dot**2 + y_dot**2 + phi_dot**2 + a_dot**2)/2
nonholonomic:
  roll: x_dot*cos(a) - R*phi_dot*cos(a)
  edge: x_dot*sin(a) - y_dot*cos(a)
"""


def test_frobenius_tells_which_constraints_on_velocities_are_holonomic(tmp_path):
    run = lagrange("check", "--json", "-", cwd=tmp_path, input=FROBENIUS)
    answer = json.loads(run.stdout)
    assert answer["integrable"] == {"together": False, "roll": True, "edge": False}
    assert answer["integrals"] == {"roll": "-R*phi + x"}
    assert answer["degrees_of_freedom"] == 2


@pytest.mark.exhaustive(keep=0.2)
def test_families_of_constraints_are_shown_as_one():
    text = """
        sizes: {N: 3}
        coordinates:
          x[i in range(N)]: {initial: i}
          q[i in range(N), 0]: {initial: 1}
          q[i in range(N), k in range(1, 4)]: {initial: 0}
        bodies:
          b[i in range(N)]:
            mass: 1
            solid: {sphere: 1}
            position: ["x[i]", 0, 0]
            orientation: {quaternion: ["q[i, 0]", "q[i, 1]", "q[i, 2]", "q[i, 3]"]}
        constraints: {end: "x[0]", link[i in range(N - 1)]: "x[i + 1] - x[i] - 1"}
        """
    spec = read_spec(text, "a.yaml")
    lines = as_text(classify(spec, values=resolve_values(spec)), verbose=False).splitlines()
    assert "  constraints: end, link[0..1], b.norm[0..2]" in lines


def test_a_family_of_constraints_that_are_not_integrable_takes_one_line():
    text = """
        sizes: {N: 3}
        coordinates: {x: {initial: 0}, y: {initial: 0}, a[i in range(N)]: {initial: 0.1*i}}
        lagrangian: x_dot**2 + y_dot**2 + sum(a_dot[i]**2 for i in range(N))
        nonholonomic:
          edge[i in range(N)]: y_dot*cos(a[i]) - x_dot*sin(a[i]) + i*a_dot[i]
          roll: x_dot - a_dot[0]
        """
    spec = read_spec(text, "a.yaml")
    lines = as_text(classify(spec, values=resolve_values(spec)), verbose=False).splitlines()
    told = [line.strip() for line in lines if "Frobenius" in line]
    assert told == [
        "roll is integrable (Frobenius), so it is holonomic: -a[0] + x is constant",
        "each of edge[0..2] is not integrable (Frobenius): it is nonholonomic",
        "together edge[0..2], roll are integrable (Frobenius): they are holonomic",
    ]


@pytest.mark.parametrize(("force", "kept"), [("", 1), ("generalized_forces: {'a[0, 0]': x}", 5)])
def test_momenta_of_a_family_take_one_line_if_all_are_kept(force, kept):
    text = f"""
        sizes: {{N: 2, M: 3}}
        coordinates: {{x: {{initial: 0}}, "a[i in range(N), j in range(M)]": {{initial: i + j}}}}
        lagrangian: x_dot**2 - x**2 + sum(a_dot[i, j]**2 for i in range(N) for j in range(M))
        {force}
        """
    spec = read_spec(text, "a.yaml")
    lines = as_text(classify(spec, values=resolve_values(spec)), verbose=False).splitlines()
    told = [line.strip() for line in lines if " = dL/d" in line]
    each = (
        "p_a[i,j] = dL/da_dot[i,j]: a[i,j] is cyclic (L does not depend on it), and no generalized force acts"
    )
    assert len(told) == kept
    assert (told == [f"{each} on it   [for i in range(2) for j in range(3)]"]) is (kept == 1)


REDUNDANT = """
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {a: 1}
positions: {a: [x, y]}
constraints: {rod: x**2 + y**2 - 1, again: 2*x**2 + 2*y**2 - 2}
"""


def test_redundant_constraints_are_named_and_do_not_count(tmp_path):
    run = lagrange("check", "-", cwd=tmp_path, input=REDUNDANT)
    assert "1 degree of freedom" in run.stdout
    assert "the constraint again depends on the others: the multipliers of rod, again are not" in run.stdout
    (answer,) = [json.loads(lagrange("check", "--json", "-", cwd=tmp_path, input=REDUNDANT).stdout)]
    assert (answer["degrees_of_freedom"], answer["initial"]["redundant"]) == (1, ["again"])


DRAWN = """
parameters: {m: 1, w: 2}
coordinates: {x: {initial: 0}, y: {initial: 0}, a: {initial: 0}}
bodies:
  b: {mass: m, solid: {sphere: 1}, position: [x, y, 0], orientation: {euler: [w*t, a, 0]}}
nonholonomic: {pulled: x_dot - w}
"""


@pytest.mark.exhaustive(keep=0.6)
def test_what_is_said_of_bodies_and_of_momenta_is_true(tmp_path, capsys):
    """The orientation depends on t, not the position; and the force that keeps a velocity may be 0."""
    system = tmp_path / "b.yaml"
    for text, said in (
        (DRAWN, "rheonomic: orientations depend"),
        (DRAWN.replace("w*t", "0"), "scleronomic:"),
    ):
        system.write_text(text, encoding="utf-8")
        assert main(["check", str(system)]) == 0
        shown = capsys.readouterr().out
        assert said in shown
        assert "L does not contain x, but forces may act along it, so that its momentum may change" in shown
    assert "positions, orientations and constraints do not depend on t" in shown


@pytest.mark.exhaustive(keep=0.5)
def test_long_formulas_are_counted_and_are_whole_in_json():
    text = """
        sizes: {N: 4}
        parameters: {k: 1.5, m: 1, c: 0.3}
        coordinates: {"x[i in range(N)]": {initial: 0.3*i}}
        lagrangian: >-
          sum(m*x_dot[i]**2/2 - k*x[i]**2/2 for i in range(N))
          - sum(c*(x[i] - x[i - 1])**2/2 for i in range(1, N))
        """
    spec = read_spec(text, "a.yaml")
    found = classify(spec, values=resolve_values(spec))
    shown = {line.split(" = ")[0].strip(): line for line in as_text(found, verbose=False).splitlines()}
    long = [one for one in as_object(found)["conserved"] if len(one["expression"]) > 200]
    assert long
    for one in long:
        count = len(re.findall(r" [+-] (?![^(]*\))", one["expression"])) + 1
        assert f"= a sum of {count} terms, see --json: " in shown[one["quantity"]]
