"""The pages about the command line say what the commands say."""

import math
import re
import runpy
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from lagrange_cli.drawing.draw import draw
from lagrange_cli.expression.vocabulary import CALLABLE
from lagrange_cli.limits import DEFAULTS
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.outputs.units import find_units
from lagrange_cli.run.massless import with_equations_of_the_massless
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.values import resolve_values

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
WIDTH = 120
"""Characters that a line of prose may have."""
CONTORTED = (
    r"foretold", r"hardly not", r"whatever moves", r"of which most", r"(?<!no number )is due", r"tell so",
    r"none checked", r"(?:is|are|be|as) said\b(?! to)", r"up to when", r"holds so many", r"in any case",
    r"as far as anyone", r"goes? on where", r"is held against", r"times ours", r"on the way",
    r"stands? under its name", r"is looked at", r"beside others", r"beyond all bounds",
    r"by the shortest way",
    r"friction (?:that )?holds", r"not felt", r"in no time", r"and get none", r"(?:are|is) looked for",
    r"stays? (?:families|one)\b", r"but for rounding", r"by the shortest", r"leapt over", r"without a word",
    r"[Ww]hat becomes of", r"acts? on nothing", r"heeded", r"told from", r"[Nn]obody (?:asks|reads|watches)",
    r"and get nowhere", r"what moves it", r"may be held", r"going on happening", r"is to be 0",
    r"(?:are|is|was) let go", r"(?:are|is) gone\b", r"nothing but rounding", r"by rounding alone",
    r"those of the members (?:up )?to", r"it is seen whether", r"again and again whether", r"in whatever",
    r"which a warning says", r"nothing is to be seen", r"\bshall\b", r"step is taken again", r"hangs? on no",
    r"Of (?:a|the) (?:given|linear|oscillator)", r"[Ii]t tells what", r"foreseen where",
)  # fmt: skip
"""Phrases, some of them quoted by readers who did not understand them, and their kind."""


SLOW = [{"README.md"}, {"plot.md", "animate.md"}]
"""Pages with films and pictures; they take as long as all others."""


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("names", [*SLOW, None], ids=["README", "pictures", "others"])
def test_what_is_made_from_the_commands_is_up_to_date(names):
    make = runpy.run_path(str(ROOT / "docs" / "make.py"))
    slow = set().union(*SLOW)
    for path, text in make["made"](lambda name: name not in slow if names is None else name in names):
        found = path.read_text(encoding="utf-8")
        assert make["masked"](found) == make["masked"](text), f"{path.name}: run python docs/make.py"


