"""The inertia and the orientation of a rigid body as they are written."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.near import known_hint, near_hint, near_match, shown
from lagrange_cli.spec import nodes
from lagrange_cli.spec.body import SOLIDS, Inertia, Orientation
from lagrange_cli.spec.fields import read_scalar, read_text
from lagrange_cli.spec.nodes import Node
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression

FORMS = {"euler": "[phi, theta, psi]", "quaternion": "[w, x, y, z]", "matrix": "[[..], [..], [..]]"}
"""The forms of an orientation, and how each is written."""
KEYS = (*FORMS, "sequence")
KEYS_ELSEWHERE = {
    "euler": "angles euler_angles eulerangles cardan tait_bryan rpy ypr",
    "quaternion": "q quat quaternions euler_parameters versor",
    "matrix": "R rot rotation rotation_matrix dcm axes_matrix",
    "sequence": "order seq axes convention rotation_order kind type",
}
SOLIDS_ELSEWHERE = {
    "sphere": "ball globe",
    "cylinder": "roller shaft drum",
    "box": "cube cuboid block brick plate parallelepiped",
    "disc": "disk wheel coin",
    "rod": "stick bar needle beam line",
}
"""Other words for these keys."""


def _meant(word: str, elsewhere: Mapping[str, str]) -> str:
    """The word of this program for one of another; nothing where there is none."""
    return next((meant for meant, words in elsewhere.items() if word in words.split()), "")


def components(
    node: Node, where: str, problems: Problems, counts: tuple[int, ...], hint: str
) -> tuple[Expression, ...] | None:
    """A list of so many scalars."""
    if not isinstance(node, nodes.Sequence) or len(node.items) not in counts:
        given = f", not {len(node.items)}" if isinstance(node, nodes.Sequence) else ""
        due = " or ".join(map(str, counts))
        if isinstance(node, nodes.Scalar) and node.text.strip().startswith("["):
            hint = "leave out the quotes around the list"
        problems.add(node.place, f"{where} must be a list of {due} components{given}", hint)
        return None
    found = [read_scalar(item, f"{where}, component {i + 1}", problems) for i, item in enumerate(node.items)]
    return tuple(one for one in found if one is not None) if None not in found else None


def square(node: nodes.Sequence, where: str, problems: Problems) -> tuple[Expression, ...] | None:
    """The nine entries of a list of rows."""
    hint = "write [[a, b, c], [d, e, f], [g, h, i]]"
    if len(node.items) != 3:
        problems.add(node.place, f"{where} must have 3 rows, not {len(node.items)}", hint)
        return None
    rows = [
        components(row, f"row {i + 1} of {where}", problems, (3,), hint) for i, row in enumerate(node.items)
    ]
    found = [one for row in rows if row is not None for one in row]
    return tuple(found) if len(found) == 9 else None


def is_square(node: Node) -> bool:
    """Whether this is written as a list of rows."""
    return isinstance(node, nodes.Sequence) and any(isinstance(row, nodes.Sequence) for row in node.items)


def read_inertia(node: Node, where: str, problems: Problems) -> Inertia | None:
    """``[I1, I2, I3]`` or a 3x3 matrix."""
    if is_square(node):
        assert isinstance(node, nodes.Sequence)
        entries = square(node, where, problems)
    else:
        entries = components(node, where, problems, (3,), "write [I1, I2, I3], or a matrix as three rows")
    return None if entries is None else Inertia("", entries, node.place)


def read_solid(node: Node, where: str, problems: Problems) -> Inertia | None:
    """``{box: [a, b, c]}``: a homogeneous solid with its sizes."""
    known = "write one of " + ", ".join(f"{{{name}: {sizes}}}" for name, sizes in SOLIDS.items())
    if not isinstance(node, nodes.Mapping) or len(node.entries) != 1:
        problems.add(node.place, f"{where} must be one solid with its sizes", known)
        return None
    ((key, value),) = node.entries
    if key.text not in SOLIDS:
        meant = _meant(key.text, SOLIDS_ELSEWHERE)
        hint = f"write {{{meant}: {SOLIDS[meant]}}}" if meant else near_hint(key.text, SOLIDS) or known
        problems.add(key.place, f"unknown solid {shown(key.text)}", hint)
        return None
    sizes = SOLIDS[key.text]
    label = f"the {key.text} of body {where.partition('body ')[2]}"
    if not sizes.startswith("["):
        size = read_scalar(value, label, problems)
        return None if size is None else Inertia(key.text, (size,), node.place)
    due = sizes.count(",") + 1
    given = components(value, label, problems, (due,), f"write {{{key.text}: {sizes}}}")
    return None if given is None else Inertia(key.text, given, node.place)


def read_orientation(node: Node, where: str, problems: Problems) -> Orientation | None:
    """``{euler: [a, b, c], sequence: zxz}``, ``{quaternion: [w, x, y, z]}`` or ``{matrix: 3x3}``."""
    hint = "write one of " + ", ".join(f"{{{form}: {example}}}" for form, example in FORMS.items())
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, f"{where} must be a mapping", hint)
        return None
    found: dict[str, Node] = {}
    for key, value in node.entries:
        word = key.text
        if word not in KEYS:
            word = _meant(word, KEYS_ELSEWHERE) or near_match(word, KEYS)
            near = f"write '{word}'" if word else known_hint(KEYS)
            problems.add(key.place, f"unknown key {shown(key.text)} in {where}", near)
            if not word:
                return None
        found[word] = value
    forms = [key for key in found if key in FORMS]
    if len(forms) != 1:
        many = (
            "only one of 'euler', 'quaternion' and 'matrix'" if forms else "angles, a quaternion or a matrix"
        )
        problems.add(node.place, f"{where} needs {many}", hint)
        return None
    (form,) = forms
    value, sequence = found[form], "zxz" if form == "euler" else ""
    if "sequence" in found:
        given = found["sequence"]
        sequence = read_text(given, f"sequence of {where}", problems)
        if form != "euler":
            problems.add(given.place, f"the sequence of {where} belongs to Euler angles", "leave it out")
        elif not is_sequence(sequence):
            problems.add(
                given.place, f"'{sequence}' is not a sequence of axes in {where}", _meant_sequence(sequence)
            )
    label = f"{form} of {where}"
    if form == "matrix" and isinstance(value, nodes.Sequence):
        entries = square(value, label, problems)
    else:
        count = 4 if form == "quaternion" else 3
        rest = ", with 0 for the angles that are not needed" if form == "euler" else ""
        entries = components(value, label, problems, (count,), f"write {FORMS[form]}{rest}")
    return None if entries is None else Orientation(form, sequence, entries, value.place)


def _meant_sequence(text: str) -> str:
    """A hint for what is no sequence of axes: ``ZXZ`` and ``313`` mean one, ``z`` a turn about one axis."""
    axes = text.lower().translate(str.maketrans("123", "xyz"))
    if is_sequence(axes):
        return f"write {axes}"
    others = [axis for axis in "zxy" if axis not in axes]
    if len(axes) in (1, 2) and is_sequence(axes + (axes[0] if len(axes) == 2 else others[0] + axes[:1])):
        whole = axes + (axes[0] if len(axes) == 2 else others[0] + axes)
        angles = ", ".join(["a", "b"][: len(axes)] + ["0", "0"][len(axes) - 1 :])
        return f"write {{euler: [{angles}], sequence: {whole}}}"
    return "write three axes, neighbours different, such as zxz, zyx or xyz"


def is_sequence(text: str) -> bool:
    """Whether it is one of the 12 sequences of axes, neighbours different."""
    return len(text) == 3 and set(text) <= set("xyz") and text[0] != text[1] != text[2]
