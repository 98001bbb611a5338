"""The JSON Schema of system files: it refuses what the reader refuses for its structure, and nothing else."""

import ast
import json
import re
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from random import Random

import jsonschema
import pytest
import yaml

from lagrange_cli.cli.main import main
from lagrange_cli.errors import LagrangeError
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.schema.file import UNKNOWN, of_reader, schema
from lagrange_cli.run.schema.readers import READERS, TABLES, WITH_KEYS
from lagrange_cli.spec import nodes
from lagrange_cli.spec.nodes import compose, decode
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.read import read_draft
from lagrange_cli.spec.readers import Entries, Single, Terms
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.table import Rare, Table
from tests.fuzzing import grammar
from tests.spec.test_bad_files import BAD
from tests.support.command import ROOT, SYSTEMS
from tests.support.files import PENDULUM

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
FILES = sorted(SYSTEMS.glob("*.yaml"))


@cache
def validator() -> jsonschema.Draft7Validator:
    made = schema()
    jsonschema.Draft7Validator.check_schema(made)
    return jsonschema.Draft7Validator(made)


def content(node: nodes.Node):
    """A file as an editor sees it: plain scalars that look like numbers are numbers."""
    if isinstance(node, nodes.Mapping):
        return {key.text: content(value) for key, value in node.entries}
    if isinstance(node, nodes.Sequence):
        return [content(item) for item in node.items]
    if node.empty:
        return None
    if node.plain and node.text in ("true", "false"):
        return node.text == "true"
    if node.plain and NUMBER.fullmatch(node.text):
        return int(node.text) if node.text.lstrip("+-").isdigit() else float(node.text)
    return node.text


WITHIN = (" in the name of a ", " is an expression that stays 0, not an ")


class Structural(Problems):
    """Tells mistakes in the structure of a file from those within its expressions."""

    def __init__(self, source) -> None:
        super().__init__(source)
        self.messages, self.within = [], False

    def add(self, place, message, hint="") -> None:
        # an index is an expression, too, and so is an equation in place of one
        if not self.within and not any(part in message for part in WITHIN):
            self.messages.append(message)
        super().add(place, message, hint)

    def add_expression(self, expression, error, where="") -> None:
        self.within = True
        super().add_expression(expression, error, where)
        self.within = False


def compare(text: str) -> bool | None:
    """Whether the schema refuses a file, None if it is no YAML; the reader must agree."""
    try:
        source = decode(text, "a.yaml")
        root = compose(source, Problems(source))
    except LagrangeError:
        return None
    problems = Structural(source)
    try:
        read_draft(root, problems)
        read_run(text.encode(), "a.yaml", None, lambda spec, problems: None)
        right = not problems.found
    except LagrangeError:
        right = False
    errors = [error.message for error in validator().iter_errors(content(root))]
    assert not (right and errors), (errors, text)
    assert errors or not problems.messages, (problems.messages, text)
    return bool(errors)


@pytest.mark.exhaustive(keep=8)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_shipped_systems_are_valid(path):
    text = path.read_text(encoding="utf-8")
    assert compare(text) is False
    try:
        plain = yaml.safe_load(text)
    except yaml.YAMLError:  # brackets of indices within a flow mapping, which only our reader takes
        return
    validator().validate(plain)


