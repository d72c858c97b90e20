"""docs/extending.md shows files of a package that is installed and tested as they are."""

import re
import tomllib
from pathlib import Path

import lockprobe
from lockprobe.foundation.plugins import GROUPS

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "examples" / "third_party"
PAGE = (ROOT / "docs" / "extending.md").read_text("utf-8")
SHOWN = dict(re.findall(r"^`([\w./]+)`:\n\n```(?:py|toml)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


def test_the_page_shows_files_as_they_are():
    assert {"pyproject.toml", "src/latecomer/late.py"} <= set(SHOWN)
    for name, text in SHOWN.items():
        assert text == (PACKAGE / name).read_text("utf-8"), name
    assert PAGE.count("\n```py\n") + PAGE.count("\n```toml\n") == len(SHOWN)


def test_the_package_adds_one_of_each_kind_and_is_tested_with_the_wheel_alone():
    points = tomllib.loads(SHOWN["pyproject.toml"])["project"]["entry-points"]
    assert set(points) == set(GROUPS.values()) - {"lockprobe.tools", "lockprobe.plant_sources"}
    assert all(group in PAGE.partition("## The package")[0] for group in points)
    assert ".ci/third-party" in (ROOT / ".ci" / "run").read_text("utf-8")


def test_an_intervention_is_short():
    assert len((PACKAGE / "src" / "latecomer" / "late.py").read_text("utf-8").splitlines()) <= 60


def test_the_page_begins_with_the_names_of_the_front_door():
    table = PAGE.partition("| names | what they are |")[2].partition("\n\n")[0]
    first = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    assert sorted(name for cell in first for name in re.findall(r"`(\w+)`", cell)) == sorted(lockprobe.__all__)