def test_the_page_of_the_output_file_names_every_output():
    page = (ROOT / "docs" / "output-file.md").read_text(encoding="utf-8")
    column = re.findall(r"^\| .*\| (.*?) \|$", page.partition("## Units")[0], re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", " ".join(column))) == set(OUTPUTS)


def test_the_examples_of_the_system_file_are_system_files():
    page = (ROOT / "docs" / "system-file.md").read_text(encoding="utf-8")
    examples = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    example, named, places, legs, walls, contact, rod, damper, vortices, phases, top, *examples = examples
    ball, rotor, plane, family, discs, *examples = examples
    drawn, others, chain, pieces, network, attraction, units, times = examples
    assert len(read_spec(network, "network.yaml").coordinates) == 3
    assert read_spec(example, "example.yaml").name == "bead on a rotating hoop"
    assert read_spec(named, "named.yaml").of_particles == ("stretch", "slip")
    assert read_spec(places, "places.yaml").order == ("cart", "bob", "bar", "tip")
    turns = (
        "sizes: {N: 3}\nparameters: {l: 1}\ncoordinates: {'a[i in range(N)]': {}, 'b[i in range(N)]': {}}\n"
    )
    turns += "masses: {'knee[i in range(N)]': 1, 'foot[i in range(N)]': 1}\n"
    assert read_spec(turns + legs, "legs.yaml").order == ("knee", "foot")
    walled = "parameters: {k: 1, m: 1, mu: 1, g: 1, F: 1}\ncoordinates: [x, y]\nmasses: {p: m}\n"
    assert read_spec(f"{walled}embedding: {{p: [x, y]}}\n{walls}", "walls.yaml").forces["generalized_forces"]
    ground = "parameters: {k: 1, m: 1, g: 1, R: 1}\ncoordinates: [y]\nmasses: {p: m}\nembedding: {p: y}\n"
    assert read_spec(ground + contact, "contact.yaml").potential
    for light, count in ((damper, 1), (vortices, 4)):
        assert len(with_equations_of_the_massless(read_spec(light, "light.yaml")).massless) == count
    assert len(with_equations_of_the_massless(read_spec(phases, "phases.yaml")).first_order) == 300
    assert [*read_spec(top, "top.yaml").bodies] == ["top"]
    assert [*read_spec(ball, "ball.yaml").events] == ["floor", "top"]
    rod = "parameters: {K: 1, T: 1}\ncoordinates: [theta]\nlagrangian: theta_dot**2/2\n"
    assert [*read_spec(rod + rotor, "rotor.yaml").events] == ["kick"]
    assert [*read_spec(f"{walled}embedding: {{p: [x, y]}}\n{plane}", "plane.yaml").events] == ["section"]
    spec = read_spec(f"{walled}embedding: {{p: [x, y]}}\n{others}", "others.yaml")
    assert [*spec.transformations] == ["polar", "falling"]
    gas = "sizes: {N: 2}\ncoordinates: {x[i in range(N)]: {initial: 1}}\nmasses: {p[i in range(N)]: 1}\n"
    gas += "embedding: {p[i in range(N)]: x[i]}\n"
    assert [*read_spec(gas + family, "gas.yaml").events] == ["wall[0]", "wall[1]", "flash"]
    gas = "sizes: {N: 3}\nparameters: {R: 1}\ncoordinates: {'x[i in range(N)]': {}, 'y[i in range(N)]': {}}\n"
    gas += "masses: {'p[i in range(N)]': 1}\nembedding: {'p[i in range(N)]': ['x[i]', 'y[i]']}\n"
    assert [*read_spec(gas + discs, "discs.yaml").events] == ["hit[1,0]", "hit[2,0]", "hit[2,1]"]
    assert draw(spec := read_spec(drawn, "drawn.yaml"), resolve_values(spec)).sliders["k"] == (1, 100)
    spec = read_spec(chain, "chain.yaml", {"N": "3"})
    assert [coordinate.name for coordinate in spec.coordinates] == ["theta[0]", "theta[1]", "theta[2]"]
    assert len(read_spec(chain + pieces, "chain.yaml").definitions) == 20
    units += "masses: {planet: m}\nembedding: {planet: [x]}\npotential: -m*mu/x\n"
    found = find_units(read_spec(units, "units.yaml"))
    assert found.texts["v/x"] == "AU/d" and not found.conflicts
    timed = "parameters: {l: 1.0, g: 9.81}\ncoordinates: [x]\nlagrangian: x_dot**2/2\n" + times
    assert {*read_spec(timed, "times.yaml").solve.times} == {"stop", "step"}
    body = attraction.removeprefix("potential: ").strip()
    assert body in (ROOT / "systems" / "figure_eight.yaml").read_text(encoding="utf-8")


def test_the_page_of_the_system_file_names_every_section_and_function():
    page = (ROOT / "docs" / "system-file.md").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`(.*?)`", page))))
    assert set(SECTIONS.keys) | set(CALLABLE) <= words


def prose(page: Path) -> Iterator[tuple[int, str]]:
    """The lines of a page with their numbers, without code, tables and what the benchmarks write."""
    within = None
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if within:
            within = None if line.startswith(within) else within
        elif line.startswith("```"):
            within = "```"
        elif line.startswith("<!-- "):
            within = "<!-- end of "
        elif not line.startswith(("|", "    ")):
            yield number, line


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    seen: Counter[str] = Counter()
    found = set()
    for _, line in prose(page):
        if heading := re.fullmatch(r"#+ (.*)", line):
            slug = re.sub(r"[^\w\- ]", "", heading[1].lower()).replace(" ", "-")
            found.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
            seen[slug] += 1
    return found


def broken(page: Path, text: str) -> Iterator[str]:
    """The links within the documentation that lead nowhere."""
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = page.parent / name if name else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            yield target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_within_the_documentation_lead_somewhere(page):
    assert list(broken(page, page.read_text(encoding="utf-8"))) == []


def test_a_link_that_leads_nowhere_is_found():
    page = ROOT / "docs" / "cli.md"
    text = "[a](security.md#the-limits) [b](security.md#none) [c](none.md) [d](https://a.org/#x) [e](#none)"
    assert list(broken(page, text)) == ["security.md#none", "none.md", "#none"]


def test_pages_that_the_code_names_exist():
    code = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "lagrange_cli").rglob("*.py"))]
    named = {name for text in code for name in re.findall(r"docs/[\w-]+\.md(?:#[\w-]+)?", text)}
    assert named
    assert list(broken(ROOT / "README.md", " ".join(f"]({name})" for name in sorted(named)))) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_lines_of_prose_are_short(page):
    assert [number for number, line in prose(page) if len(line) > WIDTH] == []


@pytest.mark.parametrize(
    "page", [*PAGES, ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name
)
def test_the_prose_is_plain(page):
    text = re.sub(r"\s+", " ", page.read_text(encoding="utf-8"))
    assert [found[0] for each in CONTORTED for found in re.finditer(each, text)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_line_within_a_paragraph_begins_like_an_item_of_a_list(page):
    """A minus sign at the beginning of a line, as after wrapping ``p - b``, would begin a list."""
    lines = dict(prose(page))
    before = [(number, lines.get(number - 1, ""), line) for number, line in lines.items()]
    item = re.compile(r" *(?:[-+*]|\d+[.)]) ")
    wrong = [
        number
        for number, above, line in before
        if item.match(line) and above.strip() and not (item.match(above) or above.startswith("  "))
        if not above.endswith(":")
    ]
    assert wrong == []


def test_the_page_on_security_lists_every_limit_with_its_number():
    page = (ROOT / "docs" / "security.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"^\| `(\w+)` \| ([\d ^]+|none) \|", page, re.MULTILINE))
    written = {
        name: re.sub(r" |\^", lambda sign: {" ": "", "^": "**"}[sign[0]], n) for name, n in listed.items()
    }
    numbers = {name: "none" if math.isinf(most) else f"{most:.0f}" for name, most in DEFAULTS.items()}
    powers = {f"10**{k}": f"{10**k}" for k in range(20)}
    assert {name: powers.get(number, number) for name, number in written.items()} == numbers
