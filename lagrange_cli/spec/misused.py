"""Mistakes in the use of a known name: its place, its indices, its component."""

from __future__ import annotations

from lagrange_cli.expression.confusions import COMPONENTS as CONFUSED_COMPONENTS
from lagrange_cli.expression.confusions import VELOCITIES, spin_component
from lagrange_cli.expression.near import known_hint, look_alike, shown
from lagrange_cli.expression.quantities import comma_inside
from lagrange_cli.expression.syntax import ExpressionError, Name, Number, Vector, names, plain_names
from lagrange_cli.expression.vocabulary import (
    AXES_COMPONENTS,
    AXES_RATES,
    BODY_COMPONENTS,
    BODY_SPIN,
    COMPONENTS,
    MOVING_COMPONENTS,
    MULTIPLIER,
    POINT,
    SPACE_SPIN,
    VELOCITY_COMPONENTS,
    member_name,
    velocity_name,
)
from lagrange_cli.spec.kinds import Kind, Meaning, Rule
from lagrange_cli.spec.meanings import Meanings
from lagrange_cli.spec.spec import Expression


def constraint_itself(name: Name, meaning: Meaning, base: str, component: str) -> ExpressionError:
    """The name of a constraint stands where only that of its multiplier has a value."""
    family = meaning.family
    hint = f"write {family.label if family else base}.{MULTIPLIER} for its Lagrange multiplier"
    message = f"'{base}' is a constraint, which is always 0"
    if component:
        message = f"the constraint '{base}' has no component '{component}'"
    return ExpressionError(name.span, message, hint)


def not_allowed(name: Name, meaning: Meaning, base: str, kind: Kind, rule: Rule) -> ExpressionError:
    """A name comes down to a ``kind`` that expressions of this section may not depend on."""
    via = ""
    if meaning.what is Kind.DEFINITION and kind is not Kind.DEFINITION:
        via = f", which depends on {'t' if kind is Kind.TIME else f'a {kind.value}'},"
    what = f"{meaning.what.value} '{base}'"
    if kind is Kind.VELOCITY and name.identifier.partition(".")[2] in MOVING_COMPONENTS:
        spins = name.identifier.partition(".")[2] in SPACE_SPIN + BODY_SPIN
        what = f"{'angular ' if spins else ''}velocity of '{base}'"
    return ExpressionError(name.span, f"the {what}{via} cannot be used", rule.hint)


def wrong_indices(name: Name, meaning: Meaning) -> ExpressionError:
    """A name has not as many indices as its family."""
    due = len(meaning.family.shape) if meaning.family else 0
    example = member_name(name.identifier, "ijklmn"[:due]) if due else name.identifier
    if meaning.what is Kind.COORDINATE and due:  # which has no components
        _, _, component = name.identifier.partition(".")
        example = member_name(name.base, "ijklmn"[:due])
        example = velocity_name(example) if component in VELOCITY_COMPONENTS else example
    if not due:
        message = f"'{name.base}' is not a family and takes no index"
        if component := _numbered_component(name, meaning):
            example = f"{name.base}.{component}"
    elif not name.indices:
        message, example = f"missing index on the family '{name.base}'", f"{example} for one member"
        members = meaning.family.members if meaning.family else ()
        if due == 1 and meaning.what is Kind.PARAMETER and len(members) in (2, 3):
            example += f", or ({', '.join(members)}) for a vector"
    else:
        message = f"wrong number of indices on '{name.base}': {len(name.indices)} instead of {due}"
    return ExpressionError(name.span, message, f"write {example}")


def two_velocities(name: Name, base: str, component: str, point: str) -> ExpressionError:
    """The velocity of a definition is asked for that stands for a ``point`` which moves in its body."""
    message = f"'{base}' is a point that moves in its body, so that it has two velocities"
    return ExpressionError(name.span, message, f"write {point}.{component} for that of the body there")


