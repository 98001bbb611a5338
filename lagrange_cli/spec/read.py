"""The text of a system file to a ``Spec``."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.confusions import STATE
from lagrange_cli.expression.near import known_hint
from lagrange_cli.limits import uncollected
from lagrange_cli.records import replace
from lagrange_cli.spec import nodes
from lagrange_cli.spec.check import check
from lagrange_cli.spec.draft import LOOKED_UP, Draft
from lagrange_cli.spec.families import expand
from lagrange_cli.spec.fields import unreadable, words_of
from lagrange_cli.spec.nodes import Node, compose, decode
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settings import SOLVE
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.table import read_table


def read_spec(text: bytes | str, filename: str, sizes: Mapping[str, str] | None = None) -> Spec:
    """Read and check a system file; ``filename`` is used in messages and for the default name.

    ``sizes`` replace those of the file, name to expression.

    Raises:
        SpecError: with every problem of the file, each with its place.
        UsageError: where ``sizes`` are not the file's, or no whole numbers greater than 0.
    """
    spec, problems = examine(text, filename, sizes)
    problems.stop_if_any()
    return spec


def examine(
    text: bytes | str, filename: str, sizes: Mapping[str, str] | None = None
) -> tuple[Spec, Problems]:
    """The same with all problems found; if there are any, the spec has the parts that could be read.

    Raises:
        SpecError: where the file is not YAML, or too wrong to be read any further.
        UsageError: as ``read_spec``.
    """
    source = decode(text, filename)
    problems = Problems(source)
    with uncollected():
        draft = read_draft(compose(source, problems), problems)
        numbers: dict[str, int] = {}
        if sizes or draft.entries("sizes"):
            from lagrange_cli.spec.sizes import resolve_sizes

            numbers = resolve_sizes(draft, sizes or {}, problems)
        if any(one.key.axes or one.is_list for key in LOOKED_UP for one in draft.written(key)):
            from lagrange_cli.spec.lookups import with_lookups

            draft = with_lookups(draft, numbers, problems)
        return check(expand(draft, numbers, problems), numbers, problems), problems


def read_draft(root: Node, problems: Problems) -> Draft:
    """The sections of the file; mistakes in their form are added to ``problems``."""
    if not isinstance(root, nodes.Mapping):
        problems.add(
            root.place,
            "a system file is a mapping, with a 'key: value' for each section",
            known_hint(SECTIONS.keys, limit=8),
        )
        problems.stop_if_any()
        raise AssertionError("unreachable")
    sections = read_table(root, SECTIONS, "", problems)
    words = [key.text for key, _ in root.entries]
    if any(SECTIONS.meant(word)[1] == STATE for word in words if word not in SECTIONS.by_word):
        sections["coordinates"] = tuple(  # their initial values are not missing
            replace(one, fields={"initial": unreadable(one.place, problems), **one.fields})
            for one in sections.get("coordinates", ())
        )
    return Draft(
        sections,
        places={SECTIONS.key_of(key.text): key.place for key, _ in root.entries},
        words={SECTIONS.key_of(word): word for word in reversed(words)},
        strange=any(word not in SECTIONS.by_word for word in words),
        solve_places=solve_places(root),
    )


def solve_places(root: nodes.Mapping) -> dict[str, Place]:
    """Where the ``solve`` section gives what: by its keys, and by ``outputs NAME`` for each output."""
    solve = next((node for key, node in root.entries if SECTIONS.read_as(key.text) == "solve"), None)
    found: dict[str, Place] = {}
    outputs: dict[str, Place] = {}
    for key, node in nodes.continued(solve, SOLVE.lists).entries if isinstance(solve, nodes.Mapping) else ():
        meant = SOLVE.read_as(key.text)
        found[meant] = node.place
        if meant == "outputs":
            outputs |= {f"outputs {word}": place for word, place in words_of(node)}
    return found | outputs
