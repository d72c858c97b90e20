"""The house stands as ARCHITECTURE.md says."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "lockprobe"
ROBOT = ROOT / "robot" / "src" / "lockprobe_robot"
ENGINES = ("lockprobe.agents.llm.client", "lockprobe.agents.llm.model", "lockprobe.__main__")


def test_the_map_is_short_and_its_floors_are_the_layers_that_are_enforced():
    text = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
    assert text.count("\n") <= 155
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    layers = [set(re.findall(r"lockprobe[._](\w+)", layer)) for layer in contracts[0]["layers"]]
    rows = re.findall(r"^\| (\d+) \| (`[^|]*) \|", text, re.MULTILINE)
    drawn = {name: int(floor) for floor, names in rows for name in re.findall(r"`(?:lockprobe_)?(\w+)`", names)}
    assert drawn == {name: floor for floor, layer in enumerate(reversed(layers)) for name in layer}
    there = {path.stem for path in SOURCE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert there - {"__init__", "__main__"} == drawn.keys() - {"robot"}
    assert sum((SOURCE / name / "__init__.py").exists() for name in there) <= 14  # rooms; wrappers.py is a file
    assert len({what for what, _ in RECIPES}) == len(RECIPES)  # each stands once


RECIPES = re.findall(
    r"^\| (an? [^|]*|your own [^|]*) \| (.*) \|$", (ROOT / "ARCHITECTURE.md").read_text("utf-8"), re.MULTILINE
)


@pytest.mark.parametrize(("what", "where"), RECIPES)
def test_a_recipe_names_places_that_exist(what, where):
    places = [place for place in re.findall(r"`([^`]+)`", where) if "/" in place or "." in place]
    assert places or "](docs/" in where or what == "a table", what
    for place in places:
        assert any((at / place).exists() for at in (SOURCE, ROOT, ROBOT)) or list(SOURCE.rglob(place)), place


def test_the_recipes_of_the_report_give_a_section_with_a_number_a_table_and_a_figure():
    """Every section that ships stands in the list of sections."""
    from lockprobe.report.questions import all_sections

    folder = SOURCE / "report" / "questions"
    with_sections = {
        path.stem for path in folder.glob("*.py") if re.search(r"^SECTIONS = ", path.read_text(), re.MULTILINE)
    }
    listed = re.search(r"_OWN = \((.*?)\)", (folder / "__init__.py").read_text(), re.DOTALL)
    assert {*re.findall(r'"(\w+)"', listed[1])} == with_sections
    for kind in ("tables", "figures"):
        names = [file.name for one in all_sections() for file in getattr(one, kind)]
        assert len(names) == len({*names}), kind


PROGRAMS = sorted(path for folder in ("benchmarks", "examples", "scripts") for path in (ROOT / folder).rglob("*.py"))


def test_what_programs_import_of_the_packages_is_there():
    imports = [(path, node) for path in PROGRAMS for node in ast.walk(ast.parse(path.read_text("utf-8")))]
    for path, node in imports:
        name = (isinstance(node, ast.ImportFrom) and node.module) or ""
        if name.startswith("lockprobe") and name not in ENGINES:
            module = importlib.import_module(name)
            for one in node.names:
                assert hasattr(module, one.name) or importlib.import_module(f"{name}.{one.name}"), path.name
