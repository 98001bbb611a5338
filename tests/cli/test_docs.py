"""The pages about the command line say what the commands say."""

import re
import runpy
from pathlib import Path

from lagrange_cli.cli import settings
from lagrange_cli.expression.vocabulary import FUNCTIONS, VECTOR_FUNCTIONS
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.sections import SECTIONS

ROOT = Path(__file__).resolve().parents[2]


def test_what_is_made_from_the_commands_is_up_to_date():
    make = runpy.run_path(str(ROOT / "docs" / "make.py"))
    for path, text in make["made"]():
        found = path.read_text(encoding="utf-8")
        assert make["masked"](found) == make["masked"](text), f"{path.name}: run python docs/make.py"


def test_the_page_of_the_output_file_names_every_output():
    page = (ROOT / "docs" / "output-file.md").read_text(encoding="utf-8")
    column = re.findall(r"^\| .*\| (.*?) \|$", page.partition("## Attributes")[0], re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", " ".join(column))) == set(settings.OUTPUTS)


def test_the_examples_of_the_system_file_are_system_files():
    page = (ROOT / "docs" / "system-file.md").read_text(encoding="utf-8")
    example, chain, pieces, attraction = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert read_spec(example, "example.yaml").name == "bead on a rotating hoop"
    spec = read_spec(chain, "chain.yaml", {"N": "3"})
    assert [coordinate.name for coordinate in spec.coordinates] == ["theta[0]", "theta[1]", "theta[2]"]
    assert len(read_spec(chain + pieces, "chain.yaml").definitions) == 20
    body = attraction.removeprefix("potential: ").strip()
    assert body in (ROOT / "systems" / "figure_eight.yaml").read_text(encoding="utf-8")


def test_the_page_of_the_system_file_names_every_section_and_function():
    page = (ROOT / "docs" / "system-file.md").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`(.*?)`", page))))
    assert set(SECTIONS) | set(FUNCTIONS) | set(VECTOR_FUNCTIONS) <= words