def texts_of_tests() -> Iterator[str]:
    """Every system file that stands in the tests as one text."""
    for path in sorted(ROOT.glob("tests/**/*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = node.value
                if re.search("^ *coordinates:|{coordinates:", text, re.MULTILINE):
                    yield text


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("part", range(4))
def test_the_files_of_the_tests_are_judged_as_by_the_reader(part):
    changed = [PENDULUM.replace(old, new) for old, new, _ in BAD]
    found = [compare(text) for text in [*changed, *texts_of_tests()][part::4]]
    assert found.count(True) > 10 and found.count(False) > 50


@pytest.mark.exhaustive(keep=0.65)
def test_files_of_a_grammar_are_judged_as_by_the_reader():
    found = [compare(grammar.system(Random(seed))) for seed in range(60)]
    assert found.count(True) > 2 and found.count(False) > 20


STRUCTURE = [
    ("solve: {stop: 1, samples: 3, step: 1}", False),
    ("solve: {method: Taylor, outputs: 'q, v'}", True),
    ("solve: {method: euler}", False),
    ("solve: {outputs: [q, nosuch]}", False),
    ("solve: {tolerance: true}", False),
    ("embedding: {a: [x]}\npositions: {a: [x]}", False),
    ("masses: {a: 1}", False),
    ("events: {e: {when: x, action: {set: {x_dot: -x_dot}}}}", True),
    ("events: {e: {direction: up, when: x}}", False),
    ("events: {e: {direction: rising}}", False),
    ("observables: {θ: x, 'y[i in range(3)]': x}", True),
    ("observables: {2y: x}", False),
    ("observables: {sin: x}", True),
    ("observables: {in: x}", False),
    ("parameters: {l: {unit: m}}", False),
    ("parameters: {l: {value: [1, 2], unit: m}}", True),
    ("potental: x", False),
    ("time: {unit: s}", True),
    ("draw:", True),
    ("draw: {rods: [[0, [x, 1]], '(0, (x, 1))', '[0, (i, x)] for i in range(3)'], springs: none}", True),
    ("draw: {rods: [[0]]}", False),
    ("draw: {rods: [[0, {x: 1}]]}", False),
    ("draw: {rods: {a: [0, [x, 1]]}}", False),
    ("draw: {points: [[x, 1], '(x, 2)'], trails: all, hide: none}", True),
    ("draw: {points: [[1, 2, 3, 4]]}", False),
    ("draw: {curves: {a: [x, 1], b: {at: [u, x], u: [0, 1], x: }, c: [[0, 0], [1, 1]]}}", True),
    ("draw: {curves: {c: {through: ['(i, 1) for i in range(3)']}, d: {through: [[0, 0], [0, 1]]}}}", True),
    ("draw: {curves: {c: {u: [0, 1]}}}", False),
    ("draw: {curves: {c: {at: [u, 1], through: [[0, 0], [0, 1]]}}}", False),
    ("draw: {curves: {c: {at: [u, v], u: [0, 1], v: [0, 1], w: [0, 1]}}}", False),
    ("draw: {curves: {c: {at: [u, 1], u: 1}}}", False),
    ("draw: {curves: {c: {through: [[0, 0]]}}}", False),
    ("draw: {colours: {x: red}, sliders: {x: [0, 1]}}", True),
    ("draw: {colors: {x: '#0f0'}}", True),
    ("draw: {colors: {x: red}, colours: {x: red}}", False),
    ("draw: {colors: {x: '<b>'}}", False),
    ("draw: {colors: {x: '#12345'}}", False),
    ("draw: {sliders: {x: 1}}", False),
    ("draw: {camera: {azimuth: 30, bounds: {x: [0, 1]}, follow: [x, 1], up: y}}", True),
    ("draw: {camera: {bounds: {w: [0, 1]}}}", False),
    ("draw: {camera: {up: x}}", False),
    ("draw: {camera: 30}", False),
    ("draw: [x]", False),
]  # fmt: skip


@pytest.mark.parametrize(("section", "valid"), STRUCTURE)
def test_the_structure_of_a_section(section, valid):
    text = f"coordinates: {{x: {{initial: 1}}}}\nlagrangian: x_dot**2/2\n{section}\n"
    assert compare(text) is not valid


def tables(table: Table) -> Iterator[Table]:
    """A table, and those of the keys within its keys."""
    yield table
    for row in table.rows:
        inner = row.read.args[0] if isinstance(row.read, partial) else TABLES.get(itself(row.read))
        if inner is not None:
            yield from tables(inner)


def test_every_reader_is_described():
    found = [*tables(SECTIONS)]
    assert {"action", "body", "bounds", "coordinate", "solve"} < {table.name for table in found}
    for table in found:
        for row in table.rows:
            reader = row.read
            assert of_reader(reader) is not UNKNOWN, f"{row.key}: add its reader to run/schema/readers.py"
            if isinstance(reader, Entries):
                assert itself(reader.value) in READERS
            else:
                function = itself(reader.func if isinstance(reader, partial) else reader)
                assert isinstance(reader, (Single, Terms)) or function in {**READERS, **WITH_KEYS}


def itself(reader):
    """A reader that is not imported before it reads, as the function that it is."""
    return reader.loaded() if isinstance(reader, Rare) else reader


def test_the_command_prints_it(capsys):
    assert main(["schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == schema()
    described = printed["properties"]["solve"]["anyOf"][0]["properties"]["stop"]["description"]
    assert described.startswith("the time at which it ends") and "](" not in json.dumps(printed)
    assert Path(ROOT / "docs" / "system-file.md").read_text(encoding="utf-8").count("lagrange schema")