def wrong_component(
    name: Name, meaning: Meaning, base: str, component: str, *, moves: bool
) -> ExpressionError:
    """A name has no such component; ``moves`` where its components have velocities."""
    if not isinstance(meaning.value, tuple):
        own = meaning.family.label if meaning.family else base
        hint = f"write {own}"
        if meaning.what is Kind.COORDINATE:
            hint += f", or {velocity_name(own)} for its velocity"
        return ExpressionError(
            name.span, f"the {meaning.what.value} '{base}' has no component '{component}'", hint
        )
    label = meaning.family.label if meaning.family else base
    known = COMPONENTS[: len(meaning.value)]
    if component in BODY_COMPONENTS:
        if component in AXES_COMPONENTS + AXES_RATES:
            hint = f"only bodies have an orientation and points such as plate.{POINT}(a, b, c)"
        else:
            hint = "only bodies have an angular velocity"
        message = f"the {meaning.what.value} '{base}' is not a rigid body"
        return ExpressionError(name.span, message, f"{hint}: see 'bodies'")
    if moves:
        known += VELOCITY_COMPONENTS[: len(meaning.value)]
    meant = CONFUSED_COMPONENTS.get(component, "") or look_alike(component, known)
    hint = f"write {label}.{meant}" if meant in known else known_hint(f"{label}.{one}" for one in known)
    if meaning.what is Kind.BODY and component not in VELOCITIES:
        hint += f", {label}.{SPACE_SPIN[0]}, {label}.{BODY_SPIN[0]}, {label}.{POINT}(a, b, c), ..."
    if component in {*VELOCITIES, *VELOCITY_COMPONENTS} and meaning.what is Kind.DEFINITION and not moves:
        hint += f"; '{label}' contains velocities, and accelerations have no names"
    if component in VELOCITIES and moves:
        velocity = ", ".join(f"{label}.{one}" for one in known[len(meaning.value) :])
        hint = f"write ({velocity}) for its velocity"
    spin = spin_component(component) if meaning.what is Kind.BODY else None
    if spin is not None:
        axes, own = (", ".join(f"{label}.{one}" for one in names) for names in (SPACE_SPIN, BODY_SPIN))
        hint = f"write {label}.{spin}" if spin else f"write ({axes}), or ({own}) along the axes of the body"
    return ExpressionError(
        name.span, f"the {meaning.what.value} '{base}' has no component '{component}'", hint
    )


def _numbered_component(name: Name, meaning: Meaning) -> str:
    """``z`` for the index of ``bead[2]``, where ``bead`` is a position; nothing for other names."""
    if meaning.what not in (Kind.PARTICLE, Kind.BODY) or "." in name.identifier or len(name.indices) != 1:
        return ""
    index = name.indices[0]
    return dict(zip("012", COMPONENTS, strict=True)).get(index.text, "") if isinstance(index, Number) else ""


def vector_items(expression: Expression) -> list[str]:
    """The components of a vector as they are written, if it is a plain one; else an example."""
    tree = expression.tree
    items = tree.items if isinstance(tree, Vector) else ()
    return [expression.excerpt(one.span) for one in items] or ["1", "2"]


def vector_hint(known: Meanings, expression: Expression, section: str = "") -> str:
    """How a scalar is made of the vectors of an expression."""
    tree = expression.tree
    if isinstance(tree, Vector) and len(tree.items) == 1:
        return "leave out the comma at the end"
    if section == "parameters":
        items = ", ".join(vector_items(expression))
        return f"write a list, [{items}]; or write vectors under 'definitions'"
    vectors = [one for one in plain_names(tree) if isinstance(known.values.get(one), tuple)]
    for one in sorted(vectors):
        components = any(name.identifier.startswith(f"{one}.") for name in names(tree))
        if components and known.table[one].what is Kind.PARTICLE:  # m1*g*m1.y: the first m1 should be a mass
            return f"{shown(one)} is a position: write its mass as a parameter M, with 'masses: {{{one}: M}}'"
    comma = comma_inside(expression.excerpt(tree.span))
    if comma and not vectors:
        return comma
    hint = f"take a component, as in {min(vectors, default='bead')}.x, or norm() or dot()"
    return f"{shown(vectors[0])} is a vector: {hint}" if len(vectors) == 1 else hint
