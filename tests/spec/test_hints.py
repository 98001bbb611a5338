"""The way out that a message shows: what was meant, by people who write systems as they do elsewhere."""

from __future__ import annotations

from itertools import product

import pytest

from tests.support.files import PENDULUM, changed, problems

PARAMETERS = "parameters:\n  m: 1\n  l: {value: 0.5, unit: m}\n  g: 9.81"
BODY = """\
coordinates: {a: {initial: 0.3}, b: {initial: 0.4}, c: {initial: 0.5}}
bodies:
  top: {mass: 1, inertia: [1, 2, 2.5], position: [a, 0, 0], orientation: {euler: [a, b, c], sequence: zxz}}
observables: {e: top.x}
"""


def hints(text: str, old: str, new: str) -> list[str]:
    assert text.count(old) == 1
    return [one.hint for one in problems(text.replace(old, new))]


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("word", ["w", "omega", "\u03c9", "Omega", "ang_vel", "angular_velocity"])
def test_angular_velocities_by_other_names(word):
    for axis, between in product("xyz123", ["", "_", "."]):
        if (word, between) != ("w", "") and not (between == "." and axis.isdecimal()):
            assert hints(BODY, "top.x", f"top.{word}{between}{axis}") == [f"write top.w{axis}"]
    whole = "write (top.wx, top.wy, top.wz), or (top.w1, top.w2, top.w3) along the axes of the body"
    assert hints(BODY, "top.x", f"top.{word}") == [whole]


def test_what_has_no_components_exists():
    """A way out is never a name that would be refused in turn."""
    assert hints(BODY, "top.x", "top.w1.x") == ["write top.w1"]
    first, second = hints(BODY, "top.x", "top.spin.x")
    assert first == "write one component, as in top.x"
    assert second.startswith("known: top.x, top.y, top.z")


@pytest.mark.parametrize(
    ("sequence", "meant"),
    [
        *((one.upper(), one) for one in ("zxz", "zyx", "xyz")),
        *((one.translate(str.maketrans("xyz", "123")), one) for one in ("zxz", "zyx", "yxy")),
        ("z", "{euler: [a, 0, 0], sequence: zxz}"),
        ("Y", "{euler: [a, 0, 0], sequence: yzy}"),
        ("xy", "{euler: [a, b, 0], sequence: xyx}"),
        ("zz", "three axes, neighbours different, such as zxz, zyx or xyz"),
        ("zxq", "three axes, neighbours different, such as zxz, zyx or xyz"),
    ],
)
def test_sequences_of_axes(sequence, meant):
    assert hints(BODY, "sequence: zxz", f"sequence: {sequence}") == [f"write {meant}"]


def test_a_body_that_turns_about_one_axis():
    found = hints(BODY, "euler: [a, b, c]", "euler: [a]")
    assert found == ["write [phi, theta, psi], with 0 for the angles that are not needed"]
    assert not problems(BODY.replace("euler: [a, b, c]", "euler: [a, 0, 0]"))


@pytest.mark.parametrize(
    ("name", "output"), [("T", "T"), ("U", "U"), ("E_kin", "T"), ("V", "U"), ("E", "energy"), ("H", "h")]
)
def test_energies_are_outputs(name, output):
    (hint,) = hints(BODY, "top.x", f"2*{name}")
    assert hint.startswith(f"--outputs {output} writes the ")
    assert hint.endswith(f"; or add {name} to the parameters")
    (hint,) = [one.hint for one in problems(f"{BODY}potential: 2*{name}\n")]
    assert "--outputs" not in hint


def test_a_position_relative_to_another():
    two = changed("  bob: m", "  bob: m\n  two: m")
    assert not problems(two.replace("embedding:", "embedding:\n  two: bob + (l, 0)"))
    (hint,) = hints(two, "embedding:", "embedding:\n  two: (bob.x, bob.vy)")
    assert hint == "a position is r(q, t): coordinates, t, parameters and other positions only"


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ("m*g*bob.y", "m*g*bob.y,", "leave out the comma at the end"),
        (PARAMETERS, "parameters: {m:1, g: 9.81, l: 1}", "write m: 1, with a space"),
        ("initial: 0.1", "initial:0.1", "write initial: 0.1, with a space"),
    ],
)
def test_what_is_missing_or_too_much_at_a_sign(old, new, hint):
    assert hints(PENDULUM, old, new)[0] == hint


ALIKE = """\
parameters: {m: 1, k: 2}
coordinates: {x: {initial: 1}}
masses: {bob: m}
positions: {bob: [x, sin(x)]}
potential: k*x**2 + bob.y
"""


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        (
            "masses",
            "m\u0430sses",
            "did you mean 'masses'? This '\u0430' is another letter that looks the same",
        ),
        ("k*x", "k*\u0445", "did you mean 'x'? This '\u0445' is another letter that looks the same"),
        (
            "k*x",
            "\u03ba*x",
            "did you mean 'k'? This '\u03ba' is another letter that looks the same: Greek small",
        ),
        ("k: 2", "\u043a: 2", "did you mean '\u043a'? Its '\u043a' is another letter that looks the same"),
        ("sin(", "s\u0456n(", "did you mean 'sin'? This '\u0456' is another letter"),
        ("bob.y", "bob.\u0443", "write bob.y"),
        ("bob.y", "b\u043eb.y", "did you mean 'bob'? This '\u043e' is another letter"),
    ],
)
def test_a_letter_of_another_alphabet_is_named(old, new, hint):
    found = hints(ALIKE, old, new)
    assert found[0].startswith(hint)
    assert len(found) == 1


def test_a_greek_letter_is_first_of_all_its_name():
    """nu looks like v, and is nu."""
    text = "parameters: {v: 1, nu: 2}\ncoordinates: {x: {initial: 1}}\nlagrangian: x_dot**2 - nu*v*x**2\n"
    assert hints(text, "nu*v", "\u03bd*v") == ["did you mean 'nu'?"]
